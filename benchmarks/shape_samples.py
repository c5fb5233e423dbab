"""Cars with keypoints for the benchmarks of shape and pose: drawn from the fleet, and real ones."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.simulation.cars import Fleet, load_fleet
from mot_sim.simulation.rig import Rig
from tracker.geometry import homogeneous, rotation_y
from tracker.types import Camera, Cuboids, Tracks

CAMERA = Rig.kitti().camera
NEAREST, FAREST = 5.0, 30.0
SKIN = 0.04  # metres: a point this near behind a face still lies on it
HIDDEN_CONFIDENCE = 0.08  # the most that a detector gives a point that it does not see
CROP = 64  # pixels: hourglass files count in a box resized to this
# Files of hourglass keypoints: name, sequence, first frame, track id. The two with a row too
# many start at their first frame; the surplus row at the end is left out.
HOURGLASS = (
    ("keypoints_2_90-100_1.txt", "0002", 90, 1),
    ("keypoints_2_95-100_1.txt", "0002", 95, 1),
    ("keypoints_4_40-55_id2.txt", "0004", 40, 2),
    ("keypoints_5_182-190_12.txt", "0005", 182, 12),
    ("keypoints_5_186-190_12.txt", "0005", 186, 12),
    ("keypoints_5_190-230_31.txt", "0005", 190, 31),
    ("keypoints_5_193-200_17.txt", "0005", 193, 17),
    ("keypoints_9_48-62_9.txt", "0009", 48, 9),
    ("keypoints_11_0-40_0.txt", "0011", 0, 0),
)


@dataclass(frozen=True, eq=False)
class DrawnCars:
    """Cars of the fleet: shape (coefficients), cuboids, exact pixels of their keypoints, and
    which of these no part of the car itself and no border hides."""

    shape: Array
    cuboids: Cuboids
    pixels: Array
    visible: Array


def draw_cars(count: int, seed: int, camera: Camera = CAMERA) -> DrawnCars:
    """Cars anywhere in the view from 5 to 30 m, whichever way they face."""
    rng = np.random.default_rng(seed)
    fleet = load_fleet(5)
    shape = fleet.sample(seed, np.arange(count)).coefficients
    z, yaw = rng.uniform(NEAREST, FAREST, count), rng.uniform(-np.pi, np.pi, count)
    half_view = 0.5 * camera.image_size[0] / camera.K[0, 0]
    x = rng.uniform(-0.85, 0.85, count) * half_view * z
    base = np.column_stack((x, np.zeros(count), z))
    return place_cars(fleet, shape, Cuboids(base, yaw, fleet.size(shape)), camera)


def place_cars(fleet: Fleet, shape: Array, cuboids: Cuboids, camera: Camera) -> DrawnCars:
    """What a camera sees of cars, each of them alone."""
    pixels, visible = [], []
    for coefficients, base, yaw in zip(shape, cuboids.base, cuboids.yaw, strict=True):
        car = fleet.car(coefficients)
        assert car.keypoints is not None
        T_cam_object = camera.T_cam_road @ homogeneous(rotation_y(float(yaw)), base)
        points_cam = car.keypoints @ T_cam_object[:3, :3].T + T_cam_object[:3, 3]
        uv = camera.project(points_cam)
        eye = -T_cam_object[:3, :3].T @ T_cam_object[:3, 3]
        inside = ((uv >= 0.0) & (uv <= np.array(camera.image_size) - 1.0)).all(axis=1)
        seen = ~hidden(eye, car.keypoints, car.vertices[car.faces])
        pixels.append(uv)
        visible.append(seen & inside)
    return DrawnCars(shape, cuboids, np.array(pixels), np.array(visible))


def hidden(eye: Array, points: Array, triangles: Array) -> Array:
    """Whether a triangle stands between the eye and each point (Moeller and Trumbore)."""
    rays = points - eye
    rays *= 1.0 - SKIN / np.linalg.norm(rays, axis=1, keepdims=True)
    a, along, across = triangles[:, 0], *(triangles[:, i] - triangles[:, 0] for i in (1, 2))
    normal = np.cross(rays[:, None], across[None])
    volume = (along * normal).sum(axis=-1)
    inverse = 1.0 / np.where(np.abs(volume) > 1e-9, volume, np.inf)
    off = eye - a
    u = (off * normal).sum(axis=-1) * inverse
    turned = np.cross(off, along)
    v = (rays[:, None] * turned).sum(axis=-1) * inverse
    t = (across * turned).sum(axis=-1) * inverse
    return ((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1)).any(axis=1)


def detect(cars: DrawnCars, sigma: float, missing: float, seed: int) -> Array:
    """Keypoints as a detector gives them: u, v, confidence.

    A share of the visible ones is missed. What is not seen lies anywhere in the box, with a
    confidence below HIDDEN_CONFIDENCE; what is seen has 0.9 or more.
    """
    rng = np.random.default_rng(seed)
    seen = cars.visible & (rng.random(cars.visible.shape) >= missing)
    low, high = np.nanmin(cars.pixels, axis=1), np.nanmax(cars.pixels, axis=1)
    anywhere = low[:, None] + rng.random(cars.pixels.shape) * (high - low)[:, None]
    found = cars.pixels + rng.normal(0.0, sigma, cars.pixels.shape)
    uv = np.where(seen[:, :, None], found, anywhere)
    chance = rng.random(seen.shape)
    confidence = np.where(seen, 0.9 + 0.1 * chance, HIDDEN_CONFIDENCE * chance)
    return np.concatenate((uv, confidence[:, :, None]), axis=2)


def scattered_clutter(cars: DrawnCars, seed: int) -> Array:
    """As many confident points as on cars, anywhere in boxes of the same sizes."""
    rng = np.random.default_rng([seed, 1])  # apart from what `detect` draws
    real = detect(cars, 0.0, 0.3, seed)
    low, high = np.nanmin(cars.pixels, axis=1), np.nanmax(cars.pixels, axis=1)
    uv = low[:, None] + rng.random(cars.pixels.shape) * (high - low)[:, None]
    return np.concatenate((uv, real[:, :, 2:]), axis=2)


def imagined_clutter(cars: DrawnCars, share: float, seed: int) -> Array:
    """What looks a little like a car: points of one, each off by a share of the box."""
    rng = np.random.default_rng([seed, 1])  # apart from what `detect` draws
    real = detect(cars, 0.0, 0.3, seed)
    side = np.nanmax(cars.pixels, axis=1) - np.nanmin(cars.pixels, axis=1)
    real[:, :, :2] += rng.normal(0.0, share, cars.pixels.shape) * side[:, None]
    return real


def misplaced_clutter(cars: DrawnCars, seed: int) -> Array:
    """Whole cars where none can stand: exact points, but lifted and widened or shrunk."""
    rng = np.random.default_rng([seed, 1])  # apart from what `detect` draws
    real = detect(cars, 2.0, 0.3, seed)
    middle = np.nanmean(real[:, :, :2], axis=1, keepdims=True)
    stretch = np.exp(rng.uniform(-0.7, 0.7, (len(real), 1, 2)))
    lift = np.array([0.0, 1.0]) * rng.uniform(-120.0, 0.0, (len(real), 1, 1))
    real[:, :, :2] = middle + (real[:, :, :2] - middle) * stretch + lift
    return real


@dataclass(frozen=True, eq=False)
class RealCars:
    """Rows of a file of hourglass keypoints: in image pixels, with the labels of their cars."""

    name: str
    sequence: KittiSequence
    keypoints: Array
    labels: Tracks

    @property
    def sides(self) -> Array:
        """Width and height of the labels' boxes, pixels."""
        return self.labels.boxes[:, 2:] - self.labels.boxes[:, :2]


