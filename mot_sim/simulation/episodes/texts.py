"""The text files of an episode, as KITTI's readers take them."""

from collections.abc import Iterator
from hashlib import sha256

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.camera_files import write_poses
from mot_sim.datasets.kitti.calibration import Calibration, write_calibration
from mot_sim.datasets.kitti.ego import EARTH_RADIUS, ORBSLAM3_MOTION_STD
from mot_sim.datasets.kitti.labels import write_labels
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.files.writing import write_lines
from mot_sim.simulation import random_numbers
from mot_sim.simulation.episode import SimulatedDrive
from mot_sim.simulation.episodes.places import TEXTS, EpisodeFiles
from mot_sim.simulation.rig import PIVOT_HEIGHT_METRES
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.simulation.truth import Truth
from tracker.geometry import homogeneous, invert, wrap_angle
from tracker.types import Camera, Detections

# Where a run begins: latitude and longitude of Karlsruhe in degrees, and metres above the sea.
ORIGIN_DEGREES = (49.0, 8.4)
ALTITUDE_METRES = 115.0
# From the unit's axes (forward, left, up) to the road's (right, down, forward).
R_ROAD_IMU = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
# Exact positions and velocities, a locked filter; satellites are not counted.
OXTS_STATUS = "0 0 4 0 0 0 0"
NOISY_MOTION_STD = ORBSLAM3_MOTION_STD  # what the source of ego-motion `noisy` says of its files
MIN_SIDE_PIXELS = 1.5e-6  # pixels; a thinner box has no area when it is printed with six decimals


def calibration_of(camera: Camera) -> Calibration:
    """A rig whose camera 0 is camera 2, its inertial unit below it, level as the road."""
    T_road_imu = homogeneous(R_ROAD_IMU, np.array([0.0, -PIVOT_HEIGHT_METRES, 0.0]))
    return Calibration(camera.K, T_cam_imu=camera.T_cam_road @ T_road_imu)


def oxts_lines(ego: Float[Array, "n 3"], tilt: Float[Array, "n 2"] | None = None) -> list[str]:
    """The rows of poses x, y, heading: the world's x is east, its y south, its z down.

    tilt: pitch and roll of the body about the inertial unit, radians; None: it stays level.

    Velocities are over the step before (the first row's: over the first step), accelerations
    and rates likewise. Positions are exact to 1e-8 m.
    """
    scale = np.cos(np.radians(ORIGIN_DEGREES[0])) * EARTH_RADIUS
    east, north = (ego[:, :2] - ego[:1, :2]).T * np.array([[1.0], [-1.0]])
    north = north + scale * np.log(np.tan(np.radians(90.0 + ORIGIN_DEGREES[0]) / 2.0))
    latitude = np.degrees(2.0 * np.arctan(np.exp(north / scale))) - 90.0
    latitude[:1] = ORIGIN_DEGREES[0]
    longitude = ORIGIN_DEGREES[1] + np.degrees(east / scale)
    yaw = np.asarray(wrap_angle(-ego[:, 2]))
    v_east, v_north = _rates(ego[:, 0]), -_rates(ego[:, 1])
    c, s = np.cos(yaw), np.sin(yaw)
    forward, left = c * v_east + s * v_north, c * v_north - s * v_east
    turn = -_rates(np.unwrap(ego[:, 2]))
    speeding, shifting = _rates(forward), _rates(left) + turn * forward
    zero = np.zeros(len(ego))
    rows = np.stack(
        (v_north, v_east, forward, left, zero, speeding, shifting, zero, speeding, shifting)
        + (zero, zero, zero, turn, zero, zero, turn),
        axis=1,
    )
    leans = ["0 0"] * len(ego)
    if tilt is not None:  # KITTI's pitch is > 0 where the front is low
        angles = _printable(tilt[:, ::-1] * (1.0, -1.0), 12).tolist()
        leans = [f"{roll:.12f} {pitch:.12f}" for roll, pitch in angles]
    return [
        f"{lat:.13f} {lon:.13f} {ALTITUDE_METRES + PIVOT_HEIGHT_METRES:.6f} {lean} {angle:.12f} "
        f"{' '.join(f'{value:.6f}' for value in row)} {OXTS_STATUS}"
        for lat, lon, lean, angle, row in zip(
            latitude.tolist(),
            longitude.tolist(),
            leans,
            _printable(yaw, 12).tolist(),
            _printable(rows, 6).tolist(),
            strict=True,
        )
    ]


def _printable(values: Float[Array, "*n"], digits: int) -> Float[Array, "*n"]:
    """The values as they are printed, and no negative zero among them."""
    return np.round(values, digits) + 0.0


def _rates(values: Float[Array, " n"]) -> Float[Array, " n"]:
    """Change a second over the step before; the first is like the second, a single one 0."""
    if len(values) < 2:
        return np.zeros(len(values))
    change = np.diff(values) / STEP_SECONDS
    return np.concatenate((change[:1], change)) + 0.0


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
    write_lines(places.text("oxts"), oxts_lines(drive.traffic.ego, drive.traffic.tilt))
    write_calibration(calibration, places.text("calibration"))
    return {part: sha256(places.text(part).read_bytes()).hexdigest() for part in TEXTS}


def exact_detections(truth: Truth) -> DetectionLog:
    """The true boxes of all cars of which a pixel is seen, with score 1."""
    tracks = truth.tracks.select(truth.pixels > 0)
    return DetectionLog(tracks.frames, Detections(tracks.boxes, np.ones(len(tracks))))


def detection_lines(log: DetectionLog) -> Iterator[str]:
    """`frame,x1,y1,x2,y2,score`, six decimals; boxes that have no area then are left out."""
    boxes, scores = log.detections.boxes, log.detections.scores
    kept = np.flatnonzero((boxes[:, 2:] - boxes[:, :2] > MIN_SIDE_PIXELS).all(axis=1))
    for row in kept.tolist():
        values = [*boxes[row].tolist(), float(scores[row])]
        yield f"{log.frames[row]},{','.join(f'{value:.6f}' for value in values)}"


def noisy_poses(
    Ts_world_cam: Float[Array, "n 4 4"], seed: int, std: tuple[float, ...] = NOISY_MOTION_STD
) -> Float[Array, "n 4 4"]:
    """The poses of an odometry whose every step is off by a little.

    std: of the left perturbation of T_now_before, translation, then rotation vector, metres and
    radians. The first pose is exact; a frame's random numbers depend on (seed, frame) alone.
    """
    from scipy.spatial.transform import Rotation

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
