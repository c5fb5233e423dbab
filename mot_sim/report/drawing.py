"""Boxes over images: detections, and tracks with their ids."""

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.report.canvas import Image, box, text, text_width
from mot_sim.report.colours import DETECTION, Colour, colour_of_id, ink_on
from tracker.types import Detections, Tracks


def draw_detections(image: Image, detections: Detections) -> None:
    """Thin grey boxes; drawn over the tracks' boxes they are the light core of the line."""
    for corners in detections.boxes:
        box(image, corners, DETECTION)


def draw_tracks(image: Image, tracks: Tracks) -> None:
    """Boxes in the colours of their ids, each with its id; the lower ones (nearer) on top."""
    for row in np.argsort(tracks.boxes[:, 3], kind="stable").tolist():
        colour = colour_of_id(int(tracks.ids[row]))
        box(image, tracks.boxes[row], colour, 3)
        _label(image, str(tracks.ids[row]), tracks.boxes[row], colour)


def _label(image: Image, words: str, corners: Float[Array, "4"], colour: Colour) -> None:
    """A tag on the upper left corner of a box, moved into the image."""
    width = text_width(words) + 8
    left = int(np.clip(round(corners[0]) - 1, 0, image.shape[1] - width))
    bottom = max(round(corners[1]), 18)
    cv2.rectangle(image, (left, bottom - 18), (left + width, bottom), colour, cv2.FILLED)
    text(image, words, (left + 4, bottom - 3), ink_on(colour))
