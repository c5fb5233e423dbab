"""Marks over images: detections, tracks with their ids, search areas, what the truth says."""

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.plotting.canvas import (
    Image,
    draw_box,
    draw_dashed_box,
    draw_line,
    draw_text,
    text_width,
    tint,
)
from mot_sim.plotting.colours import (
    DETECTION_COLOUR,
    GROUND_COLOUR,
    NEUTRAL_COLOUR,
    PANEL_COLOUR,
    ROAD_LINE_COLOUR,
    SKY_COLOUR,
    SWITCH_COLOUR,
    TRUE_COLOUR,
    WRONG_COLOUR,
    Colour,
    colour_of_id,
    ink_on,
)
from tracker.geometry import transform
from tracker.types import Camera, Detections, Tracks

SWITCH_FRAMES = 6  # frames that a switch is marked for, the first one most
AREA_TINT_SHARE = 0.16
MIN_TAGGED_PIXELS = 28.0  # of height; the words would hide lower cars
MIN_TAGGED_NEUTRAL_PIXELS = 60.0
TAG_PIXELS = 18  # height of a tag
MAX_TAG_STEPS = 4  # tags that may stand one over another beside a box
Area = tuple[int, int, int, int]  # left, top, right, bottom, pixels


def draw_detections(image: Image, detections: Detections) -> None:
    """Thin grey boxes; drawn over the tracks' boxes they are the light core of the line."""
    for corners in detections.boxes:
        draw_box(image, corners, DETECTION_COLOUR)


def draw_tracks(
    image: Image, tracks: Tracks, outlines: bool = True, taken: list[Area] | None = None
) -> None:
    """Boxes in the colours of their ids, each with its id; the lower ones (nearer) on top.

    outlines: False leaves the ids alone. taken: see `tag`.
    """
    taken = [] if taken is None else taken
    rows = np.argsort(tracks.boxes[:, 3], kind="stable").tolist()
    for row in rows if outlines else ():
        draw_box(image, tracks.boxes[row], colour_of_id(int(tracks.ids[row])), 3)
    for row in reversed(rows):  # the tags of distant cars give way
        colour = colour_of_id(int(tracks.ids[row]))
        tag(image, str(tracks.ids[row]), tracks.boxes[row], colour, taken=taken)


def draw_areas(image: Image, ids: Int[Array, " n"], areas: Float[Array, "n 4"]) -> None:
    """Search areas: tinted and dashed in the colours of the tracks that are expected there."""
    full = [row for row in range(len(ids)) if (areas[row, 2:] > areas[row, :2]).all()]
    for row in full:
        tint(image, areas[row], colour_of_id(int(ids[row])), AREA_TINT_SHARE)
    for row in full:
        draw_dashed_box(image, areas[row], colour_of_id(int(ids[row])), 1)


def draw_true_boxes(
    image: Image,
    found: Tracks,
    missed: Tracks,
    neutral: Tracks,
    taken: list[Area] | None = None,
) -> None:
    """True boxes: white; missed: red, large ones in words; neutral: grey. taken: see `tag`."""
    for corners in neutral.boxes:
        draw_dashed_box(image, corners, NEUTRAL_COLOUR, 1, 3.0)
        if corners[3] - corners[1] >= MIN_TAGGED_NEUTRAL_PIXELS:
            tag(image, "neutral", corners, NEUTRAL_COLOUR, below=True, taken=taken)
    for corners in found.boxes:
        draw_dashed_box(image, corners, TRUE_COLOUR, 1, 4.0)
    for corners in missed.boxes:
        is_large = corners[3] - corners[1] >= MIN_TAGGED_PIXELS
        draw_dashed_box(image, corners, WRONG_COLOUR, 2 if is_large else 1)
        if is_large:
            tag(image, "missed", corners, WRONG_COLOUR, below=True, taken=taken)


def draw_false(image: Image, false: Tracks, taken: list[Area] | None = None) -> None:
    """A red cross over every box that is no car's. taken: see `tag`."""
    for left, top, right, bottom in false.boxes:
        draw_line(image, np.array([(left, top), (right, bottom)]), WRONG_COLOUR, 2)
        draw_line(image, np.array([(left, bottom), (right, top)]), WRONG_COLOUR, 2)
        corners = np.array([left, top, right, bottom])
        tag(image, "false", corners, WRONG_COLOUR, below=True, taken=taken)


