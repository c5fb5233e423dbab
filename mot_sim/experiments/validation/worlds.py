"""Drives of one kind, together with what is true in them: KITTI's own, re-enacted ones, scenes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mot_sim.datasets import KittiSequence, RecordedSequence
from mot_sim.experiments.validation.reenactment import Reenacted, reenact
from mot_sim.files.fingerprint import code_digest, digest
from mot_sim.files.writing import write_lines
from mot_sim.simulation.episode import record
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.scene import Scene
from mot_sim.simulation.sensors import Detector, Profile
from mot_sim.simulation.sensors.fitting.calibrate import Progress, fit_profile
from mot_sim.simulation.sensors.fitting.measure import LabelledDetections
from mot_sim.simulation.sensors.profile import profile_lines, read_profile
from tracker.errors import BadConfig
from tracker.types import Tracks

REAL = "real"
SEED_STRIDE = 1000  # between the seeds of a re-enactment; its drives count up in between
MIN_DRIVES = 2  # of which each half is seen by a profile that was fitted to the other


@dataclass(frozen=True, eq=False)
class World:
    """Drives that are scored together."""

    name: str
    """`real`, or what was made and its seed."""
    drives: tuple[RecordedSequence, ...]
    """The drives, each with a name of its own."""
    truths: Mapping[str, Tracks]
    """What is true, by the drive's name."""


def real_world(drives: Sequence[KittiSequence]) -> World:
    """The labelled drives as they are."""
    return World(
        REAL, tuple(drives), {each.name: each.truth for each in drives if each.truth is not None}
    )


def require_foretellable(drives: Sequence[KittiSequence], halves: bool) -> None:
    """BadConfig for drives that cannot be re-enacted, or not judged by halves.

    halves: each half of the drives needs labels of cars.
    """
    for drive in drives:
        if drive.kinds != ("Car",):
            raise BadConfig(
                f"drive {drive.name}: detections of {', '.join(drive.kinds)}; the testbed drives "
                "and labels cars alone: give a detector of cars, and no --classes"
            )
    if halves and len(drives) < MIN_DRIVES:
        raise BadConfig(
            f"{len(drives)} labelled drive{'s' * (len(drives) != 1)}: no half to fit a profile to; "
            "give more, or --profile with one that was fitted elsewhere"
        )


def halves_of(drives: Sequence[KittiSequence]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Every other drive, and the others."""
    return tuple(range(0, len(drives), 2)), tuple(range(1, len(drives), 2))


def fit_halves(drives: Sequence[KittiSequence], kept: Path | None, tell: Progress) -> list[Profile]:
    """A profile for every drive, fitted to the half that it is not in."""
    profiles: list[Profile] = [Profile()] * len(drives)
    for mine, others in zip(halves_of(drives), halves_of(drives)[::-1], strict=True):
        profile = fit_to([drives[place] for place in others], kept, tell)
        for place in mine:
            profiles[place] = profile
    return profiles


def fit_to(drives: Sequence[KittiSequence], kept: Path | None, tell: Progress) -> Profile:
    """A profile fitted to labelled drives, or what an earlier call kept of that.

    kept: folder of profiles; None: nothing is kept. Raises as `fit_profile` does.
    """
    name = "-".join(drive.name for drive in drives)
    shown = [(drive.log.frames, drive.log.detections, drive.truth) for drive in drives]
    path = None if kept is None else kept / f"{digest([name, code_digest(), shown])}.toml"
    if path is None or not path.is_file():
        tell(f"fitting a profile to {name}")
        profile = fit_profile([LabelledDetections.of(drive) for drive in drives], name)
        if path is None:
            return profile
        write_lines(path, profile_lines(profile))
    return read_profile(path)


def reenacted(
    drives: Sequence[KittiSequence], kept: Path | None, tell: Progress
) -> list[Reenacted]:
    """All drives drawn; see `reenact`."""
    made = []
    for drive in drives:
        tell(f"drawing {drive.name}")
        made.append(reenact(drive, kept))
    return made


def made_world(drives: Sequence[Reenacted], profiles: Sequence[Profile], seed: int) -> World:
    """The re-enacted drives, each seen by its profile."""
    seen = [
        replace(
            each.seen_by(profile, SEED_STRIDE * seed + number), name=f"{each.drive.name}-{seed}"
        )
        for number, (each, profile) in enumerate(zip(drives, profiles, strict=True))
    ]
    truths = {drive.name: each.truth for drive, each in zip(seen, drives, strict=True)}
    return World(f"re-enacted, seed {seed}", tuple(seen), truths)


def scene_seen_by(name: str, profile: Profile, frames: int | None) -> Scene:
    """A scene of the register with its own length, or another one. Raises UnknownName."""
    scene = find_scene(name) if frames is None else find_scene(name, frames=frames)
    return replace(scene, detector=Detector(profile))


def scene_worlds(scene: Scene, seeds: Sequence[int]) -> Iterator[World]:
    """A run of the scene per seed."""
    for seed in seeds:
        episode = replace(record(scene, seed), name=f"{scene.name}-{seed}")
        yield World(f"{scene.name}, seed {seed}", (episode,), {episode.name: episode.truth})
