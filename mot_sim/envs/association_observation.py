"""What the association environment shows of the tracks, the detections and their pairs."""

from typing import Any

import numpy as np
from gymnasium import spaces
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.envs.observations import Observation, pad
from tracker import CostMatrix
from tracker.batch import BatchCosts
from tracker.geometry import box_iou
from tracker.types import Camera

BOX_LIMITS = (-1.0, 2.0)  # sides of the image: one image's size outside it on each side
MAX_GAP_SECONDS = 3.0  # without a detection; the default tracker's tracks end after that
HALF_HITS = 5.0  # detections so far that `hits` shows as 0.5
PAIR_FEATURES = ("affinity", "overlap", "detection_rank", "track_rank")


def association_space(max_tracks: int, max_detections: int) -> spaces.Space[Any]:
    """The space of `observe_association`."""
    t, d = max_tracks, max_detections
    return spaces.Dict(
        {
            "costs": spaces.Box(0.0, 1.0, (t, d), np.float64),
            "possible": spaces.MultiBinary((t, d)),
            "pairs": spaces.Box(0.0, 1.0, (t, d, len(PAIR_FEATURES)), np.float32),
            "tracks": spaces.MultiBinary(t),
            "track_boxes": spaces.Box(*BOX_LIMITS, (t, 4), np.float32),
            "ages": spaces.Box(0.0, 1.0, (t, 2), np.float32),
            "detections": spaces.MultiBinary(d),
            "boxes": spaces.Box(*BOX_LIMITS, (d, 4), np.float32),
            "scores": spaces.Box(0.0, 1.0, (d,), np.float64),
        }
    )


def observe_association(
    compared: CostMatrix | None,
    slots: Int[Array, " n"],
    camera: Camera,
    max_tracks: int,
    max_detections: int,
) -> Observation:
    """Padded arrays of a frame; compared: None after the last one. slots: of its tracks.

    costs: the tracker's, clipped to [0, 1], 1 where not `possible` (inside the search areas).
    pairs: features of a pair that do not depend on how slots and rows are ordered, all 0 where
    the pair is not possible: 1 - cost, IoU of the predicted and the new box, and 1 / (1 + rank)
    of the detection among those of the track and of the track among those of the detection, by
    cost. track_boxes (predicted), boxes: in image sides. ages: hits / (hits + 5), and seconds
    without a detection over 3, at most 1.
    """
    t, d = max_tracks, max_detections
    costs, pairs = np.full((t, d), np.inf), np.zeros((t, d, len(PAIR_FEATURES)), np.float32)
    track_boxes, ages = np.zeros((t, 4), np.float32), np.zeros((t, 2), np.float32)
    taken, boxes, scores = np.zeros(t, np.int8), np.zeros((0, 4)), np.zeros(0)
    if compared is not None:
        tracks, detections = compared.tracks, compared.detections
        boxes, scores, m = detections.boxes, detections.scores, len(detections)
        costs[slots, :m] = compared.costs
        pairs[slots, :m] = pair_features(compared.costs, tracks.beliefs.boxes, boxes)
        track_boxes[slots] = in_image_sides(tracks.beliefs.boxes, camera)
        ages[slots, 0] = tracks.hits / (tracks.hits + HALF_HITS)
        ages[slots, 1] = np.minimum(tracks.time_since_update / MAX_GAP_SECONDS, 1.0)
        taken[slots] = 1
    return {
        "costs": costs.clip(0.0, 1.0),
        "possible": np.isfinite(costs).astype(np.int8),
        "pairs": pairs,
        "tracks": taken,
        "track_boxes": track_boxes,
        "ages": ages,
        "detections": pad(np.ones(len(boxes), np.int8), d),
        "boxes": pad(in_image_sides(boxes, camera), d),
        "scores": pad(scores.clip(0.0, 1.0), d),
    }


def pair_features(
    costs: Float[Array, "n m"], predicted: Float[Array, "n 4"], boxes: Float[Array, "m 4"]
) -> Float[Array, "n m f"]:
    """PAIR_FEATURES of every pair, 0 where the cost is infinite."""
    possible = np.isfinite(costs)
    affinity = 1.0 - costs.clip(0.0, 1.0)
    overlap = np.nan_to_num(box_iou(predicted[:, None], boxes[None]))
    features = (affinity, overlap, closeness(costs), closeness(costs.T).T)
    return np.where(possible[:, :, None], np.stack(features, axis=2), 0.0).astype(np.float32)


