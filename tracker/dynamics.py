"""How an unseen car moves: not at all (the paper), or with constant velocity (a Kalman filter)."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.beliefs import Beliefs
from tracker.kernels import Kernel
from tracker.types.embedding import Embedding
from tracker.types.packed import read_only
from tracker.types.shape_pose import ShapePose

MOVE_COVARIANCES = Kernel("tracker.kernels.expecting", "move_covariances")
CORRECT_PLACES = Kernel("tracker.kernels.lifting", "correct_places")


@runtime_checkable
class Dynamics(Protocol):
    """How a belief changes with time, and with a new detection."""

    def predict(self, beliefs: Beliefs, dt: float) -> tuple[Beliefs, Float[Array, "n 2"] | None]:
        """The beliefs `dt` seconds later, not yet moved, and how far each moves meanwhile."""
        ...

    def update(self, expected: Beliefs, observed: Beliefs) -> Beliefs:
        """Row by row: the belief after an object expected there was detected here."""
        ...


@dataclass(frozen=True)
class ConstantPosition:
    """The paper's: a car stays where it was last detected, until its next detection."""

    speed_std: tuple[float, float] = (1.0, 5.0)
    """Std of the speed that it may have nevertheless, along road x and z, m/s; more: the search
    area widens faster with the time unseen."""

    def predict(self, beliefs: Beliefs, dt: float) -> tuple[Beliefs, Float[Array, "n 2"] | None]:
        """The same place, with a larger covariance."""
        return _later(beliefs, dt, *self.motion_model(dt)), None

    def motion_model(self, dt: float) -> tuple[float, Float[Array, "4 4"]]:
        """How long it goes on with its velocity, s, and what is added to the covariance."""
        return 0.0, _position_noise(round(dt, 6), tuple(self.speed_std))

    def update(self, expected: Beliefs, observed: Beliefs) -> Beliefs:
        """The detection as it is."""
        pose, embedding = _latest(expected, observed)
        if pose is observed.shape_pose and embedding is observed.embedding:
            return observed
        return observed.replaced(shape_pose=pose, embedding=embedding)


@dataclass(frozen=True)
class ConstantVelocity:
    """A Kalman filter on (x, z, velocity x, velocity z), all objects at once.

    The same filter as filterpy's `KalmanFilter` with its `Q_discrete_white_noise`, batched (a
    test holds them equal).
    """

    acceleration_std: float = 2.0
    """Std of the white-noise acceleration, m/s^2; more: the velocity follows new detections
    faster."""

    def predict(self, beliefs: Beliefs, dt: float) -> tuple[Beliefs, Float[Array, "n 2"] | None]:
        """F x and F P F' + Q; the shift of the position is returned apart."""
        return _later(beliefs, dt, *self.motion_model(dt)), beliefs.velocity * dt

    def motion_model(self, dt: float) -> tuple[float, Float[Array, "4 4"]]:
        """How long it goes on with its velocity, s, and what is added to the covariance."""
        return dt, _velocity_noise(round(dt, 6), self.acceleration_std)

    def update(self, expected: Beliefs, observed: Beliefs) -> Beliefs:
        """The Kalman update by the observed position; the box is the observed one.

        The height above the road plane, which no filter follows, is the observed one too.
        """
        n, place, seen = len(expected), expected.cuboids.base, observed.cuboids
        base, velocity, cov = np.empty((n, 3)), np.empty((n, 2)), np.empty((n, 4, 4))
        given = place, expected.velocity, expected.cov, seen.base, observed.cov
        CORRECT_PLACES(*given, base, velocity, cov)
        pose, embedding = _latest(expected, observed)
        return observed.replaced(
            cuboids=seen.replaced(base=base),
            velocity=velocity,
            cov=cov,
            shape_pose=pose,
            embedding=embedding,
        )


# The dynamics that kernels know; classes made of them are asked themselves.
OUR_DYNAMICS = (ConstantPosition, ConstantVelocity)


def _later(beliefs: Beliefs, dt: float, step: float, noise: Float[Array, "4 4"]) -> Beliefs:
    """Beliefs `dt` seconds later, where they were before. step, noise: of the motion model."""
    cov, pose = np.empty((len(beliefs), 4, 4)), beliefs.shape_pose
    MOVE_COVARIANCES(beliefs.cov, step, noise, cov)
    return beliefs.replaced(cov=cov, shape_pose=None if pose is None else pose.after(dt))


def _latest(expected: Beliefs, observed: Beliefs) -> tuple[ShapePose | None, Embedding | None]:
    """Shape and pose, and embedding, as last measured: now where that is known, else before."""
    pose, embedding = observed.shape_pose, observed.embedding
    pose = expected.shape_pose if pose is None else pose.filled_from(expected.shape_pose)
    embedding = (
        expected.embedding if embedding is None else embedding.filled_from(expected.embedding)
    )
    return pose, embedding


@lru_cache(maxsize=64)
def _position_noise(dt: float, speed_std: tuple[float, float]) -> Float[Array, "4 4"]:
    """That of a car that may have these speeds."""
    return read_only(np.diag(np.square([speed_std[0] * dt, speed_std[1] * dt, 0.0, 0.0])))


@lru_cache(maxsize=64)
def _velocity_noise(dt: float, acceleration_std: float) -> Float[Array, "4 4"]:
    """That of a car that may accelerate so; dt to the microsecond."""
    return read_only(acceleration_noise(dt, acceleration_std))


def acceleration_noise(dt: float, std: float) -> Float[Array, "4 4"]:
    """The covariance of (x, z, velocity x, velocity z) after dt seconds of constant acceleration.

    std: of the acceleration on each axis, m/s^2. Equal to filterpy's `Q_discrete_white_noise`,
    whose package loads scipy.stats.
    """
    one_axis = [[0.25 * dt**4, 0.5 * dt**3], [0.5 * dt**3, dt**2]]
    return np.kron(one_axis, np.eye(2)) * std**2
