"""Pictures of cars with their identities."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from mot_sim.simulation.registry import SCENES
from mot_sim.simulation.scenery import WEATHERS
from mot_sim.training.appearance import (
    MIN_HEIGHT_PIXELS,
    MIN_VISIBLE_SHARE,
    CarPicture,
    DescriptorDataset,
    LearningOptions,
    RenderedDrive,
    car_pictures,
    learn_descriptor,
    likelihood_map,
    pair_distances,
    training_drives,
    unit_of,
    unit_of_descriptor,
)
from tracker.descriptors import Classical, Learned, write_weights
from tracker.errors import BadConfig
from tracker.shape import Hourglass

DRIVE = RenderedDrive("gauntlet", 3, ("clear", "dusk"), (0, 4), beside=0.0)


@pytest.fixture(scope="module")
def pictures() -> list[CarPicture]:
    return list(car_pictures(DRIVE))


def test_there_is_a_picture_a_frame_and_weather_with_the_same_cars_in_it(pictures) -> None:
    assert [picture.frame for picture in pictures] == [0, 4, 0, 4]
    assert len(pictures) == DRIVE.pictures
    assert {picture.drive for picture in pictures} == {"gauntlet/3"}
    clear, dusk = pictures[0], pictures[2]
    assert len(set(clear.ids.tolist()) & set(dusk.ids.tolist())) >= 4
    # The camera exposes both alike, and its white balance leaves a part of the evening's colour.
    red, _, blue = (dusk.image.mean(axis=(0, 1)) - clear.image.mean(axis=(0, 1))).tolist()
    assert red - blue > 5.0
    assert np.abs(clear.image.astype(float) - dusk.image).mean() > 5.0


def test_cars_are_large_and_visible_enough_and_boxes_inside_the_image(pictures) -> None:
    for picture in pictures:
        height, width = picture.image.shape[:2]
        assert (picture.visible >= MIN_VISIBLE_SHARE).all()
        assert (picture.boxes[:, 3] - picture.boxes[:, 1] >= MIN_HEIGHT_PIXELS).all()
        assert (picture.boxes >= 0.0).all()
        assert (picture.boxes <= [width - 1, height - 1, width - 1, height - 1]).all()
        assert len(set(picture.ids.tolist())) == len(picture.ids)


def test_boxes_tremble_like_a_detectors_and_by_nothing_when_asked(pictures) -> None:
    drive = replace(DRIVE, weathers=("clear",), frames=(0,))
    (exact,) = car_pictures(drive, edge_std=0.0)
    shared = np.intersect1d(exact.ids, pictures[0].ids)
    rows = [np.searchsorted(picture.ids, shared) for picture in (exact, pictures[0])]
    true, seen = exact.boxes[rows[0]], pictures[0].boxes[rows[1]]
    off = np.abs(seen - true) / np.tile(true[:, 2:] - true[:, :2], 2)
    assert 0.005 < off.mean() < 0.06
    np.testing.assert_array_equal(exact.image, pictures[0].image)


def test_lessons_are_known_scenes_and_weathers_and_not_the_scenes_of_the_benchmark() -> None:
    drives = training_drives()
    assert {drive.scene for drive in drives} <= set(SCENES) - {"look_alikes", "t_junction"}
    assert {weather for drive in drives for weather in drive.weathers} <= set(WEATHERS)
    assert len({drive.name for drive in drives}) == len(drives)
    assert all(drive.seed < 900 for drive in drives)


IMAGE = np.zeros((40, 60, 3), np.uint8)


def picture(drive: str, frame: int, ids: list[int], image: np.ndarray = IMAGE) -> CarPicture:
    """A picture with cars side by side."""
    n = len(ids)
    left = 18.0 * np.arange(n)
    boxes = np.column_stack((left, np.full(n, 5.0), left + 15.0, np.full(n, 30.0)))
    return CarPicture(drive, frame, image, boxes, np.array(ids, dtype=np.int64), np.ones(n))


def dataset(seed: int = 0, within: tuple = (1.0, 0.1, 3.0), between: tuple = (0.0, 1.0, 3.0)):
    """Cars of two drives, six sightings each, with these deviations inside and between cars."""
    rng = np.random.default_rng(seed)
    cars = np.repeat(np.arange(400), 6)
    middle = rng.normal(size=(400, 3)) * between
    middle[200:] += (50.0, 50.0, -50.0)
    vectors = middle[cars] + rng.normal(size=(len(cars), 3)) * within
    return DescriptorDataset(vectors, cars, cars // 200, np.tile(np.arange(6), 400))


def test_the_map_is_that_of_the_likelihood_ratio() -> None:
    """Axes by variance ratio 0, 100 and 1: weights sqrt(r / (1 + r)) in units of the inside std."""
    mean, axes = likelihood_map(dataset(), 3, 1e-9)
    np.testing.assert_allclose(mean, dataset().vectors.mean(axis=0))
    metric = axes @ axes.T
    np.testing.assert_allclose(np.diag(metric), [0.0, 100.0 * 0.99, 0.5 / 9.0], rtol=0.12, atol=0.1)
    assert np.abs(metric - np.diag(np.diag(metric))).max() < 1.5


def test_what_all_of_a_drive_have_in_common_tells_nothing() -> None:
    _, axes = likelihood_map(dataset(between=(0.0, 1.0, 0.0)), 1, 1e-9)
    assert abs(axes[1, 0]) > 50.0 * np.abs(axes[[0, 2], 0]).max()


def test_fewer_features_than_asked_for_give_fewer_numbers() -> None:
    assert likelihood_map(dataset(), 10, 0.1)[1].shape == (3, 3)
    assert likelihood_map(dataset(), 2, 0.1)[1].shape == (3, 2)


def test_at_the_unit_as_many_pairs_of_one_car_are_farther_as_pairs_of_two_are_nearer() -> None:
    given = dataset(within=(1.0, 1.0, 1.0), between=(3.0, 3.0, 3.0))
    unit = unit_of(given)
    same, other = pair_distances(given)
    assert (same > unit).mean() == pytest.approx((other < unit).mean(), abs=2e-3)
    assert 0.01 < (same > unit).mean() < 0.3


def test_pairs_are_of_one_drive_and_of_two_frames_not_far_apart() -> None:
    vectors = np.array([[0.0], [1.0], [10.0], [100.0]])
    given = DescriptorDataset(
        vectors, np.array([1, 1, 2, 3]), np.array([0, 0, 0, 1]), np.array([0, 5, 5, 5])
    )
    same, other = pair_distances(given)
    assert same.tolist() == [1.0]
    assert other.tolist() == [10.0]
    far = DescriptorDataset(vectors, given.cars, given.drives, np.array([0, 50, 0, 0]))
    assert [len(part) for part in pair_distances(far)] == [0, 0]


def test_a_lesson_keeps_only_cars_that_are_seen_again_and_boxes_that_are_described() -> None:
    ids = list(range(10))
    pictures = [picture("a", 0, [*ids, 77]), picture("a", 3, ids), picture("b", 0, ids)]

    def look(one: CarPicture) -> np.ndarray:
        vectors = one.boxes.copy()
        vectors[(one.ids == 4) & (one.frame == 3)] = np.nan
        return vectors

    found = DescriptorDataset.of(pictures, look)
    assert len(found.cars) == 18
    assert not {4, 77} & set(found.cars.tolist())
    assert set(found.drives.tolist()) == {0}
    with pytest.raises(BadConfig, match="2 cars are seen more than once"):
        DescriptorDataset.of([picture("a", 0, [1, 2]), picture("a", 1, [1, 2])], look)
    with pytest.raises(BadConfig, match="no pictures"):
        DescriptorDataset.of([], look)


def painted(drives: int = 2, cars: int = 6, frames: int = 3) -> Iterator[CarPicture]:
    """Pictures of coloured blocks: every car has a paint of its own, the light changes."""
    for drive in range(drives):
        paints = np.random.default_rng(drive).integers(0, 200, (cars, 3))
        for frame in range(frames):
            image = np.full((40, 18 * cars, 3), 100, np.uint8)
            one = picture(str(drive), frame, list(range(cars)), image)
            for (x0, y0, x1, y1), paint in zip(one.boxes.astype(int), paints, strict=True):
                image[y0 + frame : y1, x0:x1] = paint * (1.0 - 0.1 * frame)
                image[y0 + 5 : y0 + 12, x0 + 3 : x1 - 3] = 60
            yield one


def test_weights_of_the_shipped_network_tell_painted_blocks_apart(tmp_path) -> None:
    options = LearningOptions(grid=2, length=16)
    hourglass = Hourglass.load()
    lore = learn_descriptor(painted(), hourglass, options)
    again = learn_descriptor(painted(), hourglass, options)
    np.testing.assert_array_equal(lore.weights.weights, again.weights.weights)
    assert lore.weights.hourglass == hourglass.sha256
    assert lore.equal_error < 0.1
    assert "12 cars, 36 sightings" in lore.summary
    told = lore.provenance([RenderedDrive("street", 1, ("noon",), (0,))], options)
    write_weights(tmp_path / "w.npz", lore.weights, told)
    learned = Learned.load(tmp_path / "w.npz")
    first, second = list(painted(1))[:2]
    vectors = [
        learned(
            one.image, one.boxes, hourglass(one.image[:, :, ::-1].copy(), one.boxes).activations
        )
        for one in (first, second)
    ]
    distance = np.linalg.norm(vectors[0][:, None] - vectors[1], axis=2)
    np.testing.assert_array_equal(distance.argmin(axis=1), np.arange(6))
    assert np.median(np.diag(distance)) < 1.0


def test_the_unit_of_a_descriptor_without_a_network_is_measured_in_its_own_lengths() -> None:
    one = unit_of_descriptor(painted(), Classical(unit=1.0))
    assert 0.0 < one < 2.0
    assert unit_of_descriptor(painted(), Classical(unit=2.0)) == pytest.approx(0.5 * one)


@pytest.mark.parametrize("wrong", [{"grid": 0}, {"length": 0}, {"shrink": 0.0}, {"shrink": 1.5}])
def test_options_outside_their_range_are_refused(wrong: dict) -> None:
    with pytest.raises(BadConfig, match="give 1 or more"):
        LearningOptions(**wrong)
