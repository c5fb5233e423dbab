"""The online tracker: one frame in, the identities of its detections out."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.association import Associate, Hungarian, Match, match_in_stages
from tracker.beliefs import Beliefs, Lift
from tracker.box_filter import BoxFilter, Gains
from tracker.camera_rotation_filter import CameraRotationFilter
from tracker.car_filter import CarFilter, CarStates, RoadMemory, expected_after
from tracker.cost_matrix import CostMatrix
from tracker.costs import (
    GatedPairs,
    ImageOverlap,
    Reprojection,
    Volume,
    WeightedCosts,
    weighted_sum,
)
from tracker.dynamics import OUR_DYNAMICS, ConstantPosition, ConstantVelocity, Dynamics
from tracker.ego_motion import CameraMotion, compensate_ego_motion
from tracker.errors import BadConfig
from tracker.existence import ExistenceFilter
from tracker.expectation import Expectation
from tracker.explain import Explanation
from tracker.gap_rows import GapRows
from tracker.lifecycle import ActiveTracks, Lifecycle, Partners
from tracker.motion_check import Contradiction
from tracker.output_rows import NO_GAPS, rows_of
from tracker.renewal import Renewal, picked
from tracker.score_scale import ScoreMemory, ScoreScale
from tracker.state import TrackerState
from tracker.suppression import Suppression
from tracker.types import Camera, CarEstimates, Detections, Frame, Tracks


@dataclass
class Tracker:
    """Detections to identities, a frame at a time; the components are the configuration.

    Scores are taken as probabilities. The whole memory is `state`; assign it to go back.
    """

    camera: Camera
    """The camera of the drive: intrinsics, and where it stands above the road."""
    costs: WeightedCosts
    """Weights with costs; the cost of a pair is their weighted mean. Weights must be >= 0, and one
    > 0."""
    lift: Lift = Lift()
    """How detections are placed on the road, with which uncertainty."""
    dynamics: Dynamics = ConstantPosition()
    """How an unseen car moves."""
    suppress: Suppression = Suppression()
    """Which detections are dropped before anything else."""
    associate: Associate = Hungarian()
    """How costs become pairs of tracks and detections."""
    lifecycle: Lifecycle = Lifecycle()
    """When tracks begin and end."""
    sigmas: float = 1.0
    """How far the regions of eqs. 3-4 are stretched, in standard deviations, >= 0; more: larger
    search areas."""
    strong_score: float = 0.0
    """Detections from this score on are matched first, weaker ones to the tracks that are left."""
    tie_break: float = 1e-3
    """Cost per unit of image distance. It decides between equal costs: a box inside the search
    area costs 0 in eqs. 3-4, whichever track it belongs to."""
    score_scale: ScoreScale | None = None
    """Makes probabilities of the detector's scores; None: they are taken as they are."""
    existence: ExistenceFilter | None = None
    """Decides which tracks are put out, detected or not; None: the detected ones and no others."""
    box_filter: BoxFilter | None = None
    """Mixes new boxes with the predicted ones; None: new boxes are taken as they are."""
    camera_rotation_filter: CameraRotationFilter | None = None
    """Corrects an uncertain rotation of the camera; None: it is taken as it is."""
    car_filter: CarFilter | None = None
    """Follows heading, speed and size of the cars, and carries their boxes along; None: cuboids are
    back-projected boxes."""
    gap_rows: GapRows | None = None
    """Decides which undetected cars are put out if a `car_filter` and the motion of the camera are
    there; else, or with None, `existence` does."""
    state_assumed: bool = True
    """Whether rows state headings and sizes that `lift` only assumes; False: NaN, unknown."""
    explain: bool = False
    """Whether to keep the `explanation` of the last step."""
    state: TrackerState = TrackerState()
    """The whole memory; assign it to go back."""
    explanation: Explanation | None = None
    """Why the last step matched as it did; None unless `explain` is set."""

    def __post_init__(self) -> None:
        weights = [weight for weight, _ in self.costs]
        if not weights or min(weights) < 0.0 or not 0.0 < sum(weights) < np.inf:
            raise BadConfig(f"weights {weights}: they must not be negative, and not all zero")
        if not 0.0 <= self.sigmas < np.inf:
            raise BadConfig(f"sigmas {self.sigmas:g}: give a finite number, 0 or more")

    @classmethod
    def paper(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """The paper's two-frame scheme on its geometric cues, 3D-3D and 3D-2D.

        The weights are those of the authors' script; docs/paper.md lists what the paper leaves
        open and what was chosen here.
        """
        weights = ((0.6, Volume()), (0.4, Reprojection())) if costs is None else costs
        return cls(camera, weights, suppress=Suppression(min_score=0.5), state_assumed=False)

    @classmethod
    def default(cls, camera: Camera, costs: WeightedCosts | None = None) -> "Tracker":
        """Our best: the paper's lifting and search areas, with memory and a motion model.

        The cost is the overlap of the new box with the predicted one, which was moved by the
        ego-motion and by the car's velocity on the road in 3D; mixing in 3D-3D or 3D-2D changes
        HOTA on KITTI by -0.6 to +0.1 (docs/results/ablation.md).
        """
        return cls(
            camera,
            ((1.0, ImageOverlap(0.1, drift=0.6)),) if costs is None else costs,
            lift=Lift(use_box_height=True),
            dynamics=ConstantVelocity(),
            suppress=Suppression(min_score=0.3, max_iou=0.5, max_iou_of_sure=0.7),
            associate=Hungarian(max_cost=0.7),
            lifecycle=Lifecycle(birth_score=0.8, max_gap=3.0),
            strong_score=0.8,
            tie_break=0.0,
            score_scale=ScoreScale(),
            existence=ExistenceFilter(),
            box_filter=BoxFilter(),
            camera_rotation_filter=CameraRotationFilter(),
            car_filter=CarFilter(),
            gap_rows=GapRows(),
        )

    def step(self, frame: Frame) -> Tracks:
        """The rows of this frame, with cuboids in its road frame; no detection twice.

        The arrays of the rows are the caller's, and the tracker keeps none of the frame's.
        With `existence` also the predicted boxes of tracks that should be there but were not
        detected; the score of such a row is the probability that it is right (see `gap_rows`), or
        that the object exists. Where nothing looked (`detections` None) all rows are predicted and
        no track is the worse for it: later rows are those of a run without that frame.
        """
        compared = self.cost_matrix(frame)  # suppress, lift, predict, gate, cost
        strong = compared.detections.scores >= self.strong_score
        match = match_in_stages(compared.costs, strong, self.associate)
        return self.apply_match(frame, compared, match)  # update, output

    def cost_matrix(self, frame: Frame) -> CostMatrix:
        """What this frame's detections cost against the predicted tracks, see `CostMatrix`.

        It changes nothing. Raises BadConfig when time goes backwards, MissingCue as the costs do.
        """
        given, memory = self.rescored(self.state.scores, frame)
        detections = self.suppress(given, self.camera)
        observed = self.lift(detections, self.camera)
        motion, dt = self.state.clock.since_look(frame)
        tracks, road, gated = self.state.tracks, self.state.road, None
        T_now_before, cov = motion.T_now_before, motion.covariance
        ours = self._our_dynamics(motion, cov)
        if len(tracks) and ours is not None:
            survival = 1.0 if self.existence is None else self.existence.survival(dt)
            moving = ours, (T_now_before, cov), (dt, survival)
            tracks, gated = Expectation.of(tracks, observed, *moving, self.camera, self.sigmas)
        elif len(tracks):
            tracks, T_now_before = self.predict_tracks(tracks, motion, dt, detections)
        if self.car_filter is not None:
            cars, motion_now = tracks.cars or CarStates.empty(), (T_now_before, cov, dt)
            predicted = self.car_filter.predict(cars, road, *motion_now, self.camera)
            road, tracks = predicted.memory, tracks.replaced(cars=predicted.states)
            carries, estimates = self.car_filter.carries_boxes, self.state.estimates
            if carries and motion.is_known and estimates is not None and len(tracks):
                boxes, expected = self.state.tracks.beliefs.boxes, tracks.beliefs.boxes
                cars_before = tracks.hits, estimates.means, predicted.step
                how = self.car_filter.motion, self.camera
                tracks = tracks.moved_to(expected_after(boxes, expected, *cars_before, *how))
        if gated is None:
            pairs = self.gate(tracks, observed, detections, dt)
        else:
            seen = (tracks.beliefs, observed), detections
            pairs = GatedPairs.known(*seen, (self.camera, self.sigmas, dt), gated)
        costs, unmeasured = self.pair_costs(pairs)
        return CostMatrix(pairs.matrix(costs), tracks, pairs, unmeasured, memory, road)

    def apply_match(self, frame: Frame, compared: CostMatrix, match: Match) -> Tracks:
        """The rows of this frame where this is the match, whoever made it; updates the tracks.

        compared: `cost_matrix(frame)`, since which the state has not changed. Of the unmatched
        detections those with the lifecycle's `birth_score` begin tracks.
        """
        if self.explain:
            ids, pairs, total = compared.tracks.ids, compared.pairs, compared.costs
            self.explanation = Explanation.of(frame.index, ids, pairs, self.costs, total, match)
        if not frame.looked_at:
            clock, statistics = self.state.clock, self.state.statistics.after_frame(0, 0, 0)
            self.state = replace(self.state, clock=clock.after(frame), statistics=statistics)
            estimates = self.car_estimates(compared.tracks, compared.road)
            since_look = clock.seconds_since_look(frame)
            return self._output_rows(frame, compared.tracks, estimates, since_look)
        self.state = self._update(frame, compared, match)
        return self._output_rows(frame, self.state.tracks, self.state.estimates, 0.0)

    @property
    def contradiction(self) -> Contradiction | None:
        """What all boxes so far contradict in the given motion or calibration; None: nothing."""
        return self.state.motion_check.verdict(self.camera, self.lift.car_size[1])

    def reset(self) -> None:
        """Forget everything; ids start at 0 again."""
        self.state, self.explanation = TrackerState(), None

    def rescored(self, memory: ScoreMemory, frame: Frame) -> tuple[Detections, ScoreMemory]:
        """The detections of a frame with probabilities for scores; what is known of the scores.

        memory: before this frame; it stays as it is where nothing looked.
        """
        if self.score_scale is None or not frame.looked_at:
            return frame.found, memory
        memory = self.score_scale.watch(memory, frame.found)
        return self.score_scale(memory, frame.found), memory

    def predict_tracks(
        self, tracks: ActiveTracks, motion: CameraMotion, dt: float, detections: Detections
    ) -> tuple[ActiveTracks, Float[Array, "4 4"]]:
        """The tracks as they should be after this motion, dt seconds later; T_now_before.

        detections: of that moment, by which an uncertain rotation of the camera is corrected.
        """
        beliefs, moved = self.dynamics.predict(tracks.beliefs, dt)
        T_now_before, motion_cov = motion.T_now_before, motion.covariance
        predicted = compensate_ego_motion(beliefs, self.camera, T_now_before, motion_cov, moved)
        rotation_filter = self.camera_rotation_filter
        if rotation_filter is not None and not self._turns_for_certain(motion, motion_cov):
            expected = predicted.boxes[tracks.time_since_update <= 0.0]  # detected just before
            T_now_before, motion_cov = rotation_filter(
                expected, detections.boxes, T_now_before, motion_cov, self.camera
            )
            predicted = compensate_ego_motion(beliefs, self.camera, T_now_before, motion_cov, moved)
        existence = tracks.existence
        if self.existence is not None:
            existence = existence * self.existence.survival(dt)
        predicted_tracks = tracks.replaced(
            beliefs=predicted,
            time_since_update=tracks.time_since_update + dt,
            existence=existence,
            scores=np.full(len(existence), np.nan),
        )
        return predicted_tracks, T_now_before

    def _has_our(self, *steps: str) -> bool:
        """Whether one kernel may take these steps: no class of one's own takes them otherwise."""
        own = type(self)
        return own is Tracker or all(getattr(own, each) is getattr(Tracker, each) for each in steps)

    def _our_dynamics(
        self, motion: CameraMotion, cov: Float[Array, "6 6"]
    ) -> ConstantPosition | ConstantVelocity | None:
        """The dynamics where one kernel may predict and gate by them, else None. cov: of motion."""
        ours = self.dynamics
        if not isinstance(ours, OUR_DYNAMICS) or type(ours) not in OUR_DYNAMICS:
            return None
        is_plain = self._has_our("predict_tracks", "gate") and self._turns_for_certain(motion, cov)
        return ours if is_plain else None

    def _turns_for_certain(self, motion: CameraMotion, cov: Float[Array, "6 6"]) -> bool:
        """Whether no filter corrects the rotation of the camera. cov: of the motion."""
        turns = self.camera_rotation_filter
        return turns is None or not motion.is_known or not turns.is_uncertain(cov, self.camera)

    def gate(
        self, tracks: ActiveTracks, observed: Beliefs, detections: Detections, dt: float
    ) -> GatedPairs:
        """The pairs of predicted tracks and lifted detections that are worth comparing.

        dt: seconds since the last frame that was looked at.
        """
        return GatedPairs(tracks.beliefs, observed, detections, self.camera, self.sigmas, dt)

    def pair_costs(self, pairs: GatedPairs) -> tuple[Float[Array, " k"], int]:
        """The cost of every gated pair, tie break included; how many single costs were NaN."""
        if len(pairs.pairs[0]) == 0:
            return np.zeros(0), 0
        total, _, unmeasured = weighted_sum(pairs, self.costs)
        if self.tie_break:
            total = total + self.tie_break * pairs.image_distance
        return total, unmeasured

    def _update(self, frame: Frame, compared: CostMatrix, match: Match) -> TrackerState:
        """The memory after this frame: the tracks in their old order, then the new ones."""
        state, tracks, observed = self.state, compared.tracks, compared.pairs.observed
        found, dt = compared.detections, state.clock.seconds_since_look(frame)
        partners, road = self.lifecycle.partners(match, found.scores), compared.road
        learned = state.detector, state.gains
        given = tracks, partners, observed, found, learned, dt, state.next_id
        after = self.renewal(*given)
        now = after.tracks
        if self.car_filter is not None:
            cars, road = self._update_cars(tracks.cars, compared, partners, dt)
            now = now.replaced(cars=after.cars(*cars).locked())
        n, m = compared.costs.shape
        counts = n * m, len(compared.pairs.pairs[0]), compared.unmeasured
        T, usual = state.clock.T_since_look(frame), self.lift.car_size[1]
        return TrackerState(
            now,
            state.next_id + len(partners.born),
            state.clock.after(frame),
            state.statistics.after_frame(*counts),
            after.detector,
            after.gains,
            compared.scores,
            state.motion_check.after(frame, T, observed.boxes, self.camera, usual),
            road,
            self.car_estimates(now, road),
        )

    def _update_cars(
        self, cars: CarStates | None, compared: CostMatrix, partners: Partners, dt: float
    ) -> tuple[tuple[CarStates, CarStates, CarStates], RoadMemory]:
        """The cars as predicted, those of detected tracks updated, and new ones; the road."""
        assert self.car_filter is not None
        assert cars is not None  # `cost_matrix` predicted them
        found, boxes = compared.detections, compared.detections.boxes
        matched, seen = picked(cars, partners.rows), picked(found, partners.columns)
        updated = self.car_filter.update(matched, compared.road, seen, boxes, dt, self.camera)
        begun, places = CarStates.empty(), compared.pairs.observed.cuboids.base
        if len(partners.born):
            places, new = places.take(partners.born, 0), found.select(partners.born)
            begun = self.car_filter.start(updated.memory, places, new, boxes, self.camera)
        return (cars, updated.states, begun), updated.memory

    def update_tracks(
        self,
        matched: ActiveTracks,
        observed: Beliefs,
        scores: Float[Array, " k"],
        existence: Float[Array, " k"],
        dt: float,
        gains: Gains | None,
    ) -> tuple[ActiveTracks, Gains | None]:
        """The tracks (as predicted) after detections at `observed`, row by row; gains learned.

        scores: of the detections. existence: after them. dt: seconds since the last frame.
        """
        return self.renewal.updated(matched, observed, scores, existence, dt, gains)

    @property
    def renewal(self) -> Renewal:
        """What renews the tracks by the detections of a frame."""
        parts = self.dynamics, self.box_filter, self.existence, self.lifecycle
        is_ours = self._has_our("update_tracks")
        return Renewal(*parts, self.camera, None if is_ours else self.update_tracks)

    def car_estimates(self, tracks: ActiveTracks, road: RoadMemory) -> CarEstimates | None:
        """The states of the cars behind these tracks; None without a `car_filter`."""
        if self.car_filter is None:
            return None
        return self.car_filter.estimate(tracks.cars or CarStates.empty(), road)

    def _output_rows(
        self, frame: Frame, tracks: ActiveTracks, estimates: CarEstimates | None, since_look: float
    ) -> Tracks:
        """The rows of a frame: tracks detected in it, and those that should be there.

        since_look: seconds since a detector looked; 0: it did at this frame.
        """
        gaps = NO_GAPS
        if estimates is None:
            beliefs = tracks.beliefs
            cuboids = beliefs.cuboids if self.state_assumed else self.lift.measured_part(beliefs)
        else:
            cuboids, unseen = estimates.cuboids(), tracks.time_since_update > since_look
            is_known = frame.T_now_before is not None and self.existence is not None
            if is_known and self.gap_rows is not None and unseen.any():
                gone = unseen.nonzero()[0], tracks, estimates
                likely, chosen = self.gap_rows.of_some(*gone, self.camera)
                gaps = unseen, np.asarray(likely, float), np.asarray(chosen, bool)
        decided = self.existence, gaps, since_look
        return rows_of(frame.index, tracks, *decided, cuboids, estimates, self.camera)


# Trackers by the name that the command line gives them.
TRACKERS: dict[str, Callable[[Camera], Tracker]] = {
    "default": Tracker.default,
    "paper": Tracker.paper,
}
