"""A profile: the effects of one detector with their numbers, in a versioned TOML file; weather."""

import logging
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from math import isfinite
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
from scipy.special import ndtri

from mot_sim.files.documents import read_toml
from mot_sim.files.named_objects import NameRegister
from mot_sim.simulation.sensors.boxes import Border, VisiblePart
from mot_sim.simulation.sensors.clutter import Clutter
from mot_sim.simulation.sensors.cues import AppearanceNoise, Keypoints, Pose, Shape
from mot_sim.simulation.sensors.jitter import EDGES, EdgeNoise, Jitter, edges_of_centre
from mot_sim.simulation.sensors.lives import Lives
from mot_sim.simulation.sensors.misses import Confusion, Misses
from mot_sim.simulation.sensors.multiplicity import EXAMPLE_COLUMNS, Duplicates, Merges, Splits
from mot_sim.simulation.sensors.quantiles import Quantiles
from mot_sim.simulation.sensors.scores import ScoreNoise
from mot_sim.simulation.sensors.suppression import OverlapSuppression
from tracker.errors import BadConfig, BadFile, UnknownName

VERSION = 3  # of the files; a newer one may mean what this code does not know
EXACT = ("log_odds",)  # written with all digits: detectors tie many boxes at a few scores
FOLDER = Path(__file__).parent / "profiles"
PROFILES = ("cues", "perfect", "permatrack", "pointrcnn", "rrc", "subcnn")

# What parameters were called in earlier versions, and what they are called now.
FORMER_PARAMETERS = {
    "memory": "autocorrelation",
    "flutter_memory": "flutter_autocorrelation",
    "flip_memory": "flip_autocorrelation",
    "by_cut": "by_truncation",
    "cut_by_height": "truncation_by_height",
}
STRIDES = (1, 13, 17, 23, 29)  # at which version 1's quantiles are paired; no two alike
PAIRED = (np.arange(31) + 0.5) / 31  # places of the quantiles that are taken
CENTRE_AND_SIZE = ("x", "y", "width", "height")  # of version 1's jitter
PROFILE_NAMES = NameRegister("profile", {})
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Profile:
    """The effects of one detector; an effect that is None does nothing."""

    name: str = "perfect"
    """What it is called."""
    source: str = ""
    """Where its numbers come from."""
    confusion: Confusion | None = None
    """Which vans and trucks are reported; None: all kinds are reported as cars."""
    misses: Misses | None = None
    """Which cars go unseen; None: only those without a visible pixel."""
    visible_part: VisiblePart | None = None
    """How much boxes keep to the visible part; None: boxes of the whole car."""
    jitter: Jitter | None = None
    """Errors of boxes."""
    border: Border | None = None
    """What happens to boxes at the image's border; None: they are clipped."""
    scores: ScoreNoise | None = None
    """Confidence of boxes; None: all are 1."""
    suppression: OverlapSuppression | None = None
    """Which of two objects' boxes are lost or weakened; None: none."""
    duplicates: Duplicates | None = None
    """Second boxes about one car."""
    merges: Merges | None = None
    """Cars that share one box."""
    splits: Splits | None = None
    """Vehicles in two boxes."""
    clutter: Clutter | None = None
    """Boxes where no car is."""
    lives: Lives | None = None
    """How long labelled cars are seen before and after their labels, where a drive is made from
    labels; None: they begin and end with them. Scenes know all lives: there it does nothing."""
    pose: Pose | None = None
    """Measured yaw and size; None: not measured."""
    keypoints: Keypoints | None = None
    """Measured keypoints; None: not measured."""
    shape: Shape | None = None
    """Measured shape coefficients; None: not measured."""
    appearance: AppearanceNoise | None = None
    """Descriptors of looks; None: not measured."""


# The tables of a profile's file by name, in their order.
TABLES: dict[str, type] = {
    name: get_args(hint)[0] for name, hint in get_type_hints(Profile).items() if get_args(hint)
}
# Those that are noise of a detector.
EFFECTS: dict[str, type] = {name: kind for name, kind in TABLES.items() if kind is not Lives}


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
        if key not in TABLES:
            raise UnknownName.of(f"effect in {path.name}:", key, TABLES)
        where = f"{path}: [{key}]"
        if version == 1 and key in FORMER_TABLES:
            given[key] = FORMER_TABLES[key](table, where)
        else:
            if version == 2 and key == "duplicates" and isinstance(table, dict):
                table.setdefault("at_unsure_jumps", table.get("at_jumps", 0.0))
            given[key] = dataclass_from_table(TABLES[key], table, where)
    if version == 1 and "misses" in given and "suppression" not in given:
        log.warning(
            "%s: a profile of version %d, without [suppression]: cars close behind others are "
            "found too often; fit it again with `mot-sim calibrate`", path, version,
        )  # fmt: skip
    return Profile(**given)


