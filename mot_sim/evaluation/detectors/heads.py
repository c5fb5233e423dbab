"""What networks give, as boxes: the heads of the usual families of detectors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.evaluation.detectors.networks import Outputs
from tracker.errors import BadWeights, UnknownName

# Coordinates that are nowhere above this are shares of the image, not pixels.
LARGEST_SHARE = 2.0
# The classes that are tracked here, by how many classes a data set has: COCO's 80, with a
# background 81, its 91 numbers, PASCAL VOC's 20 and 21.
NAMES_BY_COUNT: dict[int, dict[int, str]] = {
    80: {0: "person", 2: "car"},
    81: {1: "person", 3: "car"},
    91: {1: "person", 3: "car"},
    20: {14: "person", 6: "car"},
    21: {15: "person", 7: "car"},
}
COCO_80, COCO_91 = NAMES_BY_COUNT[80], NAMES_BY_COUNT[91]


@dataclass(frozen=True, eq=False)
class NetworkBoxes:
    """Boxes in the image that the network was given."""

    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max, px."""
    scores: Float[Array, " n"]
    """Probabilities."""
    labels: Int[Array, " n"]
    """Numbers of their classes."""
    names: Mapping[int, str]
    """Names of these numbers, as far as they are known."""
    is_suppressed: bool
    """Whether the network has dropped boxes that overlap others itself."""


Decode = Callable[[Outputs, tuple[int, int], Mapping[int, str]], NetworkBoxes | None]


@dataclass(frozen=True)
class Head:
    """What a family of detectors gives."""

    about: str
    """Its outputs, and whose they are; one line."""
    decode: Decode
    """Boxes of outputs, of the size of the image that the network was given (px), with names of
    classes as the file states them; None: these are no outputs of this family."""
    fit: str
    """How its images are brought to that size, a name of FITS."""


def of_yolo(
    outputs: Outputs, size: tuple[int, int], names: Mapping[int, str]
) -> NetworkBoxes | None:
    """Rows of x, y (centre), width, height, perhaps an objectness, a score a class."""
    if len(outputs) != 1:
        return None
    rows = _of_one_image(next(iter(outputs.values())))
    if rows.ndim != 2 or min(rows.shape) < 5:
        return None
    counts = {len(names)} if names else set(NAMES_BY_COUNT)
    may_be = [bool({side - 4, side - 5} & counts) for side in rows.shape]
    is_upright = rows.shape[0] < rows.shape[1] if may_be[0] == may_be[1] else may_be[0]
    if is_upright:  # v8 and later give a column a box
        rows = rows.T
    classes, count = rows.shape[1] - 4, len(names)
    if count and count not in (classes, classes - 1):
        return None
    with_objectness = count == classes - 1 if count else classes - 1 in NAMES_BY_COUNT
    scores = rows[:, 5:] * rows[:, 4:5] if with_objectness else rows[:, 4:]
    if scores.shape[1] == 0:
        return None
    centre, half = rows[:, :2], 0.5 * rows[:, 2:4]
    boxes = _pixels(np.concatenate((centre - half, centre + half), axis=1), size)
    known = names or NAMES_BY_COUNT.get(scores.shape[1], {})
    return _best(boxes, scores, known, is_suppressed=False)


def of_rows(
    outputs: Outputs, size: tuple[int, int], names: Mapping[int, str]
) -> NetworkBoxes | None:
    """Rows of x_min, y_min, x_max, y_max, score, class: what the network's own NMS leaves."""
    if len(outputs) != 1:
        return None
    rows = _of_one_image(next(iter(outputs.values())))
    if rows.ndim != 2 or rows.shape[1] not in (6, 7):
        return None
    if rows.shape[1] == 7:  # image, class, score, box: Caffe's DetectionOutput
        rows = rows[rows[:, 0] >= 0.0][:, [3, 4, 5, 6, 2, 1]]
        known = names or NAMES_BY_COUNT[21]
    else:
        known = names or COCO_80
    are_corners = bool((rows[:, 2:4] >= rows[:, :2]).all())
    if not (are_corners and _are_labels(rows[:, 5]) and _are_scores(rows[:, 4])):
        return None
    return NetworkBoxes(_pixels(rows[:, :4], size), rows[:, 4], rows[:, 5].astype(int), known, True)


