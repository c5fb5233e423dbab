"""The boxes against a wrong motion or calibration: each mistake is named, what is right is not."""

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.tracker.samples import IMAGE, LEVEL, Car, K, cars, drive
from tracker import FRAMEWORKS, Camera, Delayed, Detections, Frame, Tracker
from tracker.errors import MotionWarning
from tracker.geometry import homogeneous, invert, rotation_x, rotation_y, transform
from tracker.motion_check import CAUSES, MotionCheck
from tracker.per_class import PerClass, for_kind

FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # between our axes and OpenGL's
# From our axes to a vehicle's: x forward, y left, z up.
VEHICLE = homogeneous(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]))
PARKED = tuple(Car(x + 0.3 * (k % 3), 9.0 * k) for k in range(34) for x in (-5.0, 5.0))
SOON = 60  # frames, in which any tracker has warned for long
Path = Callable[[float], tuple[float, float, float]]


def straight(time: float) -> tuple[float, float, float]:
    """Ten metres a second, straight ahead."""
    return 0.0, 10.0 * time, 0.0


def winding(time: float) -> tuple[float, float, float]:
    """Eight metres a second, right and left."""
    return 3.0 * np.sin(0.4 * time), 8.0 * time, 0.35 * np.sin(0.8 * time)


@cache
def frames_of(
    path: Path, traffic: tuple[Car, ...] = PARKED, nod: float = 0.003, seed: int = 0
) -> list[Frame]:
    """What a nodding camera sees of cars with one yaw; nod: std, radians.

    Boxes are noisy by 2 % of their sides.
    """
    rng = np.random.default_rng(seed)
    frames: list[Frame] = []
    T_before = None
    for index in range(180):
        time = 0.1 * index
        x, z, turn = path(time)
        T_road_cam = LEVEL.T_road_cam @ homogeneous(rotation_x(float(nod * rng.normal())))
        T_world_cam = homogeneous(rotation_y(turn), np.array([x, 0.0, z])) @ T_road_cam
        standing = cars(*(car.place(time) for car in traffic), yaw=traffic[0].yaw)
        corners = transform(invert(T_world_cam), standing.corners())
        depths = corners[..., 2]
        corners = corners[(depths.min(axis=1) > 2.0) & (depths.max(axis=1) < 60.0)]
        pixels = LEVEL.project(corners)
        boxes = np.concatenate((pixels.min(axis=1), pixels.max(axis=1)), axis=1)
        sides = np.tile(boxes[:, 2:] - boxes[:, :2], 2)
        boxes = LEVEL.clip_boxes(boxes + 0.02 * sides * rng.normal(size=boxes.shape))
        boxes = boxes[(boxes[:, 2:] - boxes[:, :2]).min(axis=1) > 8.0]
        motion = None if T_before is None else invert(T_world_cam) @ T_before
        frames.append(Frame(index, time, Detections.of(boxes), motion))
        T_before = T_world_cam
    return frames


def moved(frames: list[Frame], change: Callable[[np.ndarray], np.ndarray]) -> list[Frame]:
    """The frames with every motion changed."""
    Ts = [frame.T_now_before for frame in frames]
    changed = [None if T is None else change(T) for T in Ts]
    return [replace(frame, T_now_before=T) for frame, T in zip(frames, changed, strict=True)]


def shifted(frames: list[Frame], by: int) -> list[Frame]:
    """The frames with the motions of others, so many frames later."""
    Ts = [frame.T_now_before for frame in frames]
    places = np.clip(np.arange(len(frames)) + by, 1, len(frames) - 1)
    return [
        frame if k == 0 else replace(frame, T_now_before=Ts[places[k]])
        for k, frame in enumerate(frames)
    ]


def transposed(frames: list[Frame]) -> list[Frame]:
    """The frames with the motions of poses whose rotations are transposed."""
    T_world_cam, before, changed = np.eye(4), np.eye(4), frames[:1]
    for frame in frames[1:]:
        assert frame.T_now_before is not None
        T_world_cam = T_world_cam @ invert(frame.T_now_before)
        now = homogeneous(T_world_cam[:3, :3].T, T_world_cam[:3, 3])
        changed.append(replace(frame, T_now_before=invert(now) @ before))
        before = now
    return changed


def hundredth(T: np.ndarray) -> np.ndarray:
    """The motion with its translation in another unit."""
    return homogeneous(T[:3, :3], 0.01 * T[:3, 3])


def checked(frames: list[Frame], camera: Camera = LEVEL) -> MotionCheck:
    """The check after the frames."""
    check = MotionCheck()
    for frame in frames:
        check = check.after(frame, frame.T_now_before, frame.found.boxes, camera, 1.5)
    return check


