"""Where things lie in a KITTI tree, and errors that say what lies there instead."""

import os
from pathlib import Path

from mot_sim.files.text import what_is_there
from tracker.errors import DatasetNotFound, UnknownName

ROOT_VARIABLE = "MOT_SIM_KITTI_ROOT"
SPLITS = ("training", "testing")
CURE = f"set {ROOT_VARIABLE} or pass --root"

# Frames and image sizes of the 21 training sequences (KITTI tracking benchmark).
TRAINING_FRAMES = (
    154, 447, 233, 144, 314, 297, 270, 800, 390, 803, 294,
    373, 78, 340, 106, 376, 209, 145, 339, 1059, 837,
)  # fmt: skip
TRAINING_SIZES = ((1242, 375),) * 14 + ((1224, 370),) * 4 + ((1238, 374),) * 2 + ((1241, 376),)
DEFAULT_SIZE = (1242, 375)


def find_root(root: Path | str | None = None) -> Path:
    """The root of the KITTI tree: the given one, or the one that the environment names.

    Raises DatasetNotFound when neither is given or the folder does not hold a split.
    """
    named = root or os.environ.get(ROOT_VARIABLE)
    if not named:
        raise DatasetNotFound(f"no KITTI root is given; {CURE}")
    folder = Path(named).expanduser()
    if not folder.is_dir():
        raise DatasetNotFound(f"{folder}: no KITTI root, {what_is_there(folder, '')}; {CURE}")
    if not any((folder / split).is_dir() for split in SPLITS):
        raise DatasetNotFound(
            f"{folder}: no KITTI root, it lacks 'training' and 'testing'; "
            f"{_contents(folder)}; {CURE}"
        )
    return folder


def available_sequences(root: Path | str | None = None, split: str = "training") -> list[str]:
    """The names of the sequences that have a calibration, in order."""
    calib = split_folder(find_root(root), split) / "calib"
    return sorted(path.stem for path in calib.glob("*.txt"))


def split_folder(root: Path, split: str) -> Path:
    """`<root>/<split>`; UnknownName for a split that KITTI does not have."""
    if split not in SPLITS:
        raise UnknownName.of("split", split, SPLITS)
    folder = root / split
    if not folder.is_dir():
        raise DatasetNotFound(f"{folder}: no such split; {_contents(root)}; {CURE}")
    return folder


def require_sequence(root: Path, split: str, name: str) -> Path:
    """`<root>/<split>`, checked to have the sequence's calibration."""
    folder = split_folder(root, split)
    if not (folder / "calib" / f"{name}.txt").is_file():
        there = ", ".join(available_sequences(root, split)) or "none"
        raise DatasetNotFound(
            f"{folder / 'calib' / name}.txt: no sequence '{name}'; sequences there: {there}; {CURE}"
        )
    return folder


def beside_the_splits(root: Path, kind: str, name: str, split: str) -> Path:
    """The folder of detections or odometry that lie beside the splits: `<root>/<kind>/<name>`.

    Both splits number their sequences from 0000: files for `testing` lie one folder deeper.
    """
    folder = root / kind / name
    return folder if split == "training" else folder / split


def require_file(path: Path, what: str, cure: str) -> Path:
    """The path when it is a file; else DatasetNotFound with what its folder holds instead."""
    if path.is_file():
        return path
    raise DatasetNotFound(f"{path}: no {what}; {_contents(path.parent)}; {cure}")


def training_row(name: str, split: str) -> int | None:
    """The number of one of KITTI's 21 training sequences; None for any other."""
    known = split == "training" and len(name) == 4 and name.isdecimal()
    return int(name) if known and int(name) < len(TRAINING_FRAMES) else None


def _contents(folder: Path) -> str:
    if not folder.is_dir():
        above = f"; {_contents(folder.parent)}" if folder.parent.is_dir() else ""
        return f"{folder} is {what_is_there(folder, '')}{above}"
    names = sorted(path.name for path in folder.iterdir())
    shown = ", ".join(names[:8]) + (f", ... ({len(names)} in all)" if len(names) > 8 else "")
    return f"{folder} holds {shown or 'nothing'}"
