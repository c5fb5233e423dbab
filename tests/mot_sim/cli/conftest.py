"""A KITTI tree of three short sequences, and the command line run in this process."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from mot_sim.__main__ import main

CALIBRATION = """\
P2: 700 0 600 0 0 700 180 0 0 0 1 0
R_rect 1 0 0 0 1 0 0 0 1
Tr_velo_cam 0 -1 0 0 0 0 -1 0 1 0 0 0
Tr_imu_velo 1 0 0 0 0 1 0 0 0 0 1 0
"""
OXTS_ROW = "49 8 100 0 0 0" + " 0" * 24 + "\n"  # a camera that stands still
FRAMES = 4
NAMES = ("0030", "0031", "0032")
LABELLED = NAMES[:2]

# A mot-sim command line: what it printed, and its exit code.
CommandLine = Callable[..., "Outcome"]


@dataclass(frozen=True)
class Outcome:
    """What one command came to."""

    code: int
    out: str
    err: str


@pytest.fixture
def mot_sim(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """Runs a command line at 80 columns, without the user's KITTI tree."""
    monkeypatch.setenv("COLUMNS", "80")

    def run(*arguments: object) -> Outcome:
        monkeypatch.delenv("MOT_SIM_KITTI_ROOT", raising=False)
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        return Outcome(code, *capsys.readouterr())

    return run


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The root of a tree: 0030 and 0031 have labels, 0032 has none; two cars ahead of us."""
    root = tmp_path / "kitti"
    for name in NAMES:
        write(root / "training/calib" / f"{name}.txt", CALIBRATION)
        write(root / "training/oxts" / f"{name}.txt", OXTS_ROW * FRAMES)
        write(root / "detections/rrc" / f"{name}.txt", detections())
    for name in LABELLED:
        write(root / "training/label_02" / f"{name}.txt", labels())
    return root


def boxes(frame: int) -> list[tuple[float, float, float, float]]:
    """Two cars, 40 and 30 pixels high, that creep sideways."""
    return [
        (500.0 + 2 * frame, 200.0, 560.0 + 2 * frame, 240.0),
        (700.0 - 2 * frame, 190.0, 745.0 - 2 * frame, 220.0),
    ]


def detections() -> str:
    """The boxes as a detector's file."""
    return "".join(
        f"{frame},{','.join(map(str, box))},0.9\n"
        for frame in range(FRAMES)
        for box in boxes(frame)
    )


def labels() -> str:
    """The boxes as KITTI labels with ids 0 and 1."""
    return "".join(
        f"{frame} {number} Car 0 0 -1.5 {' '.join(map(str, box))} 1.5 1.6 4 0 1.65 20 -1.5\n"
        for frame in range(FRAMES)
        for number, box in enumerate(boxes(frame))
    )


def boxes_csv() -> str:
    """The boxes as a boxes.csv of one's own."""
    return "frame,x_min,y_min,x_max,y_max,score\n" + detections()


CAMERA = """\
fx = 700
fy = 700
cx = 600
cy = 180
image_width = 1242
image_height = 375
camera_height = 1.65
"""


def write(path: Path, text: str) -> Path:
    """The path, after the text was written there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def files(folder: Path) -> list[str]:
    """Every file below a folder, hidden ones too."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
