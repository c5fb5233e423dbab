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


def draw_detections(image: Image, detections: Detections) -> None:
    """Thin grey boxes; drawn over the tracks' boxes they are the light core of the line."""
    for corners in detections.boxes:
        draw_box(image, corners, DETECTION_COLOUR)


def draw_tracks(image: Image, tracks: Tracks, outlines: bool = True) -> None:
    """Boxes in the colours of their ids, each with its id; the lower ones (nearer) on top.

    outlines: False leaves the ids alone.
    """
    for row in np.argsort(tracks.boxes[:, 3], kind="stable").tolist():
        colour = colour_of_id(int(tracks.ids[row]))
        if outlines:
            draw_box(image, tracks.boxes[row], colour, 3)
        tag(image, str(tracks.ids[row]), tracks.boxes[row], colour)


def draw_areas(image: Image, ids: Int[Array, " n"], areas: Float[Array, "n 4"]) -> None:
    """Search areas: tinted and dashed in the colours of the tracks that are expected there."""
    full = [row for row in range(len(ids)) if (areas[row, 2:] > areas[row, :2]).all()]
    for row in full:
        tint(image, areas[row], colour_of_id(int(ids[row])), AREA_TINT_SHARE)
    for row in full:
        draw_dashed_box(image, areas[row], colour_of_id(int(ids[row])), 1)


def draw_true_boxes(image: Image, found: Tracks, missed: Tracks, neutral: Tracks) -> None:
    """True boxes: white; missed: red, large ones in words; neutral: grey."""
    for corners in neutral.boxes:
        draw_dashed_box(image, corners, NEUTRAL_COLOUR, 1, 3.0)
        if corners[3] - corners[1] >= MIN_TAGGED_NEUTRAL_PIXELS:
            tag(image, "neutral", corners, NEUTRAL_COLOUR, below=True)
    for corners in found.boxes:
        draw_dashed_box(image, corners, TRUE_COLOUR, 1, 4.0)
    for corners in missed.boxes:
        is_large = corners[3] - corners[1] >= MIN_TAGGED_PIXELS
        draw_dashed_box(image, corners, WRONG_COLOUR, 2 if is_large else 1)
        if is_large:
            tag(image, "missed", corners, WRONG_COLOUR, below=True)


def draw_false(image: Image, false: Tracks) -> None:
    """A red cross over every box that is no car's."""
    for left, top, right, bottom in false.boxes:
        draw_line(image, np.array([(left, top), (right, bottom)]), WRONG_COLOUR, 2)
        draw_line(image, np.array([(left, bottom), (right, top)]), WRONG_COLOUR, 2)
        tag(image, "false", np.array([left, top, right, bottom]), WRONG_COLOUR, below=True)


def draw_switch(image: Image, corners: Float[Array, "4"], old: int, new: int, age: int = 0) -> None:
    """A yellow frame around the box of a car that was given a new id `age` frames ago."""
    share = 1.0 - age / SWITCH_FRAMES
    width = max(1, round(5 * share))
    grown = corners + np.array([-4.0, -4.0, 4.0, 4.0])
    draw_box(image, grown, SWITCH_COLOUR, width)
    if age < SWITCH_FRAMES // 2:
        tint(image, corners, SWITCH_COLOUR, 0.35 * share)
    tag(image, f"switch {old} > {new}", grown, SWITCH_COLOUR, below=True)


def tag(
    image: Image, words: str, corners: Float[Array, "4"], colour: Colour, below: bool = False
) -> None:
    """A tag on the upper, or under the lower, left corner of a box, moved into the image."""
    width = text_width(words) + 8
    left = int(np.clip(round(corners[0]) - 1, 0, max(image.shape[1] - width, 0)))
    bottom = round(corners[3]) + 18 if below else round(corners[1])
    bottom = int(np.clip(bottom, 18, image.shape[0] - 1))
    cv2.rectangle(image, (left, bottom - 18), (left + width, bottom), colour, cv2.FILLED)
    draw_text(image, words, (left + 4, bottom - 3), ink_on(colour))


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
