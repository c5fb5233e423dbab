"""Activation maps pooled over the box, times learned weights; and the file of the weights."""

from pathlib import Path

import numpy as np
import pytest

from tracker.descriptors import Classical, Learned, Weights, pool_maps, read_training, write_weights
from tracker.descriptors.weights import SHIPPED_WEIGHTS, weights_digest
from tracker.errors import BadWeights, MissingCue
from tracker.shape import Hourglass

RNG = np.random.default_rng(4)
IMAGE = np.zeros((50, 50, 3), np.uint8)
BOXES = np.array([[0.0, 0.0, 20.0, 10.0], [5.0, 5.0, 25.0, 45.0]])


def weights(channels: int = 3, grid: int = 2, length: int = 4) -> Weights:
    """Made-up weights for so many maps."""
    features = channels * grid**2 + Classical().length
    arrays = RNG.normal(size=(features, length)), RNG.normal(size=features)
    return Weights(*(array.astype(np.float32) for array in arrays), grid, "ab" * 32, 0.5)


def maps(*boxes: int, channels: int = 3) -> np.ndarray:
    return RNG.uniform(size=(len(boxes) or 2, channels, 8, 8)).astype(np.float32)


def test_cells_hold_the_means_of_the_maps_over_the_box_alone() -> None:
    """A square box is 1 / 1.15 of its window; the roots of a map are its column numbers."""
    columns = np.tile(np.arange(8, dtype=np.float32) ** 2, (1, 1, 8, 1))
    square = np.array([[10.0, 10.0, 30.0, 30.0]])
    left, right = pool_maps(columns, square, 2)[0].reshape(2, 2)[0]
    start, middle, end = 0.5 - 0.5 / 1.15, 0.5, 0.5 + 0.5 / 1.15

    def mean_between(low: float, high: float) -> float:
        fine = np.linspace(low, high, 20_001)
        return float(np.floor(8 * fine).clip(0, 7).mean())

    assert left == pytest.approx(mean_between(start, middle), abs=1e-3)
    assert right == pytest.approx(mean_between(middle, end), abs=1e-3)
    flat = np.array([[10.0, 18.0, 30.0, 22.0]])
    rows = np.ascontiguousarray(columns.transpose(0, 1, 3, 2))
    upper, lower = pool_maps(rows, flat, 2)[0].reshape(2, 2)[:, 0]
    assert (upper, lower) == (pytest.approx(3.0), pytest.approx(4.0))
    assert not pool_maps(-columns, square, 2).any()


def test_equal_maps_give_equal_cells_and_no_box_no_row() -> None:
    ones = np.ones((2, 3, 8, 8), np.float32)
    np.testing.assert_allclose(pool_maps(ones, BOXES, 4), np.ones((2, 48)), rtol=1e-6)
    assert pool_maps(ones[:0], BOXES[:0], 4).shape == (0, 48)


def test_descriptors_have_the_length_of_one_unit_whatever_the_maps() -> None:
    learned, given = Learned(*weights()), maps()
    found = learned(IMAGE, BOXES, given)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), [2.0, 2.0])
    features = np.concatenate(
        (pool_maps(given, BOXES, 2), Classical(unit=1.0)(IMAGE, BOXES)), axis=1
    )
    by_hand = (features - learned.mean) @ learned.weights
    np.testing.assert_allclose(
        found, 2.0 * by_hand / np.linalg.norm(by_hand, axis=1, keepdims=True), rtol=1e-3, atol=1e-4
    )


def test_a_box_without_activations_has_no_descriptor_even_if_it_has_no_area() -> None:
    learned, given = Learned(*weights()), maps()
    given[1] = np.nan
    point = np.array([BOXES[0], [7.0, 7.0, 7.0, 7.0]])
    found = learned(IMAGE, point, given)
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()


def test_activations_must_be_there_and_of_the_right_network() -> None:
    learned = Learned(*weights())
    with pytest.raises(MissingCue, match="needs the keypoint network's activations"):
        learned(IMAGE, BOXES)
    with pytest.raises(BadWeights, match=r"5 activation maps, the weights .* are for 3"):
        learned(IMAGE, BOXES, maps(channels=5))


def test_the_shipped_weights_are_for_the_shipped_network_and_say_how_they_came_about() -> None:
    assert Learned.load().hourglass == Hourglass.load().sha256
    training = read_training(SHIPPED_WEIGHTS)
    assert {"drives", "options", "cars", "sightings", "versions"} <= training.keys()


def test_weights_come_back_from_their_file_as_they_were(tmp_path: Path) -> None:
    path, given = tmp_path / "w.npz", weights()
    write_weights(path, given, {"seed": 3})
    found = Learned.load(path)
    np.testing.assert_array_equal(found.weights, given.weights)
    np.testing.assert_array_equal(found.mean, given.mean)
    assert (found.grid, found.hourglass, found.unit) == (2, "ab" * 32, 0.5)
    assert read_training(path) == {"seed": 3}


def test_a_file_that_is_missing_damaged_or_another_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.npz"
    with pytest.raises(BadWeights, match=r"w\.npz: no weights"):
        Learned.load(path)
    write_weights(path, weights(), {})
    whole = path.read_bytes()
    for content in (b"", b"no zip at all", whole[: len(whole) // 2], b"\x93NUMPY" + whole):
        path.write_bytes(content)
        with pytest.raises(BadWeights, match="damaged weights"):
            Learned.load(path)
    np.savez(path, weights=np.zeros(3))
    with pytest.raises(BadWeights, match="format is missing"):
        Learned.load(path)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"mean": np.zeros(3, np.float32)}, "no descriptor's"),
        ({"unit": 0.0}, "no descriptor's"),
        ({"weights": np.full((460, 4), np.nan, np.float32)}, "not finite"),
        ({"format": np.array(9)}, "format 9"),
        ({"sha256": np.array("0" * 64)}, "sha256"),
        ({"weights": np.array([{}], object)}, "damaged"),
    ],
    ids=["shapes", "unit", "not finite", "newer", "sha256", "pickle"],
)
def test_content_that_does_not_fit_together_is_refused(tmp_path: Path, change, told) -> None:
    path, given = tmp_path / "w.npz", weights()
    fields = {name: change[name] for name in change if name in given._fields}
    changed = given._replace(**fields)
    if changed.weights.dtype != object:
        write_weights(path, changed, {})
    others = {name: change[name] for name in change if name not in given._fields}
    if others or changed.weights.dtype == object:
        write_weights(path, given, {})
        with np.load(path) as file:
            np.savez(path, **{**file, **others, **(fields if not others else {})})
    with pytest.raises(BadWeights, match=told):
        Learned.load(path)


def test_every_number_changes_the_digest() -> None:
    given = weights()
    other = given.weights.copy()
    other[0, 0] += 1.0
    changed = [given._replace(weights=other), given._replace(grid=3), given._replace(unit=0.6)]
    assert len({weights_digest(each) for each in (given, *changed)}) == 4
