"""Where a camera stands, by the boxes of cars."""

import numpy as np
import pytest

from mot_sim.datasets.camera_estimate import CAR_SIZE, CAR_SIZE_STD, estimate_camera
from mot_sim.datasets.recorded import DetectionLog
from tracker.errors import BadDetections
from tracker.types import Camera, Cuboids, Detections

K = np.array([[700.0, 0.0, 640.0], [0.0, 700.0, 360.0], [0.0, 0.0, 1.0]])
SIZE = (1280, 720)


def cars_seen(camera: Camera, count: int, reach: tuple[float, float], trucks: int) -> DetectionLog:
    """Parked cars, one after another, each in four frames of a camera that comes nearer."""
    rng = np.random.default_rng(1)
    sizes = CAR_SIZE * np.exp(CAR_SIZE_STD * rng.standard_normal((count, 3)))
    sizes[:trucks] = 9.0, 3.3, 2.5
    yaws, sides = rng.uniform(-np.pi, np.pi, count), rng.uniform(-0.2, 0.2, count)
    boxes = []
    for car in range(count):
        for z in np.linspace(*reach, 4):
            base = np.array([[sides[car] * z, 0.0, z]])
            corners = Cuboids(base, yaws[car, None], sizes[car, None]).corners()[0]
            T = camera.T_cam_road
            pixels = camera.project(corners @ T[:3, :3].T + T[:3, 3])
            box = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
            boxes.append(box + rng.normal(0.0, 0.5, 4))
    found = Detections(np.array(boxes), np.full(len(boxes), 0.9))
    # between two cars nothing is seen for a second
    frames = np.repeat(np.arange(count) * 14, 4) + np.tile(np.arange(4), count)
    return DetectionLog.of(frames, found)


@pytest.mark.parametrize(
    ("height", "pitch_deg", "roll_deg", "reach"),
    [(1.3, 2.0, -1.0, (30.0, 10.0)), (9.0, -60.0, 0.0, (7.0, 4.0))],
)
def test_a_camera_is_found_by_the_cars_that_it_sees(
    height: float, pitch_deg: float, roll_deg: float, reach: tuple[float, float]
) -> None:
    camera = Camera.mounted(K, SIZE, height, *np.radians([pitch_deg, roll_deg]))
    found = estimate_camera([cars_seen(camera, 60, reach, trucks=4)], K, SIZE)
    assert found.car_count > 50
    assert found.camera.height == pytest.approx(height, rel=0.04)
    assert abs(found.camera.height - height) < found.half_widths[0] < 0.12 * height
    assert np.degrees(found.pitch) == pytest.approx(pitch_deg, abs=0.6)
    assert np.degrees(found.roll) == pytest.approx(roll_deg, abs=0.6)


def test_too_few_cars_are_refused_with_the_number_needed() -> None:
    log = cars_seen(Camera.mounted(K, SIZE, 1.3), 5, (30.0, 10.0), trucks=0)
    with pytest.raises(BadDetections, match="5 cars of which a whole box was seen; at least 12"):
        estimate_camera([log], K, SIZE)
    with pytest.raises(BadDetections, match="0 cars"):
        estimate_camera([], K, SIZE)
