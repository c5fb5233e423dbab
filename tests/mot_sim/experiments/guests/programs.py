"""Guests of the tests: small programs for our own interpreter, good ones and bad ones."""

import sys
from pathlib import Path

from mot_sim.experiments.guests import ExternalTracker

# The n-th box of every frame gets id n; half a second a drive.
GOOD = """
import json, sys
from pathlib import Path
detections, results = map(Path, sys.argv[1:3])
sequences = json.loads((detections / "sequences.json").read_text())
for name in sequences:
    seen, lines = {}, []
    for row in (detections / (name + ".txt")).read_text().split():
        frame, *box = row.split(",")
        seen[frame] = seen.get(frame, -1) + 1
        lines.append(" ".join([frame, str(seen[frame]), *box]))
    (results / (name + ".txt")).write_text("\\n".join(lines) + "\\n")
(results / "seconds.json").write_text(json.dumps({name: 0.5 for name in sequences}))
"""
CRASHES = """
import sys
print("reading the boxes", file=sys.stderr)
raise ValueError("no such weights")
"""
# Good but for one line, which is said on the command line.
RUBBISH = """
import sys
line = sys.argv.pop()
from pathlib import Path
exec(Path(sys.argv[0]).with_name("good.py").read_text())
path = results / (min(sequences) + ".txt")
path.write_text(path.read_text() + line + "\\n")
print("all well", file=sys.stderr)
"""
HANGS = """
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
open(sys.argv[1], "w").write(str(child.pid))
print("thinking", file=sys.stderr, flush=True)
time.sleep(60)
"""
PROGRAMS = {"good": GOOD, "crashes": CRASHES, "rubbish": RUBBISH, "hangs": HANGS}


def write_programs(folder: Path) -> Path:
    """The folder, with a file for every program."""
    for name, text in PROGRAMS.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def guest(folder: Path, name: str, *arguments: str, program: str | None = None) -> ExternalTracker:
    """A guest that runs one of the programs."""
    path = str(folder / f"{program or name}.py")
    return ExternalTracker(name, (sys.executable, path, "{detections}", "{results}", *arguments))
