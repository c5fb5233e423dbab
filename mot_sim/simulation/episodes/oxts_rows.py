"""The path of the ego car as OXTS rows, and where its inertial unit and camera stand."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.kitti.calibration import Calibration
from mot_sim.datasets.kitti.ego import EARTH_RADIUS
from mot_sim.simulation.traffic.traffic_state import STEP
from tracker.geometry import homogeneous, wrap_angle
from tracker.types import Camera

# Where a run begins: latitude and longitude of Karlsruhe in degrees, and metres above the sea.
ORIGIN = (49.0, 8.4)
ALTITUDE = 115.0
IMU_HEIGHT = 0.93  # metres above the road, as on KITTI's car
# From the unit's axes (forward, left, up) to the road's (right, down, forward).
R_ROAD_IMU = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
# Exact positions and velocities, a locked filter; nobody counts satellites.
STATUS = "0 0 4 0 0 0 0"


def calibration_of(camera: Camera) -> Calibration:
    """A rig whose camera 0 is camera 2, its inertial unit below it, level as the road."""
    T_road_imu = homogeneous(R_ROAD_IMU, np.array([0.0, -IMU_HEIGHT, 0.0]))
    return Calibration(camera.K, T_cam_imu=camera.T_cam_road @ T_road_imu)


def oxts_lines(ego: Float[Array, "n 3"]) -> list[str]:
    """The rows of poses x, y, heading: the world's x is east, its y south, its z down.

    Velocities are over the step before (the first row's: over the first step), accelerations
    and rates likewise. Positions are exact to 1e-8 m.
    """
    scale = np.cos(np.radians(ORIGIN[0])) * EARTH_RADIUS
    east, north = (ego[:, :2] - ego[:1, :2]).T * np.array([[1.0], [-1.0]])
    north = north + scale * np.log(np.tan(np.radians(90.0 + ORIGIN[0]) / 2.0))
    latitude = np.degrees(2.0 * np.arctan(np.exp(north / scale))) - 90.0
    latitude[:1] = ORIGIN[0]
    longitude = ORIGIN[1] + np.degrees(east / scale)
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
    return [
        f"{lat:.13f} {lon:.13f} {ALTITUDE + IMU_HEIGHT:.6f} 0 0 {angle:.12f} "
        f"{' '.join(f'{value:.6f}' for value in row)} {STATUS}"
        for lat, lon, angle, row in zip(
            latitude.tolist(), longitude.tolist(), _printable(yaw, 12).tolist(),
            _printable(rows, 6).tolist(), strict=True,
        )
    ]  # fmt: skip


def _printable(values: Float[Array, "*n"], digits: int) -> Float[Array, "*n"]:
    """The values as they are printed, and no negative zero among them."""
    return np.round(values, digits) + 0.0


def _rates(values: Float[Array, " n"]) -> Float[Array, " n"]:
    """Change a second over the step before; the first is like the second, a single one 0."""
    if len(values) < 2:
        return np.zeros(len(values))
    change = np.diff(values) / STEP
    return np.concatenate((change[:1], change)) + 0.0
