"""A recorded run of a scene."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.episode import Episode, Scene, record, record_scene_traffic
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.sensors import Detector
from mot_sim.simulation.traffic import Route, Script, Scripted
from tracker.errors import BadConfig
from tracker.geometry import invert, transform
from tracker.types import Sequence


def _traffic(models: object) -> Scripted:
    """We turn right behind a car that goes straight on."""
    ego = Script(Route([(0.0, 0.0), (8.0, 0.0), (8.0, 60.0)]), [(0.0, 6.0)])
    return Scripted([Script(Route([(15.0, 0.0), (99.0, 0.0)]), [(0.0, 6.0)])], ego)


SCENE = Scene("turn", _traffic, frame_count=15)


@pytest.fixture(scope="module")
def episode() -> Episode:
    return record(SCENE, seed=2)


def test_an_episode_is_a_sequence_like_any_other(episode) -> None:
    assert isinstance(episode, Sequence)
    frames = list(episode)
    assert [frame.index for frame in frames] == list(range(15))
    assert [frame.time for frame in frames] == pytest.approx([0.1 * i for i in range(15)])
    assert frames[0].T_now_before is None
    assert all(frame.image is None for frame in frames)


def test_motion_moves_a_standing_point_while_we_turn(episode) -> None:
    rig, point_world = SCENE.rig, np.array([[12.0, 1.0, -1.0]])
    seen = [transform(invert(rig.T_world_cam(w.ego)), point_world) for w in episode.traffic_states]
    turned = episode.traffic_states[-1].ego[2] - episode.traffic_states[0].ego[2]
    assert turned > 0.3
    for frame in list(episode)[1:]:
        assert frame.T_now_before is not None
        moved = transform(frame.T_now_before, seen[frame.index - 1])
        np.testing.assert_allclose(moved, seen[frame.index], atol=1e-9)


def test_truth_is_that_of_the_delivered_frames(episode) -> None:
    assert episode.truth.frames.tolist() == episode.exact.tracks.frames.tolist()
    assert set(episode.subset([3, 4]).truth.frames.tolist()) == {3, 4}


def test_the_same_seed_gives_the_same_bits_and_another_seed_other_ones(episode) -> None:
    again, other = record(SCENE, seed=2), record(SCENE, seed=3)
    boxes = episode.log.detections.boxes
    assert again.log.detections.boxes.tobytes() == boxes.tobytes()
    assert again.log.detections.scores.tobytes() == episode.log.detections.scores.tobytes()
    assert other.log.detections.boxes.tobytes() != boxes.tobytes()


def test_noise_leaves_the_truth_as_it_is(episode) -> None:
    noisy = record(replace(SCENE, detector=Detector(jitter=3.0)), seed=9)
    assert noisy.truth.boxes.tobytes() == episode.truth.boxes.tobytes()


def test_the_rig_is_the_scenes(episode) -> None:
    high = record(replace(SCENE, rig=Rig.kitti(height=2.5)))
    assert high.camera.height == pytest.approx(2.5)
    assert (high.truth.boxes[:, 3] > episode.truth.boxes[:, 3])[:5].all()


def test_traffic_that_was_recorded_before_gives_the_same_episode(episode) -> None:
    again = record(SCENE, 2, record_scene_traffic(SCENE, 2))
    assert again.truth.boxes.tobytes() == episode.truth.boxes.tobytes()
    assert again.log.detections.boxes.tobytes() == episode.log.detections.boxes.tobytes()


def test_a_shorter_run_is_the_beginning_of_a_longer_one(episode) -> None:
    short = record(replace(SCENE, frame_count=6), seed=2)
    first = episode.log.frames < 6
    assert short.log.detections.boxes.tobytes() == episode.log.detections.boxes[first].tobytes()
    first = episode.truth.frames < 6
    assert short.truth.boxes.tobytes() == episode.truth.boxes[first].tobytes()


def test_cast_events_and_occlusions_are_at_hand(episode) -> None:
    assert episode.vehicles.ids.tolist() == [0]
    assert "enter" in episode.events.kinds.tolist()
    assert len(episode.occlusions) == 0


def test_a_scene_without_frames_is_refused() -> None:
    with pytest.raises(BadConfig, match="0 frames"):
        Scene("none", _traffic, frame_count=0)


def test_traffic_that_is_driven_ahead_tells_how_far_it_is() -> None:
    told: list[int] = []
    one = record_scene_traffic(find_scene("street", frames=6), 0, told.append)
    assert told == [1, 2, 3, 4, 5, 6]
    other = record_scene_traffic(find_scene("street", frames=6), 0)
    assert one.checksum == other.checksum
    record_scene_traffic(find_scene("crossing", frames=6), 0, told.append)  # is not driven ahead
    assert len(told) == 6
