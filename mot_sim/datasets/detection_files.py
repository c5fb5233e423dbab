"""Files of detected boxes: their formats, strict reading, and scores as probabilities."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.box_checks import (
    CUBOID_COLUMNS,
    inverted_cure,
    refuse_normalised,
    require_cuboid_rows,
)
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.files.text import MAX_WORD_LENGTH, TextTable, read_table
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle
from tracker.types import (
    KITTI_KINDS,
    Cuboids,
    Detections,
    is_kitti_kind,
    kinds_said,
    spelled_as_kitti,
)

BadBoxes = Literal["error", "drop"]
# From h w l x y z rotation_y, in camera 0, to cuboids in the road frame.
CuboidsOfRows = Callable[[Float[Array, "n 7"]], Cuboids]
CORNER_COLUMNS = ("x1", "y1", "x2", "y2")
MIN_MAX_COLUMNS = ("x_min", "y_min", "x_max", "y_max")
SIZE_COLUMNS = ("length_m", "height_m", "width_m")
MAX_SIZE_METRES = 100.0
SIDE_COLUMNS = ("left", "top", "width", "height")
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ScoreMap:
    """From scores to the probabilities that boxes are right: a logistic curve.

    Fitted by maximum likelihood on KITTI's ten given sequences, a box being right when it meets
    a counted car with IoU >= 0.5: `python benchmarks/calibrate_scores.py` prints the numbers.
    """

    midpoint: float
    """Score at which every second box is right, finite; more: all boxes count as less sure."""
    scale: float
    """How far above `midpoint` 73 % are right, finite and > 0; more: scores tell less."""

    def __post_init__(self) -> None:
        if not (0.0 < self.scale < inf and isfinite(self.midpoint)):
            raise BadConfig(
                f"score map {self.midpoint:g},{self.scale:g}: both finite, the scale positive"
            )

    @classmethod
    def parse(cls, text: str) -> "ScoreMap":
        """From `midpoint,scale`."""
        try:
            midpoint, scale = (float(number) for number in text.split(","))
        except ValueError:
            raise BadConfig(f"score map {text!r}: write two numbers, midpoint,scale") from None
        return cls(midpoint, scale)

    def __call__(self, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """The probability that a box of that score is right."""
        from scipy.special import expit  # noqa: PLC0415 - slower to load than all the rest

        with np.errstate(over="ignore"):  # far from the midpoint it is 0 or 1
            return expit((scores - self.midpoint) / self.scale)


@dataclass(frozen=True)
class DetectionFormat:
    """How a detector's files are written."""

    columns: tuple[str, ...]
    """Names of a row's values. Boxes are x1 y1 x2 y2, x_min y_min x_max y_max or left top width
    height; without `score` all scores are 1."""
    delimiter: str | None = None
    """What separates the values; None: any white space."""
    first_frame: int = 0
    """Number of the first frame in the files, 0 or 1."""
    kinds: Mapping[str | float, str] | None = None
    """The class of KITTI that each word, or each number, of the column `type` means; rows of
    others are left out. None: there is no such column, all rows are of the class `tracked`."""
    tracked: tuple[str, ...] = ("Car",)
    """The classes whose rows are kept, of TRACKED_KINDS."""
    bad_boxes: BadBoxes = "error"
    """What happens to boxes without area or wholly outside the image."""
    open_ended: bool = False
    """Whether rows may hold more values than there are columns, all rows equally many."""
    score_map: ScoreMap | None = None
    """From the file's scores to probabilities; None: they are taken as they stand."""
    strict_kinds: bool = True
    """Whether a word that is no class of KITTI is refused; False: such rows are left out."""
    scored: bool = True
    """Whether rows must hold `score`, the last column; False: without it, as in labels, it is 1."""

    def names(self, fields: Sequence[str]) -> Sequence[str]:
        """The names of the columns of rows with as many values as the given one."""
        if not self.scored and len(fields) == len(self.columns) - 1:
            return self.columns[:-1]
        extra = len(fields) - len(self.columns) if self.open_ended else 0
        return [*self.columns, *(f"more{number}" for number in range(1, extra + 1))]

    @property
    def box_columns(self) -> tuple[str, ...]:
        """The four columns that hold a box."""
        return next(
            four
            for four in (CORNER_COLUMNS, SIDE_COLUMNS, MIN_MAX_COLUMNS)
            if four[0] in self.columns
        )

    def boxes(self, table: TextTable) -> Float[Array, "n 4"]:
        """The corners of the boxes; BadFile for NaN and infinity."""
        boxes = table.finite(self.box_columns)
        if self.box_columns == SIDE_COLUMNS:
            boxes[:, 2:] += boxes[:, :2]
        return boxes


