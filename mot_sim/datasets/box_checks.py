"""What boxes in files are taken for when they cannot be corners in pixels."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from mot_sim.files.text import TextTable

# KITTI's columns of a cuboid: metres, in camera 0, and the heading about its y, rad.
CUBOID_COLUMNS = ("h", "w", "l", "x", "y", "z", "rotation_y")
# No detector means a car that lies in the image's first pixel; shares of the image end here.
MOST_NORMALISED = 1.5


def refuse_normalised(table: TextTable, boxes: Float[Array, "n 4"], columns: Sequence[str]) -> None:
    """Raise BadFile when all boxes lie within 0..1: shares of the image, not pixels."""
    has_area = (boxes[:, 2:] > boxes[:, :2]).all()
    if len(boxes) and has_area and (np.abs(boxes) <= MOST_NORMALISED).all():
        table.reject(
            np.ones(len(boxes), bool),
            f"all {len(boxes)} boxes lie within 0..1: normalised boxes?",
            columns,
            "give pixels: multiply x by the image's width, y by its height",
        )


def inverted_cure(inverted: Bool[Array, " n"], layout: str) -> str:
    """What to do about boxes whose second corner is not below and right of the first."""
    share = f"{np.count_nonzero(inverted)} of {len(inverted)} rows are so"
    if "width" in layout:
        return f"{share}; columns are {layout}: widths and heights are positive"
    return f"{share}; columns are {layout}: were left, top, width, height written?"


def require_cuboid_rows(
    table: TextTable, rows: Float[Array, "n 7"], chosen: Bool[Array, " n"]
) -> None:
    """Raise BadFile for cuboids without a size, or wholly behind the camera, in chosen rows.

    rows: the table's CUBOID_COLUMNS.
    """
    flat = chosen & np.asarray((rows[:, :3] <= 0.0).any(axis=1))
    cure = "write metres above 0, or -1 -1 -1 where the size is not known"
    table.reject(flat, "a size that is not positive", CUBOID_COLUMNS[:3], cure)
    behind = chosen & (rows[:, 5] + 0.5 * np.hypot(rows[:, 1], rows[:, 2]) <= 0.0)
    cure = "the box is in the image; z is metres ahead of camera 0, x right, y down"
    table.reject(behind, "a cuboid wholly behind the camera", ["z"], cure)
