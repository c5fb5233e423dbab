"""Back-projection through the road plane: eq. 2 of Sharma et al., ICRA 2018.

Eq. 2 is written in the road's own axes (x right, y down along the normal n, z forward, turned
to the camera's place): with rays r = R_road_cam K^-1 x, n . K^-1 x is just r_y. Rays at or above
the horizon (r_y <= 0) never meet the road and give NaN.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

# A ray must dip at least this far (per metre of its length) below the horizon to meet the road:
# 0.0015 puts the contact of a 1.65 m high camera at 1.1 km, further than any pixel can tell.
MIN_DIP = 1.5e-3


def road_contact(rays: Float[Array, "n 3"], height: float) -> Float[Array, "n 3"]:
    """Where rays from the camera meet the road, seen from the camera: X = h r / (n . r), eq. 2."""
    dip = rays[:, 1]
    return rays * (height / np.where(dip > MIN_DIP, dip, np.nan))[:, None]
