"""What a person at the wheel does that a model does not: drifts in the lane, varies the speed.

Both are Ornstein-Uhlenbeck processes, the usual model of lane keeping. The standard deviation of
the position in the lane of sober drivers on the road is .18 to .22 m (O'Hanlon et al., Vehicle
control tests on the road, 1982, and the tests that follow it); a part of it is where a driver
likes to be. Speeds are held to about a twentieth, over ten seconds and more.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation import random_numbers

LIKED_ASIDE_METRES = 0.12  # standard deviation between drivers of where in the lane they drive
DRIFT_METRES = 0.16  # standard deviation around that
DRIFT_SECONDS = 6.0
MAX_ASIDE_METRES = 0.45  # from the lane's middle: who drifts farther would touch others
PACE_SPREAD = 0.06  # standard deviation of the logarithm of the wanted speed
PACE_SECONDS = 12.0
# Of the model's accelerations, the least that a calm driver wants: 90 % of those of KITTI's own car
# are below .7 to 1.7 m/s2 on the given drives, and the model pulls away with 1.8.
CALMEST = 0.55
BLOCK_SECONDS = 16  # that are drawn at once


@dataclass(eq=False)
class Driver:
    """The errors of one driver, from second to second; linear between."""

    seed: int
    """Random seed of the run."""
    number: int
    """Of the car."""
    level: float = 1.0
    """Times what is usual, >= 0."""
    briskness: float = field(default=1.0, init=False)
    """Part of the model's accelerations that this driver wants, CALMEST to 1."""
    _second: int = field(default=0, init=False)
    _block: list[tuple[float, float]] = field(default_factory=list, init=False)
    _liked: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._liked = LIKED_ASIDE_METRES * float(self._drawn("liked place", 0, 1)[0, 0])
        drift, pace = self._drawn("driver", 0, 1)[0].tolist()
        self._block = self._next((drift, pace))
        key = np.array([self.number + 1]), np.zeros(1, np.int64)
        calm = float(random_numbers.uniform(self.seed, "briskness", *key)[0, 0])
        self.briskness = 1.0 - min(self.level, 1.0) * (1.0 - CALMEST) * calm

    def at(self, seconds: float) -> tuple[float, float]:
        """Metres to the right of the lane's middle, and the part of the wanted speed, at a time.

        seconds: since the car is on the road, never less than in the call before.
        """
        while seconds >= self._second + BLOCK_SECONDS:
            self._second += BLOCK_SECONDS
            self._block = self._next(self._block[-1])
        row = int(seconds) - self._second
        share = seconds - int(seconds)
        (drift, pace), (later_drift, later_pace) = self._block[row], self._block[row + 1]
        drift = (1.0 - share) * drift + share * later_drift
        pace = (1.0 - share) * pace + share * later_pace
        aside = self.level * (self._liked + DRIFT_METRES * drift)
        most = MAX_ASIDE_METRES
        return min(max(aside, -most), most), float(np.exp(self.level * PACE_SPREAD * pace))

    def _next(self, state: tuple[float, float]) -> list[tuple[float, float]]:
        """The processes from the last second of a block on, of unit variance."""
        kept = np.exp([-1.0 / DRIFT_SECONDS, -1.0 / PACE_SECONDS])
        states = [np.array(state)]
        for draw in self._drawn("driver", self._second + 1, BLOCK_SECONDS):
            states.append(kept * states[-1] + np.sqrt(1.0 - kept**2) * draw)
        return [(drift, pace) for drift, pace in np.array(states).tolist()]

    def _drawn(self, effect: str, first: int, count: int) -> Float[Array, "n 2"]:
        seconds = np.arange(first, first + count)
        numbers = np.full(count, self.number + 1)  # our car's number is -1
        return random_numbers.normal(self.seed, effect, numbers, seconds, 2)
