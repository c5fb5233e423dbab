"""Cars as wires between their keypoints: fitted to images (eq. 1), or as they truly are."""

from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.plotting.canvas import Image, draw_line, tint_polygon
from mot_sim.plotting.colours import Colour, colour_of_id, mix
from mot_sim.report.expectations import BelievedPlaces
from mot_sim.simulation.truth import KeypointVisibility, Truth, project_edges
from tracker.front_end import FrontEnd
from tracker.geometry import rotation_y, transform
from tracker.shape import KEYPOINTS_36, FittedCars, Hourglass, ShapeFit
from tracker.types import Camera, Detections, Frame, Rows, Tracks

# Along one side of a car: over the roof, then back along the sill and over both arches.
SIDE_KEYPOINTS = (
    "front_bumper", "headlight", "windscreen_foot", "roof_front", "roof_rear", "rear_window_foot",
    "taillight", "rear_bumper", "rear_arch_behind", "rear_arch_top_behind", "rear_arch_top_ahead",
    "rear_arch_ahead", "front_arch_behind", "front_arch_top_behind", "front_arch_top_ahead",
    "front_arch_ahead", "front_bumper",
)  # fmt: skip
MIRRORED_KEYPOINTS = (
    "front_bumper", "headlight", "windscreen_foot", "roof_front", "roof_rear", "rear_window_foot",
    "taillight", "rear_bumper",
)  # fmt: skip
DARK_COLOUR: Colour = (16, 18, 22)
FRONT = [0, 3, 7, 4]  # corners of a cuboid's front, around it
FRONT_SHARE = 0.35  # share of a track's colour in it
MIN_WIRED_PIXELS = 14.0  # height of the lowest car that gets wires
MIN_RIMMED_PIXELS = 60.0  # height of the lowest car whose wires get a dark rim


@cache
def wires() -> tuple[tuple[int, int], ...]:
    """Pairs of rows of KEYPOINTS_36 that a wire joins."""
    row = {name: number for number, name in enumerate(KEYPOINTS_36)}
    along = [
        (row[f"{side}_{a}"], row[f"{side}_{b}"])
        for side in ("left", "right")
        for a, b in pairwise(SIDE_KEYPOINTS)
    ]
    return (*along, *((row[f"left_{name}"], row[f"right_{name}"]) for name in MIRRORED_KEYPOINTS))


@dataclass(frozen=True, eq=False)
class Wireframes(Rows):
    """The keypoints of cars in one image: one row per car."""

    ids: Int[Array, " n"]
    """Id of each car."""
    points: Float[Array, "n 36 2"]
    """Its 36 keypoints in the image, px; NaN behind the camera."""
    shown: Bool[Array, "n 36"]
    """Which points the camera sees; of fitted cars all that are not NaN."""

    @classmethod
    def true(cls, truth: Truth, frame: int) -> "Wireframes":
        """The true cars of a frame that have a visible pixel."""
        rows = truth.select((truth.tracks.frames == frame) & (truth.pixels > 0))
        seen = rows.keypoint_states == KeypointVisibility.VISIBLE
        return cls(rows.tracks.ids, rows.keypoints, np.asarray(seen, bool))


@dataclass(frozen=True)
class Fitting:
    """Finds the wireframes of boxes in images: the keypoint network, then shape and pose."""

    fit: ShapeFit = field(default_factory=ShapeFit)
    """Fits shape and pose of a car to its keypoints."""

    @cached_property
    def front_end(self) -> FrontEnd:
        """The shipped network. Raises BadWeights where it is missing."""
        return FrontEnd(Hourglass.load())

    def __call__(self, frame: Frame, camera: Camera, boxes: Tracks) -> Wireframes:
        """The wireframes of the boxes in which a car fits; none without an image."""
        if frame.image is None or not len(boxes):
            return Wireframes(np.zeros(0, np.int64), np.zeros((0, 36, 2)), np.zeros((0, 36), bool))
        asked = replace(frame, detections=Detections(boxes.boxes, np.ones(len(boxes))))
        keypoints = self.front_end(asked, camera).found.keypoints
        assert keypoints is not None
        sides = boxes.boxes[:, 2:] - boxes.boxes[:, :2]
        fitted = self.fit(keypoints, camera, self.front_end.keypoint_share * sides)
        good = np.flatnonzero(fitted.trusted)
        points = self.project(fitted.select(good), camera)
        return Wireframes(boxes.ids[good], points, np.isfinite(points).all(axis=2))

    def project(self, cars: FittedCars, camera: Camera) -> Float[Array, "n 36 2"]:
        """Where the points of fitted cars appear (eq. 1, then the camera)."""
        shapes = self.fit.model.basis.shape(cars.shape)
        turned = [points @ rotation_y(float(yaw)).T for points, yaw in zip(shapes, cars.yaw)]  # noqa: B905
        points_road = np.array(turned).reshape(-1, 36, 3) + cars.base[:, None]
        return camera.project(transform(camera.T_cam_road, points_road))


def draw_wireframes(image: Image, frames: Wireframes, colours: list[Colour]) -> None:
    """The wires, one colour per car, of large cars on a dark rim; dim to hidden points."""
    for points, shown, colour in zip(frames.points, frames.shown, colours, strict=True):
        known = np.isfinite(points).all(axis=1)
        drawn = [(a, b) for a, b in wires() if known[a] and known[b]]
        height = float(np.ptp(points[known, 1])) if drawn else 0.0
        if height < MIN_WIRED_PIXELS:
            continue
        if height > MIN_RIMMED_PIXELS:
            for a, b in drawn:
                draw_line(image, points[[a, b]], DARK_COLOUR, 3)
        for a, b in drawn:
            whole = shown[a] and shown[b]
            draw_line(image, points[[a, b]], colour if whole else mix(colour, DARK_COLOUR, 0.55))


def draw_cuboids(image: Image, places: BelievedPlaces, camera: Camera) -> None:
    """The edges of cuboids in the colours of their ids, their fronts tinted; far ones first."""
    order = np.argsort(-places.cuboids.base[:, 2], kind="stable")
    places = places.select(order)
    fronts = camera.project(transform(camera.T_cam_road, places.cuboids.corners()[:, FRONT]))
    edges = project_edges(places.cuboids, camera)
    for track_id, front, ends in zip(places.ids.tolist(), fronts, edges, strict=True):
        colour = colour_of_id(track_id)
        if np.isfinite(front).all():
            tint_polygon(image, front, colour, FRONT_SHARE)
        lines = np.stack((ends[:12], ends[12:]), axis=1)
        for line in lines[np.isfinite(lines).all(axis=(1, 2))]:
            draw_line(image, line, colour, 2)
