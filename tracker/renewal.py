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
from tracker.dynamics import OUR_DYNAMICS, ConstantVelocity, Dynamics
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
from tracker.types import Camera, Detections
from tracker.types.embedding import Embedding
from tracker.types.packed import Packed, read_only
from tracker.types.rows import Rows
from tracker.types.shape_pose import ShapePose

STEP_TRACKS = Kernel("tracker.kernels.renewing", "step_tracks")
RENEW_CARS = Kernel("tracker.kernels.renewing", "renew_cars")
Cue = TypeVar("Cue", ShapePose, Embedding)
Picked = TypeVar("Picked", bound=Rows)
# What kernels take where a filter is left out.
NO_EXISTENCE, NO_BOX_FILTER = ExistenceFilter(), BoxFilter()
NO_GAINS = NO_BOX_FILTER.start()
Updated = tuple[ActiveTracks, Gains | None]


class Renewed(NamedTuple):
    """The tracks after a frame, where they come from, and what was learned in it."""

    tracks: ActiveTracks
    """Those before it that go on, then the new ones; without cars, and never modified. Their order
    is the old one, or that of the match where all were detected."""
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
        return self.at_once(*given) if self._is_ours else self.by_parts(*given)

    @property
    def _is_ours(self) -> bool:
        """Whether one kernel knows all parts; classes made of ours are asked themselves."""
        is_known = type(self.dynamics) in OUR_DYNAMICS and type(self.lifecycle) is Lifecycle
        is_known = is_known and (self.box_filter is None or type(self.box_filter) is BoxFilter)
        judge = self.existence
        is_known = is_known and (judge is None or type(judge) is ExistenceFilter)
        return is_known and self.update is None

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
        (n, floats, ints), (m, seen, _) = tracks.packed, observed.packed
        rows, columns, missed, born = partners
        judge, smooth, most = self.existence, self.box_filter, n + len(born)
        now, whole, gains = np.empty(36 * most), np.empty(3 * most + 4, np.int64), np.empty(27)
        one_step, right = MAX_CONSECUTIVE_STEPS * dt, leaving_border(self.camera)
        count = STEP_TRACKS(
            rows, columns, missed, born, found.scores, floats, ints, n, seen, m,
            type(self.dynamics) is ConstantVelocity, judge is not None, smooth is not None,
            *learned[0], (judge or NO_EXISTENCE).settings, dt, one_step, EXISTENCE_LIMITS, right,
            *(learned[1] or self._no_gains), *(smooth or NO_BOX_FILTER).settings, GAIN_LIMITS,
            next_id, self.lifecycle.longest_gap, *seen_from(self.camera), now, whole, gains,
        )  # fmt: skip
        packed, places = Packed(count, read_only(now), read_only(whole)), whole[2 * count :]
        before, where = tracks.beliefs, (n, partners, m, places[:count])
        cues = {
            "shape_pose": _cue_after(before.shape_pose, observed.shape_pose, *where),
            "embedding": _cue_after(before.embedding, observed.embedding, *where),
        }
        beliefs = Beliefs.of_packed(packed, **cues)
        return Renewed(
            ActiveTracks.of_packed(packed, beliefs=beliefs, cars=None),
            places[:count],
            DetectorStatistics(*whole[-4:].tolist()),
            learned[1] if smooth is None else Gains.cut(read_only(gains)),
        )

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
        return Renewed(now.locked(), places, existence.detector, gains)

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
    def _no_gains(self) -> Gains:
        """What a kernel takes where nothing is learned yet."""
        return NO_GAINS if self.box_filter is None else self.box_filter.start()


def _cue_after(
    before: Cue | None,
    observed: Cue | None,
    n: int,
    partners: Partners,
    m: int,
    places: Int[Array, " r"],
) -> Cue | None:
    """A cue of the tracks after a frame; a detected track keeps it where it was not measured.

    before: of the n tracks before; observed: of the m detections. places: as `Renewed` has them.
    None where no part has it that has rows in the result.
    """
    k = len(partners.rows)
    if before is None and observed is None:
        return None
    if before is not None and observed is not None and observed.is_complete:
        rows = np.concatenate((np.arange(n), n + partners.columns, np.arange(n, n + m)))[places]
        if k == n:
            return observed.take(rows - n).locked()
        return type(before).concatenate((before, observed)).take(rows).locked()
    detected = None if before is None else before.take(partners.rows)
    if observed is not None:
        detected = observed.take(partners.columns).filled_from(detected)
    old = int(np.count_nonzero(places < n + k))
    goes_on = old > 0 or not len(places)
    used = goes_on and k < n, goes_on, old < len(places)
    parts, counts = (before, detected, observed), (n, k, m)
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
    rows = places - skipped if skipped else places
    return type(known).concatenate(each).take(rows).locked()


def picked(table: Picked, rows: Int[Array, " k"]) -> Picked:
    """The table's rows in this order; itself where those are all, in order."""
    if len(rows) == len(table) and rows.tolist() == list(range(len(rows))):
        return table
    return table.take(rows)
