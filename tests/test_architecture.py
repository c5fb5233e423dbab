"""Who may import whom, and how files are kept: the walls of the house."""

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("tracker", "mot_sim", "scenes")

# Inside `tracker`: what a room may import directly. What those may, it may as well; `errors`
# belongs to everybody. A room that is not written yet stands here already.
ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "geometry": set(),
    "types": {"geometry"},
    "shape": {"types"},
    "weights": set(),  # files of trained networks, no code
    "ego": {"types"},
    "descriptors": {"shape"},
    "front_end": {"shape", "ego", "descriptors"},
    "beliefs": {"types"},
    "transport": {"beliefs"},
    "turn_filter": {"types"},
    "dynamics": {"beliefs"},
    "lifecycle": {"dynamics"},
    "costs": {"beliefs", "shape"},
    "association": set(),
    "evidence": {"lifecycle"},
    "box_filter": {"lifecycle"},
    "state": {"evidence", "box_filter"},
    "suppression": {"types"},
    "explain": {"costs", "association"},
    "online": {"state", "costs", "association", "suppression", "explain", "transport"}
    | {"turn_filter"},
    "smoothing": set(),
    "multi_frame": {"online", "smoothing"},
    "frameworks": {"multi_frame"},
    "tracker": {"online", "frameworks"},  # the package's own front page
}
# From outside: the rooms with a door, and there only the public names.
DOORS: dict[str, set[str]] = {
    "mot_sim": {"tracker", "tracker.types", "tracker.geometry", "tracker.shape", "tracker.ego"}
    | {"tracker.costs", "tracker.association", "tracker.errors"}
    | {"tracker.front_end", "tracker.descriptors"}
    # the components of a configuration
    | {"tracker.dynamics", "tracker.lifecycle", "tracker.suppression"},
    "scenes": {"tracker", "tracker.types", "tracker.errors"},
}
# Which of our packages a package may know at all.
NEIGHBOURS: dict[str, set[str]] = {
    "tracker": {"tracker"},
    "mot_sim": {"mot_sim", "tracker"},
    "scenes": {"scenes", "mot_sim", "tracker"},
}
SIMULATORS = {"gymnasium", "highway_env", "OpenGL", "pyrender", "pygame"}
HIGHWAY = "mot_sim/simulation/traffic/highway/"
BAD_NAMES = {"utils", "util", "helpers", "helper", "manager", "data", "info", "tmp", "misc"}
MOST_LINES = 250


def reachable(room: str) -> set[str]:
    """The rooms that a room may import: itself, its edges, theirs, and `errors`."""
    found, new = {"errors"}, {room}
    while new:
        found |= new
        new = set().union(*(ROOMS[name] for name in new)) - found
    return found


def imports_of(path: Path, root: Path) -> Iterator[tuple[int, str, str | None]]:
    """Line, module and name (None for `import module`) of everything that a file imports."""
    package = path.relative_to(root).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name, None
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                yield node.lineno, module, alias.name


def room_of(module: str) -> str:
    """`types` of tracker.types.camera; `tracker` of the front page."""
    _, _, inner = module.partition(".")
    return inner.split(".")[0] or "tracker"


def is_public(module: str, name: str | None) -> bool:
    """Whether a name stands in the `__all__` of the module, where that has one."""
    if name is None:
        return True
    public = getattr(import_module(module), "__all__", None)
    return name in public if public is not None else not name.startswith("_")


def wrong(here: str, package: str, module: str, name: str | None) -> str | None:
    """Why the file `here` of this package may not import that; None if it may."""
    top = module.partition(".")[0]
    if (name or "").startswith("_"):
        return f"{name} is private to {module}"
    if top in SIMULATORS and package == "tracker":
        return "the tracker knows no simulator"
    if top == "highway_env" and not here.startswith(HIGHWAY):
        return f"only {HIGHWAY} imports highway_env"
    if top in PACKAGES and top not in NEIGHBOURS[package]:
        return f"{package} knows nothing of {top}"
    if top == "tracker":
        inside = package == "tracker"
        return wrong_room(here, module, name) if inside else wrong_door(package, module, name)
    return None


def wrong_room(here: str, module: str, name: str | None) -> str | None:
    """Why a file of the tracker may not import from that room of it."""
    importer = room_of(here.removesuffix(".py").removesuffix("/__init__").replace("/", "."))
    target = name if module == "tracker" and name in ROOMS else room_of(module)
    for room in (importer, target):
        if room not in ROOMS:
            return f"{room} is no room of the table"
    return None if target in reachable(importer) else f"{importer} may not know {target}"


def wrong_door(package: str, module: str, name: str | None) -> str | None:
    """Why another package may not import that from the tracker."""
    if module not in DOORS[package]:
        return f"{module} is no door for {package}"
    return None if is_public(module, name) else f"{name} is no public name of {module}"


def violations(root: Path) -> list[str]:
    """Every import of the packages under a root that a wall forbids: file:line: why."""
    found = []
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            here = path.relative_to(root).as_posix()
            for line, module, name in imports_of(path, root):
                reason = wrong(here, package, module, name)
                if reason is not None:
                    found.append(f"{here}:{line}: {reason}")
    return list(dict.fromkeys(found))


