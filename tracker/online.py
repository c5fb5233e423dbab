"""The online tracker: one frame in, the identities of its detections out."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.association import Associate, Hungarian, Match
from tracker.beliefs import Beliefs, Lift, transport
from tracker.costs import ImageOverlap, Pairing, Reprojection, Volume, WeightedCosts, weighted_sum
from tracker.dynamics import ConstantVelocity, Dynamics, Still
from tracker.lifecycle import Lifecycle, Population
from tracker.suppression import Suppression
from tracker.types import Camera, Detections, Frame, Tracks

# How far an unknown camera motion may be from standing still: 1 m along and 3 cm across the
# view a frame, 1 degree of yaw; the 10 Hz of KITTI in a town.
UNKNOWN_MOTION_COV = np.diag(np.square([0.1, 0.03, 1.0, 0.005, 0.02, 0.003]))


@dataclass(frozen=True, eq=False)
class State:
    """Everything that a tracker remembers; never modified, so keeping it is a copy."""

    population: Population = field(default_factory=Population.empty)
    next_id: int = 0
    time: float | None = None


@dataclass
class Tracker:
    """Detections to identities, a frame at a time; the components are the configuration.

    costs: weights with costs. sigmas: how far the regions of eqs. 3-4 are stretched, in standard
    deviations. strong_score: detections from it on are matched first, the weaker ones to what
    is left of the tracks. tie_break: added per unit of image distance where costs are equal.
    """

    camera: Camera
    costs: WeightedCosts
    lift: Lift = Lift()
    dynamics: Dynamics = Still()
    suppress: Suppression = Suppression()
    associate: Associate = Hungarian()
    lifecycle: Lifecycle = Lifecycle()
    sigmas: float = 1.0
    strong_score: float = 0.0
    tie_break: float = 1e-3
    state: State = field(default_factory=State)

    @classmethod
    def paper(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """The paper's two-frame scheme on its geometric cues, 3D-3D and 3D-2D."""
        weights = ((0.6, Volume()), (0.4, Reprojection())) if costs is None else costs
        return cls(camera, weights, suppress=Suppression(min_score=0.3))

    @classmethod
    def default(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """The same costs with a memory, a motion model and two score stages: our best."""
        return cls(
            camera,
            ((1.0, ImageOverlap(0.1)),) if costs is None else costs,
            lift=Lift(use_box_height=True),
            dynamics=ConstantVelocity(),
            suppress=Suppression(min_score=0.3, max_iou=0.5),
            associate=Hungarian(max_cost=0.7),
            lifecycle=Lifecycle(birth_score=0.8, max_gap=3.0),
            strong_score=0.8,
        )

    def step(self, frame: Frame) -> Tracks:
        """The rows (frame, id, box, score) of this frame; every detection at most once."""
        detections = self.suppress(frame.detections, self.camera)
        observed = self.lift(detections, self.camera)
        expected = self._expect(frame)
        pairing = Pairing(expected.beliefs, observed, detections, self.camera, self.sigmas)
        match = self._match(self._cost_matrix(pairing), detections.scores >= self.strong_score)
        born = match.new[detections.scores[match.new] >= self.lifecycle.birth_score]
        rows, columns = match.pairs.T
        seen = Population(
            np.concatenate((expected.ids[rows], self.state.next_id + np.arange(len(born)))),
            Beliefs.concatenate(
                (
                    self.dynamics.update(expected.beliefs.select(rows), observed.select(columns)),
                    observed.select(born),
                )
            ),
            np.zeros(len(rows) + len(born)),
            np.concatenate((expected.sightings[rows] + 1, np.ones(len(born), np.int64))),
        )
        lost = expected.select(match.lost)
        lost = lost.select(self.lifecycle.survives(lost, self.camera))
        self.state = State(
            Population.concatenate((seen, lost)), self.state.next_id + len(born), frame.time
        )
        return _rows(frame.index, seen.ids, detections.select(np.concatenate((columns, born))))

    def reset(self) -> None:
        """Forget everything; ids start at 0 again."""
        self.state = State()

    def _expect(self, frame: Frame) -> Population:
        """The living tracks where they should be at this frame."""
        population = self.state.population
        if len(population) == 0:
            return population
        dt = frame.time - self.state.time if self.state.time is not None else 0.0
        beliefs, moved = self.dynamics.predict(population.beliefs, dt)
        T_now_before, motion_cov = frame.T_now_before, frame.motion_cov
        if T_now_before is None:
            T_now_before, motion_cov = np.eye(4), UNKNOWN_MOTION_COV
        elif motion_cov is None:
            motion_cov = np.zeros((6, 6))
        beliefs = transport(beliefs, self.camera, T_now_before, motion_cov, moved)
        return replace(population, beliefs=beliefs, unseen=population.unseen + dt)

    def _cost_matrix(self, pairing: Pairing) -> Float[Array, "n m"]:
        """Rows expected, columns observed; inf outside the search areas."""
        matrix = np.full(pairing.shape, np.inf)
        rows, columns = pairing.pairs
        if len(rows):
            total, _ = weighted_sum(pairing, self.costs)
            if self.tie_break:
                total += self.tie_break * _image_distance(pairing)
            matrix[rows, columns] = total
        return matrix

    def _match(self, costs: Float[Array, "n m"], strong: Bool[Array, " m"]) -> Match:
        """Strong detections first; weak ones take what is left."""
        if strong.all():
            return self.associate(costs)
        first_columns, second_columns = np.flatnonzero(strong), np.flatnonzero(~strong)
        first = self.associate(costs[:, first_columns])
        second = self.associate(costs[np.ix_(first.lost, second_columns)])
        pairs = np.concatenate((
            np.stack((first.pairs[:, 0], first_columns[first.pairs[:, 1]]), axis=1),
            np.stack((first.lost[second.pairs[:, 0]], second_columns[second.pairs[:, 1]]), axis=1),
        ))  # fmt: skip
        return Match.of(pairs, *costs.shape)


def _image_distance(pairing: Pairing) -> Float[Array, " k"]:
    """From 0 to 1: how far the new box's centre is from the expected one, in box diagonals."""
    rows, columns = pairing.pairs
    expected, observed = pairing.expected.boxes[rows], pairing.observed.boxes[columns]
    off = 0.5 * (expected[:, :2] + expected[:, 2:] - observed[:, :2] - observed[:, 2:])
    distance = np.hypot(off[:, 0], off[:, 1])
    side = observed[:, 2:] - observed[:, :2]
    return distance / (distance + np.hypot(side[:, 0], side[:, 1]))


def _rows(frame: int, ids: Int[Array, " n"], detections: Detections) -> Tracks:
    """The track rows of one frame."""
    return Tracks(np.full(len(ids), frame), ids, detections.boxes, detections.scores)
