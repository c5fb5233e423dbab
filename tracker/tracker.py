"""The online tracker: one frame in, the identities of its detections out."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.association import Associate, Hungarian, Match, match_in_stages
from tracker.beliefs import Beliefs, Lift
from tracker.box_filter import BoxFilter, Gains
from tracker.camera_rotation_filter import CameraRotationFilter
from tracker.costs import (
    GatedPairs,
    ImageOverlap,
    Reprojection,
    Volume,
    WeightedCosts,
    weighted_sum,
)
from tracker.dynamics import ConstantPosition, ConstantVelocity, Dynamics
from tracker.ego_motion import camera_motion, compensate_ego_motion
from tracker.errors import BadConfig
from tracker.existence import DetectorStatistics, ExistenceFilter
from tracker.explain import Explanation
from tracker.lifecycle import NO_TRACKS, ActiveTracks, Lifecycle
from tracker.state import TrackerState, TrackerStatistics
from tracker.suppression import Suppression
from tracker.types import Camera, Detections, Frame, Tracks


@dataclass
class Tracker:
    """Detections to identities, a frame at a time; the components are the configuration.

    costs: weights with costs. sigmas: how far the regions of eqs. 3-4 are stretched, in standard
    deviations. strong_score: detections from it on are matched first, the weaker ones to what
    is left of the tracks. tie_break: added per unit of image distance, so that equal costs are
    decided: a box inside the search area costs 0 in eqs. 3-4, whichever track it belongs to.
    existence: decides which tracks are written out, seen or not; None: those seen, and no other.
    box_filter: how far a new box is believed; None: it is taken as it is.
    camera_rotation_filter: corrects an uncertain turn of the camera; None: it is taken as it is.
    explain: keep the last step's `explanation`. Scores are taken as probabilities.
    The whole memory is `state`; assign it to go back.
    """

    camera: Camera
    costs: WeightedCosts
    lift: Lift = Lift()
    dynamics: Dynamics = ConstantPosition()
    suppress: Suppression = Suppression()
    associate: Associate = Hungarian()
    lifecycle: Lifecycle = Lifecycle()
    sigmas: float = 1.0
    strong_score: float = 0.0
    tie_break: float = 1e-3
    existence: ExistenceFilter | None = None
    box_filter: BoxFilter | None = None
    camera_rotation_filter: CameraRotationFilter | None = None
    explain: bool = False
    state: TrackerState = TrackerState()
    explanation: Explanation | None = None

    def __post_init__(self) -> None:
        weights = [weight for weight, _ in self.costs]
        if not weights or min(weights) < 0.0 or not 0.0 < sum(weights) < np.inf:
            raise BadConfig(f"weights {weights}: they must not be negative, and not all zero")
        if not 0.0 <= self.sigmas < np.inf:
            raise BadConfig(f"sigmas {self.sigmas:g}: give a finite number, 0 or more")

    @classmethod
    def paper(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """The paper's two-frame scheme on its geometric cues, 3D-3D and 3D-2D.

        The weights are those of the authors' script; CONTRIBUTING.md lists what the paper leaves
        open and what was chosen here.
        """
        weights = ((0.6, Volume()), (0.4, Reprojection())) if costs is None else costs
        return cls(camera, weights, suppress=Suppression(min_score=0.5))

    @classmethod
    def default(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """Our best: the paper's lifting and search areas, with memory and a motion model.

        The cost is the overlap of the new box with the expected one, which ego-motion and the
        car's velocity carried over the road in 3D; mixing in 3D-3D or 3D-2D changes HOTA on
        KITTI by -0.6 to +0.1 (README, what each choice is worth).
        """
        return cls(
            camera,
            ((1.0, ImageOverlap(0.1)),) if costs is None else costs,
            lift=Lift(use_box_height=True),
            dynamics=ConstantVelocity(),
            suppress=Suppression(min_score=0.3, max_iou=0.5),
            associate=Hungarian(max_cost=0.7),
            lifecycle=Lifecycle(birth_score=0.8, max_gap=3.0),
            strong_score=0.8,
            tie_break=0.0,
            existence=ExistenceFilter(),
            box_filter=BoxFilter(),
            camera_rotation_filter=CameraRotationFilter(),
        )

    def step(self, frame: Frame) -> Tracks:
        """The rows of this frame, with cuboids in its road frame; no detection twice.

        With `evidence` also the predicted boxes of tracks that should be there but were not
        seen; the score of such a row is the probability that the object exists.
        """
        detections = self.suppress(frame.detections, self.camera)
        observed = self.lift(detections, self.camera)
        expected = self._predict(frame, detections)
        pairing = GatedPairs(expected.beliefs, observed, detections, self.camera, self.sigmas)
        costs, counts = self._cost_matrix(pairing)
        scores = detections.scores
        match = match_in_stages(costs, scores >= self.strong_score, self.associate)
        if self.explain:
            given = (frame.index, expected.ids, pairing, self.costs, costs, match)
            self.explanation = Explanation.of(*given)
        born = match.unmatched_detections
        if len(born):
            born = born[scores[born] >= self.lifecycle.birth_score]
        population, rates, gains = self._update(frame.time, expected, observed, scores, match, born)
        next_id = self.state.next_id + len(born)
        self.state = TrackerState(population, next_id, frame.time, counts, rates, gains)
        return self._output_rows(frame.index, population)

    def reset(self) -> None:
        """Forget everything; ids start at 0 again."""
        self.state, self.explanation = TrackerState(), None

    def _predict(self, frame: Frame, detections: Detections) -> ActiveTracks:
        """The living tracks where they should be at this frame."""
        population, before = self.state.tracks, self.state.time
        dt = 0.0 if before is None else elapsed(frame, before)
        if len(population) == 0 or before is None:
            return population
        beliefs, _ = self.predict_tracks(population, frame, dt, detections)
        existence = population.existence
        if self.existence is not None:
            existence = existence * self.existence.survival(dt)
        unseen, scores = population.time_since_update + dt, np.full(len(existence), np.nan)
        return population.replaced(
            beliefs=beliefs, time_since_update=unseen, existence=existence, scores=scores
        )

    def predict_tracks(
        self, population: ActiveTracks, frame: Frame, dt: float, detections: Detections
    ) -> tuple[Beliefs, Float[Array, "4 4"]]:
        """The beliefs where they should be at this frame, dt seconds later; T_now_before.

        detections: of this frame, by which an uncertain turn of the camera is corrected.
        """
        beliefs, moved = self.dynamics.predict(population.beliefs, dt)
        T_now_before, motion_cov = camera_motion(frame)
        carried = compensate_ego_motion(beliefs, self.camera, T_now_before, motion_cov, moved)
        turn_filter = self.camera_rotation_filter
        if turn_filter is None or frame.T_now_before is None:
            return carried, T_now_before
        if not turn_filter.is_uncertain(motion_cov, self.camera):
            return carried, T_now_before
        boxes = (
            carried.boxes[population.time_since_update <= 0.0],
            detections.boxes,
        )  # of those just seen
        T_now_before, motion_cov = turn_filter(*boxes, T_now_before, motion_cov, self.camera)
        return compensate_ego_motion(
            beliefs, self.camera, T_now_before, motion_cov, moved
        ), T_now_before

    def _update(
        self,
        time: float,
        expected: ActiveTracks,
        observed: Beliefs,
        scores: Float[Array, " m"],
        match: Match,
        born: Int[Array, " b"],
    ) -> tuple[ActiveTracks, DetectorStatistics, Gains | None]:
        """The living after this frame, in their old order, then the newborns; what was learned."""
        rows, columns = match.pairs.T
        lost = expected.select(match.unmatched_tracks) if len(match.unmatched_tracks) else NO_TRACKS
        matched = expected if _is_all(rows, len(expected)) else expected.select(rows)
        scores_seen, scores_born = scores.take(columns), scores.take(born)
        dt = 0.0 if self.state.time is None else time - self.state.time
        rates, gains = self.state.detector, self.state.gains
        seen, surprises, gains = self.update_tracks(matched, observed.select(columns), dt, gains)
        there, still, new = np.ones(len(rows)), lost.existence, np.ones(len(born))
        if self.existence is not None:
            judged = rates, matched, lost, (scores_seen, scores_born)
            there, still, new, rates = self.existence(*judged, observed.boxes, dt, self.camera)
        population = matched.seen_again(seen, scores_seen, there, surprises)
        if len(lost):
            population = expected.updated(rows, population)
            population.existence[match.unmatched_tracks] = still
            population = self.lifecycle.living(population, self.camera)
        if len(born):
            newborn = ActiveTracks.born(observed.select(born), scores_born, new, self.state.next_id)
            population = ActiveTracks.concatenate((population, newborn))
        return population, rates, gains

    def update_tracks(
        self, matched: ActiveTracks, observed: Beliefs, dt: float, gains: Gains | None
    ) -> tuple[Beliefs, Float[Array, "k 4"], Gains | None]:
        """What to believe of tracks (as expected now) that were seen as observed, row by row.

        dt: seconds since the last frame. Also their surprises, and the gains as learned since.
        """
        seen = self.dynamics.update(matched.beliefs, observed)
        if self.box_filter is None:
            return seen, matched.innovations, gains
        known = self.box_filter.start() if gains is None else gains
        boxes, surprises, gains = self.box_filter(known, matched, seen.boxes, dt, self.camera)
        return seen.replaced(boxes=boxes), surprises, gains

    def _output_rows(self, index: int, population: ActiveTracks) -> Tracks:
        """The rows of this frame: those seen, with their scores, and those that should be there."""
        unseen = np.isnan(population.scores)
        written = ~unseen if self.existence is None else self.existence.written(population)
        if np.count_nonzero(written) < len(population):
            population, unseen = population.select(written), unseen[written]
        boxes, scores = population.beliefs.boxes, population.scores
        if np.count_nonzero(unseen):
            boxes = np.where(unseen[:, None], self.camera.clip_boxes(boxes), boxes)
            scores = np.where(unseen, population.existence, scores)
        frames = np.full(len(scores), index)
        cuboids = population.beliefs.cuboids
        return Tracks(frames, population.ids, boxes, scores, cuboids=cuboids)

    def _cost_matrix(self, pairing: GatedPairs) -> tuple[Float[Array, "n m"], TrackerStatistics]:
        """Rows expected, columns observed; inf outside the search areas. And the new counts."""
        matrix = np.full(pairing.shape, np.inf)
        rows, columns = pairing.pairs
        unmeasured = 0
        if len(rows):
            total, _, unmeasured = weighted_sum(pairing, self.costs)
            if self.tie_break:
                total = total + self.tie_break * pairing.image_distance
            matrix[rows, columns] = total
        old = self.state.statistics
        return matrix, TrackerStatistics(
            old.frames + 1,
            old.pairs + matrix.size,
            old.compared + len(rows),
            old.unmeasured + unmeasured,
        )


def elapsed(frame: Frame, before: float) -> float:
    """Seconds since the frame at the time `before`; BadConfig when time goes backwards."""
    if not frame.time >= before:
        raise BadConfig(
            f"frame {frame.index} at {frame.time:g} s comes after one at {before:g} s: "
            "frames go forward in time; call reset() between sequences"
        )
    return frame.time - before


def _is_all(rows: Int[Array, " k"], count: int) -> bool:
    """Whether the rows are 0 ... count - 1, in order."""
    return len(rows) == count and bool((rows[1:] > rows[:-1]).all())
