"""Fills the page of the commands with what each of them says under --help."""

import os
import re
import subprocess
import sys

PLACE = "<!-- commands -->"
PYTHON = os.environ.get("MOT_SIM_PYTHON", sys.executable)  # where mot-sim is installed


def on_page_markdown(markdown: str, **_: object) -> str:
    """The page with a section for each command, where it asks for them."""
    return markdown.replace(PLACE, sections()) if PLACE in markdown else markdown


def sections() -> str:
    """A heading and the help of each command, in the order of `mot-sim --help`."""
    listed = "from mot_sim.cli import COMMANDS; print(*COMMANDS)"
    names = _said([PYTHON, "-c", listed]).split()
    parts = [_fenced(_said([PYTHON, "-m", "mot_sim", "--help"]))]
    for name in names:
        parts.append(f"## mot-sim {name}\n\n" + _fenced(help_of(name)))
    return "\n\n".join(parts)


def help_of(name: str) -> str:
    """What a command says under --help."""
    return _said([PYTHON, "-m", "mot_sim", name, "--help"])


def _fenced(text: str) -> str:
    return f"```text\n{text.strip()}\n```"


def _said(command: list[str]) -> str:
    """What a command prints, without colours; raises where it fails."""
    environment = {**os.environ, "COLUMNS": "96", "NO_COLOR": "1", "TERM": "dumb"}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)
