"""The real tree: conventions and quality, measured against what is known of it."""

import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mot_sim.datasets.kitti import (
    DETECTORS,
    KittiSequence,
    available_sequences,
    kitti_sequence,
    write_labels,
)
from mot_sim.datasets.kitti.labels import LABEL_COLUMNS, alpha_of, rows_of_cuboids
from mot_sim.datasets.kitti.places import TRAINING_FRAMES
from mot_sim.files.text import read_table
from tracker.geometry import box_iou, invert, transform, wrap_angle
from tracker.types import Tracks

pytestmark = pytest.mark.kitti

STANDING = ("0012", "0016", "0017")


@cache
def sequences(root: Path, ego: str = "oxts") -> list[KittiSequence]:
    """All 21 training sequences."""
    return [kitti_sequence(root, name, ego=ego) for name in available_sequences(root)]


def labelled(root: Path) -> list[tuple[KittiSequence, Tracks]]:
    """The sequences that have labels, with them."""
    return [(s, s.truth) for s in sequences(root) if s.truth is not None]


@cache
def motions(sequence: KittiSequence) -> np.ndarray:
    """T_now_before of all frames but the first."""
    return np.array([frame.T_now_before for frame in sequence][1:])


def clear_cars(truth: Tracks) -> Tracks:
    """Cars that are neither occluded nor truncated."""
    assert truth.occlusion is not None
    assert truth.truncation is not None
    return truth.select((truth.kinds == "Car") & (truth.occlusion == 0) & (truth.truncation == 0))


def test_all_sequences_are_read_in_time(kitti_root: Path) -> None:
    start = time.process_time()
    drives = [kitti_sequence(kitti_root, name) for name in available_sequences(kitti_root)]
    # 0.2 s plain; the type checks of the test run are most of it here.
    assert time.process_time() - start < 6.0
    assert [drive.frame_count for drive in drives] == list(TRAINING_FRAMES)
    assert sum(len(drive.log.frames) for drive in drives) == 27046


@pytest.mark.parametrize("detector", sorted(DETECTORS))
def test_every_given_file_of_detections_is_read(
    kitti_root: Path, detector: str, caplog: pytest.LogCaptureFixture
) -> None:
    expected = {"pointrcnn": 5, "rrc": 0, "permatrack": 0, "degraded": 0, "regionlets": 0}
    folder = kitti_root / "detections" / detector
    for path in sorted(folder.glob("*.txt")):
        sequence = kitti_sequence(kitti_root, path.stem, detector, ego="none")
        assert len(sequence.log.frames) > 0 or detector == "rrc_pedestrian"
        furthest = np.array([*sequence.camera.image_size] * 2) - 1
        assert (sequence.log.detections.boxes >= 0).all()
        assert (sequence.log.detections.boxes <= furthest).all()
    records = [record for record in caplog.records if "left out" in record.getMessage()]
    dropped = [record.args for record in records if isinstance(record.args, tuple)]
    assert sum(int(flat) + int(out) for _, flat, out in dropped) == expected.get(detector, 0)


def test_label_boxes_are_the_projected_cuboids(kitti_root: Path) -> None:
    overlaps = []
    for sequence, truth in labelled(kitti_root):
        cars = clear_cars(truth)
        assert cars.cuboids is not None
        corners = transform(sequence.camera.T_cam_road, cars.cuboids.corners())
        pixels = sequence.camera.project(corners)
        visible = np.isfinite(pixels).all(axis=(1, 2))
        boxes = np.hstack([pixels.min(axis=1), pixels.max(axis=1)])[visible]
        furthest = np.array([*sequence.camera.image_size] * 2) - 1.0
        overlaps.append(box_iou(np.clip(boxes, 0.0, furthest), cars.boxes[visible]))
    assert np.median(np.concatenate(overlaps)) == pytest.approx(0.977, abs=0.001)
    assert np.percentile(np.concatenate(overlaps), 5) > 0.95


def test_alpha_agrees_with_the_labels(kitti_root: Path) -> None:
    for sequence, truth in labelled(kitti_root):
        assert truth.cuboids is not None
        assert sequence.label_path is not None
        table = read_table(sequence.label_path, LABEL_COLUMNS, words=["type"])
        alpha = alpha_of(rows_of_cuboids(truth.cuboids, sequence.T_road_label))
        known = np.isfinite(alpha)
        assert np.median(np.abs(wrap_angle(alpha - table["alpha"])[known])) < 0.01


