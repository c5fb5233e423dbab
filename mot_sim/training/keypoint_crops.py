"""Crops of rendered cars with their keypoints: made, stored one file per place, and read."""

import io
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.files.array_files import require_size
from mot_sim.files.writing import write_bytes
from mot_sim.simulation.renderers import Rendered, Renderer, find_renderer
from mot_sim.simulation.scenery import post_process
from mot_sim.simulation.truth import Truth, annotate_frame
from mot_sim.training.random_views import (
    VIEWS_PER_PLACE,
    VIEWS_PER_VIEWPOINT,
    Place,
    RandomView,
    random_view,
    viewpoint,
)
from tracker.errors import BadFile, DatasetNotFound
from tracker.shape import CROP_MARGIN, cut_crops, to_shares, windows_of
from tracker.types import Rows

CROP_PIXELS = 96  # sides of a stored crop
CROP_ROOM = 1.5  # side of a stored crop over the network's: room for a detector's errors
ANY_CAR_MARK = 64  # added in `parts`
OWN_CAR_MARK = 128
MAX_CROP_BYTES = 4_000_000_000  # of the crops of one place
MIN_CROP_HEIGHT_PIXELS = 18.0  # of a box, in KITTI's camera
MIN_CROP_VISIBLE_SHARE = 0.25
MAX_TRUNCATION = 0.6
FIRST_HELD_OUT_SEED = 1_000_000  # places from this seed on are for scoring only


@dataclass(frozen=True, eq=False)
class Crops(Rows):
    """One row per car: a square around its box, CROP_ROOM times as wide as the network's crop."""

    images: UInt8[Array, "n s s 3"]
    """BGR images of the squares."""
    parts: UInt8[Array, "n s s"]
    """The `Semantic` of each pixel, plus ANY_CAR_MARK on cars, plus OWN_CAR_MARK on this car."""
    keypoints: Float[Array, "n 36 2"]
    """Keypoints (right, down) as shares of the square's side; NaN behind the camera."""
    states: UInt8[Array, "n 36"]
    """A `KeypointVisibility` per keypoint."""
    boxes: Float[Array, "n 4"]
    """Exact boxes x_min, y_min, x_max, y_max as shares of the square's side."""
    pixels: Float[Array, " n"]
    """Pixels of KITTI's camera along the square's side."""
    distance: Float[Array, " n"]
    """Distance of the car ahead of the camera, metres (z in the road frame)."""
    visible: Float[Array, " n"]
    """Visible share of the car, 0..1."""
    truncation: Float[Array, " n"]
    """Share of the car's box beyond the image, 0..1."""
    yaw: Float[Array, " n"]
    """Yaw of the car about road +y, radians."""


def make_crops(seed: int, views: int = VIEWS_PER_PLACE) -> Crops:
    """The crops of some views of one place; a function of the seed alone."""
    place, renderer = Place.of(seed), find_renderer("raster")
    parts, here = [], viewpoint(place)
    for number in range(views):
        if number and number % VIEWS_PER_VIEWPOINT == 0:
            here = viewpoint(place)
        now = random_view(place, here)
        parts.append(crops_of(now, renderer, place.seed, number))
    return Crops.concatenate(parts)


def crops_of(now: RandomView, renderer: Renderer, seed: int, frame: int) -> Crops:
    """The crops of the cars in a view that are large and visible enough."""
    scenery = now.view.instances
    count = len(now.traffic_state)
    behind = type(scenery)(
        scenery.meshes[count:], scenery.T_cam_object[count:], scenery.ids[count:]
    )
    truth = annotate_frame(now.traffic_state, now.scene_meshes, frame, None, behind).truth
    height = (truth.tracks.boxes[:, 3] - truth.tracks.boxes[:, 1]) / now.finer
    is_clear = (
        (height >= MIN_CROP_HEIGHT_PIXELS)
        & (truth.visible >= MIN_CROP_VISIBLE_SHARE)
        & (truth.truncation <= MAX_TRUNCATION)
    )
    truth = truth.select(is_clear)
    drawn = renderer.render(now.view)
    image = post_process(now.weather, now.view, drawn, seed, frame)
    return crops_from_image(image, drawn, truth, now.finer)


