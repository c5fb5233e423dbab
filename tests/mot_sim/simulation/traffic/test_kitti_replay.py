"""KITTI's labels re-enacted: the rig gives the labelled cuboids back."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.kitti import KittiSequence, kitti_sequence
from mot_sim.simulation.cars import VehicleSampler
from mot_sim.simulation.renderers import View, find_renderer
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.scenery import find_weather
from mot_sim.simulation.traffic import kitti_recording, kitti_replay
from tests.mot_sim.datasets.conftest import STEP, tiny_tree  # noqa: F401
from tracker.errors import BadConfig
from tracker.geometry import wrap_angle

RNG = np.random.default_rng(0)


def tiny(root: Path) -> KittiSequence:
    return kitti_sequence(root, "0030")


def assert_labels_come_back(sequence: KittiSequence) -> int:
    """Compare every labelled car of a sequence with what the rig sees; how many there were."""
    truth, rig, replay = sequence.truth, Rig(sequence.camera), kitti_replay(sequence)
    assert truth is not None
    assert truth.cuboids is not None
    assert truth.kinds is not None
    compared = 0
    for frame in range(len(sequence)):
        state = replay.reset(RNG) if frame == 0 else replay.step()
        rows = (truth.frames == frame) & np.isin(truth.kinds, ["Car", "Van"])
        labels = truth.select(np.flatnonzero(rows)[np.argsort(truth.ids[rows])])
        seen = rig.cuboids(state)
        assert state.ids.tolist() == labels.ids.tolist()
        assert labels.cuboids is not None
        np.testing.assert_allclose(seen.base[:, [0, 2]], labels.cuboids.base[:, [0, 2]], atol=1e-6)
        np.testing.assert_allclose(state.z, labels.cuboids.base[:, 1], atol=1e-6)
        np.testing.assert_allclose(wrap_angle(seen.yaw - labels.cuboids.yaw), 0.0, atol=1e-6)
        np.testing.assert_array_equal(seen.size, labels.cuboids.size)
        compared += len(state)
    return compared


def test_the_rig_gives_the_labels_back(tiny_tree: Path) -> None:  # noqa: F811
    assert assert_labels_come_back(tiny(tiny_tree)) == 2


def test_the_ego_car_drives_along_x_from_the_origin(tiny_tree: Path) -> None:  # noqa: F811
    recording = kitti_recording(tiny(tiny_tree))
    np.testing.assert_allclose(recording.ego[:, 0], [0.0, STEP, 2 * STEP], atol=1e-4)
    np.testing.assert_allclose(recording.ego[:, 1:], 0.0, atol=1e-6)
    assert recording.present[:, 0].tolist() == [True, False, True]


def test_speed_is_along_the_heading_and_nought_for_who_is_seen_once(
    tiny_tree: Path,  # noqa: F811
) -> None:
    sequence = tiny(tiny_tree)
    recording = kitti_recording(sequence)
    # From 20 m to 18.5 m before us in 0.2 s, while we drove 1.46 m.
    assert recording.speed[0, 0] == pytest.approx(
        (-1.5 + 2 * STEP) / 0.2 * np.cos(-1.55 + np.pi / 2), abs=0.02
    )
    assert sequence.truth is not None
    once = replace(sequence)
    object.__setattr__(once, "truth", sequence.truth.select(slice(0, 2)))
    assert kitti_recording(once).speed[0, 0] == 0.0


def test_a_sequence_that_cannot_be_replayed_is_told(tiny_tree: Path) -> None:  # noqa: F811
    sequence = tiny(tiny_tree)
    with pytest.raises(BadConfig, match="no labelled cuboids"):
        kitti_replay(replace(sequence, label_path=None))
    with pytest.raises(BadConfig, match="motion is unknown"):
        kitti_replay(replace(sequence, Ts_world_cam=None))
    with pytest.raises(BadConfig, match="needs all frames"):
        kitti_replay(sequence.subset([0, 2]))
    with pytest.raises(BadConfig, match="no labels of kinds Tram; it has Car"):
        kitti_replay(sequence, kinds=["Tram"])


@pytest.mark.kitti
@pytest.mark.parametrize("pitch", [0.0, 0.02])
def test_real_labels_come_back_to_a_micrometre(kitti_root: Path, pitch: float) -> None:
    assert assert_labels_come_back(kitti_sequence(kitti_root, "0004", pitch=pitch)) > 300


@pytest.mark.kitti
def test_a_real_drive_in_a_low_sun_is_drawn_without_a_warning(kitti_root: Path) -> None:
    sequence = kitti_sequence(kitti_root, "0000", detections=None)
    recording = kitti_recording(sequence)
    stage = SceneMeshes(VehicleSampler().sample(recording, 0), Rig(sequence.camera))
    light, raster = find_weather("low_sun").light, find_renderer("raster")
    for state in recording.states[80:110]:  # at frame 94 a shadow ends just before the camera
        view = View(sequence.camera, stage.instances(state), sun=light.sun(state.ego[2]))
        assert raster.render(view).image.any()