def real_cars(folder: Path, root: Path) -> Iterator[RealCars]:
    """The hourglass files of a folder, with KITTI's labels."""
    for name, sequence_name, first, track in HOURGLASS:
        words = [
            line.replace(",", " ").split() for line in (folder / name).read_text().splitlines()
        ]
        rows = np.array([[float(word) for word in line] for line in words if line])
        crops = rows.reshape(len(rows), -1, 3)
        sequence = kitti_sequence(root, sequence_name, detections=None)
        truth = sequence.truth
        assert truth is not None
        own = truth.select((truth.ids == track) & (truth.frames >= first))
        own = own.select(own.frames - first < frames_of(name))
        yield RealCars(name, sequence, from_crops(crops[own.frames - first], own.boxes), own)


def frames_of(name: str) -> int:
    """How many frames a file's name says that it has: `keypoints_5_182-190_12` has nine."""
    first, last = name.split("_")[2].split("-")
    return int(last) - int(first) + 1


def from_crops(crops: Array, boxes: Array) -> Array:
    """Keypoints of boxes that were resized to CROP x CROP, in image pixels."""
    keypoints = crops.copy()
    keypoints[:, :, :2] *= (boxes[:, None, 2:] - boxes[:, None, :2]) / CROP
    keypoints[:, :, :2] += boxes[:, None, :2]
    return keypoints
