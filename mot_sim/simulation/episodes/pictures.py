"""The pictures of an episode as PNG: images, depth, instances, semantics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Shaped
from numpy import ndarray as Array

from mot_sim.datasets.images import decoded
from mot_sim.files.writing import write_bytes
from mot_sim.simulation.episodes.places import PICTURES, EpisodeFiles
from mot_sim.simulation.renderers import Rendered
from tracker.errors import BadConfig, BadFile

DEPTH_STEPS_PER_METRE = 256.0  # a metre, as in KITTI's depth maps
MAX_UINT16 = 2**16 - 1
PNG_SETTINGS = [cv2.IMWRITE_PNG_COMPRESSION, 1]  # half the time of level 6, files a third larger

Pixels = Shaped[Array, "h w *c"]
Encoded = dict[str, tuple[bytes, bytes]]


@dataclass(eq=False)
class Pictures:
    """Keeps the pictures of frames, in order, and what they hash to."""

    parts: Sequence[str]
    """Kinds of pictures, of PICTURES."""
    places: EpisodeFiles | None = None
    """Where they are written; None: only the hashes are kept."""
    hashes: dict[str, list[bytes]] = field(init=False)
    """SHA-256 of each frame's pixels, by kind of picture."""

    def __post_init__(self) -> None:
        self.hashes = {part: [] for part in self.parts}

    def encode(self, rendered: Rendered) -> Encoded:
        """The files of a frame, and what their pixels hash to, by kind of picture."""
        found = {}
        for part in self.parts:
            pixels, png = ENCODERS[part](rendered), b""
            if self.places is not None:
                done, packed = cv2.imencode(".png", pixels, PNG_SETTINGS)
                assert done
                png = packed.tobytes()
            found[part] = png, _hash(pixels)
        return found

    def add(self, frame: int, encoded: Encoded) -> None:
        """Write the pictures of the next frame, each as a whole. Raises BadOutput."""
        for part, (png, pixels_hash) in encoded.items():
            if self.places is not None:
                write_bytes(self.places.picture(part, frame), png)
            self.hashes[part].append(pixels_hash)

    def digests(self, count: int) -> dict[str, str]:
        """SHA-256 of the pixels of the first frames, a part each."""
        return {part: _together(hashes[:count]) for part, hashes in self.hashes.items()}


def digest_of_folder(places: EpisodeFiles, part: str, count: int) -> str:
    """The same hash of the pictures on disk. Raises BadFile for a missing or broken one."""
    return _together([_hash(_decode(places.picture(part, frame))) for frame in range(count)])


def read_depth(path: Path) -> Shaped[Array, "h w"]:
    """Metres along the optical axis, float32; inf where nothing is, or beyond 255.99 m."""
    steps = _decode(path)
    if steps.ndim != 2:
        raise BadFile(f"{path}: colours where a depth of one channel belongs; record again")
    metres = steps.astype(np.float32) / np.float32(DEPTH_STEPS_PER_METRE)
    return np.where(steps > 0, metres, np.float32(np.inf))


def _image(rendered: Rendered) -> Pixels:
    return cv2.cvtColor(rendered.image, cv2.COLOR_RGB2BGR)


def _depth(rendered: Rendered) -> Pixels:
    """Steps of 1/256 m; 0: nothing there, or farther than the steps reach."""
    steps = np.rint(rendered.depth * np.float32(DEPTH_STEPS_PER_METRE))
    return np.where(steps <= MAX_UINT16, np.maximum(steps, 1.0), 0.0).astype(np.uint16)


def _instances(rendered: Rendered) -> Pixels:
    """The id of the car, plus 1; 0: no car."""
    highest = int(rendered.instances.max(initial=0))
    if highest >= MAX_UINT16:
        raise BadConfig(f"a car has the id {highest}: masks hold ids up to {MAX_UINT16 - 1}")
    return (rendered.instances + 1).astype(np.uint16)


def _semantics(rendered: Rendered) -> Pixels:
    return rendered.semantics


ENCODERS: dict[str, Callable[[Rendered], Pixels]] = dict(
    zip(PICTURES, (_image, _depth, _instances, _semantics), strict=True)
)


def _decode(path: Path) -> Pixels:
    if not path.exists():
        raise BadFile(f"{path}: no such picture; record again")
    pixels = decoded(path, cv2.IMREAD_UNCHANGED)
    if pixels is None:
        raise BadFile(f"{path}: not a picture that OpenCV can decode; record again")
    return pixels


def _hash(pixels: Pixels) -> bytes:
    head = f"{pixels.dtype.str} {pixels.shape}\n".encode()
    return sha256(head + np.ascontiguousarray(pixels).tobytes()).digest()


def _together(hashes: Sequence[bytes]) -> str:
    return sha256(b"".join(hashes)).hexdigest()
