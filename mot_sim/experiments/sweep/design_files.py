"""Designs in TOML files, and those that come with the package."""

from collections.abc import Mapping
from dataclasses import fields
from itertools import chain
from pathlib import Path
from typing import Any

from mot_sim.experiments.sweep.design import Design
from mot_sim.experiments.sweep.paths import Level
from mot_sim.experiments.sweep.points import Levels, Range
from mot_sim.experiments.sweep.tracker_specs import TrackerSpec
from mot_sim.files.documents import read_toml, require_inside
from tracker.errors import BadConfig, UnknownName

FOLDER = Path(__file__).parent / "designs"
DESIGNS = ("noise",)


def read_design(name: str, **changes: Any) -> Design:
    """The design of a name, or of a TOML file, with some fields changed.

    Raises UnknownName, BadFile for no TOML, BadConfig for a design that cannot be.
    """
    if name in DESIGNS:
        path = FOLDER / f"{name}.toml"
    elif name.endswith(".toml"):
        path = Path(name)
    else:
        raise UnknownName.of("design", name, DESIGNS)
    content = read_toml(path, "no design can be read")
    known = {each.name: each for each in fields(Design)}
    for key in content:
        if key not in known:
            raise UnknownName.of(f"entry of {path}:", key, known)
    content["axes"] = {
        axis: _levels(levels, f"{path}: axis {axis}")
        for axis, levels in _table(content.get("axes", {}), f"{path}: axes").items()
    }
    content["trackers"] = _trackers(content.get("trackers", ["default", "paper"]), path)
    _require_types(content, path)
    _require_profiles(content, path)
    return Design(**{**content, **changes})


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise BadConfig(f"{where}: {value!r} is no table")
    return value


def _levels(value: Any, where: str) -> Levels:
    """A list of levels, or a table low, high, log."""
    if isinstance(value, Mapping):
        try:
            return Range(float(value["low"]), float(value["high"]), bool(value.get("log", False)))
        except (KeyError, TypeError, ValueError):
            raise BadConfig(f"{where}: {dict(value)}: write {{low = 0, high = 1}}") from None
    if not isinstance(value, list) or not all(
        isinstance(each, float | int | str) for each in value
    ):
        raise BadConfig(f"{where}: {value!r} is no list of levels")
    return tuple(value)


def _trackers(value: Any, path: Path) -> tuple[str | TrackerSpec, ...]:
    """A list of words, or a table of tables."""
    if isinstance(value, list) and all(isinstance(each, str) for each in value):
        return tuple(value)
    found = []
    for name, table in _table(value, f"{path}: trackers").items():
        settings = dict(_table(table, f"{path}: tracker {name}"))
        for key, setting in settings.items():
            if not isinstance(setting, Level):
                raise BadConfig(f"{path}: tracker {name}: {key} = {setting!r}: give one value")
        found.append(TrackerSpec(name, str(settings.pop("made_by", "default")), settings))
    return tuple(found)


def _require_profiles(content: Mapping[str, Any], path: Path) -> None:
    """Raise BadFile for a profile's file that lies neither beside the design nor where we work."""
    axes = [levels for levels in content["axes"].values() if isinstance(levels, tuple)]
    for level in (*chain(*axes), *content.get("fixed", {}).values()):
        if isinstance(level, str) and level.endswith(".toml"):
            require_inside(level, f"{path}", path.parent, Path.cwd())


def _require_types(content: Mapping[str, Any], path: Path) -> None:
    """Raise BadConfig for a word where a number belongs, or the other way round."""
    wanted = {"scene": str, "mode": str, "rules": str, "fixed": dict} | dict.fromkeys(
        ("seeds", "first_seed", "frames", "samples"), int
    )
    for key, kind in wanted.items():
        if key in content and type(content[key]) is not kind:
            raise BadConfig(f"{path}: {key} = {content[key]!r}: give a {kind.__name__}")
    for axis, level in content.get("fixed", {}).items():
        if not isinstance(level, Level):
            raise BadConfig(f"{path}: fixed {axis} = {level!r}: give one value")
