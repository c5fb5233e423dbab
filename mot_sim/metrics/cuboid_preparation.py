"""Which cuboids AB3DMOT counts, which it ignores, and every pair of a label and a result.

The rules are KITTI's of 2018 (see `devkit2018`), with cuboids in place of boxes: label height
plays no part, a result of kind Van is no false positive, DontCare is tested in the image.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.metrics.cuboid_overlap import Criterion, known_cuboids
from mot_sim.metrics.matching import Overlaps, bare_rows, numbered, same_frame_pairs
from mot_sim.metrics.preprocessing import (
    PreparedSequence,
    checked_columns,
    ignored_if_unmatched,
    kind_is,
    neutral_labels,
)
from tracker.errors import BadTracks
from tracker.types import Cuboids, Tracks

# What AB3DMOT takes for a result without a score.
NO_SCORE = -1.0


@dataclass(frozen=True, eq=False)
class PreparedCuboids:
    """Cars and vans of one sequence, or of several end to end, against the output."""

    truth: Tracks
    """The labels, in the order of frames, with their cuboids; ids are numbered from 0."""
    output: Tracks
    """The tracker's rows, likewise."""
    track_scores: Float[Array, " m"]
    """For each row of the output the mean score of its track."""
    neutral: Bool[Array, " n"]
    """Which labels need not be found, but may be: vans, strongly occluded, truncated."""
    ignored: Bool[Array, " m"]
    """Which rows of the output are no false positives when nothing matches them."""
    frame_count: int
    """Frames of all sequences."""
    sequence_count: int = 1
    """How many sequences stand end to end."""

    @property
    def cuboids(self) -> tuple[Cuboids, Cuboids]:
        """Those of the labels and of the output."""
        return require_cuboids(self.truth, "truth"), require_cuboids(self.output, "output")

    def overlaps(self, criterion: Criterion) -> Overlaps:
        """All pairs of one frame that are alike at all, with their similarity."""
        rows, columns = same_frame_pairs(self.truth.frames, self.output.frames)
        labels, found = self.cuboids
        alike = criterion.similarity(labels.select(rows), found.select(columns))
        touching = alike > 0.0
        return Overlaps(self.truth, self.output, rows[touching], columns[touching], alike[touching])


def require_cuboids(tracks: Tracks, where: str) -> Cuboids:
    """The cuboids of a table; BadTracks where there are none although there are rows."""
    if tracks.cuboids is None:
        if not len(tracks):
            return Cuboids.empty()
        raise BadTracks(
            f"{where}: {len(tracks)} rows, and none with a cuboid (h w l x y z rotation_y): "
            "3D scores need cuboids; score them in 2D, or write the cuboids"
        )
    return tracks.cuboids


def prepare_cuboids(truth: Tracks, output: Tracks, frame_count: int) -> PreparedCuboids:
    """The rows of one sequence that take part, checked.

    Of the truth: Car and Van; of the output: Car and Van, all rows where there are no kinds. Rows
    with a negative id belong to no object and are left out. Results that lack a cuboid (NaN)
    match nothing. Both are in one frame in which cars stand upright. Raises BadTracks as
    `prepare_sequence`, and for labels or results without cuboids.
    """
    truth, output = checked_columns(truth, "truth"), checked_columns(output, "output")
    is_van = kind_is(truth, "Van", False)
    labels = (kind_is(truth, "Car", True) | is_van) & (truth.ids >= 0)
    ours_van = kind_is(output, "Van", False)
    ours = (kind_is(output, "Car", True) | ours_van) & (output.ids >= 0)
    by_frame, ours_by_frame = _in_order(truth.frames, labels), _in_order(output.frames, ours)
    bare_truth = bare_rows(truth, labels, frame_count, "truth")
    bare_output = bare_rows(output, ours, frame_count, "output")
    picked, found = truth.select(by_frame), output.select(ours_by_frame)
    true_cuboids, cuboids = require_cuboids(picked, "truth"), require_cuboids(found, "output")
    _require_whole(picked, true_cuboids)
    if len(cuboids) and not np.isfinite(cuboids.base).any():
        require_cuboids(found.replaced(cuboids=None), "output")
    dont_care = bare_rows(truth, kind_is(truth, "DontCare", False), frame_count, "DontCare")
    neutral = neutral_labels(truth)[by_frame]
    in_image = PreparedSequence(Overlaps.between(bare_truth, bare_output), neutral, dont_care)
    return PreparedCuboids(
        numbered(bare_truth).replaced(cuboids=true_cuboids),
        numbered(bare_output).replaced(cuboids=cuboids),
        mean_scores(numbered(bare_output).ids, found.scores),
        neutral,
        ours_van[ours_by_frame] | ignored_if_unmatched(in_image, slack=0.0),
        frame_count,
    )


def mean_scores(ids: Int[Array, " n"], scores: Float[Array, " n"] | None) -> Float[Array, " n"]:
    """For each row the mean score of its id; ids are numbered from 0."""
    if scores is None:
        return np.full(len(ids), NO_SCORE)
    if not np.isfinite(scores).all():
        row = int(np.flatnonzero(~np.isfinite(scores))[0])
        raise BadTracks(f"output: score of row {row} is {scores[row]}; write a finite number")
    return (np.bincount(ids, scores) / np.bincount(ids))[ids]


def _in_order(frames: Int[Array, " n"], chosen: Bool[Array, " n"]) -> Int[Array, " k"]:
    rows = np.flatnonzero(chosen)
    return rows[np.argsort(frames[rows], kind="stable")]


def _require_whole(labels: Tracks, cuboids: Cuboids) -> None:
    """BadTracks for a label of a car or van that lacks its cuboid."""
    lacking = ~(known_cuboids(cuboids) & (cuboids.size > 0.0).all(axis=1))
    if lacking.any():
        row = int(np.flatnonzero(lacking)[0])
        raise BadTracks(
            f"truth: the label of id {labels.ids[row]} in frame {labels.frames[row]} has no "
            f"cuboid (size {cuboids.size[row].tolist()}); 3D scores need one for every Car and Van"
        )


def end_to_end(parts: Sequence[PreparedCuboids]) -> PreparedCuboids:
    """Several sequences as one: frames and ids of each follow those of the one before."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *(part.frame_count for part in parts)]).tolist()
    return PreparedCuboids(
        _joined([part.truth for part in parts], starts),
        _joined([part.output for part in parts], starts),
        np.concatenate([part.track_scores for part in parts]),
        np.concatenate([part.neutral for part in parts]),
        np.concatenate([part.ignored for part in parts]),
        starts[-1],
        sum(part.sequence_count for part in parts),
    )


def _joined(tables: Sequence[Tracks], starts: Sequence[int]) -> Tracks:
    """Tables whose ids are numbered from 0, one after the other."""
    firsts = np.cumsum([0, *(int(table.ids.max(initial=-1)) + 1 for table in tables)])
    moved = [
        table.replaced(frames=table.frames + start, ids=table.ids + first)
        for table, start, first in zip(tables, starts, firsts, strict=False)
    ]
    return Tracks.concatenate(moved)
