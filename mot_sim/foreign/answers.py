"""What a tracker answered, as Tracks: rows, pairs, Tracks, or supervision's Detections."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import TrackingError
from tracker.types import Frame, Tracks

COLUMNS = ("x_min", "y_min", "x_max", "y_max", "id")
FORMS = (
    "give Tracks, rows x_min y_min x_max y_max id, (ids, boxes), or supervision's Detections; "
    "an empty array for no rows"
)
MIN_SHARED = 0.5  # IoU with a given box from which a guessed layout of boxes fits


class BadRows(TrackingError):
    """A tracker's output that cannot be scored."""


def tracks_from(answer: Any, frame: Frame) -> Tracks:
    """The rows of this frame.

    answer: Tracks; an array or list (n, 5 or more) of x_min, y_min, x_max, y_max in pixels and a
    whole number, the id; a tuple (ids, boxes); or supervision's Detections, of which rows with a
    `tracker_id` below 0 are left out. Raises BadRows that names the row for anything else, and
    for boxes that are turned inside out (xywh?) or lie in 0..1 (normalised?).
    """
    if isinstance(answer, Tracks):
        found = answer
    elif hasattr(answer, "xyxy") and hasattr(answer, "tracker_id"):
        found = _of_supervision(answer, frame)
    elif isinstance(answer, tuple) and len(answer) == 2 and not _is_row(answer):
        found = _of_pair(answer[0], answer[1], frame)
    else:
        found = _of_rows(answer, frame)
    _require_pixels(np.asarray(found.boxes), frame)
    return found


def _is_row(answer: tuple[Any, Any]) -> bool:
    """Whether both are rows of box and id, and not ids and boxes."""
    return all(np.ndim(each) == 1 and np.size(each) >= len(COLUMNS) for each in answer)


def _of_rows(answer: Any, frame: Frame) -> Tracks:
    if answer is None or not isinstance(answer, Iterable | np.ndarray):
        raise BadRows(f"the tracker gave a {type(answer).__name__}, not Tracks: {FORMS}")
    rows = _numbers(answer, COLUMNS)
    if rows.size == 0:
        return Tracks.empty()
    if rows.ndim != 2 or rows.shape[1] < len(COLUMNS):
        lacks = ": no ids" if rows.ndim == 2 and rows.shape[1] == 4 else ""
        raise BadRows(f"an array of shape {rows.shape}, not n rows of box and id{lacks}; {FORMS}")
    return _tracks(rows[:, 4], rows[:, :4], frame)


def _of_pair(ids: Any, boxes: Any, frame: Frame) -> Tracks:
    names, found = _numbers(ids, COLUMNS[4:]), _numbers(boxes, COLUMNS[:4])
    if found.size == 0:
        found = found.reshape(0, 4)
    if names.ndim != 1 or found.ndim != 2 or found.shape[1] < 4 or len(names) != len(found):
        raise BadRows(
            f"ids of shape {names.shape} and boxes of shape {found.shape}: give (n,) and (n, 4)"
        )
    return _tracks(names, found[:, :4], frame)


def _of_supervision(answer: Any, frame: Frame) -> Tracks:
    boxes = _numbers(answer.xyxy, COLUMNS[:4]).reshape(-1, 4)
    if len(boxes) == 0:
        return Tracks.empty()
    if answer.tracker_id is None:
        raise BadRows(f"Detections of {len(boxes)} rows without tracker_id: no ids")
    ids = _numbers(answer.tracker_id, COLUMNS[4:])
    named = ids >= 0
    scores = None if answer.confidence is None else np.asarray(answer.confidence, dtype=float)
    return _tracks(ids[named], boxes[named], frame, None if scores is None else scores[named])


def _tracks(
    ids: Float[Array, " n"],
    boxes: Float[Array, "n 4"],
    frame: Frame,
    scores: Float[Array, " n"] | None = None,
) -> Tracks:
    """Rows of this frame. Raises BadRows for ids that are no whole numbers."""
    whole = np.isfinite(ids) & (ids == np.round(ids))
    if not whole.all():
        row = int(np.flatnonzero(~whole)[0])
        raise BadRows(f"ids that are no whole numbers, in row {row}: {ids[row]:g}")
    given = np.ones(len(ids)) if scores is None else scores
    return Tracks(np.full(len(ids), frame.index), ids.astype(np.int64), boxes, given)


