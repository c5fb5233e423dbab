"""What the pages show must run: every block, every picture's command, every link."""

import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from mot_sim.__main__ import main
from tests.pages import (
    DOCS,
    HELD,
    ROOT,
    RUN,
    SHOWN,
    Block,
    blocks_of,
    check_block,
    commands_of,
    pages,
    run_block,
)

PAGES = {page.relative_to(DOCS).as_posix(): page for page in pages()}


def marked(marker: str | None) -> list[str]:
    """The pages with a block to run under a marker."""
    return [
        name
        for name, page in PAGES.items()
        if any(block.is_run and block.marker == marker for block in blocks_of(page))
    ]


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty working folder; the modules that a page's Python takes from it are forgotten."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("MOT_SIM_CACHE", str(tmp_path / "cache"))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        file = getattr(sys.modules[name], "__file__", None)
        if file is not None and Path(file).is_relative_to(tmp_path):
            del sys.modules[name]


def run_page(name: str, marker: str | None) -> None:
    """Run the blocks of a page that belong to a marker, and write all of its files."""
    names: dict[str, object] = {"__name__": "page"}
    for block in blocks_of(PAGES[name]):
        if block.note("file") is not None or (block.is_run and block.marker == marker):
            run_block(block, names)


@pytest.mark.parametrize("name", marked(None))
def test_the_blocks_of_a_page_run(name: str, workplace: Path) -> None:
    run_page(name, None)


@pytest.mark.kitti
@pytest.mark.parametrize("name", marked("kitti"))
def test_the_blocks_of_a_page_run_on_kitti(name: str, workplace: Path, kitti_root: Path) -> None:
    run_page(name, "kitti")


@pytest.mark.slow
@pytest.mark.parametrize("name", marked("slow"))
def test_the_long_blocks_of_a_page_run(name: str, workplace: Path) -> None:
    run_page(name, "slow")


@pytest.fixture
def help_of(capsys: pytest.CaptureFixture[str]) -> Callable[[str], str]:
    """What a command says under --help."""

    @cache
    def ask(command: str) -> str:
        assert main([command, "--help"]) == 0, f"no command {command}"
        return capsys.readouterr().out

    return ask


@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_only_shows_exists(name: str, help_of: Callable[[str], str]) -> None:
    for block in blocks_of(PAGES[name]):
        assert block.language in (*RUN, *HELD, *SHOWN, ""), f"{block.where}: {block.language}?"
        if not block.is_run:
            check_block(block, help_of)
        if block.note("only checked") is not None:
            assert block.note("only checked"), f"{block.where}: say why it is only checked"


@pytest.mark.parametrize("name", PAGES)
def test_every_picture_stands_beside_the_command_that_made_it(
    name: str, help_of: Callable[[str], str]
) -> None:
    page = PAGES[name]
    lines = page.read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines, 1):
        for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", line):
            assert (page.parent / target).is_file(), f"{name}:{number}: no {target}"
            made = re.fullmatch(r"<!-- made by: (.*) -->", lines[number].strip())
            assert made, f"{name}:{number}: the next line says no <!-- made by: COMMAND -->"
            command = Block(page, number, "sh", made[1], ())
            assert commands_of(command, made[1])[0][0] in ("mot-sim", "python")
            check_block(command, help_of)


@pytest.mark.parametrize("name", PAGES)
def test_every_link_of_a_page_leads_somewhere(name: str) -> None:
    page = PAGES[name]
    for target in re.findall(r"(?<!!)\[[^\]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
        path, _, anchor = target.partition("#")
        if "://" in target:
            continue
        place = (page.parent / path).resolve() if path else page
        assert place.is_file(), f"{name}: {target}"
        headings = re.findall(r"^#+ (.*)$", place.read_text(encoding="utf-8"), flags=re.MULTILINE)
        slugs = {re.sub(r"[^\w]+", "-", heading.lower()).strip("-") for heading in headings}
        assert not anchor or anchor in slugs, f"{name}: {target}; there: {sorted(slugs)}"


def test_every_page_is_in_the_navigation() -> None:
    listed = set(re.findall(r"([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE))
    assert set(PAGES) <= listed


def test_a_block_that_nobody_can_run_is_told(workplace: Path) -> None:
    page = DOCS / "strange.md"
    with pytest.raises(AssertionError, match=r"strange.md:3: nobody knows how to run rm -r"):
        run_block(Block(page, 3, "sh", "rm -r x\n", ()), {})
    with pytest.raises(AssertionError, match="no 'seeds' to make smaller"):
        run_block(Block(page, 3, "python", "1\n", (("smaller", "seeds -> 1"),)), {})
    with pytest.raises(ZeroDivisionError):
        run_block(Block(page, 3, "python", "1 / 0\n", ()), {})


def test_the_page_of_the_commands_is_what_they_say(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = spec_from_file_location("commands_hook", DOCS / "hooks" / "commands.py")
    assert spec is not None
    assert spec.loader is not None
    hook = module_from_spec(spec)
    spec.loader.exec_module(hook)
    assert "usage: mot-sim list" in hook.help_of("list")
    monkeypatch.setattr(hook, "sections", lambda: "## mot-sim list")
    assert hook.on_page_markdown(PAGES["commands.md"].read_text()).endswith("## mot-sim list\n")
    assert hook.on_page_markdown("# Other") == "# Other"
