"""PNGs of images, depth and masks."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from mot_sim.simulation.episode import record
from mot_sim.simulation.episodes import PICTURES, EpisodeFiles, read_depth
from mot_sim.simulation.episodes.pictures import ENCODERS, Pictures, digest_of_folder
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.renderers import Rendered
from mot_sim.simulation.scene import Rollout
from tests.mot_sim.simulation.episodes.conftest import SEED
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import BadConfig, BadFile


def rendered(depth: list[float], instances: list[int]) -> Rendered:
    """A frame one pixel high."""
    width = len(depth)
    return Rendered(
        np.zeros((1, width, 3), np.uint8),
        np.array([depth], np.float32),
        np.array([instances], np.int32),
        np.zeros((1, width), np.uint8),
    )


def test_depth_has_256_steps_a_metre_and_zero_where_nothing_is(tmp_path: Path) -> None:
    frame = rendered([1.0, 2.5, np.inf, 400.0, 255.99, 0.0001], [-1] * 6)
    assert ENCODERS["depth"](frame).tolist() == [[256, 640, 0, 0, 65533, 1]]
    cv2.imwrite(str(tmp_path / "d.png"), ENCODERS["depth"](frame))
    metres = read_depth(tmp_path / "d.png")
    np.testing.assert_allclose(metres[0, [0, 1, 4]], [1.0, 2.5, 255.99], atol=1 / 512)
    assert np.isinf(metres[0, 2:4]).all()


def test_masks_hold_the_id_plus_one_and_zero_for_nobody() -> None:
    masks = ENCODERS["instances"](rendered([1.0, 1.0], [-1, 7]))
    assert masks.dtype == np.uint16
    assert masks.tolist() == [[0, 8]]
    with pytest.raises(BadConfig, match="id 65535: masks hold ids up to 65534"):
        ENCODERS["instances"](rendered([1.0], [65535]))


def test_the_files_hold_what_was_rendered(recorded: Path) -> None:
    places, frame = EpisodeFiles(recorded, "0000"), 3
    truth = RenderedImages(Rollout.of(small(), SEED)).render(frame)
    image = cv2.imread(str(places.picture("images", frame)))[..., ::-1]
    np.testing.assert_array_equal(image, truth.image)
    near = truth.depth < 255.0
    depth = read_depth(places.picture("depth", frame))
    np.testing.assert_allclose(depth[near], truth.depth[near], atol=1 / 500)
    masks = cv2.imread(str(places.picture("instances", frame)), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(masks.astype(int) - 1, truth.instances)
    semantics = cv2.imread(str(places.picture("semantics", frame)), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(semantics, truth.semantics)


def test_masks_and_truth_name_the_same_cars(recorded: Path) -> None:
    exact, places = record(small(), SEED).exact, EpisodeFiles(recorded, "0000")
    for frame in range(FRAMES):
        masks = cv2.imread(str(places.picture("instances", frame)), cv2.IMREAD_UNCHANGED)
        seen = exact.select((exact.tracks.frames == frame) & (exact.pixels > 8))
        assert set(seen.tracks.ids.tolist()) <= set((np.unique(masks).astype(int) - 1).tolist())


def test_the_hash_is_of_pixels_and_their_order(recorded: Path) -> None:
    places, drawn = EpisodeFiles(recorded, "0000"), RenderedImages(Rollout.of(small(), SEED))
    pictures = Pictures(tuple(PICTURES))
    for frame in range(FRAMES):
        pictures.add(frame, pictures.encode(drawn.render(frame)))
    for part, digest in pictures.digests(FRAMES).items():
        assert digest_of_folder(places, part, FRAMES) == digest
    assert pictures.digests(2) != pictures.digests(3)


def test_a_missing_and_a_broken_picture_are_named(tmp_path: Path) -> None:
    places = EpisodeFiles(tmp_path, "0000")
    with pytest.raises(BadFile, match=r"000000\.png: no such picture; record again"):
        digest_of_folder(places, "images", 1)
    places.pictures("images").mkdir(parents=True)
    places.picture("images", 0).write_text("no picture")
    with pytest.raises(BadFile, match=r"000000\.png: not a picture"):
        digest_of_folder(places, "images", 1)
