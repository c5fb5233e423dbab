"""Every reader of text files: whatever the file, rows or one of our own errors."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mot_sim.datasets import (
    DETECTORS,
    ScoreMap,
    box_sequence,
    read_calibration,
    read_camera,
    read_cuboid_results,
    read_detections,
    read_labels,
    read_poses,
    read_results,
    tracks_of_boxes,
)
from mot_sim.datasets.estimate_files import COLUMNS as ESTIMATE_COLUMNS
from mot_sim.datasets.estimate_files import read_estimates
from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.ego import read_oxts
from mot_sim.datasets.kitti.labels import cuboids_of_rows
from mot_sim.datasets.recorded import DetectionLog, RecordedSequence
from mot_sim.datasets.trajectories import read_trajectory
from mot_sim.evaluation.own_scoring import read_mot_truth
from mot_sim.evaluation.splits import read_seqmap
from mot_sim.experiments.guests.exchange import read_guest_results
from mot_sim.metrics import spatial_scores
from tests.fuzz.door import Spoil, fuzz
from tests.fuzz.mutations import spoiled_text, spoiled_toml
from tracker.shape import KEYPOINTS_14, load_prior
from tracker.types import Camera, Cuboids, Detections, Tracks

SIZE = (1242, 375)
K = np.array([[721.5, 0.0, 609.6], [0.0, 721.5, 172.9], [0.0, 0.0, 1.0]])
CAMERA = Camera.mounted(K, SIZE, 1.65)

LABELS = b"""0 -1 DontCare -1 -1 -10 219.31 188.49 245.5 218.56 -1000 -1000 -1000 -10 -1 -1 -1
0 2 Car 0 1 -1.793451 296.74 161.75 455.22 292.37 1.96 1.82 4.43 -4.55 1.86 13.41 -2.1151
1 2 Car 1 2 -1.79 294.8 156.02 452.19 284.6 2.0 1.82 4.43 -4.65 1.84 13.58 -2.12
3 7 Van 0 0 -1.9 -1 -1 452.19 284.6 -1 -1 -1 -1000 -1000 -1000 -10
"""
RESULTS = b"".join(line + b" 0.9\n" for line in LABELS.splitlines()[1:])
AUTHORS = b"1 3 296.7 161.8 455.2 292.4 0.9\n2 3 300.5 160 450 290 0.8\n2 4 10 160 45 290 1e-3\n"
CALIBRATION = b"""P0: 721.5 0 609.6 0 0 721.5 172.9 0 0 0 1 0
P2: 721.5 0 609.6 44.9 0 721.5 172.9 0.2 0 0 1 0.003
R_rect 0.999950 0 0.0099998 0 1 0 -0.0099998 0 0.999950
Tr_velo_cam 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27
Tr_imu_velo 1 0 0 -0.81 0 1 0 0.32 0 0 1 -0.8
"""
OXTS = b"\n".join(
    f"49.0{row} 8.43{row} 112.{row} 0.03 0.01 {row}.1 {' '.join(['0.5'] * 19)} 4 10 4 4 0".encode()
    for row in range(4)
)
POSES = b"1 0 0 0 0 1 0 0 0 0 1 0\n0.8 0 0.6 1 0 1 0 0 -0.6 0 0.8 2\n1 0 0 9 0 1 0 0 0 0 1 1\n"
DETECTIONS = {
    "rrc": b"0,296.7,161.8,455.2,292.4,0.9\n2,10,20,30,40,0.1\n2,-3,1,1300,400,1\n",
    "pointrcnn": (
        b"0,2,296.7,161.8,455.2,292.4,4.2,1.5,1.6,3.9,1,1.6,20,-1.5,-1.6\n"
        b"3,1,10,20,30,40,-1.1,1.5,1.6,3.9,1,1.6,20,-1.5,-1.6\n"
    ),
    "kitti": RESULTS,
    "motchallenge": b"1,-1,296.7,161.8,158,130,0.9,-1,-1,-1\n3,-1,10,20,30,40,0.1,-1,-1,-1\n",
}
BOXES = b"frame,x_min,y_min,x_max,y_max,score\n0,296.7,161.8,455.2,292.4,0.9\n2,10,20,30,40,0.5\n"
CAMERA_FILE = b"""fx = 721.5
fy = 721.5
cx = 609.6
cy = 172.9
image_width = 1242
image_height = 375
camera_height = 1.65
pitch_deg = -1.0
roll_deg = 0.5
frame_rate = 10.0
"""
CAMERA_MATRIX = (
    b"K = [[721.5, 0, 609.6], [0, 721.5, 172.9], [0, 0, 1]]\n"
    b"image_width = 1242\nimage_height = 375\ncamera_height = 1.65\n"
)


LENS_FILE = CAMERA_MATRIX + b"distortion = [-0.3, 0.1, 0.001, 0.0, -0.01]\n"
TUM = b"# t\n0 0 0 0 0 0 0 1\n0.2 0 0 1.6 0 0.05 0 0.99875\n0.4 0 0 3 0 0 0 1\n"
TIMED = b"0 1 0 0 0 0 1 0 0 0 0 1 0\n0.4,1,0,0,0,0,1,0,0,0,0,1,2\n".replace(b",", b" ")
OWN_LABELS = b"frame,id,class,x_min,y_min,x_max,y_max\n0,7,Car,500,180,580,240\n1,7,Van,1,2,30,40\n"
VARIANCES = ",".join("0.3" if a == b else "0" for a in range(9) for b in range(a, 9))
MIXED = (
    b"Time;Track_ID;Class;Left;Top;Width;Height;Yaw;Conf\n1,5;2;car;5;8;80;60;;0,9\n"
    b"2;2;Tram;5;9;8;6;.1;1\n"
)
ESTIMATES = "\n".join([
    ",".join(ESTIMATE_COLUMNS),
    *(f"{frame},3,1.5,0,20,-1.57,8,4.2,1.5,1.7,0.01,0.9,{VARIANCES}" for frame in (0, 2)),
]).encode()  # fmt: skip
MOT_LABELS = b"1,2,100,50,30,80,1,1,0.9\n2,2,102,50,30,80,1,1,0.8\n2,4,10,5,30,80,0,8,1\n"


def tracks_of(tracks: Tracks) -> None:
    """What every user of rows leans on."""
    assert np.isfinite(tracks.boxes).all()
    assert (tracks.frames >= 0).all()
    assert (np.diff(tracks.frames) >= 0).all()


def labels(path: Path) -> None:
    tracks_of(read_labels(path, CAMERA.T_road_cam))


def results(path: Path) -> None:
    tracks_of(read_results(path, CAMERA.T_road_cam))


def cuboid_results(path: Path) -> None:
    tracks = read_cuboid_results(path, CAMERA.T_road_cam, 20)
    tracks_of(tracks)
    sound = read_labels_of(LABELS, path)
    numbers = spatial_scores(sound, tracks, 20).numbers()
    assert all(np.isfinite(numbers[name]) for name in ("sAMOTA@0.25", "MOTA3D@2m", "HOTA3D"))


def read_labels_of(content: bytes, beside: Path) -> Tracks:
    """Sound labels of cars with cuboids."""
    path = beside.with_name("labels.txt")
    path.write_bytes(b"".join(line + b"\n" for line in content.splitlines() if b"Car" in line))
    return read_labels(path, CAMERA.T_road_cam)


def cuboid_detections(path: Path) -> None:
    log = read_detections(path, DETECTORS["pointrcnn"], SIZE, 10, cuboids=road_cuboids)
    found = log.detections
    assert found.base is not None
    assert found.yaw is not None
    assert found.size is not None
    assert np.isfinite(found.base).all()
    assert (found.size > 0.0).all()


def road_cuboids(rows: np.ndarray) -> Cuboids:
    return cuboids_of_rows(rows, CAMERA.T_road_cam)[0]


def calibration(path: Path) -> None:
    found = read_calibration(path)
    assert isinstance(found, Calibration)
    camera = found.camera(SIZE)
    assert np.isfinite(camera.T_cam_road).all()
    assert np.isfinite(found.T_cam_label).all()


def oxts(path: Path) -> None:
    assert np.isfinite(read_oxts(path)).all()


def poses(path: Path) -> None:
    assert np.isfinite(read_poses(path)).all()


def detections(name: str, path: Path) -> None:
    log = read_detections(path, DETECTORS[name], SIZE, 10)
    assert isinstance(log, DetectionLog)
    assert np.isfinite(log.detections.boxes).all()
    assert ((log.frames >= 0) & (log.frames < 10)).all()


def boxes(camera: Path, path: Path) -> None:
    sequence = box_sequence(path, camera)
    for frame, _ in zip(sequence, range(50), strict=False):
        assert np.isfinite(frame.detections.boxes).all()


def trajectory(path: Path) -> None:
    found = read_trajectory(path, 10.0)
    assert np.isfinite(found.Ts_world_cam).all()
    if found.times is not None:
        between = np.linspace(found.times[0], found.times[-1], 5)
        assert np.isfinite(found.at(between)).all()


def own(path: Path) -> None:
    tracks_of(tracks_of_boxes(path))


def mot_labels(path: Path) -> None:
    home = path.parent / "drive" / "gt"
    home.mkdir(parents=True, exist_ok=True)
    (home.parent / "seqinfo.ini").write_text("[Sequence]\nseqLength=5\n")
    (home / "gt.txt").write_bytes(path.read_bytes())
    found = read_mot_truth(home / "gt.txt")
    assert len(found.tracks) == len(found.classes) == len(found.counted)
    assert np.isfinite(found.tracks.boxes).all()


def guest(path: Path) -> None:
    none = DetectionLog(np.zeros(0, np.int64), Detections.empty())
    drive = RecordedSequence(path.stem, CAMERA, 4, none, np.array([0, 1, 3]))
    tracks_of(read_guest_results([drive], path.parent)[path.stem])


def estimates(path: Path) -> None:
    frames, ids, states = read_estimates(path, CAMERA.T_road_cam)
    assert len(frames) == len(ids) == len(states)
    assert np.isfinite(states.means).all()
    assert (np.linalg.eigvalsh(states.covs) > -1e-3 * np.abs(states.covs).max(initial=1.0)).all()
    assert (np.abs(states.means[:, 3]) <= np.pi).all()


def score_map(path: Path) -> None:
    text = path.read_bytes().decode(errors="replace")
    assert ((probability := ScoreMap.parse(text)(np.array([0.0, 1.0]))) >= 0.0).all()
    assert (probability <= 1.0).all()


READERS: dict[str, tuple[bytes | list[bytes], Spoil, Callable[[Path], Any]]] = {
    "labels": (LABELS, spoiled_text, labels),
    "results": ([RESULTS, AUTHORS, LABELS], spoiled_text, results),
    "results in 3D": ([RESULTS, LABELS], spoiled_text, cuboid_results),
    "detections in 3D": (DETECTIONS["pointrcnn"], spoiled_text, cuboid_detections),
    "calibration": ([CALIBRATION, CALIBRATION.split(b"R_")[0]], spoiled_text, calibration),
    "oxts": (OXTS, spoiled_text, oxts),
    "poses": (POSES, spoiled_text, poses),
    "guest": ([RESULTS, AUTHORS.replace(b"2 ", b"3 ")], spoiled_text, guest),
    "camera": ([CAMERA_FILE, CAMERA_MATRIX], spoiled_toml, read_camera),
    "score map": (b"0.22,0.134", spoiled_text, score_map),
    "trajectory": ([TUM, TIMED, POSES], spoiled_text, trajectory),
    "seqmap": (b"0000 empty 000000 000154\n0002 empty 3 9\n", spoiled_text, read_seqmap),
    "tracks of boxes": ([OWN_LABELS, MIXED, LABELS, DETECTIONS["motchallenge"]], spoiled_text, own),
    "estimates": (ESTIMATES, spoiled_text, estimates),
    "MOTChallenge's labels": (MOT_LABELS, spoiled_text, mot_labels),
    "camera with a lens": (LENS_FILE, spoiled_toml, read_camera),
    **{
        f"detections {name}": (DETECTIONS[name], spoiled_text, partial(detections, name))
        for name in DETECTIONS
    },
}


@pytest.mark.parametrize("name", READERS)
def test_a_bad_text_file_gives_rows_or_our_own_error(name: str, folder: Path) -> None:
    good, spoil, read = READERS[name]
    fuzz(folder / "0000.txt", good, spoil, read)


def test_a_bad_table_of_boxes_gives_a_drive_or_our_own_error(folder: Path) -> None:
    camera = folder / "camera.toml"
    camera.write_bytes(CAMERA_FILE)
    fuzz(folder / "boxes.csv", BOXES, spoiled_text, partial(boxes, camera))


def test_a_bad_shape_prior_of_text_gives_our_own_error(folder: Path) -> None:
    rng = np.random.default_rng(0)
    count = len(KEYPOINTS_14)
    vectors = rng.normal(size=(2, 3 * count))
    (folder / "vectors14.txt").write_text(
        "\n".join(" ".join(f"{value:.3f}" for value in row) for row in vectors)
    )
    mean = "\n".join(f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in rng.normal(size=(count, 3)))
    fuzz(folder / "meanShape14.txt", mean.encode(), spoiled_text, lambda _: load_prior(folder))
