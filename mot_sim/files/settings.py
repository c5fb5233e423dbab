"""What decides the content of a folder, told in JSON, and compared before more is added to it."""

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from tracker.errors import BadConfig, BadOutput, OutputExists

VERSIONED_PACKAGES = ("mot-sim", "numpy", "scipy", "numba", "filterpy", "opencv-python-headless")

# What decides the results, by name; plain values, so that JSON gives back the same.
Settings = Mapping[str, str | float | int | bool | None]


def versions() -> dict[str, str]:
    """Of Python and of what computes."""
    return {"python": platform.python_version()} | {
        name: _version(name) for name in VERSIONED_PACKAGES
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def require_empty(path: Path) -> None:
    """OutputExists for a folder that holds something, BadOutput for what is no folder."""
    if holds_something(path):
        raise OutputExists(f"{path}: not empty; choose another folder, or empty it")


def holds_something(path: Path) -> bool:
    """Whether there is a folder that is not empty; BadOutput for what is no folder."""
    try:
        return any(path.iterdir())
    except FileNotFoundError:
        return False
    except OSError as error:
        raise BadOutput(f"{path}: no folder to write to: {error.strerror}") from None


def plain_settings(told: Any) -> Settings:
    """The settings that a JSON file tells. Raises ValueError for what are none."""
    for name, value in dict(told).items():
        if not isinstance(value, str | float | int | None):
            raise ValueError(f"setting {name} is {value!r:.80}")
    return dict(told)


def require_same(path: Path, before: Settings, now: Settings) -> None:
    """BadConfig that names every setting which differs."""
    if found := differing_settings(before, now):
        raise BadConfig(
            f"{path}: the run there had other settings: {'; '.join(found)}; "
            "give the same ones, or choose another folder"
        )


def differing_settings(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """What each entry that differs was and is, in the order of their names."""
    return [
        f"{name} was {before.get(name)!r} and is {now.get(name)!r}"
        for name in sorted({*before, *now})
        if before.get(name) != now.get(name)
    ]
