"""What of an image lies outside the boxes."""

import numpy as np

from tracker.ego.views import without_boxes


def test_a_box_hides_its_pixels_and_three_around() -> None:
    free = without_boxes(np.array([[10.0, 20.0, 12.0, 21.0]]), (40, 30))
    assert free.shape == (30, 40)
    v, u = np.nonzero(~free)
    assert (u.min(), v.min(), u.max(), v.max()) == (7, 17, 15, 24)


def test_no_boxes_hide_nothing_and_a_box_beyond_the_edge_is_clipped() -> None:
    assert without_boxes(np.zeros((0, 4)), (40, 30)).all()
    assert not without_boxes(np.array([[-50.0, -50.0, 900.0, 900.0]]), (40, 30)).any()


def test_boxes_without_area_or_the_wrong_way_round_hide_nothing() -> None:
    boxes = np.array([[5.0, 5.0, 5.0, 20.0], [30.0, 20.0, 10.0, 5.0]])
    assert without_boxes(boxes, (40, 30)).all()
