"""Back-projection through the road plane: eq. 2 of Sharma et al., ICRA 2018.

Rays are K^-1 x, with depth 1 (`Camera.rays`); the road is `normal . X = height` in the camera's
frame. Rays at or above the horizon never meet the road and give NaN.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

# A ray must dip at least this far (per metre of its length) below the horizon to meet the road:
# 0.0015 puts the contact of a 1.65 m high camera at 1.1 km, further than any pixel can tell.
MIN_DIP = 1.5e-3


def road_contact(
    rays: Float[Array, "n 3"], normal: Float[Array, "3"], height: float
) -> Float[Array, "n 3"]:
    """Where rays meet the road, in camera coordinates: X = h r / (n . r), eq. 2."""
    dip = rays @ normal
    return rays * (height / np.where(dip > MIN_DIP, dip, np.nan))[:, None]


def road_contact_jacobian(
    rays: Float[Array, "n 3"],
    K_inverse: Float[Array, "3 3"],
    normal: Float[Array, "3"],
    height: float,
) -> Float[Array, "n 3 4"]:
    """Derivatives of `road_contact` by the pixel's u and v, the camera's height and its pitch.

    With X = h r / (n . r): dX = (h dr - X (n . dr)) / (n . r) for a pixel, r / (n . r) for the
    height, and -X (dn . r) / (n . r) for the pitch, where looking up turns n by -e_x x n.
    """
    dip = rays @ normal
    reach = 1.0 / np.where(dip > MIN_DIP, dip, np.nan)
    per_height = rays * reach[:, None]
    contact = per_height * height
    d_rays = K_inverse[:, :2]
    jacobian = np.empty((len(rays), 3, 4))
    jacobian[:, :, :2] = height * d_rays - contact[:, :, None] * (normal @ d_rays)
    jacobian[:, :, :2] *= reach[:, None, None]
    jacobian[:, :, 2] = per_height
    jacobian[:, :, 3] = (
        contact * ((rays[:, 2] * normal[1] - rays[:, 1] * normal[2]) * reach)[:, None]
    )
    return jacobian
