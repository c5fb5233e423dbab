"""What goes by a name: ours, those of installed packages, and anybody's own as `module:name`."""

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from importlib import import_module, invalidate_caches
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import EntryPoint, entry_points
from inspect import signature
from pathlib import Path
from traceback import walk_tb
from types import ModuleType
from typing import Any, NoReturn

from mot_sim.files.fingerprint import PACKAGES, source_digest
from tracker import FRAMEWORKS, TRACKERS, Camera, cuboid_tracker
from tracker.costs import COSTS
from tracker.errors import BadConfig, TrackingError, UnknownName

MODULE_AND_NAME = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*:[^\W\d]\w*(\.[^\W\d]\w*)*")
MAX_LISTED = 8  # names of a module that an error lists


class BrokenCode(BadConfig):
    """Somebody else's code that raised when it was imported or called."""


@dataclass(frozen=True, eq=False)
class NameRegister:
    """The things of one kind, by name.

    A name is one of `ours`, one that an installed package registers, or `module:name` of anything
    that Python can import (`module:Class.method` too).
    """

    what: str
    """What one of them is called in errors: scene, cost, ..."""
    ours: Mapping[str, Any]
    """The things by name; a string is the `module:name` of one that is imported when asked for."""
    group: str | None = None
    """The group of entry points in which packages register more; None: they cannot."""
    noun: str = "callable"
    """What a module must hold."""

    def find(self, name: str) -> Any:
        """The thing of a name. Raises UnknownName, and BadConfig for one that cannot be loaded."""
        where = f"{self.what} {name!r}"
        if name in self.ours:
            found = self.ours[name]
            return self._load(where, found) if isinstance(found, str) else found
        if ":" in name:
            return self._load(where, name, is_own=True)
        point = self._entry_point(name)
        return self._load(f"{where} of {_package(point)} ({self.group})", _place(point))

    def make(self, name: str, kind: type | tuple[type, ...], /, *given: Any, **named: Any) -> Any:
        """What the callable of a name gives. Raises as `find`, BadConfig where it is not of a kind.

        Whatever somebody else's code raises becomes a BadConfig with its file and line.
        """
        found = self.find(name)
        where = f"{self.what} {name!r}"
        if not callable(found):
            raise BadConfig(f"{where} is a {type(found).__name__}, no {self.noun}")
        _require_arguments(where, found, given, named)
        try:
            made = found(*given, **named)
        except TrackingError:
            raise
        except (Exception, SystemExit) as error:  # noqa: BLE001
            _refuse(f"{where} cannot be built", error)
        if not isinstance(made, kind):
            kinds = kind if isinstance(kind, tuple) else (kind,)
            wanted = " or ".join(each.__name__ for each in kinds)
            raise BadConfig(f"{where} gives a {type(made).__name__}, no {wanted}")
        return made

    def names(self) -> list[str]:
        """All names that stand for themselves: ours first, then those of installed packages."""
        return list(dict.fromkeys([*self.ours, *self._installed()]))

    def broken(self) -> dict[str, str]:
        """What is wrong with the names of installed packages that cannot be used, by name."""
        found = {}
        for name, points in self._installed().items():
            if name in self.ours:
                found[name] = f"{self.what} {name!r} of {_package(points[0])}: we have one already"
                continue
            try:
                self.find(name)
            except TrackingError as error:
                found[name] = str(error)
        return found

    def source(self, name: str) -> str | None:
        """What stands for the source of the thing of a name, as fingerprints want it; None: ours.

        Its module is found, but not imported. Raises as `find`.
        """
        if name in self.ours:
            return None
        try:
            return source_digest(self.place(name).partition(":")[0])
        except (ImportError, ValueError):  # there is no such module
            self.find(name)
            raise

    def place(self, name: str) -> str:
        """`module:name` of what is imported when it is asked for; nothing is imported.

        Raises UnknownName, and BadConfig where two packages have one of that name.
        """
        if name in self.ours:
            return str(self.ours[name])
        return name if ":" in name else _place(self._entry_point(name))

    def __contains__(self, name: str) -> bool:
        """Whether it is written as a name of this kind can be; `module:name` is not looked up."""
        return bool(name in self.names() or MODULE_AND_NAME.fullmatch(name))

    def _installed(self) -> dict[str, list[EntryPoint]]:
        return {} if self.group is None else _installed(self.group, tuple(sys.path))

    def _entry_point(self, name: str) -> EntryPoint:
        """The only one of a name. Raises UnknownName, BadConfig where two packages have one."""
        points = self._installed().get(name)
        if points is None:
            raise UnknownName.of(self.what, name, self.names())
        if len(points) > 1:
            both = " and ".join(_package(point) for point in points)
            raise BadConfig(f"{self.what} {name!r} is registered by {both}: uninstall one")
        return points[0]

    def _load(self, where: str, place: str, is_own: bool = False) -> Any:
        """What `module:name` names. where: how errors begin. is_own: no package registers it."""
        if not MODULE_AND_NAME.fullmatch(place):
            raise BadConfig(f"{where}: {place!r} is not written as MODULE:NAME")
        module, _, path = place.partition(":")
        found: Any = _import(where, module)
        if is_own:
            _require_not_hidden(where, module)
        for part in path.split("."):
            if not hasattr(found, part):
                inside = [each for each in dir(found) if not each.startswith("_")]
                close = get_close_matches(part, inside, n=1, cutoff=0.5)
                hint = f". Did you mean {close[0]!r}?" if close else ""
                own = [each for each in inside if _is_of(found, getattr(found, each, None))]
                listed = f"; it has {', '.join(own[:MAX_LISTED])}" if own else ""
                raise BadConfig(
                    f"{where}: there is no {self.noun} {part!r} in {module}{listed}{hint}"
                )
            found = getattr(found, part)
        return found


