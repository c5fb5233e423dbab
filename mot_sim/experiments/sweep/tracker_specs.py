"""Trackers side by side: ours with parameters changed, or any object with `step` or `update`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import partial
from typing import Any

from mot_sim.evaluation.runs import Recipe, parse_costs
from mot_sim.experiments.sweep.paths import (
    Level,
    descriptions,
    fitting,
    parse_level,
    scalars,
    unknown,
    with_value,
)
from mot_sim.files.field_docstrings import field_docstrings
from mot_sim.files.named_objects import ASSOCIATION_NAMES, COST_NAMES, TRACKER_NAMES, BrokenCode
from mot_sim.foreign.isolation import (
    DEFAULT_ISOLATION,
    IsolatedTracker,
    Isolation,
    TrackerStopped,
)
from mot_sim.foreign.protocol import FRAME_RATE, Steps, make_steps
from mot_sim.foreign.register import GUESTS
from mot_sim.simulation.rig import Rig
from tracker import TRACKERS, Camera
from tracker.errors import BadConfig, UnknownName

NOT_SETTINGS = ("camera", "state", "explanation", "explain", "tracker")  # fields
BY_NAME = ("costs", "associate")  # settings that name a component
ABSENT = "none"  # instead of a component that a tracker does without


@dataclass(frozen=True)
class TrackerSpec:
    """One tracker of a sweep."""

    name: str
    """Its name in tables."""
    made_by: str = "default"
    """A name of TRACKERS, of GUESTS or of an installed package, or MODULE:CALLABLE, which is given
    the camera if it takes an argument of that name; see `as_steps` for what it may make."""
    settings: Mapping[str, Level] = field(default_factory=dict)
    """For one of TRACKERS, fields by dotted names (lifecycle.max_gap), costs
    (volume=0.6+reprojection=0.4), associate, and `none` for a component that it can do without
    (car_filter=none); else arguments of the callable."""
    isolation: Isolation = DEFAULT_ISOLATION
    """Whether `start` gives it a process of its own, and what it may take there."""

    @classmethod
    def parse(cls, text: str) -> "TrackerSpec":
        """From [NAME=]TRACKER[:SETTING=VALUE]..., TRACKER as in `made_by`."""
        head, *parts = text.split(":")
        name, equals, made_by = head.partition("=")
        if not equals:
            name, made_by = text, head
        if parts and "=" not in parts[0]:
            made_by, parts = f"{made_by}:{parts[0]}", parts[1:]
        settings: dict[str, Level] = {}
        for part in _joined(parts):
            key, equals, value = part.partition("=")
            if not (key and equals and value) or key in settings:
                raise BadConfig(
                    f"tracker {text!r}: write default:lifecycle.max_gap=1:associate=greedy, "
                    "each setting once"
                )
            settings[key] = value if key in BY_NAME else parse_level(value)
        return cls(name, made_by, settings)

    @property
    def is_ours(self) -> bool:
        """Whether it is a tracker of TRACKERS."""
        return self.made_by in TRACKERS

    @property
    def is_guest(self) -> bool:
        """Whether it is one of GUESTS, which run in environments of their own."""
        return self.made_by in GUESTS

    def with_settings(self, more: Mapping[str, Level]) -> "TrackerSpec":
        """The same with more set."""
        return replace(self, settings={**self.settings, **more}) if more else self

    def check(self) -> None:
        """Build it once. Raises UnknownName and BadConfig for what is no tracker of this name.

        Code of its own that raises, hangs or ends its process is no wrong name: trials tell.
        """
        self.description()
        if self.is_guest:
            GUESTS[self.made_by].interpreter()
        elif not self.is_ours:
            try:
                tracker = self.start(Rig.kitti().camera)
                if isinstance(tracker, IsolatedTracker):
                    tracker.close(keep=False)  # what its module prints is heard in a trial
            except BrokenCode:
                return
            except TrackerStopped as stopped:
                for kind in (UnknownName, BadConfig):
                    if stopped.kind == kind.__name__:
                        raise kind(stopped.reason) from None

    def description(self) -> dict[str, Any]:
        """What decides what it does."""
        if not self.is_ours:
            source = GUESTS[self.made_by] if self.is_guest else TRACKER_NAMES.source(self.made_by)
            return {"made_by": self.made_by, "source": source, "settings": self.settings}
        return _described(self._ours(Rig.kitti().camera))

    def start(self, camera: Camera, frame_rate: float = FRAME_RATE) -> Steps:
        """A fresh tracker, in a process of its own where `isolation` says so; `close_tracker` it.

        Raises as `build`, and TrackerStopped for what goes wrong in that process.
        """
        if self.is_guest:
            guest: Any = self.build(camera, frame_rate)
            guest.guest = replace(guest.guest, timeout=self.isolation.time_limit)
            return guest
        if not self.isolation.covers(self.made_by in TRACKER_NAMES.ours):
            return self.build(camera, frame_rate)
        code = f"{self.made_by} {TRACKER_NAMES.source(self.made_by)}"
        return IsolatedTracker(partial(self.build, camera, frame_rate), self.isolation, code)

    def build(self, camera: Camera, frame_rate: float = FRAME_RATE) -> Steps:
        """A fresh tracker for this camera. frame_rate: Hz, for those of libraries."""
        if self.is_ours:
            built: Steps = self._ours(camera)
            return built
        settings: dict[str, Any] = dict(self.settings)
        return make_steps(self.made_by, camera, frame_rate, self.name, **settings)

    def _ours(self, camera: Camera) -> Any:
        """A tracker of TRACKERS with its settings, in its framework."""
        named = {key: str(self.settings[key]) for key in BY_NAME if key in self.settings}
        costs = parse_costs(named["costs"].replace("+", ",")) if "costs" in named else None
        built: Any = Recipe(self.made_by, costs, named.get("associate")).build(camera)
        for path, value in self.settings.items():
            if path in BY_NAME:
                continue
            known = tracker_settings(built)
            if path in removable(built):
                if value != ABSENT:
                    raise BadConfig(
                        f"tracker.{path} = {value!r}: only {path}={ABSENT} is a setting of it; for "
                        f"what is inside: {path}.{_first_inside(path, known)}=..."
                    )
                built = _with(built, path, None)
                continue
            if path not in known:
                raise unknown(f"setting of tracker {self.made_by}:", path, known)
            level = fitting(value, known[path], f"tracker.{path}")
            built = _with(built, path, level)
        return built


def _joined(parts: Sequence[str]) -> list[str]:
    """The settings of a tracker's text, cut at colons, put together where a name has one.

    `costs=volume=0.6+my_module` and `MyCost=0.4` are one: my_module is no cost.
    """
    joined: list[str] = []
    for part in parts:
        key, _, value = (joined[-1] if joined else "").partition("=")
        last = value.rpartition("+")[2]
        is_cut = (key == "costs" and "=" not in last and last not in COST_NAMES) or (
            key == "associate" and last not in ASSOCIATION_NAMES
        )
        if is_cut:
            joined[-1] += f":{part}"
        else:
            joined.append(part)
    return joined


def tracker_settings(built: Any) -> dict[str, Level]:
    """The values of one of our trackers that can be set, by their dotted names.

    A framework around a tracker (a window of frames) has its own, and the tracker's.
    """
    inner = getattr(built, "tracker", None)
    return _own_settings(built) | ({} if inner is None else tracker_settings(inner))


def setting_descriptions(built: Any) -> dict[str, str]:
    """What each of `tracker_settings` is, and each of BY_NAME."""
    kind: type = type(built)
    texts = field_docstrings(kind)
    own = {name: texts[name] for name in BY_NAME if name in texts}
    for name, part in _parts(built).items():
        own |= descriptions(part, name, texts.get(name, ""))
    inner = getattr(built, "tracker", None)
    return own | ({} if inner is None else setting_descriptions(inner))


def removable(built: Any) -> frozenset[str]:
    """The components that one of our trackers has, and does without where they are `none`."""
    inner = getattr(built, "tracker", built)
    return frozenset(
        each.name for each in fields(inner)
        if each.default is None and is_dataclass(getattr(inner, each.name))
    )  # fmt: skip


def _with(built: Any, path: str, value: Level | None) -> Any:
    """A tracker, or what is in a framework, with one value changed; None: without a component."""
    if path.partition(".")[0] in _parts(built):
        return with_value(built, path, value)
    return replace(built, tracker=with_value(built.tracker, path, value))


def _first_inside(path: str, known: Mapping[str, Level]) -> str:
    """The first setting inside of a component, by its name there."""
    return next((each[len(path) + 1 :] for each in known if each.startswith(f"{path}.")), "NAME")


def _own_settings(built: Any) -> dict[str, Level]:
    return scalars(_parts(built))


def _parts(built: Any) -> dict[str, Any]:
    """The components of a tracker or framework."""
    names = [each.name for each in fields(built) if each.name not in NOT_SETTINGS]
    return {name: getattr(built, name) for name in names}


def _described(built: Any) -> dict[str, Any]:
    """What decides what a tracker or framework of ours does."""
    inner = getattr(built, "tracker", None)
    own = {"kind": type(built).__qualname__, **_parts(built)}
    return own if inner is None else {**own, "tracker": _described(inner)}


def tracker_specs_of(trackers: Sequence[str | TrackerSpec]) -> tuple[TrackerSpec, ...]:
    """The trackers of a design. Raises BadConfig for none, and for two of one name."""
    found = [TrackerSpec.parse(each) if isinstance(each, str) else each for each in trackers]
    names = [each.name for each in found]
    if not found:
        raise BadConfig("no trackers: give --trackers default,paper")
    for each in found:
        if names.count(each.name) > 1:
            raise BadConfig(f"two trackers are named {each.name}: write OTHER={each.name}")
        if ":" not in each.made_by and each.made_by not in {*TRACKER_NAMES.names(), *GUESTS}:
            raise UnknownName.of("tracker", each.made_by, [*TRACKER_NAMES.names(), *GUESTS])
    return tuple(found)


__all__ = [
    "TrackerSpec",
    "setting_descriptions",
    "tracker_settings",
    "tracker_specs_of",
]
