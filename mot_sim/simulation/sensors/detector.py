"""A detector: a profile of effects over the sightings of a whole drive, or of one frame."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.metrics.matching import same_frame_pairs
from mot_sim.simulation.cars import Vehicles
from mot_sim.simulation.sensors.boxes import Border, has_area
from mot_sim.simulation.sensors.checks import require_sigmas
from mot_sim.simulation.sensors.correlated_noise import (
    Autocorrelation,
    NoiseRequest,
    prefetch_draws,
)
from mot_sim.simulation.sensors.multiplicity import MIN_DUPLICATE_IOU
from mot_sim.simulation.sensors.profile import Profile, find_profile
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from mot_sim.simulation.truth import Truth
from tracker.geometry import box_iou
from tracker.types import Camera, Detections, Rows

Source = Literal["object", "duplicate", "merged", "split", "clutter"]
NO_OBJECT = -1


@dataclass(frozen=True, eq=False)
class Provenance(Rows):
    """Where each detection comes from, in the order of its log."""

    sources: Shaped[Array, " n"]
    """'object', 'duplicate', 'merged', 'split' or 'clutter'."""
    ids: Int[Array, " n"]
    """Object of truth that it shows, or is a copy or a part of; -1 for clutter."""
    others: Int[Array, " n"]
    """The second object in a merged box, else -1."""

    @classmethod
    def of(cls, source: Source, ids: Int[Array, " n"]) -> "Provenance":
        """Rows of one source."""
        return cls(np.full(len(ids), source, "<U9"), ids, np.full(len(ids), NO_OBJECT))


@dataclass(frozen=True, eq=False)
class Sensed:
    """What a detector gave."""

    log: DetectionLog
    """The detections."""
    provenance: Provenance
    """Where each of them comes from."""

    @classmethod
    def of(
        cls, frames: Int[Array, " n"], detections: Detections, provenance: Provenance
    ) -> "Sensed":
        """From the columns."""
        return cls(DetectionLog(frames, detections), provenance)


@dataclass(frozen=True, eq=False)
class Responses(Rows):
    """What the detector makes of each sighting."""

    sightings: Sightings
    """What could be seen."""
    boxes: Float[Array, "n 4"]
    """Boxes with their errors, pixels; may reach out of the image."""
    scores: Float[Array, " n"]
    """Confidence, 0 to 1."""
    sure: Float[Array, " n"]
    """Confidence with all noise of scores and before any suppression, 0 to 1: errors go by it."""
    reported: Bool[Array, " n"]
    """Whether it is reported: taken for a car, and not missed."""
    provenance: Provenance
    """Where each row comes from."""


@dataclass(frozen=True)
class Detector:
    """Sees what is true with the noise of a profile; each level scales one kind of noise.

    Level 1 is the profile, level 0 none of it: with every level 0, or the profile `perfect`, the
    boxes are exact and all scores are 1. A car of which no pixel is visible is never seen, at any
    level.
    """

    profile: str | Profile = "rrc"
    """Whose noise it is: a name of PROFILES, a TOML file, `module:function`, or a Profile."""
    jitter: float = 1.0
    """Factor on the errors of boxes, >= 0; more: boxes jump more; 0 turns off `visible_part`
    too."""
    misses: float = 1.0
    """Factor on the rates at which cars go unseen, >= 0; more: more gaps; 0 turns off `confusion`
    and `suppression` too."""
    score_noise: float = 1.0
    """Factor on how far scores are below 1, >= 0; more: lower, more varied scores."""
    clutter: float = 1.0
    """Factor on the rates of false alarms and duplicates, >= 0; 0 turns off merges and splits
    too."""
    cues: float = 1.0
    """Factor on the errors of yaw, size, keypoints, shape and appearance, >= 0; more: less exact
    cues."""
    effects: Profile = field(init=False, repr=False, compare=False)
    """The effects of the profile."""

    def __post_init__(self) -> None:
        levels = self.jitter, self.misses, self.score_noise, self.clutter, self.cues
        require_sigmas("a detector's level of noise", *levels)
        given = self.profile
        effects = given if isinstance(given, Profile) else find_profile(given)
        object.__setattr__(self, "effects", effects)

    def __call__(
        self,
        truth: Truth,
        seed: int,
        camera: Camera,
        frame_count: int | None = None,
        vehicles: Vehicles | None = None,
    ) -> DetectionLog:
        """The detections of all frames of an episode, clipped to the image.

        vehicles: who the cars are, for profiles that see shapes.
        """
        frames = None if frame_count is None else np.arange(frame_count)
        return self.sense(
            Sightings.from_truth(truth, vehicles), seed, camera, STEP_SECONDS, frames
        ).log

    def sense(
        self,
        sightings: Sightings,
        seed: int,
        camera: Camera,
        step: float = STEP_SECONDS,
        frames: Int[Array, " f"] | None = None,
    ) -> Sensed:
        """Detections and where each came from; step: seconds between frames.

        frames: those that are asked for (false alarms come in empty ones too); None: all up to
        the last with an object. One frame at a time gives the same bits as the whole drive at
        once.
        """
        if frames is None:
            frames = np.arange(int(sightings.frames.max(initial=-1)) + 1)
        prefetch_draws(seed, sightings.ids, sightings.frames, self._noise_request, step)
        responses = self._responses(sightings, seed, step)
        responses = self._suppressed(responses, seed, camera, step)
        reported = responses if responses.reported.all() else responses.select(responses.reported)
        merged = self._merged(reported, seed, step)
        parts = self._with_splits(merged, seed, step)
        parts += self._duplicates(responses, seed, step)
        parts += self._false_alarms(sightings, frames, seed, camera, step)
        return _put_together(parts, self.effects.border or Border(), camera)

    @cached_property
    def _noise_request(self) -> NoiseRequest:
        """The correlated normals that every sighting needs."""
        effects = self.effects
        found: list[tuple[str, tuple[Autocorrelation, ...]]] = []
        if effects.misses is not None:
            found.append(("miss", effects.misses.autocorrelations))
        if effects.jitter is not None:
            found.append(("jitter", effects.jitter.autocorrelations))
        if effects.scores is not None:
            found.append(("score", (effects.scores.autocorrelation,)))
        if effects.duplicates is not None:
            found.append(("duplicate", (effects.duplicates.autocorrelation,)))
        return tuple(found)

    def _responses(self, sightings: Sightings, seed: int, step: float) -> Responses:
        """Box, score and whether it is reported, of every sighting alone."""
        effects = self.effects
        taken_for_cars = np.ones(len(sightings), bool)
        if effects.confusion is not None and self.misses > 0.0:
            taken_for_cars = effects.confusion(sightings, seed, step)
        missed, ease = self._missed(sightings, seed, step)
        boxes = sightings.boxes
        if effects.visible_part is not None and self.jitter > 0.0:
            boxes = effects.visible_part(sightings)
        scores = sure = self._sure(sightings, ease, seed, step)
        if effects.scores is not None and self.score_noise != 1.0:
            scores = effects.scores(sightings, ease, seed, step, self.score_noise)
        if effects.jitter is not None:
            boxes = effects.jitter(boxes, sightings, sure, seed, step, self.jitter)
        provenance = Provenance.of("object", sightings.ids)
        return Responses(sightings, boxes, scores, sure, taken_for_cars & ~missed, provenance)

    def _missed(
        self, sightings: Sightings, seed: int, step: float
    ) -> tuple[Bool[Array, " n"], Float[Array, " n"]]:
        """Who goes unseen, and how well each of the others was seen; see `Misses`."""
        if self.effects.misses is None:
            return sightings.visible <= 0.0, np.zeros(len(sightings))
        return self.effects.misses(sightings, seed, step, self.misses)

    def _sure(
        self, sightings: Sightings, ease: Float[Array, " n"], seed: int, step: float
    ) -> Float[Array, " n"]:
        """The confidence with all noise of scores: boxes are as far off as with all of it."""
        if self.effects.scores is None:
            return np.ones(len(sightings))
        return self.effects.scores(sightings, ease, seed, step, 1.0)

    def _suppressed(
        self, responses: Responses, seed: int, camera: Camera, step: float
    ) -> Responses:
        """The responses without those that lose against a stronger one close by."""
        rows = np.flatnonzero(responses.reported)
        if self.effects.suppression is None or self.misses <= 0.0 or not len(rows):
            return responses
        sightings, scores = responses.sightings, responses.scores.copy()
        lost, scores[rows] = self.effects.suppression(
            sightings.frames[rows], sightings.ids[rows], camera.clip_boxes(responses.boxes[rows]),
            scores[rows], seed, step, self.misses, self.score_noise,
        )  # fmt: skip
        reported = responses.reported.copy()
        reported[rows[lost]] = False
        return responses.replaced(scores=scores, reported=reported)

    def _merged(self, responses: Responses, seed: int, step: float) -> Responses:
        """The responses, of which some take in another one that hides behind them."""
        if self.effects.merges is None or self.clutter <= 0.0:
            return responses
        sightings, boxes = responses.sightings, responses.boxes.copy()
        kept, gone, around = self.effects.merges(sightings, responses.boxes, seed, step)
        boxes[kept] = around
        provenance = Provenance.of("object", sightings.ids)
        provenance.sources[kept], provenance.others[kept] = "merged", sightings.ids[gone]
        left = np.ones(len(boxes), bool)
        left[gone] = False
        return responses.replaced(boxes=boxes, provenance=provenance).select(left)

    def _with_splits(self, responses: Responses, seed: int, step: float) -> list[Sensed]:
        """The detections of the responses, and the second halves of those that are split."""
        sightings, boxes, scores = responses.sightings, responses.boxes, responses.scores
        provenance, halves = responses.provenance, []
        if self.effects.splits is not None and self.clutter > 0.0:
            split, one, other = self.effects.splits(sightings, boxes, seed, step)
            boxes = boxes.copy()
            boxes[split] = one
            provenance.sources[split] = "split"
            second = Provenance.of("split", sightings.ids[split])
            frames = sightings.frames[split]
            halves = [Sensed.of(frames, Detections(other, scores[split]), second)]
        detections = Detections(boxes, scores, **self._cues(sightings, seed, step))
        return [Sensed.of(sightings.frames, detections, provenance), *halves]

    def _duplicates(self, responses: Responses, seed: int, step: float) -> list[Sensed]:
        """Second boxes about cars, also about cars that are missed."""
        if self.effects.duplicates is None:
            return []
        sightings, missed = responses.sightings, ~responses.reported
        rows, boxes, scores = self.effects.duplicates(
            sightings, responses.boxes, missed, seed, step, self.clutter
        )
        parts = [self._second_boxes(sightings.select(rows), boxes, scores, seed, step)]
        if self.effects.duplicates.has_jumps:
            parts += self._left_behind(responses.select(responses.reported), seed, step)
        return [part for part in parts if len(part.log.frames)]

    def _left_behind(self, found: Responses, seed: int, step: float) -> list[Sensed]:
        """Boxes of the frame before, of cars whose box jumps."""
        jitter, duplicates = self.effects.jitter, self.effects.duplicates
        if jitter is None or jitter.hold == 0.0 or duplicates is None:
            return []
        found = found.select(
            duplicates.may_be_left_behind(found.sightings, found.scores, seed, self.clutter)
        )
        if not len(found):
            return []
        sightings = found.sightings
        sure = self._sure_before(sightings, seed, step)
        before = jitter(sightings.boxes, sightings, sure, seed, step, self.jitter, back=1)
        rows, scores = duplicates.left_behind(sightings, found.boxes, before, seed)
        return [self._second_boxes(sightings.select(rows), before[rows], scores, seed, step)]

    def _sure_before(self, sightings: Sightings, seed: int, step: float) -> Float[Array, " n"]:
        """The confidence a frame before, as if all were seen then as now; see `Responses.sure`."""
        before = sightings.replaced(frames=np.maximum(sightings.frames - 1, 0))
        return self._sure(before, self._missed(before, seed, step)[1], seed, step)

    def _second_boxes(
        self,
        sightings: Sightings,
        boxes: Float[Array, "n 4"],
        scores: Float[Array, " n"],
        seed: int,
        step: float,
    ) -> Sensed:
        """Second boxes with their cues."""
        provenance = Provenance.of("duplicate", sightings.ids)
        detections = Detections(boxes, scores, **self._cues(sightings, seed, step))
        return Sensed.of(sightings.frames, detections, provenance)

    def _false_alarms(
        self,
        sightings: Sightings,
        frames: Int[Array, " f"],
        seed: int,
        camera: Camera,
        step: float,
    ) -> list[Sensed]:
        """Boxes where no car is; what lies about one is a second box (see `Duplicates`)."""
        if self.effects.clutter is None:
            return []
        found = self.effects.clutter(frames, seed, camera, step, self.clutter)
        mine, theirs = same_frame_pairs(found.frames, sightings.frames)
        free = np.ones(len(found), bool)
        free[mine[box_iou(found.boxes[mine], sightings.boxes[theirs]) >= MIN_DUPLICATE_IOU]] = False
        found = found.select(free)
        if not len(found):
            return []
        provenance = Provenance.of("clutter", np.full(len(found), NO_OBJECT))
        return [Sensed.of(found.frames, Detections(found.boxes, found.scores), provenance)]

    def _cues(
        self, sightings: Sightings, seed: int, step: float
    ) -> dict[str, Float[Array, "n ..."]]:
        """The columns that the profile measures."""
        effects, found = self.effects, {}
        if effects.pose is not None:
            found["yaw"], found["size"] = effects.pose(sightings, seed, step, self.cues)
        for name in ("keypoints", "shape", "appearance"):
            effect = getattr(effects, name)
            column = None if effect is None else effect(sightings, seed, step, self.cues)
            if column is not None:
                found["descriptor" if name == "appearance" else name] = column
        if effects.pose is not None and effects.shape is not None and "shape" in found:
            yaw = effects.pose.std(sightings, self.cues)
            shape = effects.shape.stated_std(sightings, self.cues)
            found["pose_cov"] = _pose_covariance(yaw, shape, found["shape"].shape[1])
        return found


def _put_together(parts: list[Sensed], border: Border, camera: Camera) -> Sensed:
    """All parts in the order of frames; cues that a part lacks are NaN there."""
    first = parts[0].log.detections
    frames = np.concatenate([part.log.frames for part in parts])
    detections = Detections.concatenate([_with_cues(part.log.detections, first) for part in parts])
    provenance = Provenance.concatenate([part.provenance for part in parts])
    boxes = border(detections.boxes, camera)
    detections = replace(detections, boxes=boxes)
    usable = has_area(boxes)
    if usable.all() and (frames[1:] >= frames[:-1]).all():
        return Sensed.of(frames, detections, provenance)
    rows = np.flatnonzero(usable)
    rows = rows[np.argsort(frames[rows], kind="stable")]
    return Sensed.of(frames[rows], detections.select(rows), provenance.select(rows))


def _pose_covariance(
    yaw: Float[Array, " n"], shape: Float[Array, " n"], coefficients: int
) -> Float[Array, "n c c"]:
    """The covariance of (yaw, shape) that a fit states that knows these stds of its own."""
    stds = np.column_stack([yaw, *[shape] * coefficients])
    return np.eye(1 + coefficients) * np.square(stds)[:, None, :]


def _with_cues(part: Detections, model: Detections) -> Detections:
    """The part with a NaN column for every cue of the model that it lacks."""
    columns = {}
    for name in Detections.__match_args__[2:]:
        column, like = getattr(part, name), getattr(model, name)
        if column is None and like is not None:
            columns[name] = np.full((len(part), *like.shape[1:]), np.nan)
    return replace(part, **columns) if columns else part
