"""Back-projection through the road plane: eq. 2 of Sharma et al., ICRA 2018."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

# A ray must dip at least this far (per metre of its length) below the horizon to meet the road:
# 0.0015 puts the contact of a 1.65 m high camera at 1.1 km, further than any pixel can tell.
MIN_DIP = 1.5e-3


def road_contact(
    pixels: Float[Array, "n 2"],
    K: Float[Array, "3 3"],
    normal: Float[Array, "3"],
    height: float,
) -> Float[Array, "n 3"]:
    """Where rays meet the road `normal . X = height`, in camera coordinates (eq. 2).

    NaN for rays at or above the horizon.
    """
    rays = rays_through(pixels, K)
    dip = rays @ normal
    reach = np.full(len(dip), np.nan)
    np.divide(height, dip, out=reach, where=dip > MIN_DIP)
    return rays * reach[:, None]


def road_contact_jacobian(
    pixels: Float[Array, "n 2"],
    K: Float[Array, "3 3"],
    normal: Float[Array, "3"],
    height: float,
) -> Float[Array, "n 3 4"]:
    """Derivatives of `road_contact` by u, v, the camera's height and its pitch.

    With r = K^-1 x, eq. 2 is X = h r / (n.r), so dX = (h / n.r)(I - r n^T / n.r) dr for a
    pixel, r / (n.r) dh for the height, and -X (dn.r) / (n.r) for the pitch, where looking up
    by d turns the normal by dn = d * (-e_x) x n. NaN where the ray misses the road.
    """
    rays = rays_through(pixels, K)
    dip = rays @ normal
    dip = np.where(dip > MIN_DIP, dip, np.nan)[:, None]
    contact = height * rays / dip
    jacobian = np.empty((len(rays), 3, 4))
    K_inverse = np.linalg.inv(K)
    for column in range(2):
        d_ray = K_inverse[:, column]
        jacobian[:, :, column] = height / dip * d_ray - contact * (d_ray @ normal) / dip
    jacobian[:, :, 2] = rays / dip
    d_normal = np.cross(np.array([-1.0, 0.0, 0.0]), normal)
    jacobian[:, :, 3] = -contact * (rays @ d_normal)[:, None] / dip
    return jacobian


def rays_through(pixels: Float[Array, "n 2"], K: Float[Array, "3 3"]) -> Float[Array, "n 3"]:
    """K^-1 x: the viewing rays with depth 1."""
    K_inverse = np.linalg.inv(K)
    return pixels @ K_inverse[:, :2].T + K_inverse[:, 2]
