"""From names to the drives that are diagnosed: of a scene, of a stress suite, of KITTI."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from mot_sim.datasets import KittiSequence
from mot_sim.datasets.images import ImageFolder, ImageSource
from mot_sim.diagnosis.tasks import KittiTask, SceneTask
from mot_sim.experiments.stress.suites import find_suites, read_suites
from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.seeded_episodes import default_cache
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.fingerprint import code_digest
from mot_sim.simulation.registry import scene_maker
from tracker.errors import BadConfig, DatasetNotFound


def scene_tasks(
    scene: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    contender: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a scene. Their truths are kept where `mot_sim.testing` keeps its own.

    Raises UnknownName and BadConfig for what cannot be run.
    """
    scene_maker(scene)
    if not len(seeds):
        raise BadConfig("--seeds 0: give 1 or more")
    if min(seeds) < 0:
        raise BadConfig(f"--first-seed {min(seeds)}: give 0 or more")
    conditions = Conditions.of(scene, settings)
    recordings = default_cache() / code_digest()[:16]
    for seed in seeds:
        yield SceneTask(conditions, seed, contender, recordings, attribute)


def suite_tasks(
    suite: str,
    settings: Mapping[str, Level],
    seeds: Sequence[int],
    contender: TrackerSpec,
    attribute: bool = False,
) -> Iterator[SceneTask]:
    """Runs of a stress suite; settings: what is changed in it. Raises as `scene_tasks`."""
    (found,) = find_suites([suite], read_suites())
    whole = {"scene.frames": found.frames, **found.settings, **settings}
    return scene_tasks(found.scene, whole, seeds, contender, attribute)


def kitti_tasks(drives: Sequence[KittiSequence], contender: TrackerSpec) -> Iterator[KittiTask]:
    """Sequences of a KITTI tree; all must have labels. Raises DatasetNotFound."""
    for drive in drives:
        if drive.label_path is None or drive.truth is None:
            raise DatasetNotFound(
                f"sequence {drive.name}: no labels (label_02/{drive.name}.txt); choose others: "
                "--sequences labelled takes those that have some"
            )
        yield KittiTask(replace(drive, images=None), contender, _images(drive))


def _images(drive: KittiSequence) -> ImageSource | None:
    """The images that the tree has of a drive."""
    if drive.label_path is None:
        return None
    return ImageFolder.find(drive.label_path.parents[1] / "image_02" / drive.name)


__all__ = ["kitti_tasks", "scene_tasks", "suite_tasks"]