def _numbers(given: Any, columns: tuple[str, ...]) -> Float[Array, "..."]:
    """The numbers of an array or list. Raises BadRows that names the first cell that is none."""
    given = given if isinstance(given, np.ndarray | list | tuple) else _listed(given)
    try:
        found = np.asarray(given)
    except ValueError:  # rows of unlike length
        found = np.empty(0, dtype=object)
    if found.dtype.kind in "biuf":
        return found.astype(float)
    for number, row in enumerate(given):
        cells = row if isinstance(row, np.ndarray | list | tuple) else [row]
        for place, cell in enumerate(cells):
            if isinstance(cell, str | bytes) or not np.isscalar(cell):
                what = columns[place] if place < len(columns) else f"column {place}"
                raise BadRows(f"row {number}: {what} {str(cell)[:60]!r} is no number; {FORMS}")
        if len(cells) < len(columns):
            raise BadRows(f"row {number} has {len(cells)} columns, not {', '.join(columns)}")
    if found.ndim == 1 and found.size:  # numbers as objects
        return np.asarray([float(cell) for cell in given])
    try:
        return np.asarray([[float(cell) for cell in row[: len(columns)]] for row in given])
    except (TypeError, ValueError, IndexError):
        raise BadRows(f"the tracker gave a {type(given).__name__} without rows: {FORMS}") from None


def _listed(given: Any) -> Any:
    """What has rows of some other kind (a tensor, a generator), as an array or a list."""
    return np.asarray(given) if hasattr(given, "__array__") else list(given)


def _require_pixels(boxes: Array, frame: Frame) -> None:
    """Raise BadRows for boxes that are no x_min, y_min, x_max, y_max in pixels."""
    if boxes.ndim != 2 or boxes.shape[1] != 4 or boxes.dtype.kind != "f" or len(boxes) == 0:
        return
    if (boxes >= 0.0).all() and (boxes <= 1.0).all() and boxes.any():
        raise BadRows(
            f"all coordinates of {len(boxes)} rows lie in 0..1 (row 0: {_words(boxes[0])}): "
            "normalised boxes? give pixels"
        )
    for low, high in ((0, 2), (1, 3)):
        bad = boxes[:, high] < boxes[:, low]
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise BadRows(
                f"{COLUMNS[high]} < {COLUMNS[low]} in {np.count_nonzero(bad)} of {len(boxes)} rows "
                f"(row {row}: {_words(boxes[row])}): {_layout(boxes, frame)}"
            )


def _words(box: Float[Array, " 4"]) -> str:
    return " ".join(f"{edge:.6g}" for edge in box)


def _layout(boxes: Float[Array, "n 4"], frame: Frame) -> str:
    """Which layout of boxes it may be instead: the one that fits the boxes that were given."""
    half = 0.5 * boxes[:, 2:]
    guesses = {
        "xywh": np.column_stack((boxes[:, :2], boxes[:, :2] + boxes[:, 2:])),
        "cxcywh": np.column_stack((boxes[:, :2] - half, boxes[:, :2] + half)),
    }
    fits = {name: _shared(guess, frame.found.boxes) for name, guess in guesses.items()}
    best = max(fits, key=lambda name: fits[name])
    if fits[best] >= MIN_SHARED:
        return f"{best}? give x_min y_min x_max y_max"
    return "xywh or cxcywh? give x_min y_min x_max y_max"


def _shared(boxes: Float[Array, "n 4"], given: Float[Array, "m 4"]) -> float:
    """The median over the boxes of the best IoU with one that was given."""
    if len(given) == 0:
        return 0.0
    low = np.maximum(boxes[:, None, :2], given[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], given[None, :, 2:])
    inside = np.prod(np.clip(high - low, 0.0, None), axis=2)
    areas = [
        np.prod(np.clip(each[:, 2:] - each[:, :2], 0.0, None), axis=1) for each in (boxes, given)
    ]
    union = areas[0][:, None] + areas[1][None, :] - inside
    return float(np.median((inside / np.maximum(union, 1e-9)).max(axis=1)))


__all__ = ["BadRows", "tracks_from"]
