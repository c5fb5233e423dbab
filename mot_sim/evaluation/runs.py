"""Trackers over whole drives: built by name, run over sequences, results kept as they come."""

import logging
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from time import perf_counter
from typing import Any
from warnings import catch_warnings, simplefilter

from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence, read_results
from mot_sim.evaluation.run_folder import RunFolder, SequenceStatistics
from mot_sim.files.named_objects import (
    ASSOCIATION_NAMES,
    COST_NAMES,
    TRACKER_NAMES,
    make_tracker,
)
from tracker import FRAMEWORKS, Camera, Delayed, Sequence, Tracker, Tracks
from tracker.costs import Cost, WeightedCosts
from tracker.ego import ScaleEstimate
from tracker.errors import BadConfig, MotionWarning
from tracker.front_end import STAGES, FrontEnd, SequenceWithCues, parse_cues
from tracker.per_class import PerClass, for_kind

# Called after every frame with the name of its sequence and the number of frames so far.
Progress = Callable[[str, int], None]

# What a measured cue adds to a tracker's own costs, whose weights sum up to 1: the cost and its
# weight. See docs/paper.md.
CUE_COSTS = {
    "pose": ("shape_pose", 0.1), "appearance": ("appearance", 0.1),
    "classical": ("appearance", 0.1),
}  # fmt: skip

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Recipe:
    """How to build a tracker, all by name; the names are checked here, the camera comes later."""

    tracker: str = "default"
    """A name of TRACKERS, of an installed package, or `module:name` of your own, see
    `NameRegister`."""
    costs: Mapping[str, float] | None = None
    """Weights, finite and > 0, by the cost's name, in place of the tracker's own; None: its own.
    Measured cues add those of CUE_COSTS."""
    associate: str | None = None
    """Name of the association, in place of the tracker's own; None: its own."""
    cues: str = "none"
    """What is measured in images, see `tracker.front_end.parse_cues`."""
    kinds: tuple[str, ...] = ("Car",)
    """The classes that are tracked, of TRACKED_KINDS; each by a tracker of its own."""
    lag: int | None = None
    """How many frames later the rows of a frame are decided, by a sliding window, >= 0; None: as
    the association does it."""

    def __post_init__(self) -> None:
        TRACKER_NAMES.find(self.tracker)
        if self.associate is not None:
            ASSOCIATION_NAMES.find(self.associate)
        if self.lag is not None and self.lag < 0:
            raise BadConfig(f"lag {self.lag}: rows cannot come before their frame; give 0 or more")
        if self.lag is not None and self.associate not in (None, "window"):
            raise BadConfig(
                f"lag {self.lag} with the association {self.associate}: only the window decides "
                "with a lag; leave one of the two out"
            )
        for name, weight in (self.costs or {}).items():
            COST_NAMES.make(name, Cost)
            if not (isfinite(weight) and weight > 0.0):
                raise BadConfig(f"the weight of {name} is {weight:g}; weights are above 0")
        _ = self.front_end

    @cached_property
    def front_end(self) -> FrontEnd | None:
        """What measures the cues; None where none are measured. Raises BadWeights."""
        return FrontEnd.of(self.cues) if parse_cues(self.cues) else None

    def build(self, camera: Camera) -> Tracker | Delayed:
        """The tracker for a camera; another association keeps the tracker's largest cost."""
        if self.kinds == ("Car",):
            return self._build(camera, "Car")
        return PerClass({kind: self._build(camera, kind) for kind in self.kinds})

    def _build(self, camera: Camera, kind: str) -> Tracker | Delayed:
        """The tracker of one class."""
        tracker: Tracker = for_kind(make_tracker(self.tracker, camera, Tracker), kind)
        added = {CUE_COSTS[cue][0]: CUE_COSTS[cue][1] for cue in parse_cues(self.cues)}
        own: WeightedCosts = () if self.costs is not None else tracker.costs
        named = (added if self.costs is None else self.costs).items()
        costs = own + tuple((weight, COST_NAMES.make(name, Cost)) for name, weight in named)
        tracker = replace(tracker, costs=costs)
        if self.lag is not None:
            window: Any = FRAMEWORKS["window"](tracker)
            delayed: Delayed = replace(window, lag=self.lag)
            return delayed
        if self.associate is None:
            return tracker
        whole: Tracker | Delayed = ASSOCIATION_NAMES.make(
            self.associate, (Tracker, Delayed), tracker
        )
        return whole


def parse_costs(text: str) -> dict[str, float]:
    """Weights by cost from `volume=0.6,my_module:MyCost=0.4`; a name alone weighs 1."""
    weights: dict[str, float] = {}
    for part in text.split(","):
        name, _, weight = (piece.strip() for piece in part.partition("="))
        try:
            number = float(weight) if "=" in part else 1.0
        except ValueError:
            number = float("nan")
        if not name or name in weights or not isfinite(number):
            raise BadConfig(f"costs {text!r}: write volume=0.6,reprojection=0.4, each cost once")
        weights[name] = number
    return weights