def crops_from_image(
    image: UInt8[Array, "h w 3"], drawn: Rendered, truth: Truth, finer: float
) -> Crops:
    """The squares around the cars of an image (RGB). finer: its resolution over KITTI's."""
    boxes, cuboids = truth.tracks.boxes, truth.tracks.cuboids
    assert cuboids is not None
    windows = windows_of(boxes, margin=CROP_ROOM * CROP_MARGIN)
    corners = to_shares(boxes.reshape(-1, 2, 2), windows).reshape(-1, 4)
    bgr = np.ascontiguousarray(image[:, :, ::-1])
    return Crops(
        images=cut_crops(bgr, windows, CROP_PIXELS),
        parts=cut_parts(drawn, windows, truth.tracks.ids),
        keypoints=to_shares(truth.keypoints, windows),
        states=truth.keypoint_states,
        boxes=corners,
        pixels=windows[:, 2] / finer,
        distance=cuboids.base[:, 2],
        visible=truth.visible,
        truncation=truth.truncation,
        yaw=cuboids.yaw,
    )


def cut_parts(
    drawn: Rendered, windows: Float[Array, "n 3"], ids: Int[Array, " n"]
) -> UInt8[Array, "n s s"]:
    """What each pixel of the squares shows, marked on cars; see `Crops`."""
    marked = drawn.semantics + np.where(drawn.instances >= 0, ANY_CAR_MARK, 0).astype(np.uint8)
    found = np.zeros((len(windows), CROP_PIXELS, CROP_PIXELS), np.uint8)
    for row, (u, v, side) in enumerate(windows.tolist()):
        step = side / CROP_PIXELS
        corner = np.array([u, v]) - 0.5 * side + 0.5 * step
        A = np.array([[step, 0.0, corner[0]], [0.0, step, corner[1]]])
        settings = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
        own = np.where(drawn.instances == ids[row], OWN_CAR_MARK, 0).astype(np.uint8)
        found[row] = cv2.warpAffine(marked + own, A, (CROP_PIXELS, CROP_PIXELS), flags=settings)
    return found


def shard_path(folder: Path, seed: int) -> Path:
    """The file with the crops of a place."""
    return folder / f"crops_{seed:07d}.npz"


def save_crops(crops: Crops, path: Path) -> None:
    """Write crops, as a whole or not at all."""
    held = io.BytesIO()
    np.savez(held, **{column.name: getattr(crops, column.name) for column in fields(crops)})
    write_bytes(path, held.getvalue())


def load_crops(path: Path) -> Crops:
    """Read crops. Raises DatasetNotFound, and BadFile for what `save_crops` did not write."""
    if not path.is_file():
        raise DatasetNotFound(f"no crops at {path}: make them with `mot-sim train-keypoints`")
    try:
        require_size(path, MAX_CROP_BYTES)
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as file:
            columns = [file[column.name] for column in fields(Crops)]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise BadFile(f"{path} holds no crops ({error}): delete it, it is made again") from error
    if len({len(column) for column in columns}) != 1:
        raise BadFile(f"{path}: columns of different lengths: delete it, it is made again")
    return Crops(*columns)


def gather_crops(
    folder: Path, first: int, count: int, tell: Callable[[str, int, int], None] | None = None
) -> Crops:
    """The first `count` crops of the places from seed `first` on; missing places are rendered.

    tell: called with what is done, how much is done, and how much there is.
    """
    parts: list[Crops] = []
    have, seed = 0, first
    while have < count:
        path = shard_path(folder, seed)
        if not path.is_file():
            save_crops(make_crops(seed), path)
        parts.append(load_crops(path))
        have, seed = have + len(parts[-1]), seed + 1
        if tell is not None:
            tell("crops", min(have, count), count)
    return Crops.concatenate(parts).select(slice(0, count))
