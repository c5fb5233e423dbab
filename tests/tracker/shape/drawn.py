"""Cars of the shipped prior on the road, and their keypoints, for the tests of the fit."""

from dataclasses import dataclass

import numpy as np

from tests.tracker.samples import LEVEL
from tracker.geometry import transform
from tracker.shape import CarModel, load_prior
from tracker.types import Camera

MODEL = CarModel(load_prior().first(5))


@dataclass(frozen=True)
class Drawn:
    """Coefficients, base, yaw, and keypoints with confidence 1 where the car shows them."""

    shape: np.ndarray
    base: np.ndarray
    yaw: np.ndarray
    keypoints: np.ndarray


def placed(points: np.ndarray, base: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Points of cars, `object` frame, in the road frame."""
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack((c * x + s * z, y, c * z - s * x), axis=-1) + base[:, None]


def keypoints_of(
    model: CarModel,
    shape: np.ndarray,
    base: np.ndarray,
    yaw: np.ndarray,
    camera: Camera = LEVEL,
    scale: float = 1.0,
) -> np.ndarray:
    """The exact keypoints of cars, all of them with confidence 1."""
    points = placed(scale * model.basis.shape(shape), base, yaw)
    pixels = camera.project(transform(camera.T_cam_road, points))
    return np.concatenate((pixels, np.ones((*pixels.shape[:2], 1))), axis=2)


def draw(
    n: int,
    seed: int = 0,
    sigma: float = 0.0,
    missing: float = 0.0,
    camera: Camera = LEVEL,
    model: CarModel = MODEL,
    hide: bool = True,
) -> Drawn:
    """Cars from 8 to 30 m; what they hide themselves (by the model) has no confidence."""
    rng = np.random.default_rng(seed)
    shape = np.clip(rng.normal(0.0, 1.0, (n, model.basis.size)), -2, 2) * model.std
    z, yaw = rng.uniform(8.0, 30.0, n), rng.uniform(-np.pi, np.pi, n)
    base = np.column_stack((rng.uniform(-0.5, 0.5, n) * z, np.zeros(n), z))
    keypoints = keypoints_of(model, shape, base, yaw, camera)
    keypoints[:, :, :2] += rng.normal(0.0, sigma, keypoints[:, :, :2].shape)
    seen = rng.random(keypoints.shape[:2]) >= missing
    if hide:
        away = np.arctan2(base[:, 2], -base[:, 0]) - yaw
        rows = np.floor(away * (len(model.visibility) / (2 * np.pi))).astype(int)
        seen &= model.visibility[rows % len(model.visibility)] > 0.5
    keypoints[:, :, 2] = np.where(seen, 1.0, 0.05)
    lost = rng.uniform(0.0, 300.0, keypoints[:, :, :2].shape)
    keypoints[:, :, :2] = np.where(seen[:, :, None], keypoints[:, :, :2], lost)
    return Drawn(shape, base, yaw, keypoints)
