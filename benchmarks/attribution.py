"""Is the right noise blamed? Switches with one planted cause each, and the shares in the suites.

python -m benchmarks.attribution [--each 20] [--seeds 6] [--suites]

A plant is a fault inside one effect, at an otherwise normal level of all noise: a car that is not
seen for a while, a box that jumps, a ghost that leads a track away. It counts where the car has no
switch at all without it, has one about it with it, and has that, too, with no other noise at all:
so the plant is the cause, and the only one that is needed. `--suites` prints what the switches in
the stress tests' scenes hang on instead, a line a suite.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy import ndarray as Array

from mot_sim.diagnosis.attribution import VERDICTS, Attributor, Cause, Replays, shares
from mot_sim.diagnosis.sources import DetectionStream, SourceAblation, active_sources, without
from mot_sim.diagnosis.tasks import suite_tasks
from mot_sim.diagnosis.work import diagnose
from mot_sim.experiments.executor import one_thread
from mot_sim.experiments.stress.suites import read_suites
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, drive_of
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.metrics.breaks import Breaks, Matches
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.sensors import Miscalibration, Odometry, Sightings, Timing
from mot_sim.simulation.sensors.clutter import Clutter, FalseAlarms
from mot_sim.simulation.sensors.jitter import Jitter
from mot_sim.simulation.sensors.misses import Misses
from mot_sim.simulation.sensors.multiplicity import Duplicates
from mot_sim.simulation.sensors.scores import ScoreNoise
from mot_sim.simulation.truth import labels
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Camera, Tracks

SCENES, FRAMES = ("intersection", "roundabout"), 120
TRACKER = TrackerSpec.parse("default")
LONG = (32, 45)  # frames; the default tracker remembers a car for 3 s
MOST_LOOKED_AT, MOST_TRIED = 400, 12  # spots and plants, of a kind and drive
# Scores: above that of any car, whatever noise is on; too low to be believed.
SURE, UNSURE = 1.0 + 1e-6, 0.001


@dataclass(frozen=True)
class Spot:
    """Where a fault is: a car, its first and its last frame, and how far boxes are moved."""

    car: int = 0
    first: int = 0
    last: int = -1
    shift: tuple[float, float] = (0.0, 0.0)

    def here(self, ids: Array, frames: Array) -> Array:
        """The rows that it spoils."""
        return (ids == self.car) & self.when(frames)

    def when(self, frames: Array) -> Array:
        """The frames that it spoils."""
        return (frames >= self.first) & (frames <= self.last)


@dataclass(frozen=True)
class PlantedMisses(Misses):
    """Misses, and a car that is not seen for a while."""

    spot: Spot = Spot()

    def __call__(self, sightings: Sightings, *rest: Any) -> tuple[Array, Array]:
        """See `Misses`."""
        missed, ease = super().__call__(sightings, *rest)
        return missed | self.spot.here(sightings.ids, sightings.frames), ease


@dataclass(frozen=True)
class PlantedJitter(Jitter):
    """Jitter, and a car whose box stands beside it for a while."""

    spot: Spot = Spot()

    def __call__(self, boxes: Array, sightings: Sightings, *rest: Any, back: int = 0) -> Array:
        """See `Jitter`."""
        moved = super().__call__(boxes, sightings, *rest, back=back)
        sides = np.tile(moved[:, 2:] - moved[:, :2], 2) * np.tile(self.spot.shift, 2)
        return moved + sides * self.spot.here(sightings.ids, sightings.frames)[:, None]


@dataclass(frozen=True)
class PlantedScores(ScoreNoise):
    """Scores, and a car that the detector hardly believes in for a while."""

    spot: Spot = Spot()

    def __call__(self, sightings: Sightings, *rest: Any) -> Array:
        """See `ScoreNoise`."""
        found = super().__call__(sightings, *rest)
        return np.where(self.spot.here(sightings.ids, sightings.frames), UNSURE, found)


def led_away(boxes: Array, frames: Array, spot: Spot) -> Array:
    """Boxes that leave cars, slowly at first."""
    gone = ((frames - spot.first + 1) / (spot.last - spot.first + 1)) ** 1.5
    sides = np.tile(boxes[:, 2:] - boxes[:, :2], 2)
    return boxes + sides * np.tile(spot.shift, 2) * gone[:, None]


@dataclass(frozen=True)
class PlantedDuplicates(Duplicates):
    """Second boxes, and one that covers a car and then leaves it."""

    spot: Spot = Spot()

    def __call__(self, sightings: Sightings, *rest: Any) -> tuple[Array, Array, Array]:
        """See `Duplicates`."""
        rows, boxes, scores = super().__call__(sightings, *rest)
        new = np.flatnonzero(self.spot.here(sightings.ids, sightings.frames))
        away = led_away(sightings.boxes[new], sightings.frames[new], self.spot)
        return (
            np.concatenate((rows, new)),
            np.concatenate((boxes, away)),
            np.concatenate((scores, np.full(len(new), SURE))),
        )


@dataclass(frozen=True)
class PlantedClutter(Clutter):
    """Clutter, and a ghost that covers a car and then leaves it. path: where the car is."""

    spot: Spot = Spot()
    path: tuple[tuple[float, ...], ...] = ()

    def __call__(self, frames: Array, seed: int, camera: Camera, *rest: Any) -> FalseAlarms:
        """See `Clutter`."""
        found = super().__call__(frames, seed, camera, *rest)
        when = np.arange(self.spot.first, self.spot.first + len(self.path))
        if not len(when):
            return found
        boxes = camera.clip_boxes(led_away(np.array(self.path), when, self.spot))
        new = FalseAlarms(when, np.full(len(when), 1), boxes, np.full(len(when), SURE))
        both = FalseAlarms.concatenate([found, new])
        return both.select(np.argsort(both.frames, kind="stable"))


@dataclass(frozen=True)
class PlantedOdometry(Odometry):
    """Odometry, and a turn that never was, spread over the frames of the spot; radians."""

    spot: Spot = Spot()
    angle: float = 0.0

    def __call__(self, Ts_world_cam: Array, *rest: Any) -> Array:
        """See `Odometry`."""
        poses = super().__call__(Ts_world_cam, *rest)
        frames = np.arange(len(poses))
        turned = (
            self.angle * np.cumsum(self.spot.when(frames)) / (self.spot.last - self.spot.first + 1)
        )
        steps = [np.linalg.inv(a) @ b for a, b in pairwise(poses)]
        found = [poses[0]]
        for step, more in zip(steps, np.diff(turned), strict=True):
            found.append(found[-1] @ homogeneous(rotation_y(float(more)), np.zeros(3)) @ step)
        return np.array(found)


@dataclass(frozen=True)
class PlantedTiming(Timing):
    """Frames that never come, one after another."""

    spot: Spot = Spot()

    def delivered(self, frame_count: int, seed: int, step: float) -> Array:
        """See `Timing`."""
        frames = super().delivered(frame_count, seed, step)
        return frames[~self.spot.when(frames)]


@dataclass(frozen=True)
class PlantedMiscalibration(Miscalibration):
    """A mount that is bent for a while: all boxes are moved alike; shift: pixels."""

    spot: Spot = Spot()

    def shake(self, boxes: Array, frames: Array, *rest: Any) -> Array:
        """See `Miscalibration`."""
        moved = super().shake(boxes, frames, *rest)
        return moved + np.tile(self.spot.shift, 2) * self.spot.when(frames)[:, None]


def planted(kind: type, effect: Any, **more: Any) -> Any:
    """An effect with a fault in it."""
    return kind(**{each.name: getattr(effect, each.name) for each in fields(effect)}, **more)


@dataclass(frozen=True, eq=False)
class Ground:
    """A drive without a fault, where one can be planted. steady: cars that keep their names."""

    conditions: Conditions
    recorded: Extra
    seed: int
    every: Tracks
    matches: Matches
    steady: frozenset[int]

    @classmethod
    def of(cls, scene: str, seed: int) -> "Ground":
        """A seed of a scene under the noise of RRC."""
        conditions = Conditions.of(scene, {"scene.frames": FRAMES})
        recorded = Recordings.shared().truth(conditions, seed)
        every = labels(recorded.annotations.truth)
        matches = Ground.track(conditions, recorded, seed, every)
        torn = set(Breaks.of(matches).switches.cars.tolist())
        steady = frozenset(set(matches.cars.tolist()) - torn)
        return cls(conditions, recorded, seed, every, matches, steady)

    @staticmethod
    def track(conditions: Conditions, recorded: Extra, seed: int, every: Tracks) -> Matches:
        """What the tracker makes of it."""
        stream = DetectionStream.of(drive_of(conditions, recorded, seed).sequence)
        output = Replays(TRACKER).run(stream, FRAMES)
        return Matches.of(every.select(np.isin(every.frames, stream.frames)), output, FRAMES)

    def spots(self, rng: np.random.Generator, length: tuple[int, int]) -> Iterator[Spot]:
        """Faults of steady cars that are matched well before and after."""
        cars, given = np.array(sorted(self.steady)), 0
        for _ in range(MOST_LOOKED_AT if len(cars) else 0):
            if given == MOST_TRIED:
                return
            car, long = int(rng.choice(cars)), int(rng.integers(*length))
            frames = self.matches.of_car(car).frames
            first = int(rng.integers(12, max(FRAMES - long - 12, 13)))
            if (frames < first - 5).sum() >= 5 and (frames > first + long + 5).sum() >= 5:
                given += 1
                shift = float(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 2.5))
                yield Spot(car, first, first + long - 1, (shift, 0.0))

    def switches(self, conditions: Conditions, spot: Spot, cars: Iterable[int]) -> Breaks:
        """Those of some cars about a fault."""
        matches = Ground.track(conditions, self.recorded, self.seed, self.every)
        found = Breaks.of(matches).switches
        near = (found.before <= spot.last + 10) & (found.frames >= spot.first - 2)
        return found.select(near & np.isin(found.cars, sorted(cars)))

    def made_by(self, conditions: Conditions, source: str, spot: Spot, any_car: bool) -> Breaks:
        """The switches that a fault makes, at most three: also when no other source is on."""
        found = self.switches(conditions, spot, self.steady if any_car else {spot.car})
        if not len(found):
            return found
        alone = conditions
        for other in active_sources(conditions):
            alone = alone if other == source else without(alone, other)
        left = self.switches(alone, spot, set(found.cars.tolist()))
        return found.select(np.flatnonzero(np.isin(found.cars, left.cars))[:3])

    def judged(self, conditions: Conditions, switches: Breaks) -> list[Cause]:
        """What the switches are said to hang on."""
        ablation = SourceAblation.of(conditions, self.recorded, self.seed)
        return Attributor(ablation, self.every, Replays(TRACKER)).attribute(switches)


Plant = Callable[[Ground, Spot, np.random.Generator], Conditions]


def in_effect(name: str, kind: type) -> Plant:
    """A fault of one car in an effect of the profile."""

    def plant(ground: Ground, spot: Spot, rng: np.random.Generator) -> Conditions:
        effects = ground.conditions.effects
        more: dict[str, Any] = {"spot": spot}
        if kind is PlantedClutter:
            truth = ground.recorded.annotations.truth.tracks
            own = truth.select(spot.here(truth.ids, truth.frames))
            more["path"] = tuple(tuple(box) for box in own.boxes.tolist())
        changed: dict[str, Any] = {name: planted(kind, getattr(effects, name), **more)}
        return replace(ground.conditions, effects=replace(effects, **changed))

    return plant


def in_drive(name: str, kind: type) -> Plant:
    """A fault of a whole frame."""

    def plant(ground: Ground, spot: Spot, rng: np.random.Generator) -> Conditions:
        more: dict[str, Any] = {"spot": spot}
        if kind is PlantedOdometry:
            more["angle"] = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.5))
        if kind is PlantedMiscalibration:
            more["spot"] = replace(spot, shift=(0.0, float(rng.uniform(40.0, 80.0))))
        changed: dict[str, Any] = {name: planted(kind, getattr(ground.conditions, name), **more)}
        return replace(ground.conditions, **changed)

    return plant


# Source: what plants the fault, how many frames it lasts, whether it is every car's.
PLANTS: dict[str, tuple[Plant, tuple[int, int], bool]] = {
    "misses": (in_effect("misses", PlantedMisses), LONG, False),
    "jitter": (in_effect("jitter", PlantedJitter), LONG, False),
    "scores": (in_effect("scores", PlantedScores), LONG, False),
    "duplicates": (in_effect("duplicates", PlantedDuplicates), (4, 16), False),
    "clutter": (in_effect("clutter", PlantedClutter), (4, 24), False),
    "odometry": (in_drive("odometry", PlantedOdometry), (1, 4), True),
    "timing": (in_drive("timing", PlantedTiming), LONG, True),
    "miscalibration": (in_drive("miscalibration", PlantedMiscalibration), LONG, True),
}


def judge_plants(grounds: list[Ground], source: str, wanted: int) -> list[Cause]:
    """The causes that were found for so many switches of one planted source, over all drives."""
    plant, length, any_car = PLANTS[source]
    found: list[Cause] = []
    for number, ground in enumerate(grounds):
        share = -(-(wanted - len(found)) // (len(grounds) - number))
        rng, here = np.random.default_rng([number, len(source)]), 0
        for spot in ground.spots(rng, length):
            if here >= share:
                break
            conditions = plant(ground, spot, rng)
            switches = ground.made_by(conditions, source, spot, any_car)
            if len(switches):
                causes = ground.judged(conditions, switches)
                found += causes
                here += len(causes)
    return found


def plants(each: int, seeds: int) -> None:
    """Print how often the planted source is named, and nothing else is."""
    start = perf_counter()
    grounds = [Ground.of(scene, seed) for seed in range(seeds) for scene in SCENES]
    total = right = 0
    print(f"{'planted':16}{'switches':>9}{'right':>7}  said instead")
    for source in PLANTS:
        causes = judge_plants(grounds, source, each)
        hits = sum(cause.sources == (source,) for cause in causes)
        told = Counter(
            " or ".join(cause.sources) or cause.verdict
            for cause in causes
            if cause.sources != (source,)
        )
        wrong = ", ".join(f"{name} {count}" for name, count in told.most_common())
        print(f"{source:16}{len(causes):9}{hits:7}  {wrong}", flush=True)
        total, right = total + len(causes), right + hits
    print(f"all: {right} of {total} right, {100.0 * right / max(total, 1):.1f} %")
    print(f"{perf_counter() - start:.0f} s")


def suites(seeds: int) -> None:
    """Print what the switches of each stress suite hang on."""
    for name in read_suites():
        start = process_time()
        found = diagnose(list(suite_tasks(name, {}, range(seeds), TRACKER, attribute=True)))
        cases = [case for each in found for case in each.cases if case.switched]
        causes = [
            Cause(each.before, each.frame, each.car, each.verdict, each.sources) for each in cases
        ]
        part = {source: 100.0 * n / len(cases) for source, n in shares(causes).items()}
        unexplained = Counter(each.verdict for each in causes if not each.sources)
        part |= {f"({v})": 100.0 * unexplained[v] / len(cases) for v in VERDICTS if unexplained[v]}
        told = ", ".join(f"{n} {p:.0f} %" for n, p in sorted(part.items(), key=lambda e: -e[1]))
        spent = f"{process_time() - start:.0f} CPU s"
        print(f"{name:16} {len(cases):4} switches: {told or 'none'}; {spent}", flush=True)


def main() -> None:
    """Print the table that was asked for."""
    parser = argparse.ArgumentParser(description="Is the right noise blamed?")
    parser.add_argument("--each", type=int, default=20, help="planted switches of each kind")
    parser.add_argument("--seeds", type=int, default=6, help="runs of each scene")
    parser.add_argument("--suites", action="store_true", help="the shares in the stress suites")
    options = parser.parse_args()
    with one_thread():
        if options.suites:
            suites(options.seeds)
        else:
            plants(options.each, options.seeds)


if __name__ == "__main__":
    main()
