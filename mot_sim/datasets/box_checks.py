"""What boxes in files are taken for when they cannot be corners in pixels."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray as Array

from mot_sim.files.text import TextTable

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