def test_labels_are_written_as_they_were_read(kitti_root: Path, tmp_path: Path) -> None:
    for sequence, truth in labelled(kitti_root):
        assert sequence.label_path is not None
        again = tmp_path / "again.txt"
        write_labels(truth, again, sequence.T_road_label)
        tables = [
            read_table(path, LABEL_COLUMNS, words=["type"]) for path in (sequence.label_path, again)
        ]
        for column in LABEL_COLUMNS:
            if column != "alpha":
                np.testing.assert_array_equal(tables[1][column], tables[0][column], column)


def test_standing_sequences_do_not_move(kitti_root: Path) -> None:
    for sequence in sequences(kitti_root):
        steps = np.linalg.norm(motions(sequence)[:, :3, 3], axis=1)
        assert (steps.mean() < 0.003) == (sequence.name in STANDING)


@pytest.mark.slow
def test_oxts_and_orbslam3_agree(kitti_root: Path) -> None:
    for oxts, slam in zip(sequences(kitti_root), sequences(kitti_root, "orbslam3"), strict=True):
        by_oxts, by_slam = motions(oxts), motions(slam)
        errors = by_slam @ invert(by_oxts)
        angles = np.degrees(Rotation.from_matrix(errors[:, :3, :3]).magnitude())
        assert 0.004 < np.median(angles) < 0.051, oxts.name
        if oxts.name in STANDING:
            continue
        lengths = [np.linalg.norm(Ts[:, :3, 3], axis=1).sum() for Ts in (by_slam, by_oxts)]
        ratio = lengths[0] / lengths[1]
        lowest, highest = (0.945, 0.955) if oxts.name == "0020" else (0.99, 1.066)
        assert lowest < ratio < highest, oxts.name


def test_the_stated_covariances_are_those_measured(kitti_root: Path) -> None:
    slams = {drive.name: drive for drive in sequences(kitti_root, "orbslam3")}
    squares = []
    for sequence, _ in labelled(kitti_root):
        errors = motions(slams[sequence.name]) @ invert(motions(sequence))
        vectors = Rotation.from_matrix(errors[:, :3, :3]).as_rotvec()
        squares.append(np.hstack([errors[:, :3, 3], vectors]) ** 2)
    measured = np.sqrt(np.concatenate(squares).mean(axis=0))
    stated = slams["0005"].motion_cov
    assert stated is not None
    np.testing.assert_allclose(np.sqrt(np.diag(stated)), measured, rtol=0.1)


def test_parked_cars_stand_still_in_the_world(kitti_root: Path) -> None:
    """T_now_before, chained, carries parked cars back to one place; its inverse carries none.

    Sequence 0009: 71 of 81 cars that are labelled for 15 frames or more stay within .6 m.
    """
    sequence = next(drive for drive in sequences(kitti_root) if drive.name == "0009")
    truth = sequence.truth
    assert truth is not None
    assert truth.cuboids is not None
    right, wrong = [np.eye(4)], [np.eye(4)]
    for T_now_before in motions(sequence):
        right.append(right[-1] @ invert(T_now_before))
        wrong.append(wrong[-1] @ T_now_before)
    standing = {"right": 0, "wrong": 0}
    for car in np.unique(truth.ids[truth.ids >= 0]):
        rows = np.flatnonzero((truth.ids == car) & np.isin(truth.kinds, ("Car", "Van")))
        if len(rows) < 15:
            continue
        points_cam = transform(sequence.camera.T_cam_road, truth.cuboids.base[rows])
        for name, Ts_first_now in {"right": right, "wrong": wrong}.items():
            places = np.array(
                [
                    transform(Ts_first_now[frame], point_cam[None])[0]
                    for frame, point_cam in zip(truth.frames[rows], points_cam, strict=True)
                ]
            )
            wandered = np.linalg.norm(places - np.median(places, axis=0), axis=1).max()
            standing[name] += bool(wandered < 0.6)
    assert standing == {"right": 71, "wrong": 0}


def test_real_images_ride_in_the_frames_that_have_them(kitti_root: Path) -> None:
    whole = kitti_sequence(kitti_root, "0009", images=True)
    assert whole.images is not None
    part = whole.subset(sorted(whole.images.paths))
    width, height = part.camera.image_size
    assert len(part) > 0
    for frame in part:
        assert frame.image is not None
        assert frame.image.shape == (height, width, 3)
    assert next(iter(whole)).image is None
