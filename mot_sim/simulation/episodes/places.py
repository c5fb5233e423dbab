"""Where the parts of an episode lie in its KITTI tree."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

# By part: where it is, below the root. KITTI's own places, and beside them what it lacks.
TEXTS = {
    "labels": "training/label_02",
    "calibration": "training/calib",
    "oxts": "training/oxts",
    "detections": "detections/simulated",
    "exact detections": "detections/exact",
    "odometry": "odometry/noisy",
}
PICTURES = {
    "images": "training/image_02",
    "depth": "training/depth_02",
    "instances": "training/instance_02",
    "semantics": "training/semantic_02",
}
EXTRA = "training/extra"
EPISODES_FILE = "episodes.json"  # in the root: how the episodes were made


@dataclass(frozen=True)
class EpisodeFiles:
    """The files of one episode. The extra file comes last: where it is, the episode is whole."""

    root: Path
    """Folder of the KITTI tree."""
    name: str
    """Name of the episode, as '0000'."""

    @property
    def extra(self) -> Path:
        """What KITTI's files cannot hold."""
        return self.root / EXTRA / f"{self.name}.npz"

    def text(self, part: str) -> Path:
        """The text file of a part of TEXTS."""
        return self.root / TEXTS[part] / f"{self.name}.txt"

    def pictures(self, part: str) -> Path:
        """The folder of a part of PICTURES."""
        return self.root / PICTURES[part] / self.name

    def picture(self, part: str, frame: int) -> Path:
        """The picture of a frame."""
        return self.pictures(part) / f"{frame:06d}.png"

    def trim(self, count: int) -> None:
        """Remove the pictures of all but the first frames."""
        for part in PICTURES:
            for path in self.pictures(part).glob("[0-9]*.png"):
                if int(path.stem) >= count:
                    path.unlink()

    def remove(self) -> None:
        """Remove every file of the episode, the extra file first, and folders left empty."""
        self.extra.unlink(missing_ok=True)
        for path in (self.extra, *(self.text(part) for part in TEXTS)):
            path.unlink(missing_ok=True)
            for half in path.parent.glob(f".{path.name}.*.half"):  # of a process that was killed
                half.unlink(missing_ok=True)
        for part in PICTURES:
            for path in self.pictures(part).glob("*"):
                if path.name.endswith((".png", ".half")):
                    path.unlink(missing_ok=True)
        for place in self._folders():
            with suppress(OSError):  # not there, or others lie in it
                place.rmdir()

    def _folders(self) -> Iterator[Path]:
        """The folders below the root that may hold a file of the episode, the deepest first."""
        yield from (self.pictures(part) for part in PICTURES)
        yield from (self.root / place for place in (*TEXTS.values(), *PICTURES.values(), EXTRA))
        yield from (self.root / place for place in ("training", "detections", "odometry"))


def stored_episodes(root: Path) -> list[str]:
    """The names of the episodes of a tree that are whole."""
    return sorted(path.stem for path in (root / EXTRA).glob("[0-9]*.npz"))


def begun_episodes(root: Path) -> list[str]:
    """The names of the sequences of a tree, whole or half-made."""
    begun = {path.name for path in (root / PICTURES["images"]).glob("*/")}
    begun |= {path.stem for path in (root / TEXTS["calibration"]).glob("*.txt")}
    return sorted({*stored_episodes(root), *begun})


def file_digest(path: Path) -> str | None:
    """SHA-256 of a file; None when there is none."""
    try:
        return sha256(path.read_bytes()).hexdigest()
    except FileNotFoundError:
        return None
