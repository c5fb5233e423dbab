"""Where tracks are believed to be, and where each is expected next: the search areas.

The tracks may come from any tracker: their boxes are lifted to the road and predicted as ours
are (Sharma et al., ICRA 2018, eqs. 2-4), but the association is given by their ids.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.datasets.recorded import RecordedSequence
from tracker import Tracker
from tracker.association import Hungarian
from tracker.costs import GatedPairs
from tracker.lifecycle import Lifecycle
from tracker.suppression import Suppression
from tracker.types import Camera, Cuboids, Detections, Rows, Tracks

MEMORY_SECONDS = 1.0  # for which a track without a box is still expected
MAX_ID_DIFFERENCE = 1e-6


@dataclass(frozen=True)
class SameTrack:
    """0 for the same id, else 1: ids stand in the place of descriptors."""

    def __call__(self, pairing: GatedPairs) -> Float[Array, " k"]:
        """The cost of every pair of the pairing."""
        rows, columns = pairing.pairs
        before, now = pairing.expected.embedding, pairing.detections.descriptor
        if before is None or now is None:
            return np.ones(len(rows))
        return (np.abs(before.descriptor[rows, 0] - now[columns, 0]) > MAX_ID_DIFFERENCE).astype(
            float
        )


@dataclass(frozen=True, eq=False)
class BelievedPlaces(Rows):
    """Where tracks are believed to be: one row per track, in the road frame of a frame."""

    ids: Int[Array, " n"]
    """Id of each track."""
    cuboids: Cuboids
    """Their cuboids, in the road frame."""
    cov: Float[Array, "n 2 2"]
    """Covariance of each base's (x, z), m^2; NaN: not stated."""
    heading_known: Float[Array, " n"] | None = None
    """Probability of each yaw, and not the other way round; NaN, None: the yaw is assumed."""


@dataclass(frozen=True, eq=False)
class ExpectedTracks:
    """Tracks of one frame: where they are, and where they were expected."""

    now: BelievedPlaces
    """Tracks with a box in the frame, where they are believed to be: as the tracks state it, or
    else on the road under their box."""
    expected: BelievedPlaces
    """Earlier tracks, where they were predicted to be in the frame."""
    regions: Cuboids
    """Cuboids of the expected tracks, stretched by the uncertainty."""
    areas: Float[Array, "k 4"]
    """A box in the image per expected track, px: only detections inside are compared with it."""


def following_tracker(camera: Camera, tracker: Tracker | None = None) -> Tracker:
    """A tracker that associates by ids, which its detections carry as descriptors.

    Beliefs, motion and search areas are those of `tracker`, by default our default one.
    """
    return replace(
        tracker or Tracker.default(camera),
        costs=((1.0, SameTrack()),),
        associate=Hungarian(max_cost=0.5),
        suppress=Suppression(max_iou=1.0),
        lifecycle=Lifecycle(max_gap=MEMORY_SECONDS),
        strong_score=0.0,
        tie_break=0.0,
        existence=None,
        box_filter=None,
        car_filter=None,
        explain=True,
    )


def expectations(
    drive: RecordedSequence, tracks: Tracks, tracker: Tracker | None = None
) -> Iterator[tuple[int, ExpectedTracks]]:
    """Frame by frame of the drive: its index, and where its tracks are and were expected."""
    following = following_tracker(drive.camera, tracker)
    for frame in replace(drive, images=None):
        rows = tracks.select(tracks.frames == frame.index)
        ids = rows.ids.astype(float)[:, None]
        seen = Detections(rows.boxes, np.ones(len(rows)), descriptor=ids)
        following.step(replace(frame, detections=seen))
        assert following.explanation is not None
        yield frame.index, _expected_tracks(following, following.explanation.pairing, rows)


def _expected_tracks(following: Tracker, pairing: GatedPairs, rows: Tracks) -> ExpectedTracks:
    population = following.state.tracks
    seen = population.select(population.time_since_update == 0.0)
    embedding = seen.beliefs.embedding
    ids = _ids(None if embedding is None else embedding.descriptor, len(seen))
    unsaid = np.full(len(seen), np.nan)
    lifted = BelievedPlaces(ids, seen.beliefs.cuboids, seen.beliefs.cov[:, :2, :2], unsaid)
    before = pairing.expected
    known = _ids(None if before.embedding is None else before.embedding.descriptor, len(before))
    # A box outside its own search area began its track anew, in a later row: the older belief is
    # out of date.
    _, from_the_end = np.unique(known[::-1], return_index=True)
    latest = len(known) - 1 - from_the_end
    expected = BelievedPlaces(known, before.cuboids, before.cov[:, :2, :2]).select(latest)
    regions = pairing.expected_regions.select(latest)
    return ExpectedTracks(_as_stated(lifted, rows), expected, regions, pairing.search_areas[latest])


def _as_stated(lifted: BelievedPlaces, rows: Tracks) -> BelievedPlaces:
    """The places with the cuboids that the tracks state in place of lifted boxes.

    A cuboid without a state has no covariance, and its heading is taken as it stands.
    """
    if rows.cuboids is None:
        return lifted
    row_of = {name: row for row, name in enumerate(rows.ids.tolist())}
    rows = rows.select([row_of[name] for name in lifted.ids.tolist()])
    cuboids, states = rows.cuboids, rows.estimates
    assert cuboids is not None
    known = np.isfinite(np.column_stack([cuboids.base, cuboids.yaw, cuboids.size])).all(axis=1)
    stated = BelievedPlaces(
        rows.ids,
        cuboids,
        np.full((len(rows), 2, 2), np.nan) if states is None else states.covs[:, :3:2, :3:2],
        np.ones(len(rows)) if states is None else states.heading_known,
    )
    return lifted.updated(known, stated.select(known))


def _ids(descriptor: Float[Array, "n d"] | None, count: int) -> Int[Array, " n"]:
    if descriptor is None:
        return np.zeros(count, np.int64)
    return np.rint(descriptor[:, 0]).astype(np.int64)