@dataclass(frozen=True, eq=False)
class TrackingRun:
    """What came of tracking some sequences."""

    tracks: dict[str, Tracks]
    """The tracker's rows, by sequence."""
    counts: dict[str, SequenceStatistics]
    """What was done, by sequence."""
    resumed: tuple[str, ...] = ()
    """The sequences that an earlier run had finished."""

    @property
    def frames_per_second(self) -> float | None:
        """Of wall time, over the sequences that were tracked now; None when none was."""
        fresh = [part for name, part in self.counts.items() if name not in self.resumed]
        seconds = sum(part.seconds for part in fresh)
        return sum(part.frames for part in fresh) / seconds if seconds > 0.0 else None

    @property
    def skipped_share(self) -> float | None:
        """The share of pairs that the search areas spared; None without any pair."""
        pairs = sum(part.pairs for part in self.counts.values())
        compared = sum(part.compared for part in self.counts.values())
        return 1.0 - compared / pairs if pairs else None

    @property
    def stage_ms(self) -> dict[str, float]:
        """Milliseconds a frame that each stage of the front end took; empty without cues."""
        fresh = [part for name, part in self.counts.items() if name not in self.resumed]
        frames = sum(part.frames for part in fresh if part.stages)
        sums = {stage: sum(part.stages.get(stage, 0.0) for part in fresh) for stage in STAGES}
        return {stage: 1e3 * spent / frames for stage, spent in sums.items() if spent}


def track_sequence(
    tracker: Tracker | Delayed,
    sequence: Sequence,
    progress: Progress | None = None,
    front_end: FrontEnd | None = None,
) -> tuple[Tracks, SequenceStatistics]:
    """All rows of one drive, in the order of frames. front_end: measures cues in its images."""
    start, parts, seen = perf_counter(), [], 0
    looked = None if front_end is None else SequenceWithCues(sequence, front_end)
    with catch_warnings():
        simplefilter("ignore", MotionWarning)  # logged below, with the sequence's name
        for number, frame in enumerate(looked or sequence, 1):
            parts.append(tracker.step(frame))
            seen += len(frame.found)
            log.debug(
                "%s frame %d: %d detections, %d rows",
                sequence.name, frame.index, len(frame.found), len(parts[-1]),
            )  # fmt: skip
            if progress is not None:
                progress(sequence.name, number)
    contradiction = getattr(tracker, "contradiction", None)
    if contradiction is not None:
        log.warning("%s: %s", sequence.name, contradiction.text)
    steps = len(parts)
    if isinstance(tracker, Delayed):
        parts.append(tracker.finish())
    tracks = Tracks.concatenate(parts) if parts else Tracks.empty()
    ids = len(set(tracks.ids.tolist()))
    done = tracker.counts if isinstance(tracker, Delayed) else tracker.state.statistics
    seconds = perf_counter() - start
    pairs = done.pairs, done.compared, done.unmeasured
    stages = {} if looked is None else looked.seconds
    ego_scale = getattr(sequence, "ego_scale", None)
    return tracks, SequenceStatistics(
        steps, seen, len(tracks), ids, seconds, *pairs, stages,
        None if contradiction is None else contradiction.text,
        {} if ego_scale is None else _found_scale(ego_scale.estimate),
    )  # fmt: skip


def _found_scale(found: ScaleEstimate) -> dict[str, float]:
    """The scale with its interval; nothing where it is not known."""
    if not found.known:
        return {}
    return {"factor": found.factor, "low": found.low, "high": found.high}


def result_frame(sequence: Sequence) -> Float[Array, "4 4"]:
    """T_road_label: results stand in KITTI's camera 0, or in the camera of any other drive."""
    if isinstance(sequence, KittiSequence):
        return sequence.T_road_label
    return sequence.camera.T_road_cam


def track_sequences(
    sequences: Iterable[Sequence],
    build: Callable[[Camera], Tracker | Delayed],
    folder: RunFolder | None = None,
    progress: Progress | None = None,
    front_end: FrontEnd | None = None,
) -> TrackingRun:
    """Track the sequences one after the other, each with a tracker of its own.

    folder: an entered RunFolder that keeps each sequence as soon as it is finished, and gives
    back those that it holds already. progress: called after every frame. front_end: measures
    cues in the images.
    """
    tracks: dict[str, Tracks] = {}
    counts: dict[str, SequenceStatistics] = {}
    resumed = []
    for sequence in sequences:
        name = sequence.name
        T_road_label = result_frame(sequence)
        if folder is not None and name in folder.finished:
            tracks[name] = read_results(folder.result(name), T_road_label)
            counts[name] = folder.finished[name]
            resumed.append(name)
            continue
        tracker = build(sequence.camera)
        tracks[name], counts[name] = track_sequence(tracker, sequence, progress, front_end)
        lens = getattr(sequence, "distortion", None)
        if lens is not None:
            straight = tracks[name]
            tracks[name] = straight.replaced(boxes=lens.distort_boxes(straight.boxes))
        if folder is not None:
            folder.add(name, tracks[name], counts[name], T_road_label)
        log.info("%s: %d rows of %d ids", name, counts[name].rows, counts[name].ids)
    return TrackingRun(tracks, counts, tuple(resumed))
