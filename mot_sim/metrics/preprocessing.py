"""Which rows KITTI counts, and which it neither rewards nor punishes.

The rules are those of KITTI's 2D tracking benchmark for the classes Car and Pedestrian (Geiger et
al., CVPR 2012), as TrackEval 1.3.0 (Luiten et al., IJCV 2021) applies them; label height plays no
part. Cyclist, which KITTI does not score, goes by the same rules.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.matching import (
    EPSILON,
    Overlaps,
    bare_rows,
    corners,
    match,
    same_frame_pairs,
    whole_numbers,
)
from tracker.errors import BadTracks, UnknownName
from tracker.geometry import box_area, box_intersection
from tracker.types import KITTI_KINDS, TRACKED_KINDS, Tracks, is_kitti_kind, spelled_as_kitti

MIN_OVERLAP = 0.5  # intersection over union of a match
MAX_OCCLUSION_LEVEL = 2  # KITTI's levels: 0 visible, 1 partly, 2 largely occluded, 3 unknown
MAX_TRUNCATION_LEVEL = 0
MIN_HEIGHT_PIXELS = 25.0  # pixels; an unmatched box this high or lower is ignored
MAX_DONT_CARE_SHARE = 0.5  # part of an unmatched box inside one DontCare region


@dataclass(frozen=True, eq=False)
class PreparedSequence:
    """All that takes part in scoring one class in one sequence: labels against the output."""

    overlaps: Overlaps
    """The labels, the output, and the pairs of both that overlap."""
    neutral: Bool[Array, " n"]
    """Which labels need not be found, but may be: of a similar class (vans, where cars are
    scored), strongly occluded, truncated."""
    dont_care: Tracks
    """Regions that are not labelled."""


def prepare_sequence(
    truth: Tracks, output: Tracks, frame_count: int, kind: str = "Car"
) -> PreparedSequence:
    """The rows that take part, checked, with all their overlaps.

    kind: the class that is scored, of TRACKED_KINDS. Of the truth: it, and the classes that look
    like it; without a column `kinds` all are of it; without `truncation` or `occlusion` nothing is
    truncated or occluded. Of the output: all but other kinds. Kinds are compared without case, as
    in TrackEval. Rows with a negative id belong to no object and are left out, as in both reference
    evaluators. Raises UnknownName for the kind, BadTracks as `checked_columns` and `bare_rows` do.
    """
    if kind not in TRACKED_KINDS:
        raise UnknownName.of("class", kind, TRACKED_KINDS)
    truth, output = checked_columns(truth, "truth"), checked_columns(output, "output")
    labels, scored = of_class(truth, kind), of_class(output, kind, with_similar=False)
    neutral = neutral_labels(truth, kind)
    in_order = np.argsort(truth.frames[labels], kind="stable")
    return PreparedSequence(
        Overlaps.between(
            bare_rows(truth, labels, frame_count, "truth"),
            bare_rows(output, scored, frame_count, "output"),
        ),
        neutral[labels][in_order],
        bare_rows(truth, kind_is(truth, "DontCare", False), frame_count, "DontCare"),
    )


def of_class(tracks: Tracks, kind: str, with_similar: bool = True) -> Bool[Array, " n"]:
    """Which rows are of a class, and perhaps of those that look like it.

    Without kinds all rows are of it; rows with a negative id are of no object.
    """
    chosen = kind_is(tracks, kind, True)
    for similar in TRACKED_KINDS[kind] if with_similar else ():
        chosen = chosen | kind_is(tracks, similar, False)
    return chosen & (tracks.ids >= 0)


def neutral_labels(truth: Tracks, kind: str = "Car") -> Bool[Array, " n"]:
    """Which labels need not be found, but may be: similar classes, strongly occluded, truncated."""
    neutral = np.zeros(len(truth), dtype=bool)
    for similar in TRACKED_KINDS[kind]:
        neutral |= kind_is(truth, similar, False)
    if truth.occlusion is not None:
        neutral = neutral | (truth.occlusion > MAX_OCCLUSION_LEVEL)
    if truth.truncation is not None:
        neutral = neutral | (truth.truncation > MAX_TRUNCATION_LEVEL)
    return neutral


def checked_columns(tracks: Tracks, where: str) -> Tracks:
    """The same rows with frames and ids as integers, boxes as floats, kinds in KITTI's spelling.

    Numbers may be of any type. Raises BadTracks for frames and ids that are not whole, for boxes
    that are not four numbers a row, and for a kind that is no class of KITTI.
    """
    tracks = tracks.replaced(
        frames=whole_numbers(tracks.frames, "frame", where),
        ids=whole_numbers(tracks.ids, "id", where),
        boxes=corners(tracks.boxes, where),
    )
    if tracks.kinds is None or not len(tracks):
        return tracks
    kinds = spelled_as_kitti(tracks.kinds)
    strange = ~is_kitti_kind(kinds)
    if strange.any():
        row = int(np.flatnonzero(strange)[0])
        raise BadTracks(
            f"{where}: kind {str(kinds[row])!r} of row {row} is no class of KITTI: write one of "
            f"{', '.join(KITTI_KINDS)} (case does not matter), or leave kinds out: all are cars"
        )
    return tracks.replaced(kinds=kinds)


def kind_is(tracks: Tracks, kind: str, without_kinds: bool) -> Bool[Array, " n"]:
    """Where rows are of a kind; `without_kinds` everywhere when there is no such column."""
    if tracks.kinds is None:
        return np.full(len(tracks), without_kinds)
    kinds = spelled_as_kitti(tracks.kinds)
    return np.asarray(kinds == kind, dtype=bool).reshape(len(tracks))


def ignored_if_unmatched(prepared: PreparedSequence, slack: float) -> Bool[Array, " m"]:
    """Output boxes that are no false positives when nothing matches them.

    They are too low, or lie in a DontCare region by more than the allowed part plus `slack`.
    """
    output = prepared.overlaps.output
    low = output.boxes[:, 3] - output.boxes[:, 1] <= MIN_HEIGHT_PIXELS
    return low | in_dont_care(output.frames, output.boxes, prepared.dont_care, slack)


def in_dont_care(
    frames: Int[Array, " m"], boxes: Float[Array, "m 4"], regions: Tracks, slack: float
) -> Bool[Array, " m"]:
    """Boxes of which more than the allowed part plus `slack` lies in a region of their frame.

    The regions are in the order of frames.
    """
    inside = np.zeros(len(boxes), bool)
    rows, columns = same_frame_pairs(frames, regions.frames)
    shared = box_intersection(boxes[rows], regions.boxes[columns])
    area = box_area(boxes[rows])
    covered = (area > EPSILON) & (shared > 0.0)
    much = shared[covered] / area[covered] > MAX_DONT_CARE_SHARE + slack
    inside[rows[covered][much]] = True
    return inside


def scored_rows(prepared: PreparedSequence) -> Overlaps:
    """What TrackEval scores: neutral labels, what matches them and what is ignored are gone.

    Labels and output are matched first (most overlap, at least MIN_OVERLAP a pair). Output that
    matches a neutral label leaves with it; unmatched output may be ignored.
    """
    return prepared.overlaps.keep(~prepared.neutral, counted_output(prepared))


def counted_output(prepared: PreparedSequence) -> Bool[Array, " m"]:
    """Which rows of the output `scored_rows` keeps."""
    overlaps = prepared.overlaps
    matched = match_cars(overlaps)
    leaves = ignored_if_unmatched(prepared, EPSILON)
    leaves[overlaps.columns[matched]] = prepared.neutral[overlaps.rows[matched]]
    return ~leaves


def match_cars(overlaps: Overlaps) -> Int[Array, " j"]:
    """The pairs of the matching with the most overlap, at least MIN_OVERLAP each."""
    near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
    return match(overlaps, near, overlaps.iou[near])
