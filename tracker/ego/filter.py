"""A Kalman filter over the camera's motion; through outliers it coasts at constant velocity.

Its state is the velocity of T_now_before's translation and rotation vector, six numbers in the
camera's frame. A measurement far from the prediction is left out; the covariance grows meanwhile.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.ego.rotations import motion_transform
from tracker.errors import BadConfig
from tracker.geometry import cross_matrix
from tracker.types import Camera

Motion = tuple[Float[Array, "4 4"] | None, Float[Array, "6 6"] | None]
UNKNOWN_MOTION: Motion = (None, None)
MAX_OUTLIERS_IN_A_ROW = 4


@dataclass(frozen=True, eq=False)
class MotionMeasurement:
    """A measured motion of the camera between two images."""

    twist: Float[Array, "6"]
    """Translation (metres) and rotation vector (rad) of T_now_before, camera frame of now."""
    cov: Float[Array, "6 6"]
    """Its covariance."""
    is_outlier: bool = False
    """Whether it is far from what was predicted, so that its covariance was widened."""


@dataclass(frozen=True, eq=False)
class CameraVelocity:
    """What is known of the camera's velocity."""

    mean: Float[Array, "6"]
    """Translation (m/s) and rotation vector (rad/s) of T_now_before per second, camera frame."""
    cov: Float[Array, "6 6"]
    """Its covariance."""
    age: float = 0.0
    """Seconds since the last measurement that was used."""
    outliers: int = 0
    """How many measurements in a row were outliers."""


@dataclass(frozen=True)
class Coasting:
    """How a car may move; axes of the road: right, down, forward."""

    speed: float = 60.0
    """Speed that no car exceeds, m/s, > 0; more: faster measurements are believed."""
    turn: float = 1.5
    """Turn rate that no car exceeds, rad/s, > 0; more: faster turns are believed."""
    start: tuple[float, float, float, float, float, float] = (1.5, 1.5, 20.0, 0.3, 0.3, 0.3)
    """Std of the velocity before any measurement: m/s along the axes, then rad/s about them, >
    0."""
    change: tuple[float, float, float, float, float, float] = (0.2, 0.2, 0.4, 0.1, 0.1, 0.1)
    """Std of its change within a tenth of a second (cars brake at 3 to 8 m/s^2, bumps turn them by
    half a degree a frame), > 0; more: less smooth motions."""
    gate: float = 6.0
    """Standard deviations, of six numbers together, up to which a measurement is used, > 0; more:
    worse measurements are used."""
    patience: float = 1.0
    """Seconds without any measurement after which the motion is unknown, > 0; more: it coasts
    longer."""
    scale_std: float = 0.02
    """Common error of all lengths, std as a share: that of the camera's height, which no averaging
    removes."""

    def __post_init__(self) -> None:
        low = min(self.speed, self.turn, self.gate, self.patience, *self.start, *self.change)
        if not low > 0.0:
            raise BadConfig(f"a filter of the camera's motion with {low:g}: give more than 0")

    def predict(
        self, velocity: CameraVelocity | None, camera: Camera, seconds: float
    ) -> CameraVelocity:
        """The velocity after some seconds without a measurement."""
        if velocity is None:
            return CameraVelocity(np.zeros(6), _in_camera(self.start, camera))
        wider = 4.0 ** min(
            velocity.outliers, MAX_OUTLIERS_IN_A_ROW
        )  # outliers in a row: it does move like that
        grown = velocity.cov + wider * _in_camera(self.change, camera) * (seconds / 0.1)
        return CameraVelocity(velocity.mean, grown, velocity.age + seconds, velocity.outliers)

    def step(
        self,
        velocity: CameraVelocity | None,
        measured: MotionMeasurement | None,
        camera: Camera,
        seconds: float,
    ) -> tuple[CameraVelocity | None, Motion]:
        """The velocity after this frame, and its T_now_before with the covariance of `Frame`.

        Without a measurement inside the gate: the predicted motion; without a velocity, or when
        it is too old, nothing.
        """
        expected = self.predict(velocity, camera, seconds)
        after = None if measured is None else self._combine(expected, measured, seconds)
        if after is None:
            forgotten = velocity is None or expected.age > self.patience
            outliers = expected.outliers + (measured is not None)
            after = None if forgotten else replace(expected, outliers=outliers)
        return after, UNKNOWN_MOTION if after is None else self._motion(after, seconds)

    def _combine(
        self, expected: CameraVelocity, measured: MotionMeasurement, seconds: float
    ) -> CameraVelocity | None:
        """The Kalman update; None for a measurement outside the gate."""
        seen, noise = measured.twist / seconds, measured.cov / seconds**2
        if not (np.isfinite(seen).all() and np.isfinite(noise).all() and self._possible(seen)):
            return None
        innovation = seen - expected.mean
        total = expected.cov + noise
        gain = np.linalg.solve(total, expected.cov).T
        if innovation @ np.linalg.solve(total, innovation) > self.gate**2:
            return None
        mean, keep = expected.mean + gain @ innovation, np.eye(6) - gain
        cov = keep @ expected.cov @ keep.T + gain @ noise @ gain.T
        outliers = expected.outliers + 1 if measured.is_outlier else 0
        return (
            CameraVelocity(mean, 0.5 * (cov + cov.T), 0.0, outliers)
            if self._possible(mean)
            else None
        )

    def _possible(self, velocity: Float[Array, "6"]) -> bool:
        moved, turned = np.linalg.norm(velocity[:3]), np.linalg.norm(velocity[3:])
        return bool(moved <= self.speed and turned <= self.turn)

    def _motion(self, velocity: CameraVelocity, seconds: float) -> Motion:
        """T_now_before, and the covariance of (t, rotation vector) as a left perturbation.

        A perturbation (rho, phi) moves t by rho + phi x t, so rho = dt + [t]x phi.
        """
        twist, cov = velocity.mean * seconds, velocity.cov * seconds**2
        cov[:3, :3] += self.scale_std**2 * np.outer(twist[:3], twist[:3])
        left = np.eye(6)
        left[:3, 3:] = cross_matrix(twist[:3])
        cov = left @ cov @ left.T
        return motion_transform(twist), 0.5 * (cov + cov.T)


def _in_camera(
    stds: tuple[float, float, float, float, float, float], camera: Camera
) -> Float[Array, "6 6"]:
    """The covariance of standard deviations along the road's axes."""
    R, variances = camera.T_cam_road[:3, :3], np.square(stds)
    cov = np.zeros((6, 6))
    cov[:3, :3] = (R * variances[:3]) @ R.T
    cov[3:, 3:] = (R * variances[3:]) @ R.T
    return cov
