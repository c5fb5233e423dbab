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
FACE = "the package's face"
ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "lazy_names": set(),
    "user_cache": set(),
    "kernels": {"user_cache"},
    "geometry": {"kernels"},
    "types": {"geometry"},
    "shape": {"types"},
    "weights": set(),  # files of trained networks, no code
    "ego": {"types"},
    "descriptors": {"shape"},
    "front_end": {"shape", "ego", "descriptors"},
    "beliefs": {"types"},
    "ego_motion": {"beliefs"},
    "camera_rotation_filter": {"types"},
    "dynamics": {"beliefs"},
    "car_filter": {"beliefs", "ego_motion"},
    "lifecycle": {"dynamics", "car_filter", "association"},
    "costs": {"beliefs", "shape"},
    "association": {"kernels"},
    "existence": {"lifecycle"},
    "gap_rows": {"lifecycle", "car_filter"},
    "output_rows": {"existence"},
    "box_filter": {"lifecycle"},
    "score_scale": {"types"},
    "motion_check": {"types"},
    "state": {"existence", "box_filter", "ego_motion", "score_scale", "motion_check"},
    "suppression": {"types"},
    "cost_matrix": {"costs", "state"},
    "explain": {"costs", "association"},
    "expectation": {"costs", "ego_motion", "lifecycle"},
    "renewal": {"existence", "box_filter"},
    "tracker": {
        "cost_matrix",
        "state",
        "costs",
        "association",
        "suppression",
        "explain",
        "ego_motion",
        "expectation",
        "renewal",
        "output_rows",
    }
    | {"camera_rotation_filter", "gap_rows"},
    "batch": {"tracker"},
    "cuboid_tracker": {"tracker"},
    "smoothing": set(),
    "multi_frame": {"tracker", "smoothing"},
    "frameworks": {"multi_frame"},
    "per_class": {"beliefs", "frameworks", "state", "tracker"},
    FACE: {"tracker", "cuboid_tracker", "frameworks", "lazy_names", "per_class"},
}
# Inside `mot_sim`: the wings, by the same rule. A wing's inner rooms are no business of others'
# circles: see `test_no_circle_of_files` and `test_no_knot_of_folders`.
WINGS: dict[str, set[str]] = {
    "files": set(),
    "metrics": set(),
    "tables": {"metrics", "files"},
    "foreign": {"files"},
    "datasets": {"files"},
    "plotting": {"files"},
    "evaluation": {"datasets", "metrics", "tables"},
    "simulation": {"datasets", "metrics", "plotting"},
    "envs": {"simulation", "foreign"},
    "training": {"simulation"},
    "experiments": {"simulation", "evaluation", "tables", "foreign"},
    "testing": {"experiments"},
    "report": {"experiments"},
    "diagnosis": {"experiments"},
    "demo": {"report"},
    "cli": {"demo", "report", "diagnosis", "training", "testing", "envs"},
    "__main__": {"cli"},
    FACE: {"testing", "envs"},
}
TABLES = {"tracker": ROOMS, "mot_sim": WINGS}
# From outside: the rooms with a door, and there only the public names.
DOORS: dict[str, set[str]] = {
    "mot_sim": {
        "tracker",
        "tracker.batch",
        "tracker.lazy_names",
        "tracker.kernels",
        "tracker.kernels.compiling",
        "tracker.types",
        "tracker.geometry",
        "tracker.shape",
        "tracker.ego",
    }
    | {"tracker.costs", "tracker.association", "tracker.errors"}
    | {"tracker.front_end", "tracker.descriptors"}
    # the components of a configuration
    | {"tracker.dynamics", "tracker.lifecycle", "tracker.suppression", "tracker.per_class"}
    | {"tracker.user_cache"},
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
MAX_LINES = 400


def reachable(room: str, rooms: dict[str, set[str]]) -> set[str]:
    """The rooms that a room may import: itself, its edges, theirs, and `errors`."""
    found, new = {"errors"}, {room}
    while new:
        found |= new
        new = set().union(*(rooms[name] for name in new)) - found
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
    """`types` of tracker.types.camera; FACE of the package itself."""
    _, _, inner = module.partition(".")
    return inner.split(".")[0] or FACE


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
    if top == package and package in TABLES:
        return wrong_room(here, module, name, TABLES[package])
    return wrong_door(package, module, name) if top == "tracker" else None


def wrong_room(here: str, module: str, name: str | None, rooms: dict[str, set[str]]) -> str | None:
    """Why a file may not import from that room of its own package."""
    importer = room_of(here.removesuffix(".py").removesuffix("/__init__").replace("/", "."))
    inner = "." not in module and name in rooms and name != FACE
    target = name if inner else room_of(module)
    for room in (importer, target):
        if room not in rooms:
            return f"{room} is no room of the table"
    return None if target in reachable(importer, rooms) else f"{importer} may not know {target}"


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
            "from tracker import explain",
            "explain is no public name of tracker",
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
        ("mot_sim/files/text.py", "from mot_sim.datasets import find_root", "files may not know d"),
        ("mot_sim/plotting/canvas.py", "import mot_sim.experiments", "plotting may not know exp"),
        ("mot_sim/metrics/hota.py", "from mot_sim import tables", "metrics may not know tables"),
        ("mot_sim/report/film.py", "from mot_sim import record", "report may not know the pack"),
        ("mot_sim/gadgets.py", "from mot_sim.files import text", "gadgets is no room of the"),
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
        ("tracker/__init__.py", "from .tracker import Tracker"),
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


def graph(root: Path) -> dict[str, dict[str, str]]:
    """For each module the modules it imports, each with the line that does: `file:line`."""
    paths = {}
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            paths[name.removesuffix(".__init__")] = path
    found: dict[str, dict[str, str]] = {}
    for here, path in paths.items():
        edges = found.setdefault(here, {})
        for line, module, name in imports_of(path, root):
            target = f"{module}.{name}" if f"{module}.{name}" in paths else module
            if target in paths and target != here:
                edges.setdefault(target, f"{path.relative_to(root).as_posix()}:{line}")
    return found


def folders(modules: dict[str, dict[str, str]], package: str) -> dict[str, dict[str, str]]:
    """The same for what lies right inside a package: its files and its folders."""
    found: dict[str, dict[str, str]] = {}
    inside = f"{package}."
    for here, edges in modules.items():
        for target, line in edges.items():
            if here.startswith(inside) and target.startswith(inside):
                a, b = (each.removeprefix(inside).split(".")[0] for each in (here, target))
                if a != b:
                    found.setdefault(a, {}).setdefault(b, line)
    return found


def circles(edges: dict[str, dict[str, str]]) -> list[str]:
    """The imports that lead from a place back to it, `file:line: a imports b`."""
    reach: dict[str, set[str]] = {}
    for start, targets in edges.items():
        found, new = set[str](), set(targets)
        while new:
            found |= new
            new = {target for name in new for target in edges.get(name, ())} - found
        reach[start] = found
    return [
        f"{line}: {a} imports {b}, which leads back to {a}"
        for a, targets in edges.items()
        for b, line in targets.items()
        if a in reach.get(b, ())
    ]


def knots(modules: dict[str, dict[str, str]]) -> list[str]:
    """The imports that tie folders or files of one package to each other, both ways."""
    parts = [name.split(".") for name in modules]
    packages = {".".join(each[:depth]) for each in parts for depth in range(1, len(each))}
    return [line for name in sorted(packages) for line in circles(folders(modules, name))]


def test_no_circle_of_files() -> None:
    assert circles(graph(ROOT)) == []


def test_no_knot_of_folders() -> None:
    assert knots(graph(ROOT)) == []


def test_the_import_that_closes_a_circle_is_named(tmp_path: Path) -> None:
    home = tmp_path / "mot_sim" / "files"
    home.mkdir(parents=True)
    (home / "a.py").write_text("from mot_sim.files.b import B\n")
    (home / "b.py").write_text('def f():\n    """B."""\n    import mot_sim.files.a\n')
    assert circles(graph(tmp_path)) == [
        "mot_sim/files/a.py:1: mot_sim.files.a imports mot_sim.files.b, which leads back to "
        "mot_sim.files.a",
        "mot_sim/files/b.py:3: mot_sim.files.b imports mot_sim.files.a, which leads back to "
        "mot_sim.files.b",
    ]


def test_the_imports_that_tie_a_knot_are_named(tmp_path: Path) -> None:
    for name, code in {
        "mot_sim/x/one.py": "from mot_sim.y.two import T\n",
        "mot_sim/x/three.py": "",
        "mot_sim/y/two.py": "",
        "mot_sim/y/four.py": "from mot_sim.x import three\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(code)
    assert circles(graph(tmp_path)) == []
    assert knots(graph(tmp_path)) == [
        "mot_sim/x/one.py:1: x imports y, which leads back to x",
        "mot_sim/y/four.py:1: y imports x, which leads back to y",
    ]


@pytest.mark.parametrize("package", TABLES)
def test_the_rooms_stand_on_each_other_without_a_circle(package: str) -> None:
    rooms = TABLES[package]
    for room, edges in rooms.items():
        assert all(room not in reachable(edge, rooms) for edge in edges if edge != room)


@pytest.mark.parametrize("package", TABLES)
def test_every_room_is_in_the_table_and_there(package: str) -> None:
    paths = {path.relative_to(ROOT / package) for path in (ROOT / package).rglob("*.*[!c]")}
    there = {path.parts[0].removesuffix(".py") for path in paths} - {"__init__", "py.typed"}
    assert there | {"errors", FACE} == {*TABLES[package], "errors"}


def test_the_house_has_few_rooms() -> None:
    assert 15 <= len(WINGS.keys() - {FACE}) <= 17


def public_names(root: Path) -> dict[str, list[str]]:
    """Where the public classes and functions of `tracker` and `mot_sim` are defined, by name."""
    found: dict[str, list[str]] = {}
    for package in ("tracker", "mot_sim"):
        for path in sorted((root / package).rglob("*.py")):
            for node in ast.parse(path.read_text()).body:
                is_named = isinstance(node, ast.ClassDef | ast.FunctionDef)
                if is_named and not node.name.startswith("_"):
                    place = f"{path.relative_to(root).as_posix()}:{node.lineno}"
                    found.setdefault(node.name, []).append(place)
    return found


def test_no_public_name_stands_for_two_things() -> None:
    twice = {name: places for name, places in public_names(ROOT).items() if len(places) > 1}
    assert twice == {}


def test_modules_fit_on_a_few_screens() -> None:
    lengths = {path.relative_to(ROOT): len(path.read_text().splitlines()) for path in modules()}
    assert {path: length for path, length in lengths.items() if length > MAX_LINES} == {}


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
