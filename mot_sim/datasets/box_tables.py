"""Tables of boxes as people have them: CSV of any dialect, MOTChallenge, KITTI, COCO's results."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.datasets.detection_files import (
    MIN_MAX_COLUMNS,
    SIDE_COLUMNS,
    SIZE_COLUMNS,
    DetectionFormat,
)
from mot_sim.datasets.kitti.detectors import DETECTORS
from mot_sim.files.documents import read_json
from mot_sim.files.text import MAX_WORD_LENGTH, TextTable, is_number, read_table, read_text
from tracker.errors import BadFile, UnknownName
from tracker.types import KITTI_KINDS, MOT_CLASSES, TRACKED_KINDS, spelled_as_kitti

# What people call the columns, by our names.
SPELLINGS: dict[str, tuple[str, ...]] = {
    "frame": ("frame_id", "frame_index", "frame_number", "image_id"),
    "time": ("timestamp", "time_s", "timestamp_s", "seconds"),
    "x_min": ("xmin", "x1", "bbox_x1"),
    "y_min": ("ymin", "y1", "bbox_y1"),
    "x_max": ("xmax", "x2", "bbox_x2"),
    "y_max": ("ymax", "y2", "bbox_y2"),
    "left": ("bb_left", "bbox_left"),
    "top": ("bb_top", "bbox_top"),
    "width": ("bb_width", "bbox_width"),
    "height": ("bb_height", "bbox_height"),
    "score": ("confidence", "conf", "probability"),
    "type": ("class", "kind", "label", "category", "class_name"),
    "id": ("track_id", "trackid", "object_id"),
    "yaw": (),
    "length_m": (),
    "height_m": (),
    "width_m": (),
}
# Columns of what a detector measured beside the box; an empty cell: not measured.
CUES = ("yaw", *SIZE_COLUMNS)
HEADER = "frame,x_min,y_min,x_max,y_max,score"
DELIMITERS = (",", ";", "\t", "|")
# COCO's names, and its numbers where a file does not name them, of what is tracked here.
COCO_KINDS = {kind.lower(): kind for kind in TRACKED_KINDS} | {"person": "Pedestrian"}
COCO_NUMBERS = {1: "person", 3: "car"}


@dataclass(frozen=True, eq=False)
class Entries(TextTable):
    """The entries of a JSON file."""

    def place(self, row: int) -> str:
        """The file and the entry, counted from 0."""
        return f"{self.path}: entry {row}"


def read_box_table(
    path: Path, kinds: tuple[str, ...] | None = None
) -> tuple[TextTable, DetectionFormat]:
    """The rows of a file of boxes, and how they are to be understood.

    Known are CSV with a header (any of DELIMITERS, quotes, `#` lines, any case, SPELLINGS),
    MOTChallenge's `det.txt`, rows of KITTI's labels and results, and COCO's results as JSON.
    kinds: the classes that are kept; None: those of TRACKED_KINDS that the file holds, cars where
    it does not say. Raises BadFile with file, line and value for what is none of these.
    """
    if path.suffix.lower() == ".json":
        table, form = _read_coco(path)
    else:
        lines = _filled_lines(path)
        first = lines[0][1] if lines else ""
        words = first.split()
        if len(words) in (17, 18) and not is_number(words[2]) and is_number(words[0]):
            form = DETECTORS["kitti"]
            table = read_table(path, form.names, words=["type"])
        elif first and all(is_number(field) for field in _fields(first, ",")):
            table, form = _read_motchallenge(path, first)
        else:
            table, form = _read_csv(path, lines)
    return table, replace(form, tracked=kinds or _kinds_there(table, form))


def _kinds_there(table: TextTable, form: DetectionFormat) -> tuple[str, ...]:
    """The tracked classes that a table holds; cars where it does not say."""
    if form.kinds is None:
        return ("Car",)
    written = table["type"]
    words = spelled_as_kitti(written) if written.dtype.kind == "U" else written
    there = {form.kinds.get(word) for word in np.unique(words).tolist()}
    return tuple(kind for kind in TRACKED_KINDS if kind in there) or ("Car",)


def _filled_lines(path: Path) -> list[tuple[int, str]]:
    """The lines that hold something, with their numbers; a header may follow a `#`."""
    numbered = enumerate(read_text(path).split("\n"), 1)
    filled = [(number, line.strip()) for number, line in numbered if line.strip()]
    rows = [(number, line) for number, line in filled if not line.startswith("#")]
    comments = [(number, line.lstrip("# ")) for number, line in filled if line.startswith("#")]
    if rows and comments and all(is_number(f) for f in _fields(rows[0][1], _delimiter(rows[0][1]))):
        named = [
            (number, line)
            for number, line in comments
            if number < rows[0][0] and _is_header(_fields(line, _delimiter(line)))
        ]
        return named[-1:] + rows
    return rows


def _delimiter(line: str) -> str:
    """What separates the fields of a line: the most frequent of DELIMITERS; else spaces."""
    best = max(DELIMITERS, key=line.count)
    return best if best in line else " "


def _fields(line: str, delimiter: str) -> list[str]:
    """The fields of a line without quotes; an empty one at its end is left out."""
    row = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    fields = [field.strip() for field in row]
    return fields[:-1] if len(fields) > 1 and not fields[-1] else fields


def _is_header(fields: Sequence[str]) -> bool:
    """Whether some field names a column."""
    return any(our_name(field) in SPELLINGS for field in fields)


def our_name(column: str) -> str:
    """Our name of a column, whatever its case and spelling; of an unknown one, its lower case."""
    name = column.strip().lower().replace(" ", "_")
    return next((ours for ours, others in SPELLINGS.items() if name in others), name)


def _read_csv(path: Path, lines: list[tuple[int, str]]) -> tuple[TextTable, DetectionFormat]:
    number, first = lines[0] if lines else (1, "")
    delimiter = _delimiter(first)
    named = _fields(first, delimiter) if first else []
    columns = tuple(our_name(field) for field in named)
    if not _is_header(columns):
        shown = first[:80] if first else "an empty file"
        raise BadFile(
            f"{path}:{number}: no header but {shown!r}; the first line names the columns: {HEADER}"
        )
    _require_columns(path, number, columns)
    decimal_comma = delimiter == ";"
    rows, numbers = [], []
    for place, line in lines[1:]:
        fields = _fields(line, delimiter)
        if len(fields) != len(columns):
            raise BadFile(
                f"{path}:{place}: {len(fields)} values where {len(columns)} belong: {line[:80]!r}; "
                f"a row is {' '.join(columns)}, separated by {delimiter!r}"
            )
        rows.append(fields)
        numbers.append(place)
    words = "type" in columns and not all(is_number(row[columns.index("type")]) for row in rows)
    table = TextTable(
        path, _structured(path, columns, rows, numbers, words, decimal_comma), lines=tuple(numbers)
    )
    form = DetectionFormat(columns, scored=False)
    if "type" in columns:
        if not words and rows:
            cure = f"write KITTI's classes ({', '.join(KITTI_KINDS)}; case does not matter)"
            table.reject(np.ones(len(rows), bool), "a class that is a number", ["type"], cure)
        form = replace(form, kinds={kind: kind for kind in KITTI_KINDS})
    return table, form


def _require_columns(path: Path, number: int, columns: Sequence[str]) -> None:
    """BadFile for columns that are unknown, missing, or stand twice."""
    for column in columns:
        if column not in SPELLINGS:
            hint = (
                "; is x the left edge? Write left,top,width,height (or x_min,y_min,x_max,y_max)"
                if column in ("x", "y", "w", "h", "cx", "cy")
                else ""
            )
            error = UnknownName.of("column", column, list(SPELLINGS))
            raise BadFile(f"{path}:{number}: {error}{hint}")
    twice = next((column for column in columns if columns.count(column) > 1), None)
    if twice is not None:
        raise BadFile(f"{path}:{number}: a column stands twice: {twice}, in {','.join(columns)}")
    box = SIDE_COLUMNS if "left" in columns or "top" in columns else MIN_MAX_COLUMNS
    moment = () if "time" in columns else ("frame",)
    size = SIZE_COLUMNS if set(SIZE_COLUMNS) & set(columns) else ()
    missing = [column for column in (*moment, *box, *size) if column not in columns]
    if missing:
        raise BadFile(
            f"{path}:{number}: no column {missing[0]}: {','.join(columns)}; the header is {HEADER}"
        )


def _structured(
    path: Path,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: Sequence[int],
    words: bool,
    decimal_comma: bool,
) -> np.ndarray:
    """The rows as an array with a field a column; BadFile with the line of what is no number."""
    kinds = [
        (name, f"U{MAX_WORD_LENGTH}" if name == "type" and words else "f8") for name in columns
    ]
    table = np.zeros(len(rows), dtype=kinds)
    for index, (name, kind) in enumerate(kinds):
        values = [row[index] for row in rows]
        if kind == "f8" and decimal_comma:
            values = [value.replace(",", ".", 1) for value in values]
        if kind == "f8":
            if name in CUES:
                values = [value or "nan" for value in values]
            for number, value in zip(numbers, values, strict=True):
                if not is_number(value):
                    raise BadFile(f"{path}:{number}: {name} is {value!r}, which is no number")
        table[name] = values
    return table


def _read_motchallenge(path: Path, first: str) -> tuple[TextTable, DetectionFormat]:
    """A headerless table of numbers: MOTChallenge's, whose frames count from 1."""
    form = DETECTORS["motchallenge"]
    if len(_fields(first, ",")) < len(form.columns):
        raise BadFile(
            f"{path}:1: no header but {first[:80]!r}; the first line names the columns, {HEADER}; "
            f"without one, rows are MOTChallenge's, {','.join(form.columns)},..."
        )
    table = read_table(path, form.names, form.delimiter)
    if "more1" not in (table.rows.dtype.names or ()) or not (table["more1"] > 0.0).any():
        return table, form
    names = tuple("type" if name == "more1" else name for name in table.rows.dtype.names or ())
    table.rows.dtype.names = names
    return table, replace(
        form, columns=names, open_ended=False,
        kinds={float(number): kind for kind, number in reversed(MOT_CLASSES.items())},
    )  # fmt: skip


