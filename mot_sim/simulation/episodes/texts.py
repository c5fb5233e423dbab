"""The text files of an episode, as KITTI's readers take them."""

from collections.abc import Iterator
from hashlib import sha256

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array
from scipy.spatial.transform import Rotation

from mot_sim.datasets.camera_files import write_poses
from mot_sim.datasets.kitti.calibration import write_calibration
from mot_sim.datasets.kitti.ego import ORBSLAM3_MOTION_STD
from mot_sim.datasets.kitti.labels import write_labels
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.files.writing import write_lines
from mot_sim.simulation import random_numbers
from mot_sim.simulation.episode import SimulatedDrive
from mot_sim.simulation.episodes.oxts_rows import calibration_of, oxts_lines
from mot_sim.simulation.episodes.places import TEXTS, EpisodeFiles
from mot_sim.simulation.truth import Truth
from tracker.geometry import homogeneous, invert
from tracker.types import Detections

NOISY_MOTION_STD = ORBSLAM3_MOTION_STD  # what the source of ego-motion `noisy` says of its files
THINNEST = 1.5e-6  # pixels; a thinner box has no area when it is printed with six decimals


def write_texts(drive: SimulatedDrive, places: EpisodeFiles) -> dict[str, str]:
    """Write labels, detections, calibration and motion; gives the SHA-256 of each file."""
    calibration = calibration_of(drive.camera)
    assert drive.Ts_world_cam is not None
    write_labels(
        drive.truth, places.text("labels"), drive.camera.T_road_cam @ calibration.T_cam_label
    )
    write_lines(places.text("detections"), detection_lines(drive.log))
    write_lines(places.text("exact detections"), detection_lines(exact_detections(drive.exact)))
    write_poses(noisy_poses(drive.Ts_world_cam, drive.seed), places.text("odometry"))
    write_lines(places.text("oxts"), oxts_lines(drive.traffic.ego))
    write_calibration(calibration, places.text("calibration"))
    return {part: sha256(places.text(part).read_bytes()).hexdigest() for part in TEXTS}


def exact_detections(truth: Truth) -> DetectionLog:
    """The true boxes of all cars of which a pixel is seen, with score 1."""
    tracks = truth.tracks.select(truth.pixels > 0)
    return DetectionLog(tracks.frames, Detections(tracks.boxes, np.ones(len(tracks))))


def detection_lines(log: DetectionLog) -> Iterator[str]:
    """`frame,x1,y1,x2,y2,score`, six decimals; boxes that have no area then are left out."""
    boxes, scores = log.detections.boxes, log.detections.scores
    kept = np.flatnonzero((boxes[:, 2:] - boxes[:, :2] > THINNEST).all(axis=1))
    for row in kept.tolist():
        values = [*boxes[row].tolist(), float(scores[row])]
        yield f"{log.frames[row]},{','.join(f'{value:.6f}' for value in values)}"


def noisy_poses(
    Ts_world_cam: Float[Array, "n 4 4"],
    seed: int,
    std: tuple[float, ...] = NOISY_MOTION_STD,
) -> Float[Array, "n 4 4"]:
    """The poses of an odometry whose every step is off by a little.

    std: of the left perturbation of T_now_before, translation, then rotation vector, metres and
    radians. The first pose is exact; a frame's draw hangs on (seed, frame) alone.
    """
    count = len(Ts_world_cam)
    drawn = random_numbers.normal(seed, "odometry", np.zeros(count, np.int64), np.arange(count), 6)
    moves = drawn * np.array(std)
    turns = Rotation.from_rotvec(moves[:, 3:]).as_matrix()
    noisy = Ts_world_cam.copy()
    for now in range(1, count):
        T_now_before = invert(Ts_world_cam[now]) @ Ts_world_cam[now - 1]
        T_noisy_before = homogeneous(turns[now], moves[now, :3]) @ T_now_before
        noisy[now] = noisy[now - 1] @ invert(T_noisy_before)
    return np.round(noisy, 9) + 0.0  # as they are printed, and no negative zero among them
