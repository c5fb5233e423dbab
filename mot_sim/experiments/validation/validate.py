"""The whole check: real drives, their re-enactments, scenes, and how they agree."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mot_sim.datasets import KittiSequence
from mot_sim.experiments.guests import Failure
from mot_sim.experiments.validation.agreement import Agreement
from mot_sim.experiments.validation.contestants import Contestant
from mot_sim.experiments.validation.running import Outcome, run_contestants
from mot_sim.experiments.validation.worlds import (
    REAL,
    World,
    fit_halves,
    fit_to,
    made_world,
    real_world,
    reenacted,
    require_foretellable,
    scene_seen_by,
    scene_worlds,
)
from mot_sim.simulation.sensors import Profile, find_profile
from tracker.errors import BadConfig

HALVES, ALL = "halves", "all"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Plan:
    """What is made, and how often. Raises BadConfig for numbers that make nothing."""

    contestants: Sequence[Contestant]
    """The trackers."""
    seeds: int = 5
    """Re-enactments of every drive, and runs of every scene, 1 or more."""
    profile: str = HALVES
    """The noise of made drives: `halves`, fitted now to the other half of the drives; `all`,
    fitted now to all of them; or a profile's name or file. Scenes: with `halves`, as with `all`."""
    scenes: Sequence[str] = ()
    """Scenes that are run besides."""
    frames: int | None = None
    """Frames of a scene's run; None: its own number."""
    folder: Path | None = None
    """Where drawings and scores are kept, so that a later call goes on; None: nowhere."""
    jobs: int = 1
    """Processes."""
    scenes_only: bool = False
    """Whether the scenes alone stand beside the real drives, and nothing is re-enacted."""

    def __post_init__(self) -> None:
        if self.scenes_only and not self.scenes:
            raise BadConfig("--scenes-only: no scene is named; name some with --scenes")
        if self.seeds < 1:
            raise BadConfig(f"--seeds {self.seeds}: give 1 or more")

    def part(self, name: str) -> Path | None:
        """A folder inside the kept one."""
        return None if self.folder is None else self.folder / name


@dataclass(frozen=True, eq=False)
class Validation:
    """What was found."""

    reenacted: Agreement | None
    """Real drives beside their re-enactments; None: there are none, or fewer than two trackers
    came through."""
    scenes: dict[str, Agreement] = field(default_factory=dict)
    """Real drives beside each scene, by its name."""
    failures: Mapping[str, Failure] = field(default_factory=dict)
    """Trackers that failed, and why; they are in no table."""


def validate(plan: Plan, drives: Sequence[KittiSequence], tell: Tell) -> Validation:
    """Re-enact the drives, run the scenes, and compare.

    drives: with labels, detections of cars and motion. Raises BadConfig for others.
    """
    require_foretellable(drives, plan.profile == HALVES and not plan.scenes_only)
    shared = None  # the profile of scenes, and of all drives unless each half has its own
    if plan.scenes or plan.profile != HALVES:
        shared = _shared_profile(plan, drives, tell)
    worlds = [real_world(drives)]
    if not plan.scenes_only:
        profiles = _profiles(plan, drives, shared, tell)
        stages = reenacted(drives, plan.part("drawn"), tell)
        worlds += [made_world(stages, profiles, seed) for seed in range(plan.seeds)]
    of_scenes: dict[str, list[World]] = {}
    for name in plan.scenes:
        tell(f"running {name}")
        assert shared is not None
        scene = scene_seen_by(name, shared, plan.frames)
        of_scenes[name] = list(scene_worlds(scene, range(plan.seeds)))
    everything = [*worlds, *(world for each in of_scenes.values() for world in each)]
    outcome = run_contestants(plan.contestants, everything, plan.part("scores"), plan.jobs, tell)
    if len(outcome.scores) < 2:
        return Validation(None, failures=outcome.failures)
    made = [world.name for world in worlds[1:]]
    return Validation(
        agreement(plan, outcome, made, True) if made else None,
        {
            name: agreement(plan, outcome, [world.name for world in each], False)
            for name, each in of_scenes.items()
        },
        outcome.failures,
    )


def agreement(plan: Plan, outcome: Outcome, made: Sequence[str], same_drives: bool) -> Agreement:
    """The real scores beside those of the made worlds of these names."""
    names = tuple(each.name for each in plan.contestants if each.name in outcome.scores)
    guests = frozenset(each.name for each in plan.contestants if each.guest is not None)
    return Agreement(
        names,
        guests & set(names),
        {name: outcome.scores[name][REAL] for name in names},
        {name: {world: outcome.scores[name][world] for world in made} for name in names},
        same_drives,
    )


def _profiles(
    plan: Plan, drives: Sequence[KittiSequence], shared: Profile | None, tell: Tell
) -> list[Profile]:
    """The profile of every drive."""
    if plan.profile == HALVES or shared is None:
        return fit_halves(drives, plan.part("fits"), tell)
    return [shared] * len(drives)


def _shared_profile(plan: Plan, drives: Sequence[KittiSequence], tell: Tell) -> Profile:
    """The one profile of all: as it is named, or fitted to all drives."""
    if plan.profile not in (HALVES, ALL):
        return find_profile(plan.profile)
    return fit_to(drives, plan.part("fits"), tell)
