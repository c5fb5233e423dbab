"""A picture sheet of fitted wireframes: over rendered cars and over real ones. Look at it.

    python -m benchmarks.shape_sheet OUT.png [--root KITTI --keypoints FOLDER]
        [--annotated FILE --annotated-rows FILE]

Rendered: cars of the fleet with 2 px noise and 30 % of the points missing. Real: hourglass
keypoints (14) of the frames that the tree has images of, and hand-annotated ones (36): a file of
rows in 64 x 64 boxes, and one of `index sequence frame id ...`. Green: the fit. Yellow: the
points that it was given. Red: a fit that is not trusted.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy import ndarray as Array

from benchmarks.shape_real import CROP_CONFIDENCE, CROP_SHARE, yaw_error
from benchmarks.shape_samples import (
    CAMERA,
    SKIN,
    detect,
    draw_cars,
    from_crops,
    hidden,
    real_cars,
)
from mot_sim.datasets import kitti_sequence
from mot_sim.datasets.images import ImageFolder
from mot_sim.plotting import write_image
from mot_sim.report.wireframes import MIRRORED_KEYPOINTS, SIDE_KEYPOINTS
from mot_sim.simulation.cars import load_fleet, topology
from mot_sim.simulation.renderers import Mesh, MeshInstances, Semantic, View, find_renderer
from tracker.geometry import homogeneous, rotation_y
from tracker.shape import (
    KEYPOINTS,
    KEYPOINTS_14,
    KEYPOINTS_36,
    CarModel,
    FittedCars,
    ShapeFit,
    load_prior,
)
from tracker.types import Camera

TILE = (360, 250)  # pixels
COLUMNS = 5
FITTED, DOUBTED, BEHIND, GIVEN = (60, 255, 90), (255, 70, 60), (30, 120, 60), (255, 225, 40)
EDGES = [
    *((f"{side}_{a}", f"{side}_{b}") for side in ("left", "right")
      for a, b in pairwise(SIDE_KEYPOINTS)),
    *((f"left_{name}", f"right_{name}") for name in MIRRORED_KEYPOINTS),
]  # fmt: skip
HUB_RADIUS = 3


@dataclass(frozen=True, eq=False)
class Picture:
    """One fitted car: the image, what was given, and the row of its fit."""

    image: Array
    keypoints: Array
    fitted: FittedCars
    camera: Camera
    words: str


def outline(picture: Picture) -> tuple[Array, Array]:
    """The pixels of all named points of the fitted car, and which of them it hides itself."""
    basis = load_prior(points=KEYPOINTS).first(picture.fitted.shape.shape[1])
    points = basis.shape(picture.fitted.shape)[0]
    T_road_object = homogeneous(rotation_y(float(picture.fitted.yaw[0])), picture.fitted.base[0])
    T_cam_object = picture.camera.T_cam_road @ T_road_object
    uv = picture.camera.project(points @ T_cam_object[:3, :3].T + T_cam_object[:3, 3])
    eye = -T_cam_object[:3, :3].T @ T_cam_object[:3, 3]
    body = load_fleet(basis.size).vertices(picture.fitted.shape)[0]
    return uv, hidden(eye, points * (1.0 + SKIN / 4.0), body[topology().faces])


def tile(picture: Picture) -> Array:
    """The surroundings of a car, magnified, with its wireframe."""
    canvas = np.zeros((TILE[1], TILE[0], 3), np.uint8)
    known = np.isfinite(picture.fitted.yaw[0])
    seen = picture.keypoints[picture.keypoints[:, 2] >= CROP_CONFIDENCE, :2]
    uv, behind = outline(picture) if known else (seen, np.zeros(len(seen), bool))
    points = np.concatenate((uv, seen))
    low, high = points.min(axis=0), points.max(axis=0)
    middle, sides = 0.5 * (low + high), np.maximum((high - low) * 1.35, 30.0)
    scale = float(min(TILE[0] / sides[0], TILE[1] / sides[1]))
    shift = np.array(TILE) / 2.0 - scale * middle
    A = np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]]])
    cv2.warpAffine(picture.image, A, TILE, canvas, cv2.INTER_LINEAR)
    if known:
        colour = FITTED if picture.fitted.trusted[0] else DOUBTED
        draw_wires(canvas, uv * scale + shift, behind, colour)
    for u, v in (seen * scale + shift).round().astype(int).tolist():
        cv2.circle(canvas, (u, v), 4, GIVEN, 1, cv2.LINE_AA)
    cv2.rectangle(canvas, (0, 0), (TILE[0], 19), (0, 0, 0), -1)
    cv2.putText(canvas, picture.words, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (255,) * 3, 1)
    return canvas


def draw_wires(canvas: Array, uv: Array, behind: Array, colour: tuple[int, int, int]) -> None:
    """The edges of the car, those it hides itself darker and first."""
    rows = {name: row for row, name in enumerate(KEYPOINTS)}
    pixels = np.round(uv * 16.0).astype(int)
    edges = [(rows[a], rows[b]) for a, b in EDGES]
    for dark in (True, False):
        for a, b in edges:
            if (behind[a] or behind[b]) == dark:
                ends = tuple(pixels[a].tolist()), tuple(pixels[b].tolist())
                cv2.line(canvas, *ends, BEHIND if dark else colour, 1, cv2.LINE_AA, 4)
    for name in ("left_front_wheel", "left_rear_wheel", "right_front_wheel", "right_rear_wheel"):
        if not behind[rows[name]]:
            place = tuple((uv[rows[name]]).round().astype(int).tolist())
            cv2.circle(canvas, place, HUB_RADIUS, colour, -1, cv2.LINE_AA)


def judged(degrees: float) -> str:
    """How good a fit is, for the heading of its picture."""
    return f"yaw off {degrees:.1f} deg" if np.isfinite(degrees) else "too few points, no fit"


def rendered(count: int, seed: int) -> Iterator[Picture]:
    """Cars of the fleet, drawn one by one."""
    cars, fleet, renderer = draw_cars(count, seed), load_fleet(5), find_renderer("raster")
    keypoints = detect(cars, 2.0, 0.3, seed)
    fitted = ShapeFit()(keypoints, CAMERA)
    error = yaw_error(fitted, cars.cuboids.yaw)
    paints = fleet.sample(seed, np.arange(count)).paints
    for row in range(count):
        car = fleet.car(cars.shape[row])
        semantics = np.full(len(car.faces), Semantic.CAR, np.uint8)
        mesh = Mesh(car.vertices, car.faces, car.colours(paints[row]), semantics)
        T_road_object = homogeneous(
            rotation_y(float(cars.cuboids.yaw[row])), cars.cuboids.base[row]
        )
        instances = MeshInstances(
            (mesh,), (CAMERA.T_cam_road @ T_road_object)[None], np.zeros(1, np.int64)
        )
        image = renderer.render(View(CAMERA, instances)).image
        one = fitted.select(slice(row, row + 1))
        words = f"{cars.cuboids.base[row, 2]:.0f} m, {judged(error[row])}"
        yield Picture(image, keypoints[row], one, CAMERA, words)


def hourglass(root: Path, folder: Path) -> Iterator[Picture]:
    """Real cars with the keypoints of a network, where the tree has the image."""
    fit = ShapeFit(
        CarModel(load_prior(points=KEYPOINTS_14).first(5)), min_confidence=CROP_CONFIDENCE
    )
    for cars in real_cars(folder, root):
        found = ImageFolder.find(root / "training" / "image_02" / cars.sequence.name)
        fitted = fit(cars.keypoints, cars.sequence.camera, CROP_SHARE * cars.sides)
        assert cars.labels.cuboids is not None
        error = yaw_error(fitted, cars.labels.cuboids.yaw)
        for row, frame in enumerate(cars.labels.frames.tolist()):
            if found is not None and frame in found.paths:
                words = f"{cars.sequence.name}/{frame}: {judged(error[row])}"
                one = fitted.select(slice(row, row + 1))
                image = image_of(root, cars.sequence.name, frame)
                yield Picture(image, cars.keypoints[row], one, cars.sequence.camera, words)


def annotated(root: Path, file: Path, rows: Path) -> Iterator[Picture]:
    """Real cars with keypoints that people set, where the tree has the image."""
    crops = np.loadtxt(file).reshape(-1, len(KEYPOINTS_36), 3)
    fit = ShapeFit(CarModel(load_prior().first(5)))
    for crop, row in zip(crops, np.loadtxt(rows), strict=True):
        name, frame, track = f"{int(row[1]):04d}", int(row[2]), int(row[3])
        sequence = kitti_sequence(root, name, detections=None)
        found = ImageFolder.find(root / "training" / "image_02" / name)
        truth = sequence.truth
        if truth is None or found is None or frame not in found.paths:
            continue
        own = truth.select((truth.frames == frame) & (truth.ids == track))
        keypoints = from_crops(crop[None], own.boxes)
        fitted = fit(keypoints, sequence.camera, 0.05 * (own.boxes[:, 2:] - own.boxes[:, :2]))
        assert own.cuboids is not None
        error = yaw_error(fitted, own.cuboids.yaw)[0]
        words = f"{name}/{frame} by hand: {judged(error)}"
        yield Picture(image_of(root, name, frame), keypoints[0], fitted, sequence.camera, words)


def image_of(root: Path, name: str, frame: int) -> Array:
    """A frame of the tree, RGB."""
    folder = ImageFolder.require(root / "training" / "image_02" / name)
    image = cv2.imread(str(folder.paths[frame]), cv2.IMREAD_COLOR)
    assert image is not None
    return np.ascontiguousarray(image[:, :, ::-1])


def sheet(pictures: list[Picture]) -> Array:
    """All pictures in rows."""
    tiles = [tile(picture) for picture in pictures]
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % COLUMNS)
    lines = [np.hstack(tiles[row : row + COLUMNS]) for row in range(0, len(tiles), COLUMNS)]
    return np.vstack(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--cars", type=int, default=20)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--root", type=Path, help="the KITTI tree")
    parser.add_argument("--keypoints", type=Path, help="the folder of hourglass keypoints")
    parser.add_argument("--annotated", type=Path, help="rows of hand-annotated keypoints")
    parser.add_argument("--annotated-rows", type=Path, help="sequence, frame and id of each row")
    given = parser.parse_args()
    pictures = list(rendered(given.cars, given.seed))
    if given.root and given.keypoints:
        pictures += hourglass(given.root, given.keypoints)
    if given.root and given.annotated and given.annotated_rows:
        pictures += list(annotated(given.root, given.annotated, given.annotated_rows))[::3]
    write_image(given.out, sheet(pictures))


if __name__ == "__main__":
    main()