def track(tracker: Tracker | Delayed | PerClass, frames: list[Frame]) -> None:
    """Every step."""
    for frame in frames:
        tracker.step(frame)


def cause_of(frames: list[Frame], camera: Camera = LEVEL) -> str | None:
    """What is said of the frames in the end."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MotionWarning)
        check = checked(frames, camera)
    found = check.verdict(camera, 1.5)
    return None if found is None else found.cause


PATHS = pytest.mark.parametrize("path", [straight, winding])
NODS = pytest.mark.parametrize("nod", [0.0, 0.003], ids=["level", "nodding"])


@PATHS
@NODS
@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_is_said_of_what_is_right(path: Path, nod: float, seed: int) -> None:
    assert cause_of(frames_of(path, nod=nod, seed=seed)) is None


WRONG_MOTION: dict[str, Callable[[list[Frame]], list[Frame]]] = {
    "inverse": lambda frames: moved(frames, invert),
    "opengl": lambda frames: moved(frames, lambda T: FLIP @ T @ FLIP),
    "one frame early": lambda frames: shifted(frames, 1),
    "one frame late": lambda frames: shifted(frames, -1),
    "units": lambda frames: moved(frames, hundredth),
    "vehicle axes": lambda frames: moved(frames, lambda T: VEHICLE @ T @ invert(VEHICLE)),
    "transposed": transposed,
}


@PATHS
@pytest.mark.parametrize("cause", WRONG_MOTION)
def test_a_wrong_motion_is_named(path: Path, cause: str) -> None:
    assert cause_of(WRONG_MOTION[cause](frames_of(path))) == cause


@PATHS
@pytest.mark.parametrize("cause", ["inverse", "opengl"])
def test_without_nods_the_inverse_and_opengl_axes_are_one_and_both_are_named(
    path: Path, cause: str
) -> None:
    assert cause_of(WRONG_MOTION[cause](frames_of(path, nod=0.0))) == "reversed"
    assert "world-to-camera" in CAUSES["reversed"]
    assert "OpenGL" in CAUSES["reversed"]


@PATHS
@pytest.mark.parametrize(
    ("cause", "camera"),
    [
        ("camera height", Camera.mounted(K, IMAGE, 0.5 * 1.65)),
        ("camera height", Camera.mounted(K, IMAGE, 2.0 * 1.65)),
        ("pitch", Camera.mounted(K, IMAGE, 1.65, pitch=np.radians(5.0))),
        ("pitch", Camera.mounted(K, IMAGE, 1.65, pitch=-np.radians(5.0))),
        ("focal length", Camera.mounted(K * [[0.6, 1, 1], [1, 0.6, 1], [1, 1, 1]], IMAGE, 1.65)),
        ("focal length", Camera.mounted(K * [[1.6, 1, 1], [1, 1.6, 1], [1, 1, 1]], IMAGE, 1.65)),
    ],
)
def test_a_wrong_calibration_is_named(path: Path, cause: str, camera: Camera) -> None:
    assert cause_of(frames_of(path), camera) == cause


def test_the_height_and_the_pitch_that_fit_are_told() -> None:
    low, looking_up = Camera.mounted(K, IMAGE, 0.8), Camera.mounted(K, IMAGE, 1.65, 0.1)
    with pytest.warns(MotionWarning, match=r"be 0\.7\d* m high .* about 1\.[67]\d m fits"):
        checked(frames_of(straight), low)
    with pytest.warns(MotionWarning, match=r"about -5\.\d degrees more pitch fit"):
        checked(frames_of(straight), looking_up)


@PATHS
def test_a_leap_is_named_with_its_frame(path: Path) -> None:
    frames = list(frames_of(path))
    T = frames[90].T_now_before
    assert T is not None
    frames[90] = replace(frames[90], T_now_before=homogeneous(t=np.array([3.0, 0, -3.0])) @ T)
    with pytest.warns(MotionWarning, match=r"frame 90: T_now_before leaps by 4\.\d+ m"):
        checked(frames)


def test_a_real_swerve_is_no_leap() -> None:
    """The boxes leap as well: the camera did."""

    def pushed(time: float) -> tuple[float, float, float]:
        return 2.5 * (time > 8.95), 10.0 * time, 0.0

    assert cause_of(frames_of(pushed)) is None


TRAFFIC: dict[str, list[Car]] = {
    "that drives along": [Car(3.5 * k, 15.0 + 9.0 * k, velocity=(0, 10.0)) for k in (-1, 0, 1)],
    "that overtakes": [Car(-3.5, -30.0 * k, velocity=(0, 12.5 + k)) for k in range(8)],
    "that comes towards it": [Car(-4.0, 40.0 * k, velocity=(0, -12.0)) for k in range(12)],
    "that crosses": [Car(-60.0 - 15 * k, 40.0, yaw=0.0, velocity=(8.0, 10.0)) for k in range(9)],
}


@pytest.mark.parametrize("traffic", TRAFFIC)
@NODS
def test_traffic_alone_contradicts_no_motion(traffic: str, nod: float) -> None:
    """Among these, standing still or even driving backwards can predict better."""
    assert cause_of(frames_of(straight, tuple(TRAFFIC[traffic]), nod=nod)) is None


@pytest.mark.parametrize("cause", WRONG_MOTION)
def test_of_a_camera_that_stands_nothing_can_be_said(cause: str) -> None:
    standing = drive(list(PARKED[:12]), count=120).frames
    assert cause_of(WRONG_MOTION[cause](standing)) is None


def test_few_frames_and_frames_without_boxes_or_motion_say_nothing() -> None:
    frames = moved(frames_of(straight)[:SOON], invert)
    assert cause_of(frames[:3]) is None
    assert cause_of([]) is None
    assert cause_of([replace(frame, detections=Detections.empty()) for frame in frames]) is None
    assert cause_of([replace(frame, T_now_before=None) for frame in frames]) is None
    at_once = cause_of([replace(frame, time=1.0) for frame in frames])
    assert at_once in (None, "inverse")  # no time goes by: rotations alone


@pytest.mark.parametrize("framework", ["hungarian", "window", "network_flow"])
def test_every_tracker_warns_once_and_can_be_asked(framework: str) -> None:
    tracker = FRAMEWORKS[framework](Tracker.default(LEVEL))
    with pytest.warns(MotionWarning, match="world-to-camera") as warned:
        track(tracker, moved(frames_of(straight)[:SOON], invert))
    assert len(warned) == 1
    found = tracker.contradiction  # type: ignore[union-attr]
    assert found is not None
    assert found.cause == "inverse"
    tracker.reset()
    assert tracker.contradiction is None  # type: ignore[union-attr]


def test_a_camera_that_looks_sideways_drives_sideways_rightly() -> None:
    """Its translation is that of a vehicle's axes, and the cars pass from side to side."""

    def sideways(time: float) -> tuple[float, float, float]:
        return 10.0 * time, 0.0, 0.0

    cars = tuple(Car(4.0 * k, 9.0 + 2.0 * (k % 3)) for k in range(-6, 60))
    assert cause_of(frames_of(sideways, cars)) is None


