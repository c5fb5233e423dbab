"""Gymnasium's ids: one for every scene, one for any scene, and one for association."""

import re
import sys
from collections.abc import Iterable
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType

from mot_sim.simulation.scene_names import SCENE_GROUP, SCENES

NAMESPACE = "mot_sim"
ANY_SCENE = f"{NAMESPACE}/Scene-v0"
ASSOCIATION = f"{NAMESPACE}/Association-v0"
WELL_NAMED = re.compile(r"[\w/-]+")  # what Gymnasium takes
GYMNASIUM = "gymnasium"
SCENE_ENV = "mot_sim.envs.scene_env:SceneEnv"
# What steps many episodes of an id at once.
VECTORS = {ASSOCIATION: "mot_sim.envs.association_vector_env:AssociationVectorEnv"}


class RegisterOnImport(MetaPathFinder, Loader):
    """Registers the ids when Gymnasium is first imported: who does not need it, does not wait."""

    loader: Loader
    """Gymnasium's own."""

    def find_spec(
        self, fullname: str, path: Iterable[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Gymnasium, as whoever comes after us finds it, but loaded by us; nothing else.

        path: of the package around it; that of a namespace is no `Sequence`.
        """
        if fullname != GYMNASIUM or self not in sys.meta_path:
            return None
        sys.meta_path.remove(self)
        spec = find_spec(fullname)
        if spec is not None and spec.loader is not None:
            self.loader, spec.loader = spec.loader, self
        return spec

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """What Gymnasium's own loader makes."""
        return self.loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Load it, leave no trace of us, and register."""
        assert module.__spec__ is not None
        module.__spec__.loader = module.__loader__ = self.loader
        self.loader.exec_module(module)
        register_environments()


def register_with_gymnasium() -> None:
    """Register all ids now if Gymnasium is imported already, else when it is."""
    if GYMNASIUM in sys.modules:
        register_environments()
    elif not any(isinstance(finder, RegisterOnImport) for finder in sys.meta_path):
        sys.meta_path.insert(0, RegisterOnImport())


def register_environments() -> None:
    """Register all ids that are not registered yet; their modules are imported by `gym.make`.

    Scenes of installed packages have ids like ours; only their names are looked up here.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - importing mot_sim waits for neither

    import gymnasium as gym  # noqa: PLC0415

    scenes = [*SCENES, *sorted(entry_points(group=SCENE_GROUP).names)]
    wanted = {
        ASSOCIATION: ("mot_sim.envs.association_env:AssociationEnv", {}),
        ANY_SCENE: (SCENE_ENV, {}),
        **{environment_id(name): (SCENE_ENV, {"scene": name}) for name in reversed(scenes)},
    }
    for name, (place, options) in wanted.items():
        if name not in gym.registry and WELL_NAMED.fullmatch(name):
            gym.register(name, place, vector_entry_point=VECTORS.get(name), kwargs=options)


def environment_id(scene: str) -> str:
    """`mot_sim/TJunction-v0` of the scene `t_junction`."""
    return f"{NAMESPACE}/{''.join(word.capitalize() for word in scene.split('_'))}-v0"
