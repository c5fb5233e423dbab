"""A KITTI sequence: its parts brought together."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets.kitti import KittiSequence, kitti_sequence
from tests.mot_sim.datasets.conftest import DETECTIONS, STEP, write
from tests.mot_sim.datasets.test_images import paint
from tracker.errors import BadConfig, BadFile, DatasetNotFound, UnknownName
from tracker.types import Sequence


def test_a_sequence_has_camera_frames_and_motion(tiny_tree: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030")
    assert isinstance(sequence, Sequence)
    assert isinstance(sequence, KittiSequence)
    assert sequence.name == "0030"
    assert sequence.frame_count == len(sequence) == 3
    assert sequence.camera.K.tolist() == [[100, 0, 50], [0, 100, 20], [0, 0, 1]]
    assert sequence.camera.image_size == (1242, 375)
    assert sequence.camera.height == pytest.approx(1.65)
    frames = list(sequence)
    assert [frame.time for frame in frames] == [0.0, 0.1, 0.2]
    assert [len(frame.detections) for frame in frames] == [1, 0, 2]
    assert frames[0].T_now_before is None
    for frame in frames[1:]:
        assert frame.T_now_before is not None
        assert frame.motion_cov is not None
        np.testing.assert_allclose(frame.T_now_before[:3, :3], np.eye(3), atol=1e-9)
        np.testing.assert_allclose(frame.T_now_before[:3, 3], [0, 0, -STEP], atol=1e-5)


def test_truth_stands_on_the_road_of_the_camera(tiny_tree: Path) -> None:
    truth = kitti_sequence(tiny_tree, "0030").truth
    assert truth is not None
    assert truth.cuboids is not None
    np.testing.assert_allclose(truth.cuboids.base[1], [1.06, 0.0, 20.0], atol=1e-9)


def test_height_and_pitch_reach_camera_and_truth(tiny_tree: Path) -> None:
    sequence = kitti_sequence(tiny_tree, "0030", height=1.5, pitch=0.1)
    assert sequence.camera.height == pytest.approx(1.5)
    assert sequence.camera.road_normal[2] == pytest.approx(-np.sin(0.1))
    assert sequence.truth is not None
    assert sequence.truth.cuboids is not None
    assert sequence.truth.cuboids.base[1, 1] == pytest.approx(
        1.65 * np.cos(0.1) - 20.0 * np.sin(0.1) - 1.5
    )


def test_a_subset_keeps_its_kind_and_its_truth(tiny_tree: Path) -> None:
    part = kitti_sequence(tiny_tree, "0030").subset([0, 2])
    assert isinstance(part, KittiSequence)
    assert part.truth is not None
    assert part.truth.frames.tolist() == [0, 0, 2]
    last = list(part)[-1]
    assert last.index == 2
    assert last.T_now_before is not None
    np.testing.assert_allclose(last.T_now_before[:3, 3], [0, 0, -2 * STEP], atol=1e-5)
    only_last = kitti_sequence(tiny_tree, "0030").subset([2]).truth
    assert only_last is not None
    assert only_last.frames.tolist() == [2]


def test_no_labels_is_no_truth(tiny_tree: Path) -> None:
    (tiny_tree / "training" / "label_02" / "0030.txt").unlink()
    assert kitti_sequence(tiny_tree, "0030").truth is None


def test_orbslam3_and_no_ego_motion_can_be_asked_for(tiny_tree: Path) -> None:
    frame = list(kitti_sequence(tiny_tree, "0030", ego="orbslam3"))[1]
    assert frame.T_now_before is not None
    np.testing.assert_allclose(frame.T_now_before[:3, 3], [0, 0, -0.75])
    assert all(
        frame.T_now_before is None and frame.motion_cov is None
        for frame in kitti_sequence(tiny_tree, "0030", ego="none")
    )


def test_images_are_loaded_only_when_asked_for(
    tiny_tree: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for number in (0, 2):
        paint(tiny_tree / "training/image_02/0030" / f"{number:06d}.png", (9, 0, 0), size=(200, 90))
    plain = kitti_sequence(tiny_tree, "0030")
    assert plain.camera.image_size == (200, 90)
    assert all(frame.image is None for frame in plain)
    assert caplog.text == ""
    frames = list(kitti_sequence(tiny_tree, "0030", images=True))
    assert "images for 2 of 3 frames only" in caplog.text
    assert [frame.image is not None for frame in frames] == [True, False, True]
    assert frames[0].image is not None
    assert frames[0].image.shape == (90, 200, 3)
    assert frames[0].image[0, 0].tolist() == [9, 0, 0]


def test_images_that_are_not_there_are_missed(tiny_tree: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"image_02/0030: no such folder"):
        kitti_sequence(tiny_tree, "0030", images=True)


def test_frames_are_counted_by_oxts_then_kittis_list_then_images_then_rows(
    tiny_tree: Path,
) -> None:
    training = tiny_tree / "training"
    (training / "oxts" / "0030.txt").unlink()
    assert kitti_sequence(tiny_tree, "0030", ego="none").frame_count == 3
    write(tiny_tree / "detections" / "rrc" / "0030.txt", "")
    assert kitti_sequence(tiny_tree, "0030", ego="none").frame_count == 3  # of the labels
    (training / "label_02" / "0030.txt").unlink()
    assert kitti_sequence(tiny_tree, "0030", ego="none").frame_count == 0
    paint(training / "image_02" / "0030" / "000006.png", (0, 0, 0))
    assert kitti_sequence(tiny_tree, "0030", ego="none").frame_count == 7
    (training / "calib" / "0030.txt").rename(training / "calib" / "0012.txt")
    write(tiny_tree / "detections" / "rrc" / "0012.txt", "")
    twelve = kitti_sequence(tiny_tree, "0012", ego="none")
    assert twelve.frame_count == 78
    assert twelve.camera.image_size == (1242, 375)
    (training / "calib" / "0012.txt").rename(training / "calib" / "0015.txt")
    write(tiny_tree / "detections" / "rrc" / "0015.txt", "")
    assert kitti_sequence(tiny_tree, "0015", ego="none").camera.image_size == (1224, 370)


def test_the_testing_split_has_its_own_detections_and_no_truth(tiny_tree: Path) -> None:
    (tiny_tree / "training").rename(tiny_tree / "testing")
    with pytest.raises(DatasetNotFound, match=r"rrc/testing/0030.txt: no detections"):
        kitti_sequence(tiny_tree, "0030", split="testing")
    write(tiny_tree / "detections" / "rrc" / "testing" / "0030.txt", DETECTIONS)
    sequence = kitti_sequence(tiny_tree, "0030", split="testing")
    assert len(sequence) == 3
    assert sequence.truth is None


def test_a_folder_or_file_of_ones_own_needs_its_format(tiny_tree: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    path = write(folder / "0030.txt", "1,-1,10,20,20,20,0.5,-1,-1,-1\n")
    with pytest.raises(BadConfig, match=r"mine: name their format too, --detection-format NAME"):
        kitti_sequence(tiny_tree, "0030", folder)
    for given in (folder, str(folder), path):
        sequence = kitti_sequence(tiny_tree, "0030", given, detection_format="motchallenge")
        assert next(iter(sequence)).detections.boxes.tolist() == [[10, 20, 30, 40]]
    beside = write(tiny_tree / "detections" / "mine" / "0030.txt", DETECTIONS)
    assert beside.is_file()
    sequence = kitti_sequence(tiny_tree, "0030", "mine", detection_format="rrc")
    assert len(sequence.log.frames) == 3


def test_names_that_nobody_knows_are_refused(tiny_tree: Path) -> None:
    with pytest.raises(UnknownName, match=r"unknown detector 'rcc'.*Did you mean 'rrc'"):
        kitti_sequence(tiny_tree, "0030", "rcc")
    with pytest.raises(UnknownName, match=r"unknown ego-motion 'oxt'.*Did you mean 'oxts'"):
        kitti_sequence(tiny_tree, "0030", ego="oxt")
    with pytest.raises(
        UnknownName, match=r"unknown detection format 'mot_challenge'.*Did you mean 'motchallenge'"
    ):
        kitti_sequence(tiny_tree, "0030", "rrc", detection_format="mot_challenge")


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("training/calib/0030.txt", r"calib/0030.txt: no sequence '0030'; sequences there: none"),
        ("training/oxts/0030.txt", r"oxts/0030.txt: no OXTS file; .* holds nothing; .* orbslam3"),
        ("detections/rrc/0030.txt", r"rrc/0030.txt: no detections; .* holds nothing"),
    ],
)
def test_missing_files_are_told_with_a_cure(tiny_tree: Path, path: str, message: str) -> None:
    (tiny_tree / path).unlink()
    with pytest.raises(DatasetNotFound, match=message):
        kitti_sequence(tiny_tree, "0030")


def test_a_missing_root_is_told_with_a_cure(tmp_path: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"set MOT_SIM_KITTI_ROOT or pass --root"):
        kitti_sequence(tmp_path / "nowhere", "0030")


def test_bad_boxes_can_be_dropped(tiny_tree: Path) -> None:
    write(tiny_tree / "detections" / "rrc" / "0030.txt", "0,40,10,40,30,0.9\n")
    with pytest.raises(BadFile, match=r"rrc/0030.txt:1: box without area"):
        kitti_sequence(tiny_tree, "0030")
    assert len(kitti_sequence(tiny_tree, "0030", bad_boxes="drop").log.frames) == 0
