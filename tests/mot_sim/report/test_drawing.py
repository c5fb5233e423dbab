"""Boxes over images."""

import numpy as np
import pytest

from mot_sim.report import draw_detections, draw_tracks
from mot_sim.report.colours import colour_of_id
from tracker.types import Detections, Tracks


def test_tracks_have_the_colours_of_their_ids() -> None:
    image = np.zeros((375, 1242, 3), np.uint8)
    tracks = Tracks(np.zeros(1, np.int64), np.array([4]), np.array([[100.0, 100, 200, 150]]))
    draw_tracks(image, tracks)
    assert tuple(image[150, 150]) == colour_of_id(4)
    assert not image[120, 150].any()


@pytest.mark.parametrize("corner", [(0.0, 0.0), (1230.0, 360.0)])
def test_labels_stay_in_the_image(corner) -> None:
    image = np.zeros((375, 1242, 3), np.uint8)
    u, v = corner
    tracks = Tracks(np.zeros(1, np.int64), np.array([123]), np.array([[u, v, u + 11.0, v + 14.0]]))
    draw_tracks(image, tracks)
    colour = colour_of_id(123)
    assert (image == colour).all(axis=2).sum() > 200


def test_nothing_detected_and_nobody_tracked_draw_nothing() -> None:
    image = np.zeros((20, 30, 3), np.uint8)
    draw_detections(image, Detections.empty())
    draw_tracks(image, Tracks.empty())
    assert not image.any()
