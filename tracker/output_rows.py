"""The rows that are put out for the tracks of a frame."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from tracker.existence import ExistenceFilter
from tracker.kernels import Kernel
from tracker.lifecycle import ActiveTracks, seen_from
from tracker.types import Camera, CarEstimates, Cuboids, Tracks
from tracker.types.packed import NO_INTS, Packed

WRITE_ROWS = Kernel("tracker.kernels.writing", "write_rows")
# What decides in the kernel which tracks are put out, as it numbers them.
GIVEN, LIKELY, DETECTED = 0, 1, 2
# Tracks of which `GapRows` decides: which, with which probability each of them, which of them are
# put out; of none.
Gaps = tuple[Bool[Array, " #n"], Float[Array, " k"], Bool[Array, " k"]]
NO_GAPS: Gaps = np.zeros(0, bool), np.zeros(0), np.zeros(0, bool)


def rows_of(
    frame: int,
    tracks: ActiveTracks,
    existence: ExistenceFilter | None,
    gaps: Gaps,
    since_look: float,
    cuboids: Cuboids,
    estimates: CarEstimates | None,
    camera: Camera,
) -> Tracks:
    """The rows of the tracks that are put out, in arrays of their own; see `Tracker.step`.

    frame: its number. existence: what decides of tracks; of those in gaps others do. since_look:
    seconds since a detector looked; 0: it did at this frame, else only what is in view is put out.
    cuboids, estimates: of all tracks, as rows state them.
    """
    n, floats, ints = tracks.packed
    rule, lifetime, threshold, written = DETECTED, 1.0, 0.0, np.empty(n, bool)
    if existence is not None:
        rule, lifetime, threshold = LIKELY, existence.prediction_lifetime, existence.threshold
        if type(existence).written is not ExistenceFilter.written:
            rule, written = GIVEN, np.array(existence.written(tracks, since_look), bool)
    numbers, whole = np.empty(12 * n), np.empty(2 * n, np.int64)
    count = WRITE_ROWS(
        floats, ints, n, since_look, rule, lifetime, threshold, *gaps, *seen_from(camera), frame,
        cuboids.packed.floats, written, numbers, whole,
    )  # fmt: skip
    if estimates is not None:
        is_all = count == n
        estimates = estimates.copied() if is_all else estimates.take(written.nonzero()[0])
    return Tracks(
        whole[:count],
        whole[count : 2 * count],
        numbers[: 4 * count].reshape(count, 4),
        numbers[4 * count : 5 * count],
        cuboids=Cuboids.of_packed(Packed(count, numbers[5 * count :], NO_INTS)),
        estimates=estimates,
    )
