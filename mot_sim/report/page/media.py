"""Clips and pictures inside the page, as far as its size allows."""

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from mot_sim.report.page.sources import ResultSource

MEDIA_TYPES = {
    ".mp4": "video/mp4", ".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg",
    ".gif": "image/gif",
}  # fmt: skip
# The codecs in an MP4 that browsers play; mp4v, OpenCV's own, is none of them.
PLAYABLE_CODECS = (b"avc1", b"avc3", b"av01", b"vp09")


@dataclass(frozen=True)
class Medium:
    """A file of a result. uri: its bytes, for the page; None: left out, because of `reason`."""

    name: str
    path: Path
    uri: str | None
    reason: str = ""

    @property
    def is_clip(self) -> bool:
        """Whether it moves in a player."""
        return self.path.suffix.lower() == ".mp4"

    @property
    def title(self) -> str:
        """Its name as words."""
        return PurePosixPath(self.name).stem.replace("-", " ").replace("_", " ")


def load_media(sources: Sequence[ResultSource], room: int) -> dict[int, list[Medium]]:
    """The files of every source, by its place; in turns, until `room` bytes are taken."""
    found: dict[int, list[Medium]] = {place: [] for place in range(len(sources))}
    most = max((len(source.result.files) for source in sources), default=0)
    for turn in range(most):
        for place, source in enumerate(sources):
            if turn < len(source.result.files):
                medium = _load(source.folder, source.result.files[turn], room)
                room -= len(medium.uri or "")
                found[place].append(medium)
    return found


def _load(folder: Path, name: str, room: int) -> Medium:
    """One file; left out with its reason where it is missing, too large, or cannot be shown."""
    path = folder / name
    kind = MEDIA_TYPES.get(path.suffix.lower())
    if kind is None:
        return Medium(name, path, None, f"no browser shows {path.suffix or 'such files'} in a page")
    try:
        size = path.stat().st_size
        if 4 * size > 3 * room:
            told = f"{size / 1e6:.1f} MB: the page would be too large"
            return Medium(name, path, None, told)
        content = path.read_bytes()
    except OSError as error:
        return Medium(name, path, None, f"cannot be read: {error.strerror}")
    if path.suffix.lower() == ".mp4" and not any(codec in content for codec in PLAYABLE_CODECS):
        return Medium(name, path, None, "no H.264: browsers do not play it; write the clip again")
    return Medium(name, path, f"data:{kind};base64,{b64encode(content).decode()}")


__all__ = ["Medium", "load_media"]
