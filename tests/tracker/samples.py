"""What the tests of the tracker share: a camera, made-up beliefs, and short drives."""

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass

import numpy as np

from tracker.beliefs import Beliefs
from tracker.costs import GatedPairs
from tracker.geometry import box_iou, homogeneous, invert, rotation_y, transform
from tracker.types import Camera, Cuboids, Detections, Frame
from tracker.types.embedding import Embedding
from tracker.types.shape_pose import ShapePose

K = np.array([[700.0, 0.0, 620.0], [0.0, 710.0, 187.0], [0.0, 0.0, 1.0]])
IMAGE = (1242, 375)
HEIGHT = 1.65
LEVEL = Camera.mounted(K, IMAGE, HEIGHT)
PITCHED = Camera.mounted(K, IMAGE, HEIGHT, pitch=-0.04, roll=0.02)
CAR = np.array([3.9, 1.5, 1.63])
AWAY = -np.pi / 2  # the yaw of a car that drives away from the camera


def cars(*places: tuple[float, float], yaw: float = AWAY) -> Cuboids:
    """Cars at these (x, z) on the road, all with the same yaw."""
    n = len(places)
    xz = np.array(places, dtype=float).reshape(-1, 2)
    base = np.column_stack((xz[:, 0], np.zeros(n), xz[:, 1]))
    return Cuboids(base, np.full(n, yaw), np.tile(CAR, (n, 1)))


def outlines(cuboids: Cuboids, camera: Camera = LEVEL) -> np.ndarray:
    """The upright boxes around the cuboids, not clipped; all of them in front of the camera."""
    pixels = camera.project(transform(camera.T_cam_road, cuboids.corners()))
    return np.concatenate((pixels.min(axis=1), pixels.max(axis=1)), axis=1)


def beliefs_at(
    *places: tuple[float, float], std: float = 0.5, camera: Camera = LEVEL, yaw: float = AWAY
) -> Beliefs:
    """Beliefs of cars at these (x, z), uncertain by `std` metres, with their outlines as boxes.

    The further apart two of them stand, the more their shapes and their looks differ.
    """
    cuboids = cars(*places, yaw=yaw)
    n = len(cuboids)
    cov = np.zeros((n, 4, 4))
    cov[:, [0, 1], [0, 1]] = std**2
    cov[:, [2, 3], [2, 3]] = 4.0
    boxes = outlines(cuboids, camera) if n else np.zeros((0, 4))
    looks = ShapePose(
        0.05 * cuboids.base[:, ::2], cuboids.yaw, np.tile(0.01 * np.eye(3), (n, 1, 1))
    )
    look = Embedding(0.05 * cuboids.base[:, ::2])
    return Beliefs(cuboids, np.zeros((n, 2)), cov, boxes, looks, look)


def pairing_of(
    expected: Beliefs, observed: Beliefs, sigmas: float = 1.0, camera: Camera = LEVEL
) -> GatedPairs:
    """What a cost receives when these were expected and those observed."""
    detections = Detections(observed.boxes, np.ones(len(observed)))
    return GatedPairs(expected, observed, detections, camera, sigmas)


@dataclass(frozen=True)
class Car:
    """A car in a fixed road frame: where it is at time 0, its yaw and its velocity."""

    x: float
    z: float
    yaw: float = AWAY
    velocity: tuple[float, float] = (0.0, 0.0)

    def place(self, time: float) -> tuple[float, float]:
        """Its (x, z) at a time."""
        return self.x + self.velocity[0] * time, self.z + self.velocity[1] * time

    def at(self, time: float) -> Cuboids:
        """Where the car stands at a time."""
        return cars(self.place(time), yaw=self.yaw)


# Where the ego car is, x, z and turn about road +y (positive: to the right), at a time.
EgoPath = Callable[[float], tuple[float, float, float]]


def standing(time: float) -> tuple[float, float, float]:
    """An ego car that does not move."""
    return 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Drive:
    """Frames of exact boxes, and which car every row of them is."""

    frames: list[Frame]
    cars: list[list[int]]


def drive(
    moving: list[Car],
    ego: EgoPath = standing,
    count: int = 20,
    hidden: Callable[[int, int], bool] = lambda frame, car: False,
    score: Callable[[int, int], float] = lambda frame, car: 0.95,
    rate: float = 10.0,
    know_motion: bool = True,
    camera: Camera = LEVEL,
) -> Drive:
    """What the camera sees of the cars, frame by frame; hidden(frame, car) takes a box away."""
    frames, names, T_world_before = [], [], None
    for index in range(count):
        time = index / rate
        x, z, turn = ego(time)
        T_world_road = homogeneous(rotation_y(turn), np.array([x, 0.0, z]))
        T_world_cam = T_world_road @ camera.T_road_cam
        boxes, scores, rows = [], [], []
        for name, car in enumerate(moving):
            corners_cam = transform(invert(T_world_cam), car.at(time).corners())[0]
            if hidden(index, name) or corners_cam[:, 2].min() < 1.0:
                continue
            pixels = camera.project(corners_cam)
            box = camera.clip_boxes(np.concatenate((pixels.min(axis=0), pixels.max(axis=0))))
            if (box[2:] - box[:2]).min() > 5.0:
                boxes.append(box)
                scores.append(score(index, name))
                rows.append(name)
        motion = None if T_world_before is None else invert(T_world_cam) @ T_world_before
        motion_cov = np.diag([1e-4] * 3 + [1e-7] * 3)
        detections = Detections(np.array(boxes).reshape(-1, 4), np.array(scores))
        frames.append(
            Frame(index, time, detections, motion, None if motion is None else motion_cov)
            if know_motion
            else Frame(index, time, detections)
        )
        names.append(rows)
        T_world_before = T_world_cam
    return Drive(frames, names)


def frames_with(*boxes: list) -> list[Frame]:
    """Frames of these boxes, a tenth of a second apart, from a camera that stands still."""
    return [
        Frame(index, index / 10, Detections.of(rows), None if index == 0 else np.eye(4))
        for index, rows in enumerate(boxes)
    ]


def ids_of(tracker, seen: Drive) -> dict[int, list[int]]:
    """Run the tracker: for each car the ids it had, in the order of frames (no repeats).

    A detection has the id of the row that overlaps it most; other rows are predictions.
    """
    had: dict[int, list[int]] = {}
    for frame, cars in zip(seen.frames, seen.cars, strict=True):
        tracks = tracker.step(frame)
        overlap = box_iou(frame.detections.boxes[:, None], tracks.boxes[None])
        for car, row in zip(cars, overlap, strict=True):
            if len(row) == 0 or row.max() < 0.5:
                continue
            name, ids = int(tracks.ids[row.argmax()]), had.setdefault(car, [])
            if not ids or ids[-1] != name:
                ids.append(name)
    return had


def locked(thing: object) -> object:
    """The same table, array or tuple of them, made read-only: whoever writes into it fails."""
    if isinstance(thing, np.ndarray):
        thing.flags.writeable = False
    elif isinstance(thing, tuple | list):
        for part in thing:
            locked(part)
    elif is_dataclass(thing):
        for field in fields(thing):
            locked(getattr(thing, field.name))
    return thing
