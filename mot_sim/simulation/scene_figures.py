"""What a camera sees of a scene, in figures: how dense, how hidden, how turned, how many."""

from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mot_sim.simulation.scene import Rollout, Scene
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS, TrafficState
from mot_sim.simulation.truth import Truth, annotate
from mot_sim.simulation.truth.labels import is_labelled
from tracker.geometry import wrap_angle

# Cars that count: as high as KITTI's evaluation asks for, as near as its labels reach, in sight.
MIN_HEIGHT_PIXELS = 25.0  # pixels
MAX_DISTANCE_METRES = 80.0  # metres
MIN_VISIBLE = 0.2
OCCLUDED_BELOW = 0.5
TURNED_RADIANS = np.radians(30.0)
MINUTE_SECONDS = 60.0


@dataclass(frozen=True)
class LabelFigures:
    """What labels are of: shares of them, and quantiles of how much they show of a car.

    Scored labels are those of KITTI's levels 0 to 2 that are not truncated. Quantiles of no label
    are NaN.
    """

    level_2: float
    """Share of the labels that are largely occluded, 0 to 1."""
    level_3: float
    """Share of the labels that say `unknown`, which are not scored, 0 to 1."""
    low: float
    """Share of the scored labels that are lower than KITTI's evaluation asks for, 0 to 1."""
    low_and_hidden: float
    """Share of the scored labels that are as low, and of level 2, 0 to 1."""
    pixels_1: float
    """Pixels that are seen of the car of a scored label: quantile .01."""
    pixels_5: float
    """Quantile .05."""
    pixels_10: float
    """Quantile .1."""
    pixels_50: float
    """Median."""

    @classmethod
    def of(
        cls, levels: np.ndarray, truncated: np.ndarray, heights: np.ndarray, pixels: np.ndarray
    ) -> "LabelFigures":
        """The figures of labels: KITTI's level of each, whether it is truncated, pixels."""
        scored = (levels <= 2) & ~truncated
        low, hidden = heights[scored] < MIN_HEIGHT_PIXELS, levels[scored] == 2
        seen = pixels[scored] if scored.any() else np.array([np.nan])
        return cls(
            _share(levels == 2), _share(levels == 3), _share(low), _share(low & hidden),
            *np.quantile(seen, (0.01, 0.05, 0.1, 0.5)).tolist(),
        )  # fmt: skip


# Of the ten given sequences, measured in their re-enactment: what `benchmarks.labels` prints.
KITTI_LABELS = LabelFigures(0.192, 0.018, 0.204, 0.043, 0.0, 210.0, 317.0, 1371.0)


@dataclass(frozen=True)
class Figures:
    """Means over runs of a scene; cars count that are large and near enough and in sight."""

    cars: float
    """Cars per frame of which at least a share of MIN_VISIBLE is visible."""
    occluded: float
    """Share of the cars in sight of which less than half is visible, 0 to 1."""
    turned: float
    """Share of the visible cars that head more than 30 degrees off the ego's heading, 0 to 1."""
    ids: float
    """Different visible cars per minute."""
    yaw_rate: float
    """Largest of the ego car, degrees per second."""
    labels: LabelFigures
    """Of the labels by which trackers are scored."""


def figures_of_rollout(rollout: Rollout, truth: Truth | None = None) -> Figures:
    """The figures of one run; truth: of it, where it is known already."""
    truth = truth or annotated_truth(rollout)
    near = truth.select(np.flatnonzero(cars_in_sight(truth)))
    visible = near.select(near.visible >= MIN_VISIBLE)
    assert visible.tracks.cuboids is not None
    labelled = truth.select(np.flatnonzero(is_labelled(truth)))
    occlusion, truncation = labelled.tracks.occlusion, labelled.tracks.truncation
    assert occlusion is not None
    assert truncation is not None
    heading = np.abs(np.asarray(wrap_angle(visible.tracks.cuboids.yaw + 0.5 * np.pi)))
    frames, ego = len(rollout), np.unwrap(rollout.traffic.ego[:, 2])
    turns = np.abs(np.diff(ego, n=1)) / STEP_SECONDS
    return Figures(
        cars=len(visible) / frames,
        occluded=_share(near.visible < OCCLUDED_BELOW),
        turned=_share(heading > TURNED_RADIANS),
        ids=len(np.unique(visible.tracks.ids)) / (frames * STEP_SECONDS / MINUTE_SECONDS),
        yaw_rate=float(np.degrees(turns.max(initial=0.0))),
        labels=LabelFigures.of(
            occlusion,
            truncation > 0,
            labelled.tracks.boxes[:, 3] - labelled.tracks.boxes[:, 1],
            labelled.pixels,
        ),
    )


def figures_of(
    scene: Scene, seeds: Iterable[int], progress: Callable[[], None] | None = None
) -> Figures:
    """The mean figures of the runs of some seeds; progress: called after each frame."""
    rollouts = (Rollout.of(scene, seed) for seed in seeds)
    return mean_figures(
        [figures_of_rollout(each, annotated_truth(each, progress)) for each in rollouts]
    )


def annotated_truth(rollout: Rollout, progress: Callable[[], None] | None = None) -> Truth:
    """What is true in a run; progress: called after each frame."""
    states = _with_progress(rollout.traffic_states, progress)
    return annotate(states, rollout.scene_meshes, rollout.scenery_in).truth


def mean_figures(found: Sequence[Figures]) -> Figures:
    """The means of the figures of some runs."""
    means = _means(Figures, found, {"labels"})
    return Figures(**means, labels=LabelFigures(**_means(LabelFigures, [f.labels for f in found])))


def cars_in_sight(truth: Truth) -> np.ndarray:
    """Which cars are large and near enough, with a pixel to be seen; bool, one a row."""
    cuboids = truth.tracks.cuboids
    assert cuboids is not None
    height = truth.amodal_boxes[:, 3] - truth.amodal_boxes[:, 1]
    distance = np.hypot(cuboids.base[:, 0], cuboids.base[:, 2])
    return (height >= MIN_HEIGHT_PIXELS) & (distance <= MAX_DISTANCE_METRES) & (truth.pixels > 0)


def _means(kind: type, found: Sequence[Any], but: Set[str] = frozenset()) -> dict[str, Any]:
    """The mean of each field."""
    names = [each.name for each in fields(kind) if each.name not in but]
    return {name: float(np.mean([getattr(one, name) for one in found])) for name in names}


def _with_progress(
    states: Iterable[TrafficState], progress: Callable[[], None] | None
) -> Iterator[TrafficState]:
    for state in states:
        yield state
        if progress is not None:
            progress()


def _share(which: np.ndarray) -> float:
    """The share of True; 0 of nothing."""
    return float(which.mean()) if len(which) else 0.0