def _read_coco(path: Path) -> tuple[TextTable, DetectionFormat]:
    """COCO's results, `[{image_id, category_id, bbox, score}, ...]`, or a whole data set of it."""
    content = read_json(path)
    named: Mapping[Any, str] = COCO_NUMBERS
    if isinstance(content, dict):
        listed = content.get("categories", [])
        if isinstance(listed, list) and all(isinstance(each, dict) for each in listed):
            known = {
                each["id"]: str(each.get("name"))
                for each in listed
                if isinstance(each.get("id"), int | str)
            }
            named = known or COCO_NUMBERS
        content = content.get("annotations")
    if not isinstance(content, list):
        entries = "[{image_id, category_id, bbox, score}, ...]"
        raise BadFile(f"{path}: no list of results as COCO has them: {entries}")
    # an empty list may hold either
    has_ids = not content or any(isinstance(each, dict) and "track_id" in each for each in content)
    columns = ("frame", *SIDE_COLUMNS, "score", "type", *(("id",) if has_ids else ()))
    kinds = [(name, f"U{MAX_WORD_LENGTH}" if name == "type" else "f8") for name in columns]
    rows = []
    for number, entry in enumerate(content):
        try:
            left, top, width, height = entry["bbox"]
            row = [entry["image_id"], left, top, width, height, entry.get("score", 1.0)]
            numbers = [float(value) for value in row]
            category = entry.get("category_id")
            word = named.get(category, str(category))
            more = [float(entry["track_id"])] if has_ids else []
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise BadFile(
                f"{path}: entry {number}: {type(error).__name__}: {error}: {str(entry)[:80]}; an "
                "entry is {image_id (the frame), category_id, bbox [left, top, width, height], "
                "score}"
            ) from None
        rows.append((*numbers, COCO_KINDS.get(word.lower(), word), *more))
    table = Entries(path, np.array(rows, dtype=kinds))
    there = np.unique(table["type"]).tolist()
    form = DetectionFormat(columns, kinds={kind: kind for kind in (*KITTI_KINDS, *there)})
    return table, replace(form, strict_kinds=False)