def draw_switch(
    image: Image,
    corners: Float[Array, "4"],
    old: int,
    new: int,
    age: int = 0,
    taken: list[Area] | None = None,
) -> None:
    """A yellow frame around the box of a car that was given a new id `age` frames ago.

    taken: see `tag`.
    """
    share = 1.0 - age / SWITCH_FRAMES
    width = max(1, round(5 * share))
    grown = corners + np.array([-4.0, -4.0, 4.0, 4.0])
    draw_box(image, grown, SWITCH_COLOUR, width)
    if age < SWITCH_FRAMES // 2:
        tint(image, corners, SWITCH_COLOUR, 0.35 * share)
    tag(image, f"switch {old} > {new}", grown, SWITCH_COLOUR, below=True, taken=taken)


def tag(
    image: Image,
    words: str,
    corners: Float[Array, "4"],
    colour: Colour,
    below: bool = False,
    taken: list[Area] | None = None,
) -> None:
    """A tag on the upper, or under the lower, left corner of a box, moved into the image.

    taken: the places of the tags that stand, to which this one gives way, and is added; None: none.
    """
    taken = [] if taken is None else taken
    places = _tag_places(image, text_width(words) + 8, corners, below)
    place, least = places[0], -1
    for each in places:
        shared = sum(_shared_pixels(each, other) for other in taken)
        if least < 0 or shared < least:
            place, least = each, shared
        if not shared:
            break
    taken.append(place)
    left, top, right, bottom = place
    cv2.rectangle(image, (left, top), (right, bottom), colour, cv2.FILLED)
    draw_text(image, words, (left + 4, bottom - 3), ink_on(colour))


def _tag_places(image: Image, width: int, corners: Float[Array, "4"], below: bool) -> list[Area]:
    """Where a tag may stand, the best place first: at its edge, further away from it, beside it."""
    height, room = image.shape[0], max(image.shape[1] - width, 0)
    edge = round(corners[3]) + TAG_PIXELS if below else round(corners[1])
    away = TAG_PIXELS if below else -TAG_PIXELS
    first, last = round(corners[0]) - 1, round(corners[2]) + 1
    wanted = [
        (start, edge + step * away)
        for step in range(MAX_TAG_STEPS)
        for start in (first, last - width)
    ]
    wanted += [(last, edge), (first - width, edge)]
    found = []
    for start, end in wanted:
        left, bottom = min(max(start, 0), room), min(max(end, TAG_PIXELS), height - 1)
        found.append((left, bottom - TAG_PIXELS, left + width, bottom))
    return found


def _shared_pixels(a: Area, b: Area) -> int:
    """How many pixels two tags share."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    return max(width, 0) * max(min(a[3], b[3]) - max(a[1], b[1]), 0)


def plain_ground(camera: Camera, words: str) -> Image:
    """What stands in for an image that is not there: sky, ground, a road ahead, and a note."""
    width, height = camera.image_size
    image = np.empty((height, width, 3), np.uint8)
    image[:] = SKY_COLOUR
    horizon = np.array([(-4000.0, 0.0, 4000.0), (4000.0, 0.0, 4000.0)])
    left, right = camera.project(transform(camera.T_cam_road, horizon))
    if np.isfinite((left, right)).all():
        below = 3.0 * height
        ground = np.array([left, right, (3.0 * width, below), (-2.0 * width, below)])
        cv2.fillConvexPoly(image, np.round(ground).astype(np.int32), GROUND_COLOUR, cv2.LINE_AA)
        _draw_plain_road(image, camera)
    size = 15
    place = ((width - text_width(words, size)) // 2, 24)
    right = place[0] + text_width(words, size) + 8
    cv2.rectangle(image, (place[0] - 8, 6), (right, 31), PANEL_COLOUR, cv2.FILLED)
    draw_text(image, words, place, TRUE_COLOUR, size)
    return image


def _draw_plain_road(image: Image, camera: Camera) -> None:
    """Lines on the road plane every 10 m across, and every 4 m along."""
    depth = np.array([6.0, 150.0])
    for x in np.arange(-24.0, 25.0, 4.0):
        points = np.stack((np.full(2, x), np.zeros(2), depth), axis=1)
        _road_line(image, camera, points)
    for z in (10.0, 20.0, 30.0, 40.0, 60.0, 80.0):
        _road_line(image, camera, np.array([(-24.0, 0.0, z), (24.0, 0.0, z)]))


def _road_line(image: Image, camera: Camera, points_road: Float[Array, "n 3"]) -> None:
    pixels = camera.project(transform(camera.T_cam_road, points_road))
    if np.isfinite(pixels).all():
        draw_line(image, pixels, ROAD_LINE_COLOUR)
