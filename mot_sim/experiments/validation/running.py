"""Every contestant in every world: tracked, scored drive by drive, and kept."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mot_sim.experiments.executor import Executor
from mot_sim.experiments.guests import ExternalTrackerFailed, Failure
from mot_sim.experiments.score_cache import ScoreCache
from mot_sim.experiments.validation.contestants import Contestant, find_contestant
from mot_sim.experiments.validation.worlds import World
from mot_sim.files.fingerprint import code_digest, digest
from mot_sim.metrics import Scores, evaluate_sequence
from mot_sim.simulation.sensors.fitting.calibrate import Progress
from tracker.errors import TrackingError

# Scores by contestant, then by world, then in the order of the world's drives.
Found = dict[str, dict[str, list[Scores]]]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of all contestants."""

    scores: Found = field(default_factory=dict)
    """Scores of those that came through everywhere, by name and world, a drive after the other."""
    failures: dict[str, Failure] = field(default_factory=dict)
    """Those that failed somewhere, and why."""


@dataclass(frozen=True, eq=False)
class _Task:
    """A worker's task: one contestant in some worlds."""

    name: str
    worlds: tuple[World, ...]

    def scores(self) -> list[list[Scores]] | Failure:
        """A list of scores a world, or why there are none."""
        contestant = find_contestant(self.name)
        drives = [drive for world in self.worlds for drive in world.drives]
        try:
            tracks = contestant.tracker.track(drives).tracks
        except ExternalTrackerFailed as failed:
            return Failure(str(failed), failed.stderr)
        except TrackingError as error:
            return Failure(str(error))
        return [
            [
                evaluate_sequence(world.truths[drive.name], tracks[drive.name], drive.frame_count)
                for drive in world.drives
            ]
            for world in self.worlds
        ]


def run_contestants(
    contestants: Sequence[Contestant],
    worlds: Sequence[World],
    kept: Path | None,
    jobs: int,
    tell: Progress,
) -> Outcome:
    """All contestants in all worlds. kept: folder of scores, from which a later call goes on."""
    cache = None if kept is None else ScoreCache(kept)
    found: Found = {each.name: {} for each in contestants}
    failures: dict[str, Failure] = {}
    tasks, keys = [], _keys(contestants, worlds)
    for contestant in contestants:
        missing = []
        for world in worlds:
            before = None if cache is None else cache.read(keys[contestant.name, world.name])
            if before is None:
                missing.append(world)
            else:
                found[contestant.name][world.name] = [before[each.name] for each in world.drives]
        tasks += list(_tasks(contestant, missing))
    with Executor(jobs).open() as workers:
        for place, result in workers.run(_Task.scores, tasks):
            task = tasks[place]
            if isinstance(result, Failure):
                failures.setdefault(task.name, result)
                tell(f"{task.name}: failed")
                continue
            for world, scores in zip(task.worlds, result, strict=True):
                found[task.name][world.name] = scores
                if cache is not None:
                    by_drive = dict(zip([each.name for each in world.drives], scores, strict=True))
                    about = {"tracker": task.name, "world": world.name}
                    cache.write(keys[task.name, world.name], by_drive, about)
            tell(f"{task.name}: {', '.join(world.name for world in task.worlds)}")
    for name in failures:
        del found[name]
    return Outcome(found, failures)


def _tasks(contestant: Contestant, worlds: Sequence[World]) -> Iterator[_Task]:
    """A guest is started once for all worlds; ours take a world at a time."""
    if contestant.guest is not None:
        if worlds:
            yield _Task(contestant.name, tuple(worlds))
        return
    for world in worlds:
        yield _Task(contestant.name, (world,))


def _keys(
    contestants: Sequence[Contestant], worlds: Sequence[World]
) -> Mapping[tuple[str, str], str]:
    """What decides the scores of each contestant in each world, as one word."""
    hashes = {world.name: _digest_of(world) for world in worlds}
    mine = {}
    for each in contestants:
        guest = each.guest
        if guest is None:
            mine[each.name] = digest([each.name, code_digest()])
        else:
            settings = [guest.command[2:], guest.environment, guest.min_score]
            mine[each.name] = digest([each.name, *settings])
    return {(name, world): digest([mine[name], hashes[world]]) for name in mine for world in hashes}


def _digest_of(world: World) -> str:
    """Of all that a tracker is shown, and of what it is scored by."""
    parts = []
    for drive in world.drives:
        log = drive.log
        seen = [log.frames, log.detections.boxes, log.detections.scores]
        stand = [drive.camera.K, drive.frame_count, drive.frame_rate, drive.Ts_world_cam]
        truth = replace(world.truths[drive.name], cuboids=None)
        kinds = [] if truth.kinds is None else truth.kinds.tolist()
        levels = [truth.truncation, truth.occlusion]
        parts.append([drive.name, seen, stand, truth.frames, truth.ids, truth.boxes, kinds, levels])
    return digest(parts)
