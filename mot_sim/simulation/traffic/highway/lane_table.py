"""The lanes of a road in arrays: where many cars are along many lanes, all at once."""

from collections.abc import Mapping

import numpy as np
from highway_env.road.lane import AbstractLane, StraightLane
from highway_env.road.road import LaneIndex
from jaxtyping import Float, Int
from numpy import ndarray as Array

LATERAL_MARGIN_METRES = 1.0  # highway-env's rule of who is on a lane
OVERHANG_METRES = 5.0  # the same, beyond its ends


class LaneTable:
    """All lanes of a network, a row each. `AbstractLane.local_coordinates` of many points.

    The sums are highway-env's in its order, so that a car alone gives the same bits.
    """

    def __init__(self, lanes: Mapping[LaneIndex, AbstractLane]) -> None:
        """The lanes of a network by name, straight ones and bends."""
        self.names = list(lanes)
        self.rows = {name: row for row, name in enumerate(self.names)}
        every, count = list(lanes.values()), len(lanes)
        self.length = np.array([float(lane.length) for lane in every])
        self.reach = np.array([0.5 * lane.width_at(0.0) for lane in every]) + LATERAL_MARGIN_METRES
        self.circles = np.array([circle_around(lane) for lane in every]).reshape(-1, 3)
        self.is_bent = np.array([not isinstance(lane, StraightLane) for lane in every], bool)
        self.any_bent = bool(self.is_bent.any())
        self.origin, self.ahead, self.right = np.zeros((3, count, 2))
        self.radius, self.phase, self.sense = np.zeros((3, count))
        for row, lane in enumerate(every):
            if isinstance(lane, StraightLane):
                self.origin[row] = lane.start
                self.ahead[row], self.right[row] = lane.direction, lane.direction_lateral
            else:
                self.origin[row], self.radius[row] = lane.center, lane.radius
                self.phase[row], self.sense[row] = lane.start_phase, lane.direction

    def may_hold(self, positions: Float[Array, "n 2"]) -> Int[Array, " k"]:
        """The rows of the lanes that somebody may be on."""
        x, y, radius = self.circles.T
        apart = np.hypot(x[:, None] - positions[:, 0], y[:, None] - positions[:, 1])
        return np.flatnonzero((apart < radius[:, None]).any(axis=1))

    def who_is_on(
        self, rows: Int[Array, " k"], positions: Float[Array, "n 2"]
    ) -> dict[LaneIndex, list[tuple[int, float]]]:
        """For lanes that hold somebody, which points are on them, and how far along.

        By highway-env's rule, `AbstractLane.on_lane`.
        """
        along, aside = self.project(rows, positions)
        on_it = np.abs(aside) <= self.reach[rows][:, None]
        on_it &= (along >= -OVERHANG_METRES) & (
            along < self.length[rows][:, None] + OVERHANG_METRES
        )
        lanes, points = np.nonzero(on_it)
        found: dict[LaneIndex, list[tuple[int, float]]] = {}
        for row, point, place in zip(
            rows[lanes].tolist(), points.tolist(), along[lanes, points].tolist(), strict=True
        ):
            found.setdefault(self.names[row], []).append((point, place))
        return found

    def project(
        self, rows: Int[Array, " k"], positions: Float[Array, "n 2"]
    ) -> tuple[Float[Array, "k n"], Float[Array, "k n"]]:
        """Metres along each of some lanes, and right of it, of each point."""
        apart = positions[None] - self.origin[rows][:, None]
        along = np.matmul(apart, self.ahead[rows][:, :, None])[..., 0]
        aside = np.matmul(apart, self.right[rows][:, :, None])[..., 0]
        if self.any_bent and (bent := self.is_bent[rows]).any():
            radius, sense = self.radius[rows[bent]][:, None], self.sense[rows[bent]][:, None]
            x, y = apart[bent, :, 0], apart[bent, :, 1]
            turn = np.arctan2(y, x) - self.phase[rows[bent]][:, None]
            turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
            along[bent] = sense * turn * radius
            aside[bent] = sense * (radius - np.hypot(x, y))
        return along, aside

    def own_places(
        self, rows: Int[Array, " n"], positions: Float[Array, "n 2"]
    ) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Metres along the lane of each point, and right of it."""
        apart = (positions - self.origin[rows])[:, None]
        along = np.matmul(apart, self.ahead[rows][:, :, None])[:, 0, 0]
        aside = np.matmul(apart, self.right[rows][:, :, None])[:, 0, 0]
        if self.any_bent and (bent := self.is_bent[rows]).any():
            radius, phase = self.radius[rows[bent]], self.phase[rows[bent]]
            sense, apart = self.sense[rows[bent]], apart[bent]
            angle = np.arctan2(apart[:, 0, 1], apart[:, 0, 0])
            angle = phase + ((angle - phase + np.pi) % (2.0 * np.pi) - np.pi)
            along[bent] = sense * (angle - phase) * radius
            far = np.sqrt(np.matmul(apart, apart.swapaxes(1, 2))[:, 0, 0])
            aside[bent] = sense * (radius - far)
        return along, aside


def circle_around(lane: AbstractLane) -> tuple[float, float, float]:
    """x, y, radius of a circle outside of which nobody is on a lane."""
    points = np.array([lane.position(along, 0.0) for along in np.linspace(0.0, lane.length, 9)])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = np.hypot(*(points - middle).T).max()
    # The points on a bend lie apart: a sixteenth of its length is more than it bulges between.
    beside = 0.5 * float(lane.width_at(0.0)) + LATERAL_MARGIN_METRES
    spare = OVERHANG_METRES + beside + (float(lane.length) - reach) / 16.0
    return float(middle[0]), float(middle[1]), float(reach + max(spare, OVERHANG_METRES + beside))