TRACKER_NAMES = NameRegister("tracker", {**TRACKERS, "cuboids": cuboid_tracker}, "mot_sim.trackers")
COST_NAMES = NameRegister("cost", COSTS, "mot_sim.costs")
ASSOCIATION_NAMES = NameRegister("association", FRAMEWORKS)


def make_tracker(name: str, camera: Camera, kind: type = object, /, **settings: Any) -> Any:
    """The tracker of a name for a camera, which is given where an argument is called `camera`.

    Raises UnknownName, and BadConfig for what cannot be built, or is not of a kind.
    """
    make = TRACKER_NAMES.find(name)
    takes_camera = callable(make) and "camera" in signature(make).parameters
    given = {**settings, "camera": camera} if takes_camera else settings
    return TRACKER_NAMES.make(name, kind, **given)


def without_own_name(text: str) -> str:
    """`MODULE:CALLABLE` of `NAME=MODULE:CALLABLE`, the name that a tracker has in tables."""
    head, equals, rest = text.partition("=")
    return rest if equals and ":" not in head else text


class FolderFinder:
    """Finds the modules of one folder. It stands last in `sys.meta_path`, so it hides no others."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Where a module of the folder itself lies; packages find their own insides."""
        return PathFinder.find_spec(name, [self.folder], target) if path is None else None


@contextmanager
def importable(folder: str) -> Iterator[None]:
    """While it lasts, modules of the folder are found, after all others."""
    finder = FolderFinder(folder)
    sys.meta_path.append(finder)
    invalidate_caches()  # files may be younger than what Python remembers of their folder
    try:
        yield
    finally:
        sys.meta_path.remove(finder)


@lru_cache(maxsize=16)
def _installed(group: str, path: tuple[str, ...]) -> dict[str, list[EntryPoint]]:
    """The entry points of a group by name; path: where they are looked for."""
    found: dict[str, list[EntryPoint]] = {}
    for point in entry_points(group=group):
        found.setdefault(point.name, []).append(point)
    return found


def _package(point: EntryPoint) -> str:
    """Name and version of the package that an entry point belongs to."""
    return f"package {point.dist.name} {point.dist.version}" if point.dist else "a package"


