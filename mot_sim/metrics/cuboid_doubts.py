"""What is likely wrong with cuboids that can be scored: another frame, order or origin."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.metrics.cuboid_errors import CuboidErrors

MIN_ROWS = 20  # that something is named of
FAR_METRES = 15.0  # no camera is off by so much at the median
HALF_HEIGHT = (0.5, 1.1)  # m by which the centre of a car lies above its bottom
MIN_SWAPPED = 1.5  # m by which length and height are off where they are swapped


def doubts_of_cuboids(errors: CuboidErrors) -> list[str]:
    """Sentences about what is likely wrong with the results' cuboids; none for sound ones."""
    known = errors.select(np.isfinite(errors.centre))
    if len(errors) >= MIN_ROWS and not len(known):
        return ["no row that meets a label in the image says where its car stands"]
    if len(known) < MIN_ROWS:
        return []
    found = []
    centre, vertical = _middle(known.centre), _middle(known.vertical)
    if centre > FAR_METRES:
        found.append(
            f"cuboids are {centre:.0f} m off at the median although their boxes meet labels: x y z "
            "are metres in camera 0, x right, y down, z forward"
        )
    elif HALF_HEIGHT[0] < -vertical < HALF_HEIGHT[1]:
        found.append(
            f"cuboids stand {-vertical:.2f} m above the labels, half a car: y is that of the "
            "bottom face, not of the centre"
        )
    length, height = _middle(known.size[:, 0]), _middle(known.size[:, 1])
    if length < -MIN_SWAPPED and height > MIN_SWAPPED:
        found.append(
            f"cuboids are {-length:.1f} m too short and {height:.1f} m too high: columns are h w l"
        )
    return found


def _middle(errors: Float[Array, " n"]) -> float:
    """The median with its sign; NaN where nothing is known."""
    known = errors[np.isfinite(errors)]
    return float(np.median(known)) if len(known) else np.nan