def of_ssd(
    outputs: Outputs, size: tuple[int, int], names: Mapping[int, str]
) -> NetworkBoxes | None:
    """Arrays of boxes, of scores, and of classes where there is a score a box."""
    if outputs and all(array.size <= 1 for array in outputs.values()):  # perhaps a count of 0
        return NetworkBoxes(np.zeros((0, 4)), np.zeros(0), np.zeros(0, int), names or COCO_91, True)
    found = [name for name, array in outputs.items() if array.ndim > 1 and array.shape[-1] == 4]
    if not found:
        return None
    is_batch = outputs[found[0]].ndim == 3
    arrays = {
        name: array[0] if is_batch and array.ndim > 1 else array for name, array in outputs.items()
    }
    boxes = arrays.pop(found[0])
    if found[0] == "detection_boxes":  # TensorFlow's: y before x
        boxes = boxes[:, [1, 0, 3, 2]]
    boxes, count = _pixels(boxes, size), len(boxes)
    for scores in arrays.values():
        if scores.ndim == 2 and len(scores) == count:
            known = names or NAMES_BY_COUNT.get(scores.shape[1], {})
            return _best(boxes, scores, known, is_suppressed=False)
    columns = [each for each in arrays.values() if each.shape == (count,)]
    # classes are whole numbers, if need be those that are no scores
    labels = sorted(
        filter(_are_labels, columns), key=lambda each: (each.dtype.kind == "f", _are_scores(each))
    )
    scores_of = [each for each in columns if _are_scores(each) and labels and each is not labels[0]]
    if not scores_of:
        return None
    label = labels[0].astype(int)
    return NetworkBoxes(boxes, scores_of[0].astype(float), label, names or COCO_91, True)


HEADS: dict[str, Head] = {
    "yolo": Head("one output, rows or columns: box, (objectness,) a score a class; YOLOv3-v9, v11, "
                 "YOLOX with decoded boxes", of_yolo, "letterbox"),
    "rows": Head("one output, rows: corners, score, class; YOLOv10, exports with NMS, Caffe's SSD",
                 of_rows, "letterbox"),
    "ssd": Head("outputs boxes, scores, classes; or boxes, scores by class; torchvision, "
                "TensorFlow's detection models, SSD", of_ssd, "stretch"),
}  # fmt: skip


def boxes_of_outputs(
    outputs: Outputs, size: tuple[int, int], names: Mapping[int, str], head: str | None, what: str
) -> tuple[str, NetworkBoxes]:
    """The boxes of a network's outputs, and the head that they are of; None: the first that fits.

    what: the file, for messages. Raises UnknownName for heads that there are not, BadWeights where
    none fits.
    """
    if head is not None and head not in HEADS:
        raise UnknownName.of("head", head, HEADS)
    for name in [head] if head else ("rows", "yolo", "ssd"):
        found = HEADS[name].decode(outputs, size, names)
        if found is not None:
            return name, found
    shapes = ", ".join(f"{name} {list(array.shape)}" for name, array in outputs.items())
    known = f" with {len(names)} classes" if names else ""
    heads = "; ".join(f"{name}: {each.about}" for name, each in HEADS.items())
    raise BadWeights(
        f"{what}: its outputs ({shapes}){known} are not those of "
        f"{f'head {head}' if head else 'a detector known here'}. Known heads: {heads}"
    )


def _of_one_image(array: Shaped[Array, "..."]) -> Shaped[Array, "..."]:
    """A table, without the dimensions of a batch of one."""
    while array.ndim > 2 and array.shape[0] == 1:
        array = array[0]
    return array


def _pixels(boxes: Float[Array, "n 4"], size: tuple[int, int]) -> Float[Array, "n 4"]:
    """Boxes in pixels, of pixels or of shares of the image."""
    boxes = boxes.astype(float)
    are_shares = len(boxes) > 0 and np.abs(boxes).max() <= LARGEST_SHARE
    return boxes * np.tile(size, 2) if are_shares else boxes


def _best(
    boxes: Float[Array, "n 4"],
    scores: Float[Array, "n c"],
    names: Mapping[int, str],
    is_suppressed: bool,
) -> NetworkBoxes:
    """Each box with its likeliest class."""
    labels = scores.argmax(axis=1)
    best = scores[np.arange(len(scores)), labels].astype(float)
    return NetworkBoxes(boxes, best, labels, names, is_suppressed)


def _are_labels(column: Shaped[Array, " n"]) -> bool:
    """Whether these may be numbers of classes."""
    return bool((column >= 0).all() and (column == np.round(column)).all())


def _are_scores(column: Shaped[Array, " n"]) -> bool:
    """Whether these may be probabilities."""
    return bool(((column >= 0.0) & (column <= 1.0)).all())
