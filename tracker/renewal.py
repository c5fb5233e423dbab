"""The tracks after a frame: those detected in it, those that live on without, those that begin."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.beliefs import Beliefs
from tracker.box_filter import LIMITS as GAIN_LIMITS
from tracker.box_filter import BoxFilter, Gains
from tracker.car_filter import CarStates
from tracker.dynamics import ConstantPosition, ConstantVelocity, Dynamics
from tracker.existence import LIMITS as EXISTENCE_LIMITS
from tracker.existence import (
    DetectorStatistics,
    ExistenceFilter,
    ExistenceUpdate,
    leaving_border,
)
from tracker.kernels import Kernel
from tracker.lifecycle import (
    MAX_CONSECUTIVE_STEPS,
    ActiveTracks,
    Lifecycle,
    Partners,
    seen_from,
)
from tracker.types import Camera, Cuboids, Detections
from tracker.types.embedding import Embedding
from tracker.types.rows import Rows
from tracker.types.shape_pose import ShapePose

STEP_TRACKS = Kernel("tracker.kernels.renewing", "step_tracks")
RENEW_CARS = Kernel("tracker.kernels.renewing", "renew_cars")
Cue = TypeVar("Cue", ShapePose, Embedding)
Picked = TypeVar("Picked", bound=Rows)
# What kernels take where a filter is left out.
NO_EXISTENCE, NO_BOX_FILTER = ExistenceFilter(), BoxFilter()
NO_GAINS = NO_BOX_FILTER.start()
# The dynamics, filters of boxes and of existence, and lives that one kernel knows; classes made of
# them are asked themselves.
OUR_PARTS = (
    (ConstantVelocity, ConstantPosition),
    (type(None), BoxFilter),
    (type(None), ExistenceFilter),
    (Lifecycle,),
)
Updated = tuple[ActiveTracks, Gains | None]


class Renewed(NamedTuple):
    """The tracks after a frame, where they come from, and what was learned in it."""

    tracks: ActiveTracks
    """Those before it that go on, then the new ones; without cars. Their order is the old one, or
    that of the match where all were detected."""
    places: Int[Array, " n"]
    """The row of each, counted through the tracks before, the detected ones, all detections."""
    detector: DetectorStatistics
    """What is known of the detector."""
    gains: Gains | None
    """What is known of the noise of boxes."""

    def cars(self, before: CarStates, updated: CarStates, begun: CarStates) -> CarStates:
        """The cars behind the tracks. begun: of those that begin, in order; the others by rows."""
        if len(self.places) == len(updated) and len(before) == len(updated) and not len(begun):
            return updated
        count, states, hypotheses = len(self.places), before.covs.shape[3], before.means.shape[1]
        means, covs = (count, hypotheses, states), (count, hypotheses, states, states)
        out = np.empty(means), np.empty(covs), np.empty((count, hypotheses))
        given = [(part.means, part.covs, part.log_weights) for part in (before, updated, begun)]
        RENEW_CARS(self.places, *given[0], *given[1], *given[2], *out)
        return CarStates(*out)


class Renewal(NamedTuple):
    """How tracks are renewed by the detections of a frame."""

    dynamics: Dynamics
    """How places follow detections."""
    box_filter: BoxFilter | None
    """How boxes do; None: new boxes are taken as they are."""
    existence: ExistenceFilter | None
    """How probable tracks are then; None: detections are objects."""
    lifecycle: Lifecycle
    """When tracks begin and end."""
    camera: Camera
    """The camera of the drive."""
    update: Callable[..., Updated] | None = None
    """What updates the detected tracks, called as `updated`, which None stands for."""

    def __call__(
        self,
        tracks: ActiveTracks,
        partners: Partners,
        observed: Beliefs,
        found: Detections,
        learned: tuple[DetectorStatistics, Gains | None],
        dt: float,
        next_id: int,
    ) -> Renewed:
        """The tracks after a frame; tracks: as predicted for it.

        observed: all detections, lifted. learned: before the frame. dt: seconds since the last
        one. next_id: of the first track that begins. Parts of one's own are asked; for ours one
        kernel does all, by the kernels that the parts have.
        """
        given = tracks, partners, observed, found, learned, dt, next_id
        parts = [type(part) for part in self[:4]]
        is_ours = all(part in ours for part, ours in zip(parts, OUR_PARTS, strict=True))
        if is_ours and self.update is None:
            return self.at_once(*given)
        return self.by_parts(*given)

    def at_once(
        self,
        tracks: ActiveTracks,
        partners: Partners,
        observed: Beliefs,
        found: Detections,
        learned: tuple[DetectorStatistics, Gains | None],
        dt: float,
        next_id: int,
    ) -> Renewed:
        """`by_parts` for our own dynamics, in one kernel."""
        rows, columns, missed, born = partners
        detector, gains = learned
        judge, smooth = self.existence or NO_EXISTENCE, self.box_filter or NO_BOX_FILTER
        if gains is None:
            gains = NO_GAINS if smooth is NO_BOX_FILTER else smooth.start()
        counts = np.empty(4, np.int64)
        after = Gains(np.empty((3, 4)), np.empty((3, 1)), np.empty((3, 4)))
        moves, judges = type(self.dynamics) is ConstantVelocity, self.existence is not None
        one_step, right = MAX_CONSECUTIVE_STEPS * dt, leaving_border(self.camera)
        of_existence = np.array(detector), judge._settings, dt, one_step, EXISTENCE_LIMITS, right
        of_boxes = smooth.size_limits, smooth.border, smooth.prior, GAIN_LIMITS
        before = tracks.time_since_update, tracks.hits, tracks.existence, tracks.innovations
        out = _Columns.empty(len(tracks) + len(born))
        count = STEP_TRACKS(
            rows, columns, missed, born, found.scores, tracks.ids, *_columns(tracks.beliefs),
            *before, *_columns(observed), moves, judges, self.box_filter is not None,
            *of_existence, *gains, *of_boxes, next_id, *self._limits, *out, counts, *after,
        )  # fmt: skip
        expected, counted = tracks.beliefs, (len(tracks), len(rows), len(observed))
        poses = _parts(expected.shape_pose, observed.shape_pose, partners)
        looks = _parts(expected.embedding, observed.embedding, partners)
        renewed = out.tracks(count, poses, looks, counted, columns)
        if self.box_filter is None:
            return Renewed(*renewed, DetectorStatistics(*counts.tolist()), learned[1])
        for array in after:
            array.setflags(write=False)
        return Renewed(*renewed, DetectorStatistics(*counts.tolist()), after)

    def by_parts(
        self,
        tracks: ActiveTracks,
        partners: Partners,
        observed: Beliefs,
        found: Detections,
        learned: tuple[DetectorStatistics, Gains | None],
        dt: float,
        next_id: int,
    ) -> Renewed:
        """The same, part after part, so that any part can be asked."""
        rows, columns, missed, born = partners
        scores, (n, k) = found.scores, (len(tracks), len(rows))
        existence = ExistenceUpdate.certain(tracks, partners, learned[0])
        if self.existence is not None:
            given = learned[0], tracks, partners, found, dt
            existence = self.existence(*given, self.camera)
        update, before = self.update or self.updated, tracks.replaced(cars=None)
        detected = picked(before, rows), picked(observed, columns), scores[columns]
        now, gains = update(*detected, existence.tracks[rows], dt, learned[1])
        places = n + np.arange(k)
        if len(missed):
            now = before.replaced(existence=existence.tracks).updated(rows, now)
            places = np.arange(n)
            places[rows] = n + np.arange(k)
            alive = self.lifecycle.are_alive(now, self.camera).nonzero()[0]
            now, places = picked(now, alive), places[alive]
        if len(born):
            new = ActiveTracks.born(observed.take(born), scores[born], existence.born, next_id)
            now = ActiveTracks.concatenate((now, new))
            places = np.concatenate((places, n + k + born))
        return Renewed(now, places, existence.detector, gains)

    def updated(
        self,
        matched: ActiveTracks,
        observed: Beliefs,
        scores: Float[Array, " k"],
        existence: Float[Array, " k"],
        dt: float,
        gains: Gains | None,
    ) -> Updated:
        """See `Tracker.update_tracks`."""
        beliefs, innovations, gains = self.beliefs_after(matched, observed, dt, gains)
        return matched.seen_again(beliefs, scores, existence, innovations), gains

    def beliefs_after(
        self, matched: ActiveTracks, observed: Beliefs, dt: float, gains: Gains | None
    ) -> tuple[Beliefs, Float[Array, "k 4"], Gains | None]:
        """What these tracks are after these detections, row by row, and their innovations.

        And what was learned of the noise of boxes; see `ActiveTracks` for innovations.
        """
        updated, innovations = self.dynamics.update(matched.beliefs, observed), matched.innovations
        if self.box_filter is None:
            return updated, innovations, gains
        known = self.box_filter.start() if gains is None else gains
        boxes, innovations, gains = self.box_filter(known, matched, updated.boxes, dt, self.camera)
        return updated.replaced(boxes=boxes), innovations, gains

    @property
    def _limits(self) -> tuple[float, Float[Array, "4"], Float[Array, "4"], float]:
        """The longest gap, and what tells who is in view."""
        return self.lifecycle.longest_gap, *seen_from(self.camera)


class _Columns(NamedTuple):
    """The columns of tracks that a kernel writes, in its order."""

    ids: Int[Array, " n"]
    base: Float[Array, "n 3"]
    yaw: Float[Array, " n"]
    size: Float[Array, "n 3"]
    velocity: Float[Array, "n 2"]
    cov: Float[Array, "n 4 4"]
    boxes: Float[Array, "n 4"]
    since: Float[Array, " n"]
    hits: Int[Array, " n"]
    existence: Float[Array, " n"]
    innovations: Float[Array, "n 4"]
    scores: Float[Array, " n"]
    places: Int[Array, " n"]

    @classmethod
    def empty(cls, n: int) -> "_Columns":
        """Room for so many rows."""
        ids, hits, places = np.empty((3, n), np.int64)
        yaw, since, existence, scores = np.empty((4, n))
        (base, size), (boxes, innovations) = np.empty((2, n, 3)), np.empty((2, n, 4))
        velocity, cov = np.empty((n, 2)), np.empty((n, 4, 4))
        moments = since, hits, existence, innovations, scores, places
        return cls(ids, base, yaw, size, velocity, cov, boxes, *moments)

    def tracks(
        self,
        count: int,
        poses: tuple[ShapePose | None, ShapePose | None, ShapePose | None],
        looks: tuple[Embedding | None, Embedding | None, Embedding | None],
        counts: tuple[int, int, int],
        columns: Int[Array, " k"] | None,
    ) -> tuple[ActiveTracks, Int[Array, " n"]]:
        """The first so many rows as tracks, and their places.

        poses, looks: of the tracks before, the detected ones, all detections; counts: of those.
        The detected ones' may be left out where they are those of the detections in `columns`.
        """
        if count < len(self.ids):
            first = _Columns(*[each[:count] for each in self])
            return first.tracks(count, poses, looks, counts, columns)
        where = counts, self.places, columns
        cues = _cue(poses, *where), _cue(looks, *where)
        cuboids = Cuboids(self.base, self.yaw, self.size)
        beliefs = Beliefs(cuboids, self.velocity, self.cov, self.boxes, *cues)
        moments = self.since, self.hits, self.existence, self.innovations, self.scores
        return ActiveTracks(self.ids, beliefs, *moments), self.places


def _latest(before: Cue | None, observed: Cue | None, partners: Partners) -> Cue | None:
    """A cue of tracks that were detected: now where it was measured, else before."""
    old = None if before is None else before.take(partners.rows)
    return old if observed is None else observed.take(partners.columns).filled_from(old)


def _parts(
    before: Cue | None, observed: Cue | None, partners: Partners
) -> tuple[Cue | None, Cue | None, Cue | None]:
    """A cue of the tracks before, of the detected ones, and of all detections, as `_cue` has it."""
    if before is not None and observed is not None and observed.is_complete:
        return before, None, observed
    return before, _latest(before, observed, partners), observed


def _cue(
    parts: tuple[Cue | None, Cue | None, Cue | None],
    counts: tuple[int, int, int],
    places: Int[Array, " n"],
    columns: Int[Array, " k"] | None,
) -> Cue | None:
    """The rows of a cue in these places of all parts; NaN where a part lacks it.

    None where no part has it that has rows in the result. With `columns` the second part may be
    left out where the others are there: it is then the third one's rows in these.
    """
    before, detected, observed = parts
    n, k, m = counts
    if columns is not None and before is not None and detected is None and observed is not None:
        rows = np.concatenate((np.arange(n), n + columns, np.arange(n, n + m)))[places]
        if k == n:
            return observed.take(rows - n)
        return type(before).concatenate((before, observed)).take(rows)
    if before is detected is observed is None:
        return None
    old = int(np.count_nonzero(places < n + k))
    goes_on = old > 0 or not len(places)
    used = goes_on and k < n, goes_on, old < len(places)
    having = [part if is_used else None for part, is_used in zip(parts, used, strict=True)]
    known = next((part for part in having if part is not None), None)
    if known is None:
        return None
    each = [
        known.unknown(count) if part is None else part
        for part, count, is_used in zip(having, counts, used, strict=True)
        if is_used
    ]
    skipped = 0 if used[0] else n if used[1] else n + k
    return type(known).concatenate(each).take(places - skipped if skipped else places)


def picked(table: Picked, rows: Int[Array, " k"]) -> Picked:
    """The table's rows in this order; itself where those are all, in order."""
    if len(rows) == len(table) and rows.tolist() == list(range(len(rows))):
        return table
    return table.take(rows)


def _columns(beliefs: Beliefs) -> tuple[Array, ...]:
    """The columns that every belief has."""
    cuboids = beliefs.cuboids
    place = cuboids.base, cuboids.yaw, cuboids.size
    return *place, beliefs.velocity, beliefs.cov, beliefs.boxes