def _place(point: EntryPoint) -> str:
    """`module:name` of an entry point, without extras."""
    return point.value.partition("[")[0].replace(" ", "")


def _import(where: str, module: str) -> ModuleType:
    """A module. Raises BadConfig where it is not there, or raises at import."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if not f"{module}.".startswith(f"{error.name}."):
            _refuse(f"{where}: module {module} raises at import", error)
        top, here = module.partition(".")[0], Path.cwd()
        close = get_close_matches(top, [path.stem for path in here.glob("*.py")], n=1)
        hint = f". Did you mean {close[0]!r}?" if close and close[0] != top else ""
        finders = [each for each in sys.meta_path if isinstance(each, FolderFinder)]
        folders = {"", str(here)} & {*sys.path, *(each.folder for each in finders)}
        searched = f"the working folder {here}, " if folders else ""
        raise BadConfig(
            f"{where}: {error.msg}; looked in {searched}PYTHONPATH and the installed packages{hint}"
        ) from None
    except (Exception, SystemExit) as error:  # noqa: BLE001
        _refuse(f"{where}: module {module} raises at import", error)


def _require_arguments(
    where: str, call: Any, given: tuple[Any, ...], named: Mapping[str, Any]
) -> None:
    """Raise BadConfig for arguments that a callable does not take."""
    try:
        takes = signature(call)
    except ValueError:  # of a builtin
        return
    try:
        takes.bind(*given, **named)
    except TypeError as error:
        raise BadConfig(f"{where} cannot be built: TypeError: {error}") from None


def _refuse(where: str, error: BaseException) -> NoReturn:
    """Raise BrokenCode: the error of somebody else's code in one line, with file and line."""
    words = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
    place = place_of(error)
    raise BrokenCode(
        f"{where}: {type(error).__name__}: {words}{f' ({place})' if place else ''}"
    ) from None


def place_of(error: BaseException, own: bool = False) -> str | None:
    """FILE:LINE of somebody else's code that an error comes from; None where none has a part in it.

    The last line of a module in the working folder; own: of no other.
    """
    here = Path.cwd()
    near: list[tuple[Path, int]] = []
    other: list[tuple[Path, int]] = []
    for frame, line in walk_tb(error.__traceback__):
        file = Path(frame.f_code.co_filename)
        if str(frame.f_globals.get("__name__")).partition(".")[0] in (*PACKAGES, "importlib"):
            continue
        is_near = file.is_relative_to(here) and not file.is_relative_to(sys.prefix)
        (near if is_near else other).append((file, line))
    if isinstance(error, SyntaxError) and error.filename is not None:
        near.append((Path(error.filename), error.lineno or 1))
    if near:
        file, line = near[-1]
        return f"{file.relative_to(here) if file.is_relative_to(here) else file}:{line}"
    return f"{other[-1][0]}:{other[-1][1]}" if other and not own else None


def _require_not_hidden(where: str, module: str) -> None:
    """Raise BadConfig where a module of the working folder is not the one that was found."""
    top, here = module.partition(".")[0], Path.cwd()
    own = [path for path in (here / top / "__init__.py", here / f"{top}.py") if path.is_file()]
    file = getattr(sys.modules.get(top), "__file__", None) or "one that is built in"
    if own and not any(path.resolve() == Path(file).resolve() for path in own):
        raise BadConfig(
            f"{where}: {own[0].relative_to(here)} of the working folder is hidden by another "
            f"module {top!r} ({file}): give yours another name"
        )


def _is_of(module: Any, thing: Any) -> bool:
    """Whether a module or class holds the definition of a thing, or a value of its own."""
    if isinstance(thing, ModuleType):
        return False
    return getattr(thing, "__module__", module.__name__) == module.__name__


__all__ = [
    "ASSOCIATION_NAMES",
    "COST_NAMES",
    "TRACKER_NAMES",
    "BrokenCode",
    "NameRegister",
    "importable",
    "make_tracker",
    "place_of",
    "without_own_name",
]