@pytest.mark.parametrize("cause", ["inverse", "opengl"])
def test_of_one_car_in_a_second_driving_backwards_is_told(cause: str) -> None:
    frames = frames_of(straight, (Car(-3.0, 30.0, velocity=(0, 5.0)),), nod=0.0)[:13]
    assert cause_of(frames) is None
    assert cause_of(WRONG_MOTION[cause](frames)) == "reversed"


def test_a_camera_that_looks_back_drives_backwards_rightly() -> None:
    def backwards(time: float) -> tuple[float, float, float]:
        return 0.0, 100.0 - 10.0 * time, 0.0

    for around in (PARKED, (*PARKED, Car(0.0, 110.0, velocity=(0, -10.0)))):
        frames = frames_of(backwards, around)
        assert cause_of(frames) is None
        assert cause_of(frames[:13]) is None


def test_trackers_of_several_classes_say_it_once() -> None:
    kinds = "Car", "Cyclist"
    tracker = PerClass({kind: for_kind(Tracker.default(LEVEL), kind) for kind in kinds})
    frames = [
        replace(frame, detections=frame.found.replaced(kinds=np.full(len(frame.found), "Car")))
        for frame in moved(frames_of(straight)[:SOON], invert)
    ]
    assert tracker.contradiction is None
    with pytest.warns(MotionWarning, match="world-to-camera") as warned:
        track(tracker, frames)
    assert len(warned) == 1
    assert tracker.contradiction is not None
    assert tracker.contradiction.cause == "inverse"


def test_a_state_that_is_gone_back_to_knows_nothing_of_later_frames() -> None:
    frames = moved(frames_of(straight)[:SOON], invert)
    tracker = Tracker.default(LEVEL)
    track(tracker, frames[:4])
    before = tracker.state
    with pytest.warns(MotionWarning):
        track(tracker, frames[4:])
    tracker.state = before
    assert tracker.contradiction is None
