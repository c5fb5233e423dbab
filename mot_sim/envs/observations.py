"""Frames as padded arrays, in spaces whose bounds are finite."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from jaxtyping import Float, Shaped
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.types import Camera, Detections, Frame, Tracks

Observation = dict[str, Any]
MAX_MOTION_METRES = 1e3  # metres of the camera's motion between two frames
MAX_ID = 2**31 - 1
NO_ID = -1
MAX_ROWS = 4096


def require_padding(name: str, count: int) -> None:
    """BadConfig for a number of padded rows that is out of range."""
    if not 1 <= count <= MAX_ROWS:
        raise BadConfig(f"{name} is {count}: give 1 to {MAX_ROWS}")


@dataclass(frozen=True)
class ObservationBuilder:
    """How frames of a camera are observed."""

    camera: Camera
    """The camera."""
    image: bool
    """Whether the RGB image is part of the observation."""
    max_detections: int
    """Rows of the padded arrays, 1 to 4096; of more detections those with the highest scores are
    kept."""
    duration: float
    """Length of the longest episode, s."""

    def __post_init__(self) -> None:
        require_padding("max_detections", self.max_detections)

    def space(self) -> spaces.Space[Any]:
        """image (h w 3), boxes (n 4), scores (n), mask (n), odometry (4 4), time (1)."""
        width, height = self.camera.image_size
        found: dict[str, spaces.Space[Any]] = {
            "boxes": box_space(self.camera, self.max_detections),
            "scores": spaces.Box(0.0, 1.0, (self.max_detections,), np.float64),
            "mask": spaces.MultiBinary(self.max_detections),
            "odometry": spaces.Box(-MAX_MOTION_METRES, MAX_MOTION_METRES, (4, 4), np.float64),
            "time": spaces.Box(0.0, self.duration, (1,), np.float64),
        }
        if self.image:
            found["image"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
        return spaces.Dict(found)

    def observe(self, frame: Frame) -> Observation:
        """The padded arrays of a frame, new ones every time.

        odometry: T_now_before, the identity where it is not known.
        """
        detections = surest(frame.found, self.max_detections)
        motion = np.eye(4) if frame.T_now_before is None else frame.T_now_before.copy()
        found: Observation = {
            "boxes": pad_boxes(detections.boxes, self.camera, self.max_detections),
            "scores": pad(detections.scores.clip(0.0, 1.0), self.max_detections),
            "mask": pad(np.ones(len(detections), np.int8), self.max_detections),
            "odometry": motion.clip(-MAX_MOTION_METRES, MAX_MOTION_METRES),
            "time": np.array([frame.time]),
        }
        if self.image:
            found["image"] = frame.image
        return found


def surest(detections: Detections, count: int) -> Detections:
    """The detections with the largest scores, in the order they stand in."""
    if len(detections) <= count:
        return detections
    order = np.argsort(-detections.scores, kind="stable")[:count]
    return detections.select(np.sort(order))


def box_space(camera: Camera, count: int) -> spaces.Box:
    """Boxes up to one image's size outside the image."""
    width, height = camera.image_size
    low = np.tile(np.array([-width, -height] * 2, float), (count, 1))
    high = np.tile(np.array([2.0 * width, 2.0 * height] * 2), (count, 1))
    return spaces.Box(low, high, dtype=np.float64)


def pad_boxes(boxes: Float[Array, "n 4"], camera: Camera, count: int) -> Float[Array, "c 4"]:
    """The boxes inside the bounds of their space, zeros below."""
    width, height = camera.image_size
    size = np.array([width, height, width, height], float)
    return pad(boxes.clip(-size, 2.0 * size), count)


def pad(rows: Shaped[Array, "n *d"], count: int, value: int = 0) -> Shaped[Array, "c *d"]:
    """A new array of `count` rows, the given ones first."""
    padded = np.full((count, *rows.shape[1:]), value, rows.dtype)
    padded[: len(rows)] = rows[:count]
    return padded


def track_space(camera: Camera, count: int) -> spaces.Space[Any]:
    """boxes (n 4), ids (n; -1 where there is none), mask (n)."""
    return spaces.Dict(
        {
            "boxes": box_space(camera, count),
            "ids": spaces.Box(NO_ID, MAX_ID, (count,), np.int64),
            "mask": spaces.MultiBinary(count),
        }
    )


def observe_tracks(tracks: Tracks, camera: Camera, count: int) -> Observation:
    """The rows of one frame, padded; of more than fit the first are observed."""
    return {
        "boxes": pad_boxes(tracks.boxes[:count], camera, count),
        "ids": pad(tracks.ids[:count], count, NO_ID),
        "mask": pad(np.ones(min(len(tracks), count), np.int8), count),
    }
