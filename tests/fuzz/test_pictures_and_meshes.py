"""Images, depth maps and cars of a user's own: decoded, or refused."""

import json
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from mot_sim.datasets import ImageFolder
from mot_sim.simulation.cars import load_car
from mot_sim.simulation.episodes import read_depth
from tests.fuzz.door import fuzz
from tests.fuzz.mutations import spoiled_bytes, spoiled_text
from tracker.errors import BadFile

PIXELS = np.random.default_rng(0).integers(0, 255, (6, 8, 3)).astype(np.uint8)
TRIANGLES = trimesh.Trimesh(
    [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 4]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)


def encoded(ending: str, pixels: np.ndarray) -> bytes:
    done, raw = cv2.imencode(ending, pixels)
    assert done
    return raw.tobytes()


@pytest.mark.parametrize("ending", [".png", ".jpg", ".bmp"])
def test_a_bad_image_is_decoded_or_refused(ending: str, folder: Path) -> None:
    def read(path: Path) -> None:
        image = ImageFolder.require(folder).load(0)
        assert image is not None
        assert image.ndim == 3

    fuzz(folder / f"000000{ending}", encoded(ending, PIXELS), spoiled_bytes, read)


def test_a_bad_depth_map_is_decoded_or_refused(folder: Path) -> None:
    steps = np.arange(48, dtype=np.uint16).reshape(6, 8) * 300
    good = [encoded(".png", steps), encoded(".png", PIXELS[:, :, 0])]
    fuzz(folder / "000000.png", good, spoiled_bytes, read_depth)


@pytest.mark.parametrize("ending", ["obj", "glb"])
def test_a_bad_mesh_is_a_car_or_refused(ending: str, folder: Path) -> None:
    content = TRIANGLES.export(file_type=ending)
    good = content.encode() if isinstance(content, str) else content
    spoil = spoiled_text if ending == "obj" else spoiled_bytes
    fuzz(folder / f"car.{ending}", good, spoil, partial(load_car, length=4.0))


@pytest.mark.parametrize("way", ["../secret.bin", "{outside}/secret.bin", "link.bin"])
def test_a_mesh_reads_no_file_outside_its_folder(way: str, folder: Path) -> None:
    home = folder / "home"
    home.mkdir()
    scene = trimesh.Scene(TRIANGLES)
    files = trimesh.exchange.gltf.export_gltf(scene)
    about = json.loads(files["model.gltf"])
    buffers = {entry["uri"]: entry for entry in about["buffers"]}
    assert buffers
    (folder / "secret.bin").write_bytes(b"".join(files[name] for name in buffers))
    (home / "link.bin").symlink_to(folder / "secret.bin")
    for entry in buffers.values():
        entry["uri"] = way.format(outside=folder)
    (home / "car.gltf").write_text(json.dumps(about))
    with pytest.raises(BadFile, match=r"outside its folder|is no gltf mesh"):
        load_car(home / "car.gltf")
    for name in buffers:
        (home / name).write_bytes(files[name])
    (home / "car.gltf").write_bytes(files["model.gltf"])
    assert len(load_car(home / "car.gltf").faces) == 4  # what lies beside it is found