def closeness(costs: Float[Array, "n m"]) -> Float[Array, "n m"]:
    """1 / (1 + how many entries of the same row are smaller)."""
    smaller = costs[:, None, :] < costs[:, :, None]
    return 1.0 / (1.0 + np.count_nonzero(smaller, axis=2))


def in_image_sides(boxes: Float[Array, "n 4"], camera: Camera) -> Float[Array, "n 4"]:
    """Boxes with the image's width and height for units, clipped to BOX_LIMITS."""
    width, height = camera.image_size
    return (boxes / (width, height, width, height)).clip(*BOX_LIMITS).astype(np.float32)


def observe_batch(
    compared: BatchCosts,
    slots: Int[Array, " n"],
    camera: Camera,
    max_tracks: int,
    max_detections: int,
) -> Observation:
    """`observe_association` of every drive, as arrays with one row per drive.

    slots: of all tracks.
    """
    e, t, d = len(compared.starts) - 1, max_tracks, max_detections
    tracks, detections = compared.tracks, compared.detections
    costs, pairs = np.ones((e, t, d)), np.zeros((e, t, d, len(PAIR_FEATURES)), np.float32)
    possible = np.zeros((e, t, d), np.int8)
    track_boxes, ages = np.zeros((e, t, 4), np.float32), np.zeros((e, t, 2), np.float32)
    taken, there = np.zeros((e, t), np.int8), np.zeros((e, d), np.int8)
    boxes, scores = np.zeros((e, d, 4), np.float32), np.zeros((e, d))
    is_finite = np.isfinite(compared.costs)
    rows, columns = (which[is_finite] for which in compared.pairs)
    of_track, of_found = compared.track_drives, compared.detection_drives
    places = np.arange(len(of_found)) - compared.columns[of_found]
    cells = of_track[rows], slots[rows], places[columns]
    found = compared.costs[is_finite]
    costs[cells], possible[cells] = found.clip(0.0, 1.0), 1
    overlap = np.nan_to_num(box_iou(tracks.beliefs.boxes[rows], detections.boxes[columns]))
    ranks = closeness_of_pairs(rows, found), closeness_of_pairs(columns, found)
    pairs[cells] = np.stack((1.0 - found.clip(0.0, 1.0), overlap, *ranks), axis=1)
    mine = of_track, slots
    track_boxes[mine] = in_image_sides(tracks.beliefs.boxes, camera)
    ages[(*mine, 0)] = tracks.hits / (tracks.hits + HALF_HITS)
    ages[(*mine, 1)] = np.minimum(tracks.time_since_update / MAX_GAP_SECONDS, 1.0)
    taken[mine] = 1
    theirs = of_found, places
    boxes[theirs] = in_image_sides(detections.boxes, camera)
    scores[theirs], there[theirs] = detections.scores.clip(0.0, 1.0), 1
    return {
        "costs": costs,
        "possible": possible,
        "pairs": pairs,
        "tracks": taken,
        "track_boxes": track_boxes,
        "ages": ages,
        "detections": there,
        "boxes": boxes,
        "scores": scores,
    }


def closeness_of_pairs(lines: Int[Array, " k"], costs: Float[Array, " k"]) -> Float[Array, " k"]:
    """1 / (1 + how many pairs of the same line cost less)."""
    order = np.lexsort((costs, lines))
    line, cost = lines[order], costs[order]
    steps = np.arange(len(order))
    is_first = np.ones(len(order), bool)
    is_first[1:] = line[1:] != line[:-1]
    is_dearer = is_first.copy()
    is_dearer[1:] |= cost[1:] != cost[:-1]
    rank = np.maximum.accumulate(np.where(is_dearer, steps, 0))
    rank -= np.maximum.accumulate(np.where(is_first, steps, 0))
    closeness = np.empty(len(order))
    closeness[order] = 1.0 / (1.0 + rank)
    return closeness
