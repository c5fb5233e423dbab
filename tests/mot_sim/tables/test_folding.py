"""Tables on a terminal: folded to its width, and never cut; where there is none, not folded."""

import os
import pty
import re
import subprocess
import sys

import pytest

from mot_sim.tables import COUNTS, Column, Table, with_ends

NAME = "jitter=2.5, max_gap=12, a_long_axis=0.125"
TEXT = "many words that may be folded where there is room for only some of them side by side"
CODE = """
from mot_sim.cli.terminal import Terminal
from tests.mot_sim.tables.test_folding import TABLE
Terminal().show(TABLE)
"""
VALUES = (0.927912, 0.110123, 1.0)
TABLE = Table(
    (
        Column("point", "name"), Column("tracker", "name"),
        *(each for name in ("HOTA", "MOTA") for each in with_ends(Column(name, "rate"))),
        *(Column(name, "count") for name in COUNTS), Column("what"),
    ),
    ((NAME, "default", *VALUES, *VALUES, *range(123450, 123458), TEXT),),
    "a title that is longer than forty letters and says what the table shows",
    note="2 seeds: too few",
)  # fmt: skip
CELLS = ("default", "92.79 [11.01, 100.00]", *(f"{n:,d}" for n in range(123450, 123458)))


def on_terminal(columns: int) -> str:
    """What the table is on a terminal of this width."""
    main, other = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(columns), "TERM": "xterm", "NO_COLOR": "1"}
    process = subprocess.Popen(
        [sys.executable, "-c", CODE], stdout=other, stderr=other, env=environment
    )
    os.close(other)
    parts = []
    while True:
        try:
            part = os.read(main, 65536)
        except OSError:  # how Linux says that the other end is closed
            break
        if not part:
            break
        parts.append(part)
    os.close(main)
    assert process.wait() == 0
    return re.sub(r"\x1b\[[0-9;]*m", "", b"".join(parts).decode()).replace("\r\n", "\n")


@pytest.mark.parametrize("columns", [40, 100])
def test_no_number_and_no_name_is_cut_on_a_terminal(columns: int) -> None:
    text = on_terminal(columns)
    assert "…" not in text
    for cell in (NAME, *CELLS):
        assert cell in text
    assert text.count(NAME) > 1  # again beside every group of columns
    words = TEXT.split()
    assert [word for word in re.findall(r"\w+", text) if word in {*words}][-len(words) :] == words
    assert max(map(len, text.splitlines())) <= max(columns, len(NAME) + 40)


def test_a_wide_terminal_gets_one_table() -> None:
    assert on_terminal(400).count(NAME) == 1


def test_without_a_terminal_every_row_is_one_line() -> None:
    environment = {**os.environ, "COLUMNS": "40"}
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, env=environment, check=True
    )
    lines = [line.strip() for line in done.stdout.splitlines() if line.strip()]
    assert lines[0] == TABLE.title
    assert lines[-1] == TABLE.note
    (row,) = [line for line in lines if NAME in line]
    assert re.split(r" {2,}", row) == [NAME, "default", CELLS[1], CELLS[1], *CELLS[2:], TEXT]