def former_jitter(table: Any, where: str) -> Jitter:
    """Jitter of edges from version 1's errors of centre and size. Raises BadConfig."""
    if not isinstance(table, Mapping):
        raise BadConfig(f"{where}: {table!r} is no table of parameters")
    for key in table:
        if key not in CENTRE_AND_SIZE:
            raise UnknownName.of(f"parameter of {where}", key, CENTRE_AND_SIZE)
    x, y, width, height = (
        dataclass_from_table(EdgeNoise, table.get(key, {}), f"{where} {key}")
        for key in CENTRE_AND_SIZE
    )
    left, right, horizontal = edges_of_centre(x, width)
    upper, lower, vertical = edges_of_centre(y, height)
    return Jitter(left, upper, right, lower, horizontal, vertical)


def former_duplicates(table: Any, where: str) -> Duplicates:
    """Second boxes from version 1's distributions, which were drawn one by one. Raises BadConfig.

    Of the quantiles of each number, examples are made that pair them in different orders.
    """
    if not isinstance(table, Mapping):
        raise BadConfig(f"{where}: {table!r} is no table of parameters")
    plain = dict(table)
    for name, stride in zip(EXAMPLE_COLUMNS, STRIDES, strict=True):
        if isinstance(table.get(name), Mapping):
            values = dataclass_from_table(Quantiles, table[name], f"{where} {name}")
            plain[name] = values.of_normal(ndtri(PAIRED * stride % 1.0)).round(4).tolist()
        else:
            plain[name] = [0.0] * len(PAIRED)
    made: Duplicates = dataclass_from_table(Duplicates, plain, where)
    return made


# Tables that version 1 wrote differently, and what reads them.
FORMER_TABLES = {"jitter": former_jitter, "duplicates": former_duplicates}


def dataclass_from_table(kind: type, table: Any, where: str) -> Any:
    """A dataclass from a TOML table, its own dataclasses from theirs. Raises BadConfig."""
    if not isinstance(table, Mapping):
        raise BadConfig(f"{where}: {table!r} is no table of parameters")
    hints = get_type_hints(kind)
    for key in table:
        if key not in hints and FORMER_PARAMETERS.get(key) in hints:
            raise UnknownName(
                f"{where}: '{key}' is called '{FORMER_PARAMETERS[key]}' now: rename it"
            )
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
    for name in TABLES:
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
            digits = 17 if each.name in EXACT else 8
            numbers = ", ".join(f"{number:.{digits}g}" for number in value)
            lines.append(f"{each.name} = [{numbers}]")
        else:
            lines.append(f"{each.name} = {value:.6g}")
    return lines + inner


@dataclass(frozen=True)
class SensorWeather:
    """What a weather does to a profile; its numbers are ours, not measured."""

    odds: float = 0.0
    """Added to the log-odds of being found; lower: more misses."""
    far: float = 0.0
    """Added on top for boxes of 25 px and lower, less up to 35 px; lower: more misses of far
    cars."""
    glare: float = 0.0
    """Least share of the misses that a frame's objects have in common, 0 to 1; more: many are
    missed at once, for about half a second."""
    jitter: float = 1.0
    """Factor on the errors of boxes; more: boxes jump more."""
    clutter: float = 1.0
    """Factor on the rate of false alarms; more: more false tracks."""
    score_shift: float = 0.0
    """Added to the scores' latent y before it is mapped to log-odds; lower: lower scores."""

    def __call__(self, profile: Profile) -> Profile:
        """The profile in this weather; effects that it lacks stay away."""
        misses, jitter = profile.misses, profile.jitter
        scores, clutter = profile.scores, profile.clutter
        if misses is not None:
            small = tuple(
                odds + self.far * (number < 3) for number, odds in enumerate(misses.by_height)
            )
            misses = replace(
                misses,
                base=misses.base + self.odds,
                by_height=small,
                shared=max(misses.shared, self.glare),
                shared_seconds=0.5 if self.glare > misses.shared else misses.shared_seconds,
            )
        if jitter is not None:
            parts = {name: getattr(jitter, name) for name in EDGES}
            jitter = replace(
                jitter,
                **{n: replace(p, spread=p.spread * self.jitter) for n, p in parts.items()},
            )
        if scores is not None:
            scores = replace(
                scores, by_visible=tuple(y + self.score_shift for y in scores.by_visible)
            )
        if clutter is not None:
            clutter = replace(clutter, rate=clutter.rate * self.clutter)
        return replace(profile, misses=misses, jitter=jitter, scores=scores, clutter=clutter)


WEATHERS: dict[str, SensorWeather] = {
    "clear": SensorWeather(),
    "rain": SensorWeather(-0.7, -0.3, 0.15, 1.3, 1.5, -0.3),
    "fog": SensorWeather(-0.5, -2.0, 0.1, 1.2, 0.8, -0.5),
    "glare": SensorWeather(-0.5, 0.0, 0.5, 1.2, 1.5, -0.4),
    "night": SensorWeather(-1.0, -0.7, 0.2, 1.4, 2.0, -0.6),
}


def in_weather(profile: Profile, name: str) -> Profile:
    """A profile in a weather of WEATHERS. Raises UnknownName."""
    if name not in WEATHERS:
        raise UnknownName.of("weather", name, WEATHERS)
    return WEATHERS[name](profile)
