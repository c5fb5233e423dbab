"""Whole drives side by side give the rows of one tracker per drive; who cannot is left alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from tracker import TRACKERS, Camera, Detections, Frame, Tracker, Tracks
from tracker.batch import follows_together, prepare_frames, track_drives
from tracker.costs import GatedPairs, ImageOverlap, ShapeAndPose

SCENE = "street"


@pytest.fixture(scope="module")
def street() -> tuple[Camera, list[Frame]]:
    """A camera and what comes from it."""
    episode = record(find_scene(SCENE, frames=14), 0)
    return episode.camera, list(episode)


def seen(frame: Frame, seed: int, share: float) -> Frame:
    """A frame with a share of its boxes, in another order, each moved a bit, on its own numbers."""
    rng, found = np.random.default_rng((seed, frame.index)), frame.found
    rows = rng.permutation(len(found))[: int(np.ceil(share * len(found)))]
    boxes = found.boxes[rows] + rng.normal(0.0, 1.0, (len(rows), 1))
    return replace(frame, detections=Detections(boxes, rng.uniform(0.2, 1.0, len(rows))))


@settings(max_examples=12)
@given(
    name=st.sampled_from(sorted(TRACKERS)),
    drives=st.lists(
        st.tuples(st.integers(0, 9), st.integers(0, 14), st.floats(0.0, 1.0)),
        min_size=1,
        max_size=5,
    ),
)
def test_drives_give_what_each_gives_alone(
    street: tuple[Camera, list[Frame]], name: str, drives: list[tuple[int, int, float]]
) -> None:
    camera, recorded = street
    given = [[seen(each, seed, share) for each in recorded[:n]] for seed, n, share in drives]
    tracker = TRACKERS[name](camera)
    prepared = [prepare_frames(tracker, frames, SCENE) for frames in given]
    together = track_drives(tracker, prepared, [[each.index for each in one] for one in given])
    for rows, frames in zip(together, given, strict=True):
        one = TRACKERS[name](camera)
        alone = Tracks.concatenate([Tracks.empty(), *(one.step(frame) for frame in frames)])
        for column in ("frames", "ids", "boxes", "scores"):
            mine, theirs = getattr(rows, column), getattr(alone, column)
            np.testing.assert_array_equal(mine, theirs, err_msg=column, strict=True)


def test_trackers_that_may_look_at_other_pairs_are_left_alone(
    street: tuple[Camera, list[Frame]],
) -> None:
    class Mine(ImageOverlap):
        """A cost of the user's."""

        def __call__(self, pairing: GatedPairs) -> np.ndarray:
            return super().__call__(pairing)

    class MyTracker(Tracker):
        """A tracker of the user's."""

    camera, _ = street
    default = Tracker.default(camera)
    assert follows_together(default)
    assert follows_together(Tracker.paper(camera))
    assert not follows_together(replace(default, costs=((1.0, Mine()),)))
    assert not follows_together(Tracker.default(camera, ((1.0, ShapeAndPose()),)))
    assert not follows_together(replace(default, explain=True))
    assert not follows_together(MyTracker.default(camera))
    assert not follows_together(object())
