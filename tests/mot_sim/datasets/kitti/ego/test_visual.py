"""Ego-motion that is seen in the images of a KITTI tree."""

import logging
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.__main__ import main
from mot_sim.datasets import kitti_sequence
from mot_sim.datasets.kitti import Calibration, write_calibration
from mot_sim.datasets.recorded import RecordedSequence
from tests.mot_sim.datasets.conftest import write
from tests.tracker.ego.corridor import CAMERA, STRAIGHT, K, filmed, misses
from tracker import Frame
from tracker.errors import BadCalibration, BadFile, DatasetNotFound
from tracker.geometry import invert

NAME = "0040"


@pytest.fixture
def street_tree(tmp_path: Path) -> Path:
    """The root of a tree with nine images of the street, one box, and no OXTS."""
    write_calibration(Calibration(K), write(tmp_path / "training/calib" / f"{NAME}.txt", ""))
    write(tmp_path / "detections/rrc" / f"{NAME}.txt", "2,250,80,300,110,9.5\n")
    for number, image in enumerate(filmed(STRAIGHT)[0]):
        show(tmp_path, number, image)
    return tmp_path


def show(root: Path, number: int, image: np.ndarray, name: str = NAME) -> Path:
    """The path of a frame's image, written."""
    path = root / "training/image_02" / name / f"{number:06d}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(cv2.imencode(".png", image)[1].tobytes())
    return path


def frames(root: Path) -> list[Frame]:
    return list(kitti_sequence(root, NAME, ego="visual"))


def test_the_motion_is_seen_in_the_images(street_tree: Path) -> None:
    drive = kitti_sequence(street_tree, NAME, ego="visual")
    assert drive.camera.image_size == CAMERA.image_size
    seen = list(drive)
    assert len(seen) == 9
    assert seen[0].T_now_before is seen[0].motion_cov is None
    for frame, truth in zip(seen[1:], filmed(STRAIGHT)[1], strict=True):
        assert frame.image is None  # nobody asked for them
        assert frame.T_now_before is not None
        assert frame.motion_cov is not None
        rotation, direction, length = misses(frame.T_now_before, truth)
        assert rotation < 0.06
        assert direction < 1.5
        assert abs(length) < 0.05


def test_with_images_and_without_a_thread_the_motion_is_the_same(street_tree: Path) -> None:
    drive = kitti_sequence(street_tree, NAME, ego="visual", images=True)
    assert drive.motion is not None
    plain = replace(drive, motion=replace(drive.motion, threaded=False))
    for one, other in list(zip(drive, plain, strict=True))[1:]:
        assert one.image is not None
        assert one.T_now_before is not None
        assert other.T_now_before is not None
        assert one.T_now_before.tobytes() == other.T_now_before.tobytes()


def test_over_dropped_frames_motion_is_composed(street_tree: Path) -> None:
    drive: RecordedSequence = kitti_sequence(street_tree, NAME, ego="visual")
    whole = [frame.T_now_before for frame in drive]
    first, second = drive.subset([3, 6])
    assert first.T_now_before is None
    assert second.T_now_before is not None
    composed = whole[6] @ whole[5] @ whole[4]  # type: ignore[operator]
    np.testing.assert_allclose(second.T_now_before, composed, atol=1e-12)
    assert second.motion_cov is not None
    assert np.linalg.eigvalsh(second.motion_cov).min() > 0.0
    single = list(drive)[6].motion_cov
    assert single is not None
    assert np.trace(second.motion_cov) > np.trace(single)
    assert list(drive.subset([])) == []


