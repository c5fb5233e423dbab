"""The rows that are put out equal those of plain NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import Bool
from numpy import ndarray as Array

from tests.tracker.kernels.plain_existence import plain_written
from tests.tracker.kernels.plain_renewal import same_values
from tests.tracker.kernels.test_tracks import cameras, counts, seeds, some_tracks
from tracker import output_rows
from tracker.existence import ExistenceFilter
from tracker.kernels import load
from tracker.lifecycle import ActiveTracks, in_view
from tracker.output_rows import NO_GAPS, Gaps, rows_of
from tracker.types import Camera, CarEstimates, Tracks


class EveryOther(ExistenceFilter):
    """A filter of one's own."""

    def written(self, tracks: ActiveTracks, since_look: float = 0.0) -> Bool[Array, " n"]:
        return tracks.ids % 2 == 0


def plain_rows(
    frame: int,
    tracks: ActiveTracks,
    existence: ExistenceFilter | None,
    gaps: Gaps,
    since_look: float,
    camera: Camera,
) -> Tracks:
    """The rows, by the operations of tables."""
    missed, scores, boxes = np.isnan(tracks.scores), tracks.scores, tracks.beliefs.boxes
    written = tracks.time_since_update <= since_look if since_look > 0.0 else ~missed
    if existence is not None:
        scores = np.where(missed, tracks.existence, scores)
        written = plain_written(existence, tracks, since_look)
        if type(existence) is EveryOther:
            written = existence.written(tracks)
    unseen, likely, chosen = gaps
    if len(unseen):
        scores = scores.copy()
        scores[unseen], written[unseen] = likely, chosen
    if since_look > 0.0:
        written = written & in_view(tracks.beliefs, camera)
    boxes = np.where(missed[:, None], camera.clip_boxes(boxes), boxes)
    frames = np.full(len(tracks), frame)
    cuboids = tracks.beliefs.cuboids
    return Tracks(frames, tracks.ids, boxes, scores, cuboids=cuboids).select(written)


@pytest.mark.parametrize("filters", [None, ExistenceFilter(), EveryOther()])
@given(
    seed=seeds,
    count=counts,
    camera=cameras,
    since_look=st.sampled_from([0.0, 0.1]),
    has_gaps=st.booleans(),
)
def test_the_rows_of_a_frame(filters, seed, count, camera, since_look, has_gaps) -> None:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    tracks, gaps = some_tracks(rng, count, 0.1), NO_GAPS
    missed = rng.random(count) < 0.5
    tracks = tracks.replaced(scores=np.where(missed, np.nan, tracks.scores))
    if has_gaps and filters is not None:
        k = np.count_nonzero(missed)
        gaps = missed, rng.random(k), rng.random(k) < 0.5
    decided = filters, gaps, since_look
    expected = plain_rows(7, tracks, *decided, camera)
    rows = rows_of(7, tracks, *decided, tracks.beliefs.cuboids, None, camera)
    same_values(rows, expected)
    rows.cuboids.base[:], rows.boxes[:] = -1.0, -1.0  # the caller's own
    states = replace(CarEstimates.unknown(count), heading_known=np.arange(count) * 1.0)
    again = rows_of(7, tracks, *decided, tracks.beliefs.cuboids, states, camera)
    same_values(replace(again, estimates=None), expected)
    at = np.searchsorted(tracks.ids, expected.ids)
    np.testing.assert_array_equal(again.estimates.heading_known, at)


def test_the_kernel_numbers_what_decides_as_its_caller_does() -> None:
    writing = load("tracker.kernels.writing")
    for name in ("GIVEN", "LIKELY", "DETECTED"):
        assert getattr(writing, name) == getattr(output_rows, name)
