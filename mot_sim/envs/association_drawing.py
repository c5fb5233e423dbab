"""A picture of a frame of the association environment: who was taken for whom, at which cost."""

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.envs.association_actions import Decision
from mot_sim.plotting.canvas import draw_box, draw_dashed_box
from mot_sim.plotting.colours import DETECTION_COLOUR, WRONG_COLOUR, colour_of_id
from mot_sim.plotting.drawing import Area, plain_ground, tag
from tracker import CostMatrix
from tracker.types import Camera


def draw_association(
    compared: CostMatrix, decision: Decision | None, camera: Camera, words: str
) -> UInt8[Array, "h w 3"]:
    """Predicted boxes dashed, detections by what became of them, under a line of words.

    A matched detection has the colour of its track, with id and cost; a new one id and `new`; a
    rejected one is grey; red is what was refused. decision: None where nothing is decided yet.
    """
    image = plain_ground(camera, words)
    tracks, boxes = compared.tracks, compared.detections.boxes
    for track_id, corners in zip(tracks.ids.tolist(), tracks.beliefs.boxes, strict=True):
        draw_dashed_box(image, corners, colour_of_id(track_id), 1)
    if decision is None:
        for corners in boxes:
            draw_box(image, corners, DETECTION_COLOUR, 2)
        return image
    placed = {
        column: (int(tracks.ids[row]), f"{compared.costs[row, column]:.2f}")
        for row, column in decision.match.pairs.tolist()
    }
    born = decision.match.unmatched_detections.tolist()
    placed |= {
        column: (new, "new") for column, new in zip(born, decision.born_ids.tolist(), strict=True)
    }
    taken: list[Area] = []
    # Near cars, whose boxes end lower, are drawn last.
    for column in np.argsort(boxes[:, 3], kind="stable").tolist():
        corners = boxes[column]
        if column in placed:
            track_id, label = placed[column]
            draw_box(image, corners, colour_of_id(track_id), 2)
            tag(image, f"{track_id}: {label}", corners, colour_of_id(track_id), taken=taken)
        elif decision.refused[column]:
            draw_box(image, corners, WRONG_COLOUR, 2)
            tag(image, "refused", corners, WRONG_COLOUR, below=True, taken=taken)
        else:
            draw_box(image, corners, DETECTION_COLOUR, 1)
    return image
