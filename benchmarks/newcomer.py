"""From a clone to a tracker of one's own that is scored, or stressed: a page, by the clock.

    python -m benchmarks.newcomer [--page first|stress] [--repository ADDRESS] [--keep DIR]

Both pages begin with the installation of the first steps. The goal of `first` counts it, that of
`stress` (until the JUnit file of the suite `smoke` is written) does not. A page's commands run
word for word in one shell, in an empty folder, with an empty home and no variables of the user's
but those of pip; its files are saved where the page says. Only the address of the repository is
filled in: this checkout's last commit, unless another is named.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from tests.pages import DOCS, ROOT, Block, blocks_of

PAGE = DOCS / "quickstart" / "first.md"
STRESS_PAGE = DOCS / "quickstart" / "stress.md"
MARK = "@@"  # before the clock's lines in the shell's output
# Seconds, on a machine that does nothing else; of the second page those after the installation.
GOALS = {PAGE: 300.0, STRESS_PAGE: 180.0}


@dataclass(frozen=True)
class Step:
    """A block of the page, and the seconds that it took."""

    what: str
    seconds: float


def newcomer_blocks(page: Path) -> list[Block]:
    """What a newcomer types and saves, by the page; the installation comes first."""
    blocks = [block for block in blocks_of(page) if block.note("newcomer") is not None]
    return blocks if page == PAGE else [newcomer_blocks(PAGE)[0], *blocks]


def follow(place: Path, repository: str, page: Path = PAGE) -> tuple[list[Step], str]:
    """Follow a page in an empty folder: the steps by the clock, and what was printed.

    Raises RuntimeError with the end of the output where a command fails.
    """
    home = place / "home"
    home.mkdir()
    kept = {name: value for name, value in os.environ.items() if name.startswith("PIP_")}
    clean = {**kept, "HOME": str(home), "PATH": _path(), "TERM": "dumb", "LANG": "C.UTF-8"}
    blocks = newcomer_blocks(page)
    done = subprocess.run(
        ["bash", "-c", script_of(blocks, repository)],
        cwd=place,
        env=clean,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"the page fails with {done.returncode}: {done.stdout[-3000:]}")
    marks = [line.split(" ", 2)[1:] for line in done.stdout.splitlines() if line.startswith(MARK)]
    times = [float(mark[0]) for mark in marks]
    steps = [
        Step(mark[1], after - before)
        for mark, before, after in zip(marks[1:], times, times[1:], strict=False)
    ]
    said = [line for line in done.stdout.splitlines() if not line.startswith(MARK)]
    return steps, "\n".join(said)


def script_of(blocks: list[Block], repository: str) -> str:
    """All blocks as one shell script that tells the time after each."""
    clock = f'printf "{MARK} %s %s\\n" "$(date +%s.%N)"'
    lines = ["set -eo pipefail", f"{clock} start"]
    for block in blocks:
        file = block.note("file")
        if file is None:
            lines.append(block.text.replace("REPOSITORY", repository))
        else:
            lines.append(f"cat > {file} <<'END OF THE FILE'\n{block.text}END OF THE FILE")
        lines.append(f"{clock} {file or block.text.split(chr(10), 1)[0].split()[0]}")
    return "\n".join(lines)


def _path() -> str:
    """Where the system's commands and this Python are, without the environment we run in."""
    ours = str(Path(sys.prefix) / "bin")
    places = [place for place in os.environ["PATH"].split(os.pathsep) if place != ours]
    return os.pathsep.join([str(Path(sys.base_prefix) / "bin"), *places])


def main() -> None:
    """Follow the page and print what each step took."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repository", default=str(ROOT), help="what git clones")
    parser.add_argument("--keep", type=Path, help="an empty folder to work in, which stays")
    parser.add_argument("--page", choices=("first", "stress"), default="first")
    given = parser.parse_args()
    page = PAGE if given.page == "first" else STRESS_PAGE
    if given.keep is not None:
        given.keep.mkdir(parents=True, exist_ok=True)
        steps, said = follow(given.keep.resolve(), given.repository, page)
    else:
        with tempfile.TemporaryDirectory() as folder:
            steps, said = follow(Path(folder), given.repository, page)
    print(said)
    for step in steps:
        print(f"{step.seconds:8.1f} s  {step.what}")
    counted = steps if page == PAGE else steps[1:]
    total, goal = sum(step.seconds for step in counted), GOALS[page]
    what = "in all" if page == PAGE else "after the installation"
    print(f"{total:8.1f} s  {what}; the goal is {goal:.0f}: {'kept' if total < goal else 'missed'}")


if __name__ == "__main__":
    main()