def read_detections(
    path: Path,
    form: DetectionFormat,
    image_size: tuple[int, int],
    frame_count: int | None = None,
    bad_boxes: BadBoxes | None = None,
    counted_in: Path | None = None,
    cuboids: CuboidsOfRows | None = None,
) -> DetectionLog:
    """The detections in a file, clipped to the image [0, width - 1] x [0, height - 1].

    bad_boxes: "error" refuses boxes without area and boxes wholly outside the image, "drop"
    leaves them out and logs how many; None: as the format says. An empty file holds no
    detections. Raises BadFile with file and line for NaN and infinity, inverted boxes, frames
    outside the sequence (when frame_count says how long it is; counted_in: by the lines of this
    file), and rows that are not numbers.
    cuboids: from h w l x y z rotation_y to cuboids in the road frame; they are read with it, and
    BadFile is raised for sizes that are not positive and cuboids wholly behind the camera,
    BadConfig for a format that has none. None: only boxes are read.
    """
    table = read_table(path, form.names, form.delimiter, words=_words(form))
    return check_detections(
        table, form, image_size, frame_count, bad_boxes or form.bad_boxes, counted_in, cuboids
    )


def check_detections(
    table: TextTable,
    form: DetectionFormat,
    image_size: tuple[int, int],
    frame_count: int | None,
    bad_boxes: BadBoxes,
    counted_in: Path | None = None,
    cuboids: CuboidsOfRows | None = None,
) -> DetectionLog:
    """The detections of a table that was read; see `read_detections`."""
    frames = table.frames(frame_count, form.first_frame, counted_in)
    boxes, box_columns = form.boxes(table), form.box_columns
    has_scores = "score" in (table.rows.dtype.names or ())
    scores = table.finite(["score"])[:, 0] if has_scores else np.ones(len(table))
    sides = boxes[:, 2:] - boxes[:, :2]
    inverted = (sides < 0.0).any(axis=1)
    table.reject(
        inverted, "inverted box", box_columns, inverted_cure(inverted, " ".join(box_columns))
    )
    refuse_normalised(table, boxes, box_columns)
    furthest = np.array([*image_size, *image_size], dtype=float) - 1.0
    clipped = np.clip(boxes, 0.0, furthest)
    kinds = (
        np.full(len(table), form.tracked[0]) if form.kinds is None else kinds_of_rows(table, form)
    )
    keep = np.isin(kinds, form.tracked)
    flat = (sides == 0.0).any(axis=1)
    outside = ~flat & (clipped[:, 2:] <= clipped[:, :2]).any(axis=1)
    if bad_boxes == "error":
        cure = 'mend the file, or leave such boxes out: --drop-bad-boxes, bad_boxes="drop"'
        width, height = image_size
        table.reject(keep & flat, "box without area", box_columns, cure)
        table.reject(
            keep & outside, f"box wholly outside the {width}x{height} image", box_columns, cure
        )
    elif (keep & (flat | outside)).any():
        message = "%s: %d boxes without area and %d wholly outside the image are left out"
        log.warning(message, table.path, (keep & flat).sum(), (keep & outside).sum())
    keep &= ~(flat | outside)
    if has_scores:
        scores = _probabilities(scores, form, table.path)
    said = None if form.tracked == ("Car",) else kinds[keep]
    cues = {name: column[keep] for name, column in _cues(table).items()}
    detections = Detections(clipped[keep], scores[keep], **cues, kinds=said)
    if cuboids is not None:
        found = cuboids(_cuboid_rows(table, form, keep))
        detections = detections.replaced(base=found.base, yaw=found.yaw, size=found.size)
    return DetectionLog.of(frames[keep], detections)


