"""Tracks as tables of boxes for other programs: CSV, COCO's results, MOTChallenge's rows."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mot_sim.datasets.box_tables import COCO_KINDS, COCO_NUMBERS
from mot_sim.datasets.export import kinds_or_cars, motchallenge_lines, scores_or_ones
from tracker.errors import BadTracks
from tracker.types import Tracks

CSV_HEADER = "frame,id,class,x_min,y_min,x_max,y_max,score"
COCO_BY_KIND = {COCO_KINDS[name]: number for number, name in COCO_NUMBERS.items()}


@dataclass(frozen=True)
class BoxWriter:
    """A format of files of boxes; `read_box_table` reads them all."""

    about: str
    """What it is, one line."""
    suffix: str
    """How its files end."""
    lines: Callable[[Tracks], Iterator[str]]
    """The lines of a file, in the order of frames."""


def csv_lines(tracks: Tracks) -> Iterator[str]:
    """CSV_HEADER and a line per row, all digits kept; frames and ids as they are."""
    yield CSV_HEADER
    kinds, scores = kinds_or_cars(tracks.kinds, len(tracks)), scores_or_ones(tracks).tolist()
    for row in _in_order(tracks):
        box = ",".join(map(repr, tracks.boxes[row].tolist()))
        yield f"{tracks.frames[row]},{tracks.ids[row]},{kinds[row]},{box},{scores[row]!r}"


def coco_lines(tracks: Tracks) -> Iterator[str]:
    """COCO's results: a list of {image_id, category_id, bbox, score, track_id}; a line an entry.

    image_id is the frame. Raises BadTracks for classes that COCO does not have.
    """
    kinds, scores = kinds_or_cars(tracks.kinds, len(tracks)), scores_or_ones(tracks).tolist()
    lines = []
    for row in _in_order(tracks):
        if kinds[row] not in COCO_BY_KIND:
            raise BadTracks(f"COCO has no class {kinds[row]}: leave its rows out, or write csv")
        left, top, right, bottom = tracks.boxes[row].tolist()
        entry = {
            "image_id": int(tracks.frames[row]),
            "category_id": COCO_BY_KIND[kinds[row]],
            "bbox": [left, top, right - left, bottom - top],
            "score": scores[row],
            "track_id": int(tracks.ids[row]),
        }
        lines.append(json.dumps(entry))
    yield "["
    yield from (line + "," for line in lines[:-1])
    yield from lines[-1:]
    yield "]"


def _in_order(tracks: Tracks) -> list[int]:
    """The rows in the order of frames."""
    order: list[int] = np.argsort(tracks.frames, kind="stable").tolist()
    return order


# By the names that `mot-sim export --to` takes.
BOX_WRITERS = {
    "csv": BoxWriter("OUT/NAME.csv, whose header names the columns", ".csv", csv_lines),
    "coco": BoxWriter("OUT/NAME.json, COCO's results with a track_id", ".json", coco_lines),
    "mot": BoxWriter("OUT/NAME.txt, MOTChallenge's rows alone", ".txt", motchallenge_lines),
}
