"""Cars as wires."""

from dataclasses import replace

import numpy as np

from mot_sim.report.wireframes import Fitting, Wireframes, draw_wireframes, wires
from mot_sim.simulation.rig import Rig
from tests.mot_sim.report.small import drive
from tracker.shape import KEYPOINTS_36, FittedCars
from tracker.types import Frame, Tracks

CAMERA = Rig.kitti().camera


def test_wires_reach_every_keypoint_but_the_wheels_and_are_the_same_on_both_sides() -> None:
    reached = {number for wire in wires() for number in wire}
    left_out = {KEYPOINTS_36[number] for number in set(range(36)) - reached}
    assert left_out == {f"{side}_{axle}_wheel" for side in ("left", "right")
                        for axle in ("front", "rear")}  # fmt: skip
    assert len(set(wires())) == len(wires()) == 2 * 16 + 8


def test_true_wireframes_lie_in_the_cars_boxes() -> None:
    truth = drive().exact
    cars = Wireframes.true(truth, 4)
    now = truth.select(truth.tracks.frames == 4)
    assert cars.ids.tolist() == now.tracks.ids.tolist()
    for points, shown, box in zip(cars.points, cars.shown, now.amodal_boxes, strict=True):
        inside = (points > box[:2] - 1.5).all(axis=1) & (points < box[2:] + 1.5).all(axis=1)
        assert inside.all()
        assert 3 < shown.sum() < 36


def test_a_fitted_mean_car_appears_where_the_road_says() -> None:
    """The mean car 20 m ahead that drives away: symmetric about its middle, tail towards us."""
    fitting = Fitting()
    cars = replace(
        FittedCars.unknown(1, 5),
        shape=np.zeros((1, 5)),
        yaw=np.array([-np.pi / 2]),
        base=np.array([[2.0, 0.0, 20.0]]),
    )
    (points,) = fitting.project(cars, CAMERA)
    row = {name: number for number, name in enumerate(KEYPOINTS_36)}
    left, right = points[row["left_taillight"]], points[row["right_taillight"]]
    tail = 20.0 + fitting.fit.model.basis.mean[row["left_taillight"], 0]
    middle = CAMERA.K[0, 0] * 2.0 / tail + CAMERA.K[0, 2]
    np.testing.assert_allclose(0.5 * (left[0] + right[0]), middle, atol=0.5)
    assert left[0] < right[0]
    front, rear = points[row["left_front_bumper"]], points[row["left_rear_bumper"]]
    assert front[1] < rear[1]  # what is nearer stands lower in the image


def test_boxes_without_an_image_have_no_wireframe() -> None:
    frame = Frame(0, 0.0, drive().log.at(0))
    rows = drive().truth
    assert not len(Fitting()(frame, drive().camera, rows))
    assert not len(Fitting()(frame, drive().camera, Tracks.empty()))


def test_large_cars_are_wired_on_a_rim_and_tiny_ones_are_not_drawn() -> None:
    points = np.random.default_rng(0).uniform(0.0, 1.0, (1, 36, 2))
    shown = np.ones((1, 36), bool)
    drawn = []
    for size in (90.0, 30.0, 6.0):
        image = np.full((100, 100, 3), 128, np.uint8)
        wireframes = Wireframes(np.array([1]), size * points, shown)
        draw_wireframes(image, wireframes, [(255, 255, 255)])
        drawn.append((int((image > 150).sum()), int((image < 60).sum())))
    assert drawn[0][0] > 0 < drawn[0][1]
    assert drawn[1][0] > 0 == drawn[1][1]
    assert drawn[2] == (0, 0)


def test_points_behind_the_camera_take_their_wires_along() -> None:
    image = np.zeros((100, 100, 3), np.uint8)
    nothing = Wireframes(np.array([1]), np.full((1, 36, 2), np.nan), np.zeros((1, 36), bool))
    draw_wireframes(image, nothing, [(255, 255, 255)])
    assert not image.any()
