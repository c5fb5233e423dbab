"""Which cuboids AB3DMOT counts, which it ignores, and every pair of a label and a result.

The rules are KITTI's of 2018 (see `devkit2018`), with cuboids in place of boxes: label height
plays no part, a result of kind Van is no false positive, DontCare is tested in the image.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

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
    match_cars,
    neutral_labels,
    of_class,
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
    meets_label: Bool[Array, " m"]
    """Which rows of the output match a label in the image, IoU of at least 1/2."""
    meets_neutral: Bool[Array, " m"]
    """Which of those match a neutral one."""
    frame_count: int
    """Frames of all sequences."""
    sequence_count: int = 1
    """How many sequences stand end to end."""

    def overlaps(self, criterion: Criterion) -> Overlaps:
        """All pairs of one frame that are alike at all, with their similarity."""
        if criterion.measure == "iou":  # whatever its threshold
            return self._by_volume
        return self._alike(criterion)

    @cached_property
    def _by_volume(self) -> Overlaps:
        """The pairs that share some volume, with their 3D IoU: polygons are slow."""
        return self._alike(Criterion("iou", 0.5))

    def _alike(self, criterion: Criterion) -> Overlaps:
        rows, columns = same_frame_pairs(self.truth.frames, self.output.frames)
        labels = require_cuboids(self.truth, "truth").select(rows)
        alike = criterion.similarity(labels, require_cuboids(self.output, "output").select(columns))
        near = alike > 0.0
        return Overlaps(self.truth, self.output, rows[near], columns[near], alike[near])

    def lenient(self) -> "PreparedCuboids":
        """The same, where what matches a neutral label in the image is no false positive either."""
        return replace(self, ignored=self.ignored | self.meets_neutral)

    def scored_in_image(self, overlaps: Overlaps) -> Overlaps:
        """Of overlaps in 3D the rows that TrackEval scores in 2D: see `scored_rows`."""
        leaves = np.where(self.meets_label, self.meets_neutral, self.ignored)
        return overlaps.keep(~self.neutral, ~leaves)


def require_cuboids(tracks: Tracks, where: str) -> Cuboids:
    """The cuboids of a table; BadTracks where there are none although there are rows."""
    cuboids = tracks.cuboids
    if cuboids is None and not len(tracks):
        return Cuboids.empty()
    if cuboids is None or (len(tracks) and not np.isfinite(cuboids.base).any()):
        raise BadTracks(
            f"{where}: {len(tracks)} rows, and none with a cuboid (h w l x y z rotation_y): "
            "3D scores need cuboids; score them in 2D, or write the cuboids"
        )
    return cuboids


def prepare_cuboids(
    truth: Tracks, output: Tracks, frame_count: int, kind: str = "Car"
) -> PreparedCuboids:
    """The rows of one sequence that take part, checked.

    kind: the class that is scored. Of truth and output: it, and the classes that look like it (Van
    where cars are scored); all rows where there are no kinds. Rows with a negative id belong to no
    object and are left out. Results that lack a cuboid (NaN) match nothing. Both are in one frame
    in which cars stand upright. Raises as `prepare_sequence`, and BadTracks for labels or results
    without cuboids.
    """
    truth, output = checked_columns(truth, "truth"), checked_columns(output, "output")
    labels, ours = rows_of_class(truth, kind), rows_of_class(output, kind)
    bare_truth = bare_rows(truth, of_class(truth, kind), frame_count, "truth")
    bare_output = bare_rows(output, of_class(output, kind), frame_count, "output")
    picked, found = truth.select(labels), output.select(ours)
    true_cuboids, cuboids = require_cuboids(picked, "truth"), require_cuboids(found, "output")
    _require_whole(picked, true_cuboids)
    dont_care = bare_rows(truth, kind_is(truth, "DontCare", False), frame_count, "DontCare")
    neutral = neutral_labels(truth, kind)[labels]
    in_image = PreparedSequence(Overlaps.between(bare_truth, bare_output), neutral, dont_care)
    pairs = match_cars(in_image.overlaps)
    meets = np.full(len(ours), -1)
    meets[in_image.overlaps.columns[pairs]] = neutral[in_image.overlaps.rows[pairs]]
    bare_output = numbered(bare_output)
    return PreparedCuboids(
        truth=numbered(bare_truth).replaced(cuboids=true_cuboids),
        output=bare_output.replaced(cuboids=cuboids),
        track_scores=mean_scores(bare_output.ids, found.scores),
        neutral=neutral,
        ignored=~kind_is(found, kind, True) | ignored_if_unmatched(in_image, slack=0.0),
        meets_label=meets >= 0,
        meets_neutral=meets > 0,
        frame_count=frame_count,
    )


def rows_of_class(tracks: Tracks, kind: str, with_similar: bool = True) -> Int[Array, " k"]:
    """The rows that `of_class` picks, in the order of frames."""
    rows = np.flatnonzero(of_class(tracks, kind, with_similar))
    return rows[np.argsort(tracks.frames[rows], kind="stable")]


def mean_scores(ids: Int[Array, " n"], scores: Float[Array, " n"] | None) -> Float[Array, " n"]:
    """For each row the mean score of its id; ids are numbered from 0."""
    if scores is None:
        return np.full(len(ids), NO_SCORE)
    if not np.isfinite(scores).all():
        row = int(np.flatnonzero(~np.isfinite(scores))[0])
        raise BadTracks(f"output: score of row {row} is {scores[row]}; write a finite number")
    return (np.bincount(ids, scores) / np.bincount(ids))[ids]


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
        np.concatenate([part.meets_label for part in parts]),
        np.concatenate([part.meets_neutral for part in parts]),
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
