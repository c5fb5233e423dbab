"""What a result hangs on, as one short word: settings, the code, and the libraries it runs on."""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from mot_sim.files.settings import versions

SWEEP_FORMAT = 1  # of a sweep's folder and of its trials; raised when either changes
PACKAGES = ("tracker", "mot_sim", "scenes")  # ours
DIGEST_LETTERS = 32  # hexadecimal digits of a digest that are kept: 128 bits

# The rooms of mot_sim that decide no number of a trial, and what of the experiments does.
UNDECIDING_ROOMS = {
    "cli",
    "report",
    "plotting",
    "tables",
    "training",
    "envs",
    "testing",
    "diagnosis",
}
DECIDING_FILES = {
    f"sweep/{name}.py" for name in ("conditions", "tracker_specs", "drives", "paths", "trial")
}
# What records traffic and truth: folders and files of our packages.
TRUTH_PLACES = (
    *("scenes", "mot_sim/simulation", "mot_sim/files", "mot_sim/datasets"),
    *(f"tracker/{room}" for room in ("types", "geometry", "kernels", "shape", "lazy_names.py")),
    *(f"mot_sim/experiments/sweep/{name}.py" for name in ("conditions", "drives")),
)
NO_TRUTH_PLACES = ("mot_sim/simulation/sensors/fitting",)
CODE_SUFFIXES = (".py", ".npz", ".toml", ".onnx", ".json")


def digest(content: Any) -> str:
    """A hash of plain values, dataclasses and arrays; equal content gives equal words."""
    text = json.dumps(canonical(content), sort_keys=True)
    return sha256(text.encode()).hexdigest()[:DIGEST_LETTERS]


def canonical(content: Any) -> Any:
    """The content as JSON can hold it: classes by name, arrays by the hash of their bytes."""
    if content is None or isinstance(content, bool | int | float | str):
        return content
    if isinstance(content, Mapping):
        return {str(name): canonical(value) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [canonical(value) for value in content]
    if isinstance(content, np.ndarray):
        held = sha256(np.ascontiguousarray(content).tobytes()).hexdigest()
        return [str(content.dtype), list(content.shape), held]
    if is_dataclass(content):
        kind = type(content)
        values = {
            each.name: canonical(getattr(content, each.name))
            for each in fields(content)
            if each.init
        }
        return {_kind(kind): values}
    return _kind(type(content))


def _kind(kind: type) -> str:
    """A class by name; one that is neither ours nor of a library that `versions` tells, and source.

    So a cost or an effect of somebody's own counts as another when its file is edited.
    """
    name = f"{kind.__module__}:{kind.__qualname__}"
    top = kind.__module__.partition(".")[0]
    known = {*PACKAGES, *sys.stdlib_module_names, "numpy", "scipy", "__main__"}
    return name if top in known else f"{name}:{source_digest(kind.__module__)}"


@lru_cache(maxsize=1)
def code_digest() -> str:
    """Of the source of everything that computes a trial, and of the versions it runs on."""
    return _digest_of(_has_weight)


@lru_cache(maxsize=1)
def truth_digest() -> str:
    """The same of what records the traffic and the truth of a run: no tracker, no detector."""
    return _digest_of(records_truth)


def _digest_of(counts: Callable[[Path], bool]) -> str:
    """Of the files of our packages that count, by their path from the package on."""
    total = sha256()
    for package in PACKAGES:
        home = _home(package)
        for path in sorted(path for path in home.rglob("*") if path.suffix in CODE_SUFFIXES):
            name = path.relative_to(home.parent)
            if counts(name):
                total.update(f"{name.as_posix()}\n".encode() + path.read_bytes())
    return digest([SWEEP_FORMAT, total.hexdigest(), versions()])


def records_truth(name: Path) -> bool:
    """Whether a file of our packages can change the recorded truth of a run."""
    return any(f"{name.as_posix()}/".startswith(f"{place}/") for place in TRUTH_PLACES) and not any(
        f"{name.as_posix()}/".startswith(f"{place}/") for place in NO_TRUTH_PLACES
    )


def _has_weight(name: Path) -> bool:
    """Whether a file of our packages can change a trial."""
    if name.parts[0] != "mot_sim":
        return True
    if name.parts[1] == "experiments":
        return "/".join(name.parts[2:]) in DECIDING_FILES
    return name.parts[1] not in UNDECIDING_ROOMS


def _home(package: str) -> Path:
    """The folder of a package; found by name, since mot_sim imports no scenes."""
    found = import_module(package).__path__
    return Path(next(iter(found)))


def source_digest(module: str) -> str:
    """Of the source of a module that is not ours; of its name where it has no file.

    The module is not imported. Raises ModuleNotFoundError, or ValueError, where there is none.
    """
    if module in sys.modules:
        file = getattr(sys.modules[module], "__file__", None)
    elif (spec := find_spec(module)) is not None:
        file = spec.origin if spec.has_location else None
    else:
        raise ModuleNotFoundError(f"No module named {module!r}", name=module)
    return module if file is None else sha256(Path(file).read_bytes()).hexdigest()[:DIGEST_LETTERS]
