"""Cues of an episode stand in the columns that the tracker's costs read."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.episode import Episode, record
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.sensors import Detector, Sightings, find_profile
from tracker import Tracker
from tracker.costs import COSTS
from tracker.errors import MissingCue, UnknownName
from tracker.geometry import wrap_angle
from tracker.types import Tracks

BARE = {"houses": 0.0, "trees": 0.0, "furniture": 0.0, "frames": 12}


@pytest.fixture(scope="module")
def episode() -> Episode:
    return record(find_scene("gauntlet", profile="cues", **BARE), 2)


def test_every_cue_has_its_column(episode) -> None:
    seen = episode.log.detections
    assert seen.yaw is not None
    assert seen.shape is not None
    assert seen.keypoints is not None
    assert seen.descriptor is not None
    assert seen.size is not None
    assert seen.keypoints.shape == (len(seen), 36, 3)
    assert seen.shape.shape == (len(seen), 5)


def test_shapes_are_those_of_the_cast_with_noise(episode) -> None:
    exact = Detector("cues", cues=0.0)(
        episode.exact, 2, episode.camera, len(episode), episode.vehicles
    )
    rows = episode.vehicles.rows(episode.exact.tracks.ids[episode.exact.pixels > 0])
    np.testing.assert_array_equal(exact.detections.shape, episode.vehicles.coefficients[rows])
    noisy = episode.log.detections.shape
    assert noisy is not None
    assert 0.01 < np.abs(noisy - exact.detections.shape).mean() < 1.0


def test_the_stated_doubt_is_that_of_the_profile(episode) -> None:
    seen = episode.log.detections
    assert seen.pose_cov is not None
    exact = Detector("cues", cues=0.0)(
        episode.exact, 2, episode.camera, len(episode), episode.vehicles
    )
    exact_shape, covs = exact.detections.shape, exact.detections.pose_cov
    assert exact_shape is not None
    assert covs is not None
    np.testing.assert_array_equal(covs, 0.0)
    stds = np.sqrt(seen.pose_cov[:, np.arange(6), np.arange(6)])
    off = wrap_angle(seen.yaw - exact.detections.yaw) / stds[:, 0]
    straight = np.abs(off) < 8.0  # the others were seen the wrong way round
    assert straight.mean() > 0.85
    assert 0.6 < np.std(off[straight]) < 1.4  # errors last 1.6 s: few are independent
    claimed = find_profile("cues").shape.stated  # which is less than the fit's true error
    np.testing.assert_allclose(stds[:, 1:], claimed)
    assert 1.0 < np.std((seen.shape - exact_shape) / stds[:, 1:]) < 3.0


def test_a_second_box_of_a_car_shows_the_same_car(episode) -> None:
    effects = replace(find_profile("cues"), duplicates=find_profile("subcnn").duplicates)
    sights = Sightings.from_truth(episode.exact, episode.vehicles)
    sensed = Detector(effects).sense(sights, 2, episode.camera)
    seen, origin = sensed.log.detections, sensed.provenance
    seconds = np.flatnonzero(origin.sources == "duplicate")
    compared = 0
    for row in seconds:
        same = (origin.sources == "object") & (origin.ids == origin.ids[row])
        here = np.flatnonzero(same & (sensed.log.frames == sensed.log.frames[row]))
        for first in here:  # none where the car itself was missed
            np.testing.assert_array_equal(seen.descriptor[row], seen.descriptor[first])
            np.testing.assert_array_equal(seen.shape[row], seen.shape[first])
            compared += 1
    assert compared > 0


def test_the_shape_and_pose_cost_reads_them(episode) -> None:
    costs = ((0.3, COSTS["shape_pose"]()), (0.7, COSTS["image_overlap"](0.1)))
    tracker = Tracker.default(episode.camera, costs=costs)
    tracks = Tracks.concatenate([tracker.step(frame) for frame in episode])
    assert len(tracks) > 0.8 * len(episode.log.detections)
    plain = record(find_scene("gauntlet", **BARE), 2)
    tracker = Tracker.default(plain.camera, costs=costs)
    frames = list(plain)
    tracker.step(frames[0])
    with pytest.raises(MissingCue):
        tracker.step(frames[1])


def test_an_unknown_profile_gets_a_hint() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'pointrcnn'"):
        find_scene("gauntlet", profile="pointrcn")
