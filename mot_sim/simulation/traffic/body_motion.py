"""How the body of a car pitches and rolls: on bumps, when it brakes and turns, on slopes.

The body is a damped oscillator on its springs (the textbooks' quarter car, Gillespie, Fundamentals
of Vehicle Dynamics, 1992): white noise of the road, stronger the faster it drives (ISO 8608: the
rate of height changes over time grows with the root of the speed), and the accelerations of the
car drive it. A slope that changes slowly along the road comes on top. The numbers below are those
of the OXTS units on KITTI's given drives: steps of pitch and roll from frame to frame (.01 to .08
degrees in the median of a drive), their autocorrelation (+.55, -.1, -.3 after 1, 2, 3 frames),
what pitch and acceleration have in common, and the slope at which labelled cars stand ahead.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS

FREQUENCY_HZ = 1.15  # of the body on its springs
DAMPING = 0.3  # as a part of the critical one
BUMP_DEGREES = (0.12, 0.12)  # standard deviation of pitch and roll that bumps give at 8 m/s
BUMP_SPEED = 8.0  # m/s
ROUGHNESS_SPREAD = 0.45  # of the logarithm of how rough the roads of a run are
# Degrees for each m/s2: the nose rises when the car gains speed, the body leans out of a bend.
PITCH_ACCELERATION, ROLL_ACCELERATION = 0.07, -0.1
SLOPE_DEGREES = (0.35, 0.45)  # standard deviation of the road ahead to the road under the car
SLOPE_METRES = 35.0  # along the road after which a slope is another one
ROUNDING_METRES = 8.0  # over which a road changes its slope
SUBSTEPS = 5  # of integration in a step
SMOOTHING = 0.3  # of accelerations, for each step
JUMP_METRES = 10.0  # in a step: the car has begun somewhere else


@dataclass(eq=False)
class BodyMotion:
    """Pitch and roll of the body of one car, step by step."""

    seed: int
    """Random seed of the run."""
    level: float = 1.0
    """Times what is usual, >= 0; 0: the body stays level."""
    _pose: Float[Array, "3"] | None = field(default=None, init=False)
    _steps: int = field(default=0, init=False)
    _speed: float = field(default=0.0, init=False)
    _pulls: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2), init=False)
    _lean: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2), init=False)
    _rate: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2), init=False)
    _slope: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2), init=False)
    _slope_ahead: Float[Array, "2"] = field(default_factory=lambda: np.zeros(2), init=False)

    def step(self, pose: Float[Array, "3"]) -> Float[Array, "2"]:
        """Pitch (> 0 looks up) and roll (> 0 leans right), radians, of a car that is at x, y,
        heading now, 0.1 s after the call before."""
        before = pose if self._pose is None else self._pose
        moved = float(np.hypot(*(pose - before)[:2]))
        if moved > JUMP_METRES:
            before, moved = pose, self._speed * STEP_SECONDS
        speed = moved / STEP_SECONDS
        drawn = self._drawn()
        if self._pose is None:
            self._slope = self._slope_ahead = np.radians(SLOPE_DEGREES) * drawn[0]
            speed_before = speed
        else:
            speed_before = self._speed
        turn = float(pose[2] - before[2]) / STEP_SECONDS
        gain = (speed - speed_before) / STEP_SECONDS if self._steps > 1 else 0.0
        pulls = np.radians((PITCH_ACCELERATION * gain, ROLL_ACCELERATION * speed * turn))
        self._pulls += SMOOTHING * (pulls - self._pulls)
        kept = float(np.exp(-moved / SLOPE_METRES))
        fresh = np.sqrt(1.0 - kept**2)
        new = fresh * np.radians(SLOPE_DEGREES) * drawn[0]
        self._slope_ahead = kept * self._slope_ahead + new
        nearer = 1.0 - float(np.exp(-moved / ROUNDING_METRES))
        self._slope = self._slope + nearer * (self._slope_ahead - self._slope)
        self._spring(speed, drawn[1:])
        self._pose, self._speed = pose.copy(), speed
        self._steps += 1
        return np.asarray(self.level * (self._slope + self._lean))

    def _spring(self, speed: float, drawn: Float[Array, "k 2"]) -> None:
        """The oscillators, driven for a step."""
        stiff, dt = 2.0 * np.pi * FREQUENCY_HZ, STEP_SECONDS / SUBSTEPS
        # White noise of density q on a damped oscillator gives a variance q / (4 d w^3).
        std = np.radians(BUMP_DEGREES) * self._roughness() * np.sqrt(speed / BUMP_SPEED)
        noise = std * np.sqrt(4.0 * DAMPING * stiff**3 / dt)
        for draw in drawn:
            force = stiff**2 * (self._pulls - self._lean) - 2.0 * DAMPING * stiff * self._rate
            self._rate = self._rate + dt * (force + noise * draw)
            self._lean = self._lean + dt * self._rate

    def _drawn(self) -> Float[Array, "k 2"]:
        key = np.zeros(1, np.int64), np.array([self._steps])
        numbers = random_numbers.normal(self.seed, "body motion", *key, 2 * (SUBSTEPS + 1))
        return numbers.reshape(-1, 2)

    def _roughness(self) -> float:
        key = np.zeros(1, np.int64), np.zeros(1, np.int64)
        drawn = float(random_numbers.normal(self.seed, "roughness", *key)[0, 0])
        return float(np.exp(ROUGHNESS_SPREAD * drawn))