def modules() -> list[Path]:
    return [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def without_docstrings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """The public functions, classes and methods of a module that say nothing about themselves."""
    scopes: list[ast.Module | ast.ClassDef] = [tree]
    while scopes:
        for node in scopes.pop().body:
            if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name.startswith("_"):
                continue
            if ast.get_docstring(node) is None:
                yield node.lineno, node.name
            if isinstance(node, ast.ClassDef):
                scopes.append(node)


def test_nobody_imports_through_a_wall() -> None:
    assert violations(ROOT) == []


@pytest.mark.parametrize(
    ("file", "code", "told"),
    [
        ("tracker/types/camera.py", "from tracker.beliefs import Lift", "types may not know bel"),
        ("tracker/geometry/ground.py", "import tracker.types", "geometry may not know types"),
        ("tracker/geometry/ground.py", "from tracker import Camera", "geometry may not know"),
        ("tracker/geometry/__init__.py", "from ..types import Camera", "geometry may not know"),
        (
            "tracker/beliefs.py",
            "def f():\n    from tracker.tracker import Tracker",
            "beliefs may not",
        ),
        ("tracker/association/greedy.py", "from tracker.costs import COSTS", "association may not"),
        (
            "tracker/costs/volume.py",
            "from mot_sim.simulation.rig import Rig",
            "tracker knows nothing of mot",
        ),
        ("tracker/tracker.py", "import scenes.crossing", "tracker knows nothing of scenes"),
        ("tracker/tracker.py", "import gymnasium as gym", "the tracker knows no simulator"),
        ("tracker/gadgets.py", "from tracker.types import Camera", "gadgets is no room"),
        (
            "mot_sim/simulation/truth.py",
            "from tracker.types.rows import Rows",
            "tracker.types.rows is no",
        ),
        ("mot_sim/simulation/truth.py", "import tracker.tracker", "tracker.tracker is no door"),
        (
            "mot_sim/simulation/truth.py",
            "from tracker import online",
            "online is no public name of tracker",
        ),
        ("mot_sim/simulation/truth.py", "from tracker.types import rows", "rows is no public name"),
        (
            "mot_sim/simulation/registry.py",
            "from scenes.crossing import SCENE",
            "mot_sim knows nothing of sc",
        ),
        (
            "mot_sim/envs/scene_env.py",
            "import highway_env.envs",
            "only mot_sim/simulation/traffic/highway/ imports",
        ),
        (
            "mot_sim/evaluation/runs.py",
            "from mot_sim.evaluation.scoring import _rates",
            "_rates is private",
        ),
        ("scenes/town.py", "from tracker.costs import COSTS", "tracker.costs is no door for sc"),
    ],
)
def test_a_forbidden_import_is_found(tmp_path: Path, file: str, code: str, told: str) -> None:
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(f'"""A room."""\n\n{code}\n')
    found = violations(tmp_path)
    assert len(found) == 1
    assert found[0].startswith(f"{file}:{4 if 'def ' in code else 3}: {told}")


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("tracker/types/camera.py", "from tracker.geometry import invert"),
        ("tracker/types/camera.py", "from tracker.types.rows import Rows"),
        ("tracker/lifecycle.py", "from tracker.types import Camera"),
        ("tracker/tracker.py", "from tracker.errors import BadConfig"),
        ("tracker/__init__.py", "from .online import Tracker"),
        ("mot_sim/evaluation/runs.py", "from tracker import TRACKERS, Tracker"),
        ("mot_sim/evaluation/runs.py", "from tracker.costs import COSTS"),
        ("mot_sim/simulation/traffic/highway/roads.py", "import highway_env"),
        (
            "scenes/town.py",
            "from mot_sim.simulation.traffic import Scripted\nfrom tracker.types import Camera",
        ),
    ],
)
def test_an_allowed_import_is_let_through(tmp_path: Path, file: str, code: str) -> None:
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(f'"""A room."""\n\n{code}\n')
    assert violations(tmp_path) == []


def test_the_rooms_stand_on_each_other_without_a_circle() -> None:
    for room, edges in ROOMS.items():
        assert all(room not in reachable(edge) for edge in edges if edge != room)


def test_every_room_of_the_tracker_is_in_the_table() -> None:
    there = {path.name.removesuffix(".py") for path in (ROOT / "tracker").glob("[!_]*")}
    assert there - {"py.typed"} <= set(ROOMS)


def test_modules_fit_on_a_few_screens() -> None:
    lengths = {path.relative_to(ROOT): len(path.read_text().splitlines()) for path in modules()}
    assert {path: length for path, length in lengths.items() if length > MOST_LINES} == {}


def test_the_first_line_of_a_file_says_what_room_it_is() -> None:
    silent = [path.relative_to(ROOT) for path in modules() if path.read_text()[:3] != '"""']
    assert silent == []


def test_whatever_is_public_has_a_docstring() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in modules()
        for line, name in without_docstrings(ast.parse(path.read_text()))
    ]
    assert found == []


def test_no_file_is_named_after_nothing() -> None:
    parts = [
        part.removesuffix(".py") for path in modules() for part in path.relative_to(ROOT).parts
    ]
    assert BAD_NAMES.isdisjoint(parts)
