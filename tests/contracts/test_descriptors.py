"""What every descriptor of the register promises."""

import numpy as np
import pytest

from tests.tracker.samples import locked
from tracker.descriptors import DESCRIPTORS, Descriptor
from tracker.shape import Hourglass

BOXES = np.array([[20.0, 30.0, 99.0, 89.0], [150.0, 40.0, 229.0, 99.0], [300.0, 20.0, 339.0, 49.0]])
PAINTS = ((190, 30, 30), (30, 60, 190), (225, 225, 220))


def street(light: float = 1.0) -> np.ndarray:
    """A grey picture with a car of another paint in each box."""
    image = np.full((130, 400, 3), 110.0)
    image[::7] = 125.0
    for box, paint in zip(BOXES.astype(int).tolist(), PAINTS, strict=True):
        left, top, right, bottom = box
        image[top : bottom + 1, left : right + 1] = paint
        image[top + 3 : (top + bottom) // 2, left + 6 : right - 5] = (45, 55, 60)
    return (light * image).astype(np.uint8)


class Measured:
    """A descriptor with the network that feeds it, if it needs one."""

    def __init__(self, name: str) -> None:
        self.descriptor = DESCRIPTORS[name]()
        self.hourglass = Hourglass.load() if self.descriptor.needs_activations else None

    def __call__(self, image: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        seen = None
        if self.hourglass is not None:
            seen = locked(self.hourglass(np.ascontiguousarray(image[:, :, ::-1]), boxes))
        return self.descriptor(image, boxes, None if seen is None else seen.activations)


@pytest.fixture(scope="module", params=list(DESCRIPTORS))
def measure(request: pytest.FixtureRequest) -> Measured:
    return Measured(request.param)


def test_it_satisfies_the_protocol(measure: Measured) -> None:
    assert isinstance(measure.descriptor, Descriptor)


def test_there_is_a_row_a_box_of_the_stated_length(measure: Measured) -> None:
    for count in (0, 1, 3):
        found = measure(locked(street()), locked(BOXES[:count].copy()))
        assert found.shape == (count, measure.descriptor.length)
        assert np.isfinite(found).all()


def test_a_box_beside_the_image_or_of_one_pixel_gives_nan_and_the_others_stay(measure) -> None:
    nothing = np.array([[500.0, 20.0, 560.0, 60.0], [70.0, 70.0, 71.0, 71.0]])
    mixed = np.concatenate((nothing[:1], BOXES, nothing[1:]))
    found = measure(street(), mixed)
    assert np.isnan(found[[0, 4]]).all()
    np.testing.assert_allclose(found[1:4], measure(street(), BOXES), atol=1e-5)


def test_the_same_picture_gives_the_same_and_the_order_of_boxes_does_not_matter(measure) -> None:
    first = measure(street(), BOXES)
    np.testing.assert_array_equal(measure(street(), BOXES), first)
    np.testing.assert_allclose(measure(street(), BOXES[::-1])[::-1], first, atol=1e-5)


def test_a_car_in_a_jittered_box_and_less_light_is_nearer_to_itself_than_to_others(measure) -> None:
    first = measure(street(), BOXES)
    jitter = np.array([[2.0, -1.0, 1.0, 2.0], [-2.0, 1.0, 2.0, -1.0], [1.0, 1.0, -1.0, 0.0]])
    later = measure(street(0.85), BOXES + jitter)
    distance = np.linalg.norm(first[:, None] - later[None], axis=2)
    np.testing.assert_array_equal(distance.argmin(axis=1), [0, 1, 2])
