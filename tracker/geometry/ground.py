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


def road_contact_jacobian(
    rays: Float[Array, "n 3"], contact: Float[Array, "n 3"], d_rays: Float[Array, "3 2"]
) -> Float[Array, "n 2 4"]:
    """Derivatives of a contact's x and z by the pixel's u and v, the camera's height and pitch.

    contact: `road_contact(rays, height)`. d_rays: derivatives of a ray by u and v, R_road_cam
    K^-1 [:, :2]. With X = h r / r_y: dX = h (dr - r / r_y dr_y) / r_y for a pixel and X / h for
    the height. Looking up by d turns the ray by (0, -r_z, r_y) d, which gives (0, h) + X z / h.
    """
    per_height = contact[:, ::2] / contact[:, 1:2]
    jacobian = np.empty((len(rays), 2, 4))
    pixel = d_rays[::2] - per_height[:, :, None] * d_rays[1]
    np.multiply(pixel, (contact[:, 1] / rays[:, 1])[:, None, None], out=jacobian[:, :, :2])
    jacobian[:, :, 2] = per_height
    np.multiply(per_height, contact[:, 2:], out=jacobian[:, :, 3])
    jacobian[:, 1, 3] += contact[:, 1]
    return jacobian
