"""Things of a user's own, and broken ones, as files of a working folder."""

from pathlib import Path

GOOD = '''"""Things of my own."""

from dataclasses import dataclass, replace

import numpy as np
from mot_sim import Bound, Roads, Route, Scene, Script, Scripted, Suite, Tracker
from tracker.lifecycle import Lifecycle


def my_scene(*, speed: float = 14.0, frames: int = 12) -> Scene:
    """One car drives ahead of us, another overtakes both."""

    def traffic(models):
        ego = Script(Route([(0.0, 0.0), (400.0, 0.0)]), [(0.0, 8.0)])
        ahead = Script(Route([(25.0, 0.0), (400.0, 0.0)]), [(0.0, 8.0)])
        fast = Script(Route([(-20.0, -3.5), (400.0, -3.5)]), [(0.0, speed)])
        return Scripted([ahead, fast], ego)

    return Scene("overtaking", traffic, frames, Roads())


@dataclass(frozen=True)
class MyCost:
    """How much lower the lower of two boxes is."""

    def __call__(self, pairing):
        rows, columns = pairing.pairs
        expected, observed = pairing.expected.boxes[rows], pairing.observed.boxes[columns]
        one, other = expected[:, 3] - expected[:, 1], observed[:, 3] - observed[:, 1]
        return 1.0 - np.minimum(one, other) / np.maximum(one, other)


class Numbers:
    """The same boxes under the same numbers."""

    def update(self, boxes, scores):
        return np.column_stack((boxes, np.arange(len(boxes))))


def forgetful(camera):
    """The default tracker with a short memory."""
    return replace(Tracker.default(camera), lifecycle=Lifecycle(birth_score=0.8, max_gap=0.5))


def greedy(tracker):
    """An association of my own."""
    from tracker.association import Greedy

    return replace(tracker, associate=Greedy(1.0))


MY_SUITE = Suite("overtaken", "one car overtakes", "mine:my_scene", 8, (Bound("HOTA", 0.2),))
'''
BAD = """N = 5


def gives_none(*, frames=10):
    return None


def raises(*, frames=10):
    raise ValueError("no\\n cars")


def needs(speed, *, frames=10):
    return None


def timeless(*, speed=3.0):
    return None


def weathered(*, weather="noon", frames=10):
    return None


def late(*, frames=10):
    from mot_sim import Scene

    return Scene("late", lambda models: models.nothing, frames)


class Takes:
    def __init__(self, weight):
        pass


class NoCost:
    pass


class RaisingCost:
    def __call__(self, pairing):
        raise KeyError("nope")


class Stepper:
    def step(self, frame):
        return 1 / 0
"""
FILES = {
    "mine.py": GOOD,
    "bad.py": BAD,
    "divides.py": "import math\nx = 1 / 0\n",
    "syntax.py": "x = 1\ndef f(:\n",
    "lacks.py": "import no_such_library\n",
    "ends.py": "raise SystemExit(3)\n",
    "scenes.py": "def my_scene(*, frames=10):\n    return None\n",
}


def write_own_things(folder: Path) -> Path:
    """The folder with all of these files in it."""
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


def write_package(
    folder: Path, name: str, entry_points: dict[str, dict[str, str]], version: str = "1.0"
) -> None:
    """An installed package in a folder of Python's path. entry_points: values by group and name."""
    home = folder / f"{name}-{version}.dist-info"
    home.mkdir(parents=True)
    (home / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    text = "".join(
        f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in points.items())
        for group, points in entry_points.items()
    )
    (home / "entry_points.txt").write_text(text)
