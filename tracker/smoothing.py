"""Where a car was at every moment, from all its detections: filterpy's Kalman and RTS smoother."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

# std of the velocity before anything is known of it, m/s.
SPEED_STD = 10.0


@dataclass(frozen=True, eq=False)
class Path:
    """The states of a car over time, with their covariances; one per moment."""

    states: Float[Array, "n 4"]
    """x, z, velocity x, velocity z; m and m/s, in a frame that does not move."""
    covs: Float[Array, "n 4 4"]
    """Their covariances."""


def smoothed(
    times: Float[Array, " n"],
    seen: Int[Array, " k"],
    places: Float[Array, "k 2"],
    covs: Float[Array, "k 2 2"],
    acceleration_std: float,
) -> Path:
    """The path of a car with nearly constant velocity through its measured places.

    times: of all moments, increasing. seen: which of them have a measured place, the first among
    them; places and covs: those, in a frame that does not move. acceleration_std: m/s^2.
    """
    from filterpy.common import Q_discrete_white_noise
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=4, dim_z=2)
    kalman.x = np.array([*places[0], 0.0, 0.0])
    kalman.P = np.diag([0.0, 0.0, SPEED_STD**2, SPEED_STD**2])
    kalman.P[:2, :2] = covs[0]
    kalman.H = np.eye(2, 4)
    n = len(times)
    states, state_covs = np.empty((n, 4)), np.empty((n, 4, 4))
    Fs, Qs = [np.eye(4)] * n, [np.zeros((4, 4))] * n
    states[0], state_covs[0] = kalman.x, kalman.P
    measured = dict(zip(seen.tolist(), range(len(seen)), strict=True))
    for k in range(1, n):
        dt = times[k] - times[k - 1]
        Fs[k] = np.eye(4) + dt * np.eye(4, k=2)
        Qs[k] = Q_discrete_white_noise(2, dt, acceleration_std**2, block_size=2, order_by_dim=False)
        kalman.predict(F=Fs[k], Q=Qs[k])
        if k in measured:
            kalman.update(places[measured[k]], R=covs[measured[k]])
        states[k], state_covs[k] = kalman.x, kalman.P
    states, state_covs, _, _ = kalman.rts_smoother(states, state_covs, Fs, Qs)
    return Path(states, state_covs)