def test_frames_without_images_coast_and_it_is_said(
    street_tree: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = street_tree / "training/image_02" / NAME
    for number in (0, 5):
        (folder / f"{number:06d}.png").unlink()
    with caplog.at_level(logging.WARNING):
        seen = frames(street_tree)
    assert "images for 7 of 9 frames only" in caplog.text
    assert [frame.T_now_before is None for frame in seen] == [True] * 2 + [False] * 7
    spread = [np.trace(frame.motion_cov) for frame in seen[4:8] if frame.motion_cov is not None]
    assert spread[0] < spread[1] < spread[2] > spread[3]


def test_without_images_the_cure_is_named(tiny_tree: Path) -> None:
    with pytest.raises(DatasetNotFound, match=r"image_02/0030: no numbered images.*oxts"):
        kitti_sequence(tiny_tree, "0030", ego="visual")


def test_images_of_another_size_than_the_calibration_are_refused(tiny_tree: Path) -> None:
    for folder in ("calib", "oxts"):
        source = tiny_tree / "training" / folder / "0030.txt"
        write(tiny_tree / "training" / folder / "0007.txt", source.read_text())
    show(tiny_tree, 0, np.zeros((188, 620, 3), np.uint8), "0007")
    with pytest.raises(BadCalibration, match=r"images of 620x188 pixels.* is for 1242x375"):
        kitti_sequence(tiny_tree, "0007", None, ego="visual")


def test_more_images_than_frames_are_refused(tiny_tree: Path) -> None:
    for number in (1, 2, 3):  # numbered from 1
        show(tiny_tree, number, np.zeros((375, 1242, 3), np.uint8), "0030")
    with pytest.raises(BadFile, match=r"000003.png: the sequence has 3 frames, counted from 0"):
        kitti_sequence(tiny_tree, "0030", ego="visual")


def test_an_image_of_another_size_half_way_is_named(street_tree: Path) -> None:
    show(street_tree, 4, np.zeros((94, 310, 3), np.uint8))
    with pytest.raises(BadFile, match=r"000004.png: 310x94 pixels where the first .* 620x188"):
        frames(street_tree)


def test_a_broken_image_file_is_named(street_tree: Path) -> None:
    path = street_tree / "training/image_02" / NAME / "000004.png"
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(BadFile, match=r"000004.png: not an image"):
        frames(street_tree)


@pytest.mark.parametrize("kind", ["grey", "16 bits"])
def test_grey_and_16_bit_files_are_read_as_rgb(street_tree: Path, kind: str) -> None:
    wanted = frames(street_tree)
    for number, image in enumerate(filmed(STRAIGHT)[0]):
        other = image[:, :, 0] if kind == "grey" else image.astype(np.uint16) * 257
        show(street_tree, number, other)
    for frame, want in list(zip(frames(street_tree), wanted, strict=True))[1:]:
        assert frame.T_now_before is not None
        np.testing.assert_allclose(frame.T_now_before, want.T_now_before, atol=1e-9)


def test_the_command_line_tracks_with_visual_motion(
    street_tree: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = street_tree / "out"
    arguments = ["track", "--root", street_tree, "--sequences", NAME, "--ego", "visual"]
    assert main([*map(str, arguments), "--out", str(out)]) == 0
    assert (out / f"{NAME}.txt").is_file()
    assert main(["list"]) == 0
    assert "visual" in capsys.readouterr().out


@pytest.mark.kitti
def test_the_real_clips_agree_with_oxts(kitti_root: Path) -> None:
    errors = []
    for name, first, last in (("0005", 0, 16), ("0009", 47, 63)):
        chosen = range(first, last)
        seen = kitti_sequence(kitti_root, name, ego="visual").subset(chosen)
        true = kitti_sequence(kitti_root, name, ego="oxts").subset(chosen)
        for frame, truth in list(zip(seen, true, strict=True))[2:]:
            assert frame.T_now_before is not None
            assert truth.T_now_before is not None
            errors.append(misses(frame.T_now_before, truth.T_now_before))
    rotation, direction, length = np.median(np.abs(errors), axis=0)
    assert rotation <= 0.06
    assert direction <= 2.5
    assert length <= 0.05


def test_poses_and_seen_motion_are_the_same_thing(street_tree: Path) -> None:
    drive = kitti_sequence(street_tree, NAME, ego="visual")
    motions = [frame.T_now_before for frame in drive]
    Ts_world_cam = [np.eye(4)]
    for T_now_before in motions[1:]:
        assert T_now_before is not None
        Ts_world_cam.append(Ts_world_cam[-1] @ invert(T_now_before))
    posed = replace(drive, motion=None, Ts_world_cam=np.array(Ts_world_cam))
    for frame, seen in list(zip(posed, motions, strict=True))[1:]:
        np.testing.assert_allclose(frame.T_now_before, seen, atol=1e-12)
