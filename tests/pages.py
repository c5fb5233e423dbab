"""The pages of the documentation, cut into blocks; and how a block is run.

Comments in front of a block say how: `<!-- file: NAME -->` it is written into that file;
`<!-- kitti -->`, `<!-- slow -->` it runs under that marker; `<!-- smaller: A -> B -->` in the tests
A is B; `<!-- only checked: WHY -->` it does not run, but its commands, options and syntax are
checked; `<!-- newcomer: ... -->` is for `benchmarks.newcomer`.
"""

import ast
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
SCRIPT = Path(sys.executable).with_name("mot-sim")  # the installed console script
BLOCK = re.compile(
    r"(?P<notes>(?:^<!--[^\n]*-->\n)*)^```(?P<language>\w*)[^\n]*\n(?P<text>.*?)^```$",
    flags=re.DOTALL | re.MULTILINE,
)
NOTE = re.compile(r"^<!-- (?P<name>[a-z ]+?)(?:: (?P<value>.*))? -->$", flags=re.MULTILINE)
RUN = ("python", "sh")  # languages that are run; "" is read as sh, and only checked
HELD = ("toml", "csv", "json")  # contents of files
SHOWN = ("text",)  # what is printed, and how folders look


@dataclass(frozen=True)
class Block:
    """A fenced block of a page. line: of the page, from 1."""

    page: Path
    line: int
    language: str
    text: str
    notes: tuple[tuple[str, str], ...]

    def note(self, name: str) -> str | None:
        """What a comment in front of the block says; None where there is none of that name."""
        return next((value for key, value in self.notes if key == name), None)

    @property
    def where(self) -> str:
        """Page and line."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    @property
    def small(self) -> str:
        """The text as the tests run it."""
        text = self.text
        for key, value in self.notes:
            if key == "smaller":
                old, _, new = value.partition(" -> ")
                assert old in text, f"{self.where}: no {old!r} to make smaller"
                text = text.replace(old, new)
        return text

    @property
    def marker(self) -> str | None:
        """`kitti`, `slow`, or None: of the plain tests."""
        return next((name for name in ("kitti", "slow") if self.note(name) is not None), None)

    @property
    def is_run(self) -> bool:
        """Whether it is run; else it is only checked."""
        return self.language in RUN and self.note("only checked") is None


def pages() -> list[Path]:
    """All pages, in order."""
    return sorted(path for path in DOCS.rglob("*.md"))


def blocks_of(page: Path) -> list[Block]:
    """The blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(
            page,
            text[: found.start("language")].count("\n") + 1,
            found["language"],
            found["text"],
            tuple((note["name"], note["value"] or "") for note in NOTE.finditer(found["notes"])),
        )
        for found in BLOCK.finditer(text)
    ]


def commands_of(block: Block, text: str) -> list[list[str]]:
    """The words of each line of a shell block; comments and line ends escaped by \\ are gone."""
    lines = text.replace("\\\n", " ").splitlines()
    return [words for line in lines if (words := shlex.split(line, comments=True))]


def run_block(block: Block, names: dict[str, Any]) -> None:
    """Run a block in the working folder. names: what the page's Python blocks share."""
    file = block.note("file")
    if file is not None:
        Path(file).write_text(block.small, encoding="utf-8")
    elif block.language == "python":
        exec(compile("\n" * block.line + block.small, str(block.page), "exec"), names)
    elif block.language == "sh":
        for words in commands_of(block, block.small):
            run_command(block, words)


def run_command(block: Block, words: list[str]) -> None:
    """Run one command of a shell block."""
    if words[0] == "export":
        name, _, value = words[1].partition("=")
        os.environ.setdefault(name, value)  # a KITTI tree that is there is taken
    elif words[0] == "mot-sim":  # as a user starts it, who is in the working folder
        given = [os.path.expandvars(word) for word in words[1:]]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            [SCRIPT, *given], check=False, env=environment, timeout=600, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        assert done.returncode == 0, f"{block.where}: {shlex.join(words)}: {done.stderr}"
    elif words[0] == "python":
        environment = {**os.environ, "PYTHONPATH": f"{os.getcwd()}{os.pathsep}{ROOT}"}
        subprocess.run([sys.executable, *words[1:]], check=True, env=environment, timeout=300)
    else:
        raise AssertionError(f"{block.where}: nobody knows how to run {shlex.join(words)}")


def check_block(block: Block, help_of: Any) -> None:
    """Check what is not run: the syntax of Python, that commands and their options exist."""
    if block.language == "python":
        ast.parse(block.text)
        return
    for words in commands_of(block, block.text) if block.language in ("sh", "") else ():
        if words[0] == "mot-sim" and len(words) > 1:
            text = help_of(words[1])
            for word in words[2:]:
                option = word.partition("=")[0]
                assert not option.startswith("--") or option in text, (
                    f"{block.where}: mot-sim {words[1]} has no {option}"
                )
        elif words[:2] == ["python", "-m"] and words[2].startswith("benchmarks."):
            place = ROOT / (words[2].replace(".", "/") + ".py")
            assert place.is_file(), f"{block.where}: no {words[2]}"
