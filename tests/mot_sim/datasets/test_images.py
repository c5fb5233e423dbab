"""Folders of numbered images."""

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.datasets.images import ImageFolder
from tracker.errors import BadFile, DatasetNotFound


def paint(path: Path, rgb: tuple[int, int, int], size: tuple[int, int] = (6, 4)) -> None:
    """Write an image of one colour."""
    image = np.full((size[1], size[0], 3), rgb[::-1], dtype=np.uint8)
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image)


def test_images_are_rgb_and_found_by_their_number(tmp_path: Path) -> None:
    paint(tmp_path / "000002.png", (255, 10, 0))
    (tmp_path / "SOURCE.md").write_text("not an image")
    folder = ImageFolder.require(tmp_path)
    assert folder.image_size == (6, 4)
    image = folder.load(2)
    assert image is not None
    assert image.shape == (4, 6, 3)
    assert image[0, 0].tolist() == [255, 10, 0]
    assert folder.load(0) is None


def test_the_first_number_can_be_another_than_0(tmp_path: Path) -> None:
    paint(tmp_path / "000001.png", (0, 0, 0))
    assert ImageFolder.require(tmp_path, first_frame=1).load(0) is not None


def test_no_images_is_none_or_an_error(tmp_path: Path) -> None:
    assert ImageFolder.find(tmp_path) is None
    assert ImageFolder.find(tmp_path / "nowhere") is None
    with pytest.raises(
        DatasetNotFound, match=r"nowhere: no such folder; give images named 000000.png"
    ):
        ImageFolder.require(tmp_path / "nowhere")
    with pytest.raises(DatasetNotFound, match="no numbered images in it"):
        ImageFolder.require(tmp_path)


def test_broken_and_odd_images_are_named(tmp_path: Path) -> None:
    paint(tmp_path / "000000.png", (0, 0, 0))
    paint(tmp_path / "000001.png", (0, 0, 0), size=(5, 4))
    (tmp_path / "000002.png").write_bytes(b"no image")
    (tmp_path / "000003.png").write_bytes(b"")
    folder = ImageFolder.require(tmp_path)
    with pytest.raises(BadFile, match=r"000001.png: 5x4 pixels where the first .* has 6x4"):
        folder.load(1)
    for number in (2, 3):
        with pytest.raises(BadFile, match=rf"00000{number}.png: not an image"):
            folder.load(number)


def test_frames_without_an_image_are_counted_aloud(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    paint(tmp_path / "000000.png", (0, 0, 0))
    folder = ImageFolder.require(tmp_path)
    with caplog.at_level(logging.WARNING):
        folder.warn_of_gaps(1)
        assert caplog.text == ""
        folder.warn_of_gaps(3)
    assert "images for 1 of 3 frames only" in caplog.text
