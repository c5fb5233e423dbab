"""What README.md shows must run: its examples, its commands, its files; and names in the docs."""

import ast
import re
import shlex
from pathlib import Path

import pytest

from benchmarks.architecture import Architecture
from mot_sim.datasets import read_camera
from tests.pages import blocks_of

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
README = (ROOT / "README.md").read_text()
MAX_LINES = 130


def blocks(language: str) -> list[str]:
    """The fenced blocks of a language."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)
    return [text for name, text in fenced if name == language]


def test_it_is_short_and_every_block_is_run_or_checked_here() -> None:
    assert len(README.splitlines()) <= MAX_LINES
    assert README.count("```") == 2 * (len(blocks("python")) + len(blocks("sh")))
    assert len(blocks("python")) == 3


def test_the_example_runs_and_keeps_both_identities(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[0], "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert all(line.startswith("[0 1]") for line in lines)


def test_the_scene_is_run_tracked_and_scored(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[1], "README.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    assert float(first.split()[1].rstrip(",")) > 0.4
    assert second.split()[:3] == ["0.0", "to", "1.0"]


def test_the_environment_gives_detections_and_keeps_its_truth_apart(
    capsys: pytest.CaptureFixture[str],
) -> None:
    names: dict[str, object] = {}
    exec(compile(blocks("python")[2], "README.md", "exec"), names)
    assert "(64, 4)" in capsys.readouterr().out
    assert "truth" not in names["observation"]  # type: ignore[operator]
    assert "truth" in names["info"]  # type: ignore[operator]


def test_the_camera_file_is_read(tmp_path: Path) -> None:
    given = {block.note("file"): block for block in blocks_of(DOCS / "quickstart" / "kitti.md")}
    path = tmp_path / "camera.toml"
    path.write_text(given["camera.toml"].text)
    assert read_camera(path).camera.height == pytest.approx(1.65)


def test_every_command_and_option_that_is_shown_exists(
    capsys: pytest.CaptureFixture[str],
) -> None:
    from mot_sim.__main__ import main

    shown = [
        shlex.split(line, comments=True)
        for block in blocks("sh")
        for line in block.splitlines()
        if not line.startswith("#")
    ]
    shown += [shlex.split(text) for text in re.findall(r"`(mot-sim [^`]*)`", README)]
    assert len(shown) > 8
    for program, *command in shown:
        if program == "pip":
            assert command == ["install", "-e", "."]
            continue
        assert program == "mot-sim"
        assert main([command[0], "--help"]) == 0
        text = capsys.readouterr().out
        for word in command[1:]:
            assert not word.startswith("--") or word in text, f"{command[0]} has no {word}"


def test_every_benchmark_that_is_named_exists() -> None:
    named = re.findall(r"python -m (benchmarks[\w.]*)", README)
    assert named
    for module in named:
        assert (ROOT / f"{module.replace('.', '/')}.py").is_file(), module


def test_every_file_that_is_linked_is_there() -> None:
    targets = re.findall(r"\]\(([^)#]+)(#[^)]*)?\)", README)
    assert len(targets) > 12
    for target, anchor in targets:
        assert (ROOT / target).exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.*)$", (ROOT / target).read_text(), flags=re.MULTILINE)
            assert anchor[1:] in [heading.lower().replace(" ", "-") for heading in headings]


def test_a_row_of_the_results_is_a_row_of_the_page_of_results() -> None:
    rows = re.findall(
        r"^\| (.*?) \| (\d\d\.\d\d) \| (\d\d\.\d\d) \| (.*?) \| (\d+) \|$", README, re.M
    )
    assert len(rows) == 6
    page = (DOCS / "results" / "kitti.md").read_text()
    longer = {"default": "default, ego oxts", "the paper's two frames": "paper, ego oxts"}
    for name, hota, mota, idf1, switches in rows:
        line = next(
            at for at in page.splitlines() if at.startswith(f"| {longer.get(name, name)} |")
        )
        cells = [cell.strip() for cell in line.split("|")]
        assert (cells[3], cells[2], cells[6], cells[9]) == (hota, mota, idf1, switches), name


def test_every_page_of_results_names_commands_and_the_day() -> None:
    pages = sorted((DOCS / "results").glob("*.md"))
    assert pages
    for page in pages:
        text = page.read_text()
        assert [block for block in blocks_of(page) if block.language == "sh"], page.name
        assert re.search(r"(printed|Drawn) on\s+\d{4}-\d\d-\d\d", text, re.IGNORECASE), page.name


def test_the_picture_of_the_architecture_shows_every_package_and_leads_down() -> None:
    house = Architecture.of(ROOT)
    drawn = (DOCS / "architecture.svg").read_text()
    for name in house.packages:
        assert f">{name}</text>" in drawn, f"{name}: draw docs/architecture.svg again"
    assert all(house.floors[here] > house.floors[there] for here, there in house.imports)


def test_every_path_of_the_architecture_page_is_there() -> None:
    tree = re.findall(r"^ *([\w/]+(?:/|\.py|\.yml)) ", (DOCS / "architecture.md").read_text(), re.M)
    assert len(tree) > 35
    homes = (ROOT, ROOT / "mot_sim", ROOT / "tracker")
    missing = [path for path in tree if not any((home / path).exists() for home in homes)]
    assert missing == []


def members(package: str) -> dict[str, set[str]]:
    """The classes of a package, with their fields, properties and methods."""
    found: dict[str, set[str]] = {}
    for path in (ROOT / package).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef):
                names = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
                fields = [part.target for part in node.body if isinstance(part, ast.AnnAssign)]
                names |= {field.id for field in fields if isinstance(field, ast.Name)}
                found.setdefault(node.name, set()).update(names)
    return found


def test_every_name_of_the_glossary_is_in_the_code() -> None:
    text = (DOCS / "glossary.md").read_text()
    known = members("tracker") | members("mot_sim")
    named = re.findall(r"`([A-Z][a-z]\w+)(?:\.(\w+))?`", text)
    assert len(named) > 40
    for name, member in named:
        assert name in known, name
        assert not member or member in known[name], f"{name}.{member}"
    for path in re.findall(r"`((?:tracker|mot_sim)/[\w/.]+)`", text):
        assert (ROOT / path).exists(), path