def _cuboid_rows(
    table: TextTable, form: DetectionFormat, keep: Bool[Array, " n"]
) -> Float[Array, "k 7"]:
    """The kept rows' cuboids in KITTI's columns, with headings in [-pi, pi)."""
    lacking = [name for name in CUBOID_COLUMNS if name not in form.columns]
    if lacking:
        raise BadConfig(
            f"{table.path}: its format has no {', '.join(lacking)}, so no cuboids can be read; "
            "leave --cuboids out"
        )
    rows = table.finite(CUBOID_COLUMNS)
    require_cuboid_rows(table, rows, keep)
    rows[:, 6] = wrap_angle(rows[:, 6])
    return rows[keep]


def _cues(table: TextTable) -> dict[str, Float[Array, "n ..."]]:
    """Yaw and size, where the table has such columns; NaN: not measured."""
    names, found = table.rows.dtype.names or (), {}
    if "yaw" in names:
        table.reject(np.isinf(table["yaw"]), "yaw is not finite", ["yaw"], "give radians")
        found["yaw"] = table["yaw"]
    if set(SIZE_COLUMNS) <= set(names):
        size = table.block(SIZE_COLUMNS)
        bad = ~(np.isnan(size) | ((size > 0.0) & (size < MAX_SIZE_METRES))).all(axis=1)
        table.reject(bad, "a size that no vehicle has", SIZE_COLUMNS, "give metres above 0")
        found["size"] = size
    return found


def _probabilities(
    scores: Float[Array, " n"], form: DetectionFormat, path: Path
) -> Float[Array, " n"]:
    """Scores as probabilities; warns of scores that cannot be any."""
    if form.score_map is not None:
        return form.score_map(scores)
    if ((scores < 0.0) | (scores > 1.0)).any():
        message = (
            "%s: scores from %g to %g are no probabilities; tracker default finds their scale "
            "by how the boxes fare, others take them for ones: --score-map MIDPOINT,SCALE maps them"
        )
        log.warning(message, path, scores.min(), scores.max())
    return scores


def _words(form: DetectionFormat) -> Sequence[str]:
    return ("type",) if form.kinds is not None and _of_words(form.kinds) else ()


def _of_words(kinds: Mapping[str | float, str]) -> bool:
    """Whether the column `type` holds words, not numbers."""
    return any(isinstance(word, str) for word in kinds)


def kinds_of_rows(table: TextTable, form: DetectionFormat) -> Shaped[Array, " n"]:
    """The class of each row; says what a file holds in which nothing is tracked."""
    if form.kinds is None:
        return np.full(len(table), form.tracked[0])
    written = table["type"]
    if _of_words(form.kinds):
        written = spelled_as_kitti(written)
        cure = f"KITTI's classes are {', '.join(KITTI_KINDS)} (case does not matter)"
        if form.strict_kinds:
            table.reject(~is_kitti_kind(written), "no class of KITTI", ["type"], cure)
    kinds = np.full(len(table), "", dtype=f"U{MAX_WORD_LENGTH}")
    for word, kind in form.kinds.items():
        kinds[written == word] = kind
    if len(table) and not np.isin(kinds, form.tracked).any():
        message = "%s: holds %s, and nothing of %s, which alone is tracked: nothing comes out"
        found = kinds_said(np.where(kinds == "", written.astype(str), kinds))
        log.warning(message, table.path, found, " or ".join(form.tracked))
    return kinds
