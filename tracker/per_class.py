"""Several classes at once: a tracker for each, which sees the boxes of its class alone."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tracker.beliefs import Lift
from tracker.errors import BadConfig, UnknownName
from tracker.frameworks import Delayed
from tracker.motion_check import Contradiction
from tracker.state import TrackerStatistics
from tracker.tracker import Tracker
from tracker.types import TRACKED_KINDS, Detections, Frame, Tracks


@dataclass(frozen=True)
class ClassPrior:
    """What is known of a class before anything is measured."""

    size: tuple[float, float, float]
    """Length, height and width, metres: the medians of KITTI's labels (ten sequences)."""
    height_std: float
    """Std of the height there, share of it."""
    speed_std: tuple[float, float]
    """Std of the speed along road x and z, m/s."""
    birth_score: float
    """The probability from which a detection begins a track, 0 to 1, see `Lifecycle`: people are
    detected with less certainty than cars."""
    max_gap: float
    """Seconds that a track lives on without a detection, > 0, see `Lifecycle`: people turn."""
    least_confirmed: float
    """The share of boxes that must be seen again for a scale of scores to be doubted, 0 to 1, see
    `ScoreScale`: poles and trees taken for people are seen again as well."""


# Std of length and width of walkers and riders, shares of them: arms and legs move.
OUTLINE_STD = 0.25
# Of the classes that are no cars; those of Pedestrian by `benchmarks.pedestrians`.
CLASS_PRIORS = {
    "Pedestrian": ClassPrior((0.67, 1.71, 0.6), 0.067, (1.5, 1.5), 0.5, 1.5, 0.8),
    "Cyclist": ClassPrior((1.65, 1.74, 0.57), 0.044, (3.0, 5.0), 0.5, 1.5, 0.8),
}


def for_kind(tracker: Tracker, kind: str) -> Tracker:
    """The same tracker for another class than Car: with its size, speeds, births and gaps.

    Births and gaps only become easier and shorter: a tracker without memory stays one. kind: of
    TRACKED_KINDS; Car gives the tracker as it is. UnknownName for any other class.
    """
    if kind not in TRACKED_KINDS:
        raise UnknownName.of("class", kind, TRACKED_KINDS)
    if kind not in CLASS_PRIORS:
        return tracker
    prior = CLASS_PRIORS[kind]
    lift: Lift = replace(
        tracker.lift,
        car_size=prior.size,
        car_size_std=prior.height_std,
        speed_std=prior.speed_std,
    )
    scale, before, car_filter = tracker.score_scale, tracker.lifecycle, tracker.car_filter
    if scale is not None:
        scale = replace(scale, least_confirmed=max(scale.least_confirmed, prior.least_confirmed))
    if car_filter is not None:
        pace = max(prior.speed_std)
        car_filter = replace(
            car_filter,
            size=prior.size,
            size_std=(OUTLINE_STD, prior.height_std, OUTLINE_STD),
            start_speed=(pace, pace),
            carries_boxes=False,
        )
    return replace(
        tracker,
        lift=lift,
        lifecycle=replace(
            before,
            birth_score=min(before.birth_score, prior.birth_score),
            max_gap=min(before.max_gap, prior.max_gap),
        ),
        strong_score=min(tracker.strong_score, prior.birth_score),
        score_scale=scale,
        car_filter=car_filter,
        gap_rows=None,
    )


@dataclass
class PerClass:
    """One tracker a class: no track takes a box of another class, and all ids differ.

    `step` and `finish` are those of `Delayed`; online trackers leave nothing to `finish`. Boxes of
    other classes than the named ones are left out.
    """

    trackers: Mapping[str, Tracker | Delayed]
    """The tracker of each class, of TRACKED_KINDS; an object of its own for each."""

    def __post_init__(self) -> None:
        unknown = set(self.trackers) - set(TRACKED_KINDS)
        if unknown or not self.trackers:
            named = ", ".join(sorted(self.trackers)) or "none"
            raise BadConfig(f"classes {named}: name some of {', '.join(TRACKED_KINDS)}")

    @property
    def counts(self) -> TrackerStatistics:
        """What was done since the reset, over all classes; frames count once."""
        parts = [
            tracker.counts if isinstance(tracker, Delayed) else tracker.state.statistics
            for tracker in self.trackers.values()
        ]
        return TrackerStatistics(
            max(part.frames for part in parts),
            sum(part.pairs for part in parts),
            sum(part.compared for part in parts),
            sum(part.unmeasured for part in parts),
        )

    @property
    def contradiction(self) -> Contradiction | None:
        """What all boxes so far, of one of the classes, contradict in the given motion or
        calibration; None: nothing."""
        each = (getattr(tracker, "contradiction", None) for tracker in self.trackers.values())
        return next((found for found in each if found is not None), None)

    def reset(self) -> None:
        """Forget everything; ids start anew."""
        for tracker in self.trackers.values():
            tracker.reset()

    def step(self, frame: Frame) -> Tracks:
        """The rows that are decided by now, with the column `kinds`.

        Raises BadConfig for detections that do not say their classes where several are tracked.
        """
        found = frame.detections
        if found is not None and found.kinds is None and len(self.trackers) > 1:
            raise BadConfig(
                f"frame {frame.index}: the detections do not say their class, but "
                f"{', '.join(self.trackers)} are tracked: give the column `kinds`"
            )
        return self._merged(
            {
                kind: tracker.step(replace(frame, detections=_of_kind(found, kind)))
                for kind, tracker in self.trackers.items()
            }
        )

    def finish(self) -> Tracks:
        """The rows of all frames that `step` gave none of."""
        return self._merged(
            {
                kind: tracker.finish()
                for kind, tracker in self.trackers.items()
                if isinstance(tracker, Delayed)
            }
        )

    def _merged(self, rows: Mapping[str, Tracks]) -> Tracks:
        """The rows of all classes in the order of frames, their ids made different."""
        count, numbers = len(self.trackers), {kind: i for i, kind in enumerate(self.trackers)}
        parts = [
            part.replaced(
                ids=part.ids * count + numbers[kind], kinds=np.full(len(part), kind, dtype="U32")
            )
            for kind, part in rows.items()
        ]
        if not parts:
            return Tracks.empty().replaced(kinds=np.zeros(0, dtype="U32"))
        together = Tracks.concatenate(parts)
        return together.select(np.argsort(together.frames, kind="stable"))


def _of_kind(detections: Detections | None, kind: str) -> Detections | None:
    """The detections of a class, all where they do not say; None where nothing looked."""
    if detections is None or detections.kinds is None:
        return detections
    return detections.select(detections.kinds == kind).replaced(kinds=None)
