"""Colours and gradients over a grid."""

import numpy as np
import pytest

from tracker.descriptors import Classical, can_be_cut, patches
from tracker.errors import BadImage

RED, BLUE, WHITE, BLACK = (180, 30, 30), (30, 50, 160), (225, 225, 220), (30, 30, 32)


def street(*cars: tuple[tuple[float, float, float, float], tuple[int, int, int]]) -> np.ndarray:
    """A grey picture with two-part cars: a dark upper half of glass, the paint below it."""
    image = np.full((120, 400, 3), 110, np.uint8)
    image[::7] = 125
    for (left, top, right, bottom), paint in cars:
        x0, y0, x1, y1 = int(left), int(top), int(right), int(bottom)
        image[y0 : y1 + 1, x0 : x1 + 1] = paint
        image[y0 + 3 : (y0 + y1) // 2, x0 + 4 : x1 - 3] = (45, 55, 60)
    return image


NEAR, FAR = (20.0, 30.0, 99.0, 89.0), (150.0, 40.0, 189.0, 69.0)


def distance(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.linalg.norm(first - second))


def described(image: np.ndarray, *boxes: tuple) -> np.ndarray:
    return Classical()(image, np.array(boxes))


@pytest.mark.parametrize("paint", [RED, BLUE, WHITE, BLACK])
def test_a_car_is_itself_at_half_the_size_and_no_car_of_another_paint(paint) -> None:
    large = described(street((NEAR, paint)), NEAR)[0]
    small = described(street((FAR, paint)), FAR)[0]
    for other in {RED, BLUE, WHITE, BLACK} - {paint}:
        assert distance(large, small) < distance(large, described(street((FAR, other)), FAR)[0])


def test_neither_exposure_nor_the_colour_of_the_light_matters_much() -> None:
    image = street((NEAR, RED), (FAR, WHITE))
    noon = described(image, NEAR, FAR)
    dusk = described((image * np.array([0.7, 0.55, 0.4])).astype(np.uint8), NEAR, FAR)
    assert distance(noon[0], dusk[0]) < 0.5 * distance(noon[0], noon[1])
    assert distance(noon[1], dusk[1]) < 0.5 * distance(noon[0], noon[1])


def test_vectors_have_the_length_of_one_unit_and_gradients_their_share() -> None:
    image = street((NEAR, RED))
    found = Classical(gradients=0.3, unit=0.5)(image, np.array([NEAR]))
    assert np.linalg.norm(found) == pytest.approx(2.0)
    per_cell = 8
    assert np.linalg.norm(found[:, -16 * per_cell :]) ** 2 == pytest.approx(0.3 * 4.0)


def test_boxes_without_two_pixels_in_the_image_have_no_descriptor() -> None:
    image = street((NEAR, RED))
    boxes = np.array([(5.0, 5.0, 5.0, 5.0), (500.0, 20.0, 560.0, 60.0), (-20.0, 30.0, 1.0, 60.0),
                      (-20.0, 30.0, 30.0, 60.0)])  # fmt: skip
    np.testing.assert_array_equal(can_be_cut(image, boxes), [False, False, False, True])
    found = Classical()(image, boxes)
    np.testing.assert_array_equal(np.isnan(found).all(axis=1), [True, True, True, False])


def test_a_picture_of_one_colour_gives_finite_numbers() -> None:
    for level in (0, 255):
        flat = np.full((50, 50, 3), level, np.uint8)
        assert np.isfinite(Classical()(flat, np.array([(5.0, 5.0, 40.0, 30.0)]))).all()


def test_a_patch_is_what_is_inside_the_box() -> None:
    image = np.zeros((40, 60, 3), np.uint8)
    image[10:20, 20:36] = (10, 200, 30)
    cut = patches(image, np.array([(20.0, 10.0, 35.0, 19.0)]), 8)
    np.testing.assert_array_equal(cut[0], np.broadcast_to((10, 200, 30), (8, 8, 3)))
    outside = patches(image, np.array([(30.0, 10.0, 45.0, 19.0)]), 8)
    assert (outside[0, :, -2:] == 0).all()
    assert patches(image, np.zeros((0, 4)), 8).shape == (0, 8, 8, 3)


def test_other_images_are_refused_with_the_cure() -> None:
    box = np.array([NEAR])
    for image, told in (
        (np.zeros((50, 50), np.uint8), "COLOR_GRAY2RGB"),
        (np.zeros((50, 50, 3), np.uint16), "divide by 256"),
    ):
        with pytest.raises(BadImage, match=told):
            Classical()(image, box)
