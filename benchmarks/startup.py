"""What starting costs: CPU seconds until a package is imported, or help is shown.

    python -m benchmarks.startup [--repeat 15]

Each line runs in processes of its own, in turn with the others; user and system time, median and
least, and how much of the median is on top of a bare interpreter's. Bytecode is kept, as on users'
machines. Goals: `import tracker` 0.3 s, `mot-sim --help` 0.2 s.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

PYTHON = (sys.executable, "-c")
HELP = (sys.executable, "-m", "mot_sim")
BARE = "python -c pass"
LINES: dict[str, tuple[str, ...]] = {
    BARE: (*PYTHON, "pass"),
    "import tracker": (*PYTHON, "import tracker"),
    "import mot_sim": (*PYTHON, "import mot_sim"),
    "from tracker import Tracker, Frame": (*PYTHON, "from tracker import Tracker, Frame"),
    "mot-sim --help": (*HELP, "--help"),
    "mot-sim --version": (*HELP, "--version"),
    "mot-sim track --help": (*HELP, "track", "--help"),
    "import numpy": (*PYTHON, "import numpy"),
}


def seconds(command: tuple[str, ...], environment: dict[str, str]) -> float:
    """User and system seconds of a process. Raises CalledProcessError where it fails."""
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, env=environment, check=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print a row a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=15)
    repeat: int = parser.parse_args().repeat
    with tempfile.TemporaryDirectory() as kept:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": kept, "OMP_NUM_THREADS": "1"}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for command in LINES.values():  # writes the bytecode
            seconds(command, environment)
        rounds = [
            [seconds(command, environment) for command in LINES.values()] for _ in range(repeat)
        ]
    found = dict(zip(LINES, zip(*rounds, strict=True), strict=True))
    bare = median(found[BARE])
    print(f"{'CPU seconds':36} median  least  on top")
    for name, measured in found.items():
        middle = median(measured)
        print(f"{name:36} {middle:6.3f} {min(measured):6.3f}  {middle - bare:6.3f}")


if __name__ == "__main__":
    main()
