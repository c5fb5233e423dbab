"""The few modules of highway-env that we drive with, without those of its environments.

Its `__init__` loads all environments, and with them pygame, matplotlib, pandas and scipy.stats:
ten times what it takes to load its roads and cars.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import module_from_spec
from types import ModuleType

PACKAGE = "highway_env"
PARTS = ("road.lane", "road.road", "vehicle.behavior")


class WholeLater(MetaPathFinder):
    """Finds the package itself when somebody imports it after its parts, and gives it those."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """As the finder of files; None for anything else than the package."""
        spec = PathFinder.find_spec(fullname, path, target) if fullname == PACKAGE else None
        if spec is None or spec.loader is None:
            return None
        execute = spec.loader.exec_module

        def with_parts(module: ModuleType) -> None:
            for name, part in [*sys.modules.items()]:
                if name.rpartition(".")[0] == PACKAGE:
                    setattr(module, name.rpartition(".")[2], part)
            execute(module)

        spec.loader.exec_module = with_parts  # type: ignore[method-assign]
        return spec


def load_parts() -> None:
    """Load PARTS; whoever imports the package afterwards gets all of it."""
    spec = None if PACKAGE in sys.modules else PathFinder.find_spec(PACKAGE)
    if spec is None:  # it is loaded, or missing, which the next import tells
        return
    sys.modules[PACKAGE] = module_from_spec(spec)
    try:
        for part in PARTS:
            import_module(f"{PACKAGE}.{part}")
    finally:
        del sys.modules[PACKAGE]
    sys.meta_path.insert(0, WholeLater())
