"""The keypoint network at use: its door, its files, its images."""

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import kitti_sequence
from mot_sim.datasets.images import ImageFolder
from tracker.errors import BadImage, BadWeights
from tracker.geometry import wrap_angle
from tracker.shape import SHIPPED_HOURGLASS, Hourglass, ShapeFit
from tracker.shape.keypoints import OTHER_SIDE, colour_of, network_input

BOXES = np.array([[20.0, 20.0, 90.0, 60.0], [-40.0, 10.0, 30.0, 70.0], [100.0, 30.0, 130.0, 60.0]])


@pytest.fixture(scope="module")
def hourglass() -> Hourglass:
    return Hourglass.load()


@pytest.fixture
def image() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 255, (100, 160, 3)).astype(np.uint8)


def test_the_shipped_weights_are_small_and_say_where_they_come_from(hourglass: Hourglass) -> None:
    assert SHIPPED_HOURGLASS.stat().st_size <= 8_000_000
    assert {"seed", "crops", "epochs", "size"} <= set(hourglass.card["training"])
    assert hourglass.sha256 == hashlib.sha256(SHIPPED_HOURGLASS.read_bytes()).hexdigest()


def test_every_box_has_keypoints_and_activations(hourglass: Hourglass, image: np.ndarray) -> None:
    seen = hourglass(image, BOXES)
    assert seen.keypoints.shape == (3, 36, 3)
    assert np.isfinite(seen.keypoints).all()
    assert ((seen.keypoints[:, :, 2] >= 0.0) & (seen.keypoints[:, :, 2] <= 1.0)).all()
    assert seen.activations.shape == (3, *hourglass.card["activations"])
    assert len(seen.select(slice(0, 2))) == 2


def test_boxes_together_and_alone_are_the_same(hourglass: Hourglass, image: np.ndarray) -> None:
    together = hourglass(image, np.tile(BOXES, (14, 1)))  # more than go in at once
    for row in (0, 1, 2, 40):
        alone = hourglass(image, BOXES[row % 3][None])
        assert together.keypoints[row] == pytest.approx(alone.keypoints[0], abs=1e-3)


def test_a_shifted_image_shifts_the_keypoints(hourglass: Hourglass, image: np.ndarray) -> None:
    shifted = np.zeros((150, 200, 3), np.uint8)
    shifted[30:130, 24:184] = image
    box = BOXES[2:]
    first, second = hourglass(image, box), hourglass(shifted, box + (24.0, 30.0, 24.0, 30.0))
    off = second.keypoints - first.keypoints - (24.0, 30.0, 0.0)
    assert np.abs(off).max() < 0.05


def test_the_mirror_image_of_a_crop_has_mirrored_keypoints(
    hourglass: Hourglass, image: np.ndarray
) -> None:
    box = np.array([[40.0, 20.0, 120.0, 80.0]])
    flipped = box.copy()
    flipped[:, [0, 2]] = image.shape[1] - 1.0 - box[:, [2, 0]]
    here = hourglass(image, box).keypoints[0]
    there = hourglass(np.ascontiguousarray(image[:, ::-1]), flipped).keypoints[0, OTHER_SIDE]
    there[:, 0] = image.shape[1] - 1.0 - there[:, 0]
    assert there == pytest.approx(here, abs=0.02)
    once = Hourglass.load(mirrored=False)
    assert once(image, box).activations == pytest.approx(hourglass(image, box).activations)
    assert np.abs(once(image, box).keypoints[0] - here).max() > 0.02


def test_boxes_that_show_nothing_are_nan(hourglass: Hourglass, image: np.ndarray) -> None:
    nothing = np.array([[5.0, 5.0, 6.0, 6.0], [500.0, 5.0, 600.0, 60.0], [np.nan] * 4])
    seen = hourglass(image, np.concatenate((nothing, BOXES[:1])))
    assert np.isnan(seen.keypoints[:3]).all()
    assert np.isnan(seen.activations[:3]).all()
    assert np.isfinite(seen.keypoints[3]).all()


def test_no_box_is_no_row(hourglass: Hourglass, image: np.ndarray) -> None:
    seen = hourglass(image, np.zeros((0, 4)))
    assert seen.keypoints.shape == (0, 36, 3)
    assert len(seen) == 0


def test_a_grey_image_is_seen_as_three_equal_channels(
    hourglass: Hourglass, image: np.ndarray
) -> None:
    grey = image[:, :, 0]
    wanted = hourglass(np.dstack([grey] * 3), BOXES).keypoints
    for given in (grey, grey[:, :, None]):
        assert hourglass(given, BOXES).keypoints == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (np.zeros((10, 10, 3), np.uint16), "257"),
        (np.zeros((10, 10, 3)), "give uint8"),
        (np.zeros((10, 10, 4), np.uint8), "(10, 10, 4)"),
        (np.zeros((0, 10, 3), np.uint8), "(0, 10, 3)"),
    ],
)
def test_other_images_are_refused(hourglass: Hourglass, wrong: np.ndarray, told: str) -> None:
    with pytest.raises(BadImage) as caught:
        hourglass(wrong, BOXES)
    assert told in str(caught.value)


