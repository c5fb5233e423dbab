"""A profile: the effects of one detector with their numbers, in a versioned TOML file."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from math import isfinite
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from mot_sim.files.documents import read_toml
from mot_sim.files.named_objects import NameRegister
from mot_sim.simulation.sensors.appearance import AppearanceNoise
from mot_sim.simulation.sensors.border import Border
from mot_sim.simulation.sensors.clutter import Clutter
from mot_sim.simulation.sensors.confusion import Confusion
from mot_sim.simulation.sensors.duplicates import Duplicates
from mot_sim.simulation.sensors.jitter import Jitter
from mot_sim.simulation.sensors.keypoints import Keypoints
from mot_sim.simulation.sensors.merges import Merges
from mot_sim.simulation.sensors.misses import Misses
from mot_sim.simulation.sensors.occlusion import VisiblePart
from mot_sim.simulation.sensors.pose import Pose
from mot_sim.simulation.sensors.scores import ScoreNoise
from mot_sim.simulation.sensors.shape import Shape
from mot_sim.simulation.sensors.splits import Splits
from tracker.errors import BadConfig, BadFile, UnknownName

VERSION = 1  # of the files; a newer one may mean what this code does not know
FOLDER = Path(__file__).parent / "profiles"
PROFILES = ("cues", "perfect", "permatrack", "pointrcnn", "rrc", "subcnn")

PROFILE_NAMES = NameRegister("profile", {})

EFFECTS: dict[str, type] = {
    "confusion": Confusion,
    "misses": Misses,
    "visible_part": VisiblePart,
    "jitter": Jitter,
    "border": Border,
    "scores": ScoreNoise,
    "duplicates": Duplicates,
    "merges": Merges,
    "splits": Splits,
    "clutter": Clutter,
    "pose": Pose,
    "keypoints": Keypoints,
    "shape": Shape,
    "appearance": AppearanceNoise,
}


@dataclass(frozen=True)
class Profile:
    """The effects of one detector; an effect that is None does nothing.

    Without `confusion` all kinds are reported as cars.
    """

    name: str = "perfect"
    source: str = ""
    confusion: Confusion | None = None
    misses: Misses | None = None
    visible_part: VisiblePart | None = None
    jitter: Jitter | None = None
    border: Border | None = None
    scores: ScoreNoise | None = None
    duplicates: Duplicates | None = None
    merges: Merges | None = None
    splits: Splits | None = None
    clutter: Clutter | None = None
    pose: Pose | None = None
    keypoints: Keypoints | None = None
    shape: Shape | None = None
    appearance: AppearanceNoise | None = None


def find_profile(name: str) -> Profile:
    """The profile of a name, of a TOML file, or of `module:function`, which gives one.

    Raises UnknownName, BadFile and BadConfig.
    """
    if name in PROFILES:
        return read_profile(FOLDER / f"{name}.toml")
    if name.endswith(".toml"):
        return read_profile(Path(name))
    if ":" in name:
        profile: Profile = PROFILE_NAMES.make(name, Profile)
        return profile
    raise UnknownName.of("profile", name, PROFILES)


def read_profile(path: Path) -> Profile:
    """A profile file, checked. Raises BadFile when it is no TOML or of a newer version."""
    content = read_toml(path, "no profile can be read")
    version = content.pop("version", None)
    if not isinstance(version, int) or not 1 <= version <= VERSION:
        raise BadFile(
            f"{path}: a profile of version {version}; this mot-sim reads up to {VERSION}: "
            "take a newer mot-sim, or fit again with `mot-sim calibrate`"
        )
    given: dict[str, Any] = {key: content.pop(key, "") for key in ("name", "source")}
    for key, word in given.items():
        if not isinstance(word, str):
            raise BadConfig(f"{path}: {key} = {word!r}: give a word")
    for key, table in content.items():
        if key not in EFFECTS:
            raise UnknownName.of(f"effect in {path.name}:", key, EFFECTS)
        given[key] = dataclass_from_table(EFFECTS[key], table, f"{path}: [{key}]")
    return Profile(**given)


def dataclass_from_table(kind: type, table: Any, where: str) -> Any:
    """A dataclass from a TOML table, its own dataclasses from theirs. Raises BadConfig."""
    if not isinstance(table, Mapping):
        raise BadConfig(f"{where}: {table!r} is no table of parameters")
    hints = get_type_hints(kind)
    for key in table:
        if key not in hints:
            raise UnknownName.of(f"parameter of {where}", key, hints)
    for each in fields(kind):
        required = each.default is MISSING and each.default_factory is MISSING
        if required and each.name not in table:
            raise BadConfig(f"{where}: {each.name} is missing")
    values = {key: _value(hints[key], value, f"{where} {key}") for key, value in table.items()}
    return kind(**values)


def _value(hint: Any, value: Any, where: str) -> Any:
    """A TOML value as its field wants it: floats, tuples of floats, dataclasses."""
    if isinstance(hint, UnionType):
        hint = next(each for each in get_args(hint) if each is not type(None))
    if is_dataclass(hint):
        return dataclass_from_table(hint, value, where)  # type: ignore[arg-type]
    if get_origin(hint) is tuple:
        if not isinstance(value, list):
            raise BadConfig(f"{where}: {value!r} is no list of numbers")
        return tuple(_number(each, where) for each in value)
    if hint is int:
        number = _number(value, where)
        if not number.is_integer():
            raise BadConfig(f"{where}: {value} is no whole number")
        return int(number)
    return _number(value, where)


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadConfig(f"{where}: {value!r} is no number")
    if not isfinite(value):
        raise BadConfig(f"{where}: {value} is not finite")
    return float(value)


def profile_lines(profile: Profile) -> list[str]:
    """The TOML of a profile; `read_profile` gives the same back."""
    lines = [f"version = {VERSION}", f'name = "{profile.name}"', f'source = "{profile.source}"']
    for name in EFFECTS:
        effect = getattr(profile, name)
        if effect is not None:
            lines += ["", *_table_lines(name, effect)]
    return lines


def _table_lines(name: str, effect: Any) -> list[str]:
    """A table and, after its numbers, the tables inside it."""
    lines, inner = [f"[{name}]"], []
    for each in fields(effect):
        value = getattr(effect, each.name)
        if is_dataclass(value):
            inner += _table_lines(f"{name}.{each.name}", value)
        elif isinstance(value, tuple):
            lines.append(f"{each.name} = [{', '.join(f'{number:.8g}' for number in value)}]")
        else:
            lines.append(f"{each.name} = {value:.6g}")
    return lines + inner
