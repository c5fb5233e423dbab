"""No path that a file names leads outside the given folders; no pickle is ever loaded."""

import ast
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from mot_sim.datasets.boxes import RUN_FILE
from mot_sim.evaluation.run_folder import RunFolder
from mot_sim.experiments.stress.suites import read_suites
from mot_sim.experiments.sweep.design import read_design
from mot_sim.simulation.episodes import EpisodeFiles, EpisodeFolder, record_episode, verify_episode
from mot_sim.simulation.episodes.extra import Metadata, arrays_of, read_extra, write_extra
from mot_sim.simulation.episodes.reading import read_episode
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.sensors.profile import FOLDER
from tests.mot_sim.simulation.episodes.small import small
from tracker.errors import BadFile

ROOT = Path(__file__).parents[2]
OUTSIDE = ("../../victim", "/victim", "..", "a/b", "a\x00b", "0000/../../victim")
# Who may unpickle: what our own processes packed a moment ago, those with a user's tracker in them
# too (its code runs here, whatever it answers), and files of torch, weights only.
UNPICKLERS = {
    "mot_sim/experiments/executor.py",
    "mot_sim/foreign/serving.py",
    "mot_sim/foreign/tracker_process.py",
    "mot_sim/training/learning.py",
}


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_run_file_cannot_name_what_lies_outside(name: str, folder: Path) -> None:
    with RunFolder.open(folder / "run", {"a": 1.0}, ["0000"]):
        about = json.loads((folder / "run" / RUN_FILE).read_text())
        about["sequences"][name] = {
            "frames": 1, "detections": 1, "rows": 1, "ids": 1, "seconds": 0.0
        }  # fmt: skip
        (folder / "run" / RUN_FILE).write_text(json.dumps(about))
    if name == "..":  # of `...txt`, in the folder
        return
    with pytest.raises(BadFile, match="named like a path"):
        RunFolder.open(folder / "run", {"a": 1.0}, ["0000"], overwrite=True)


@pytest.mark.parametrize("name", [*OUTSIDE, "\u0660\u0660\u0660\u0660", "00000"])
def test_a_list_of_episodes_cannot_name_what_lies_outside(name: str, folder: Path) -> None:
    EpisodeFolder.open(folder / "town", {}, 1, 6).write()
    path = folder / "town" / "episodes.json"
    about = json.loads(path.read_text())
    path.write_text(json.dumps({**about, "episodes": [name]}))
    with pytest.raises(BadFile, match="not numbered"):
        EpisodeFolder.open(folder / "town", {}, 1, 6, overwrite=True)


def test_an_episode_cannot_name_a_profile_outside(folder: Path) -> None:
    places = EpisodeFiles(folder / "tree", "0000")
    record_episode(small(), 3, places)
    stored = read_episode(folder / "tree")
    for where, expected in (("tree/mine.toml", False), ("mine.toml", True)):
        (folder / where).write_bytes((FOLDER / "perfect.toml").read_bytes())
        told = replace(
            stored.metadata, scene="crossing", knobs={"profile": str(folder / where), "frames": 6}
        )
        assert isinstance(told, Metadata)
        write_extra(places.extra, told, arrays_of(stored))
        assert read_extra(places.extra).metadata.knobs == told.knobs
        finding = verify_episode(folder / "tree", "0000", find_scene)
        assert ("lies outside" in (finding.trouble or "")) == expected


@pytest.mark.parametrize("read", [read_design, lambda path: read_suites(Path(path))])
def test_designs_and_suites_cannot_name_a_profile_outside(read: object, folder: Path) -> None:
    assert callable(read)
    home = folder / "home"
    home.mkdir()
    for place in (folder, home):
        (place / "mine.toml").write_bytes((FOLDER / "perfect.toml").read_bytes())
    for place, is_outside in ((folder, True), (home, False)):
        named = json.dumps(str(place / "mine.toml"))
        design = f'scene = "crossing"\nframes = 5\n[axes]\n"scene.profile" = ["rrc", {named}]\n'
        suite = (
            f'[a]\nabout = "b"\nscene = "crossing"\nframes = 5\n'
            f'settings = {{"scene.profile" = {named}}}\nbounds = {{HOTA = 0.1}}\n'
        )
        path = home / "file.toml"
        path.write_text(design if read is read_design else suite)
        if is_outside:
            with pytest.raises(BadFile, match="lies outside"):
                read(str(path))
        else:
            read(str(path))


def sources() -> list[Path]:
    return [
        path
        for package in ("tracker", "mot_sim", "scenes")
        for path in sorted((ROOT / package).rglob("*.py"))
    ]


def unsafe(path: Path) -> Iterator[str]:
    """The calls of a file that could run what another file holds."""
    here = path.relative_to(ROOT).as_posix()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom | ast.Import):
            module = node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
            packers = {"pickle", "dill", "marshal", "shelve", "cloudpickle"}
            if module in packers and here not in UNPICKLERS:
                yield f"{here}:{node.lineno}: imports {module}"
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        given = {word.arg: ast.unparse(word.value) for word in node.keywords}
        if called in {"np.load", "numpy.load"} and given.get("allow_pickle") != "False":
            yield f"{here}:{node.lineno}: np.load without allow_pickle=False"
        if called.endswith("torch.load") and given.get("weights_only") != "True":
            yield f"{here}:{node.lineno}: torch.load without weights_only=True"
        if called in {"eval", "exec", "joblib.load", "yaml.load", "os.system"}:
            yield f"{here}:{node.lineno}: {called}"
        if called.startswith("subprocess.") and given.get("shell") == "True":
            yield f"{here}:{node.lineno}: a shell"


def test_no_file_is_unpickled_or_run() -> None:
    assert [found for path in sources() for found in unsafe(path)] == []


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("np.load(path)", "np.load without"),
        ("np.load(path, allow_pickle=True)", "np.load without"),
        ("import pickle", "imports pickle"),
        ("torch.load(path)", "torch.load without"),
        ("eval(text)", "eval"),
        ("subprocess.run(text, shell=True)", "a shell"),
    ],
)
def test_an_unsafe_call_is_found(
    code: str, told: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = folder / "mot_sim.py"
    path.write_text(f"{code}\n")
    monkeypatch.setattr("tests.fuzz.test_paths_and_pickles.ROOT", folder)
    assert [told in found for found in unsafe(path)] == [True]