def test_an_image_is_not_changed(hourglass: Hourglass, image: np.ndarray) -> None:
    before = image.copy()
    hourglass(image, BOXES)
    assert (image == before).all()
    assert colour_of(image) is image


def test_the_network_is_given_planes_around_zero() -> None:
    crops = np.full((1, 2, 2, 3), 128, np.uint8)
    crops[0, 0, 0] = 0, 128, 192
    planes = network_input(crops)
    assert planes.shape == (1, 3, 2, 2)
    assert planes[0, :, 0, 0] == pytest.approx([-2.0, 0.0, 1.0])


@pytest.mark.kitti
def test_yaw_of_real_cars_comes_out_of_their_keypoints(
    hourglass: Hourglass, kitti_root: Path
) -> None:
    drive = kitti_sequence(kitti_root, "0009", detections=None)
    pictures, cars = ImageFolder.require(kitti_root / "training/image_02/0009"), drive.truth
    assert cars is not None
    whole = (cars.occlusion == 0) & (cars.truncation == 0) & (cars.cuboids.base[:, 2] < 30.0)
    cars = cars.select(whole & (cars.kinds == "Car") & np.isin(cars.frames, list(pictures.paths)))
    assert len(cars) > 10
    off = []
    for frame in np.unique(cars.frames).tolist():
        now, image = cars.select(cars.frames == frame), pictures.load(frame)
        assert image is not None
        seen = hourglass(np.ascontiguousarray(image[:, :, ::-1]), now.boxes)
        fitted = ShapeFit()(
            seen.keypoints, drive.camera, 0.05 * (now.boxes[:, 2:] - now.boxes[:, :2])
        )
        off += np.abs(wrap_angle(fitted.yaw - now.cuboids.yaw)).tolist()
    assert np.degrees(np.nanmedian(off)) < 10.0


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    for suffix in (".onnx", ".json"):
        shutil.copy(SHIPPED_HOURGLASS.with_suffix(suffix), tmp_path / f"mine{suffix}")
    return tmp_path / "mine.onnx"


def describe(path: Path, **changes: object) -> None:
    """Change what the card says; a value of None takes it out."""
    card = json.loads(path.with_suffix(".json").read_text()) | changes
    told = {name: value for name, value in card.items() if value is not None}
    path.with_suffix(".json").write_text(json.dumps(told))


def with_hash(path: Path, content: bytes) -> None:
    """Other content whose hash the card knows."""
    path.write_bytes(content)
    describe(path, sha256=hashlib.sha256(content).hexdigest())


def field(number: int, content: bytes) -> bytes:
    """A protobuf field that holds bytes (fewer than 128)."""
    return bytes([number << 3 | 2, len(content)]) + content


def other_onnx() -> bytes:
    """An ONNX of another network: its one output is its input."""
    dims = b"".join(field(1, bytes([0x08, size])) for size in (1, 3))
    kind = field(1, bytes([0x08, 1]) + field(2, dims))
    node = field(1, b"crops") + field(2, b"heatmaps") + field(4, b"Identity")
    graph = field(1, node) + field(2, b"other")
    graph += field(11, field(1, b"crops") + field(2, kind))
    graph += field(12, field(1, b"heatmaps") + field(2, kind))
    return bytes([0x08, 7]) + field(8, field(1, b"") + bytes([0x10, 13])) + field(7, graph)


BROKEN: dict[str, tuple[Callable[[Path], object], str]] = {
    "no weights": (lambda path: path.unlink(), "No such file"),
    "no card": (lambda path: path.with_suffix(".json").unlink(), "No such file"),
    "a card that is no JSON": (lambda path: path.with_suffix(".json").write_text("{"), "mine.json"),
    "a card that is a list": (lambda path: path.with_suffix(".json").write_text("[]"), "no format"),
    "a card without a hash": (lambda path: describe(path, sha256=None), "no sha256"),
    "a later format": (lambda path: describe(path, format=99), "format 99"),
    "a flipped bit": (lambda path: path.write_bytes(path.read_bytes()[:-1] + b"!"), "SHA-256"),
    "half a file": (lambda path: path.write_bytes(path.read_bytes()[:5000]), "SHA-256"),
    "no ONNX at all": (lambda path: with_hash(path, b"hello"), "no ONNX that"),
    "another network": (lambda path: with_hash(path, other_onnx()), "does not take"),
    "other shapes": (lambda path: describe(path, heatmaps=[14, 16, 16]), "promises"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_broken_weights_are_refused_with_a_cure(copied: Path, what: str) -> None:
    spoil, told = BROKEN[what]
    assert Hourglass.load(copied).sha256
    spoil(copied)
    with pytest.raises(BadWeights) as caught:
        Hourglass.load(copied)
    assert told in str(caught.value)
    assert "train-keypoints" in str(caught.value) or "reads" in str(caught.value)
