"""What glass and paint mirror: the sky at flat angles, the sun where it meets the eye."""

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers.view import Semantic

SKY = np.array([196.0, 208.0, 220.0])
GROUND = 0.3  # of the sky's light, what comes from below the horizon
BRIGHT = 120.0  # grey levels of the sun in a face that mirrors it
# By semantic id: the share of light mirrored straight on, the share more at flat angles, and
# how narrow the sun's image is. The first two are near Fresnel's for glass and clear coat.
SHINE = np.zeros((256, 3))
SHINE[Semantic.CAR] = 0.02, 0.5, 18.0
SHINE[Semantic.GLASS] = 0.16, 0.7, 40.0


def specular_light(
    semantics: UInt8[Array, " k"],
    points: Float[Array, "k 3"],
    normals: Float[Array, "k 3"],
    up: Float[Array, "3"],
    sun: Float[Array, "3"],
    bright: float,
) -> Float[Array, "k 3"]:
    """The light that faces at points mirror into the camera, to be added.

    All in the camera's frame: up and the direction to the sun, unit vectors. bright: of the sun,
    0 to 1.
    """
    straight, flat, narrow = SHINE[semantics].T
    distance = np.sqrt(np.einsum("ki,ki->k", points, points))
    towards = (-np.einsum("ki,ki->k", normals, points) / distance).clip(0.0, 1.0)
    # What is mirrored comes from 2 (n . v) n - v, with v = -point / distance to the eye.
    axes = np.stack((up, sun), axis=1)
    to_up, to_sun = (
        2.0 * towards[:, None] * (normals @ axes) + points @ axes / distance[:, None]
    ).T
    sky = GROUND + (1.0 - GROUND) * np.clip(2.0 * to_up + 0.35, 0.0, 1.0)
    share = straight + flat * (1.0 - towards) ** 4
    glint = np.where(narrow > 0.0, np.maximum(to_sun, 1e-3) ** narrow, 0.0)
    return (share * sky)[:, None] * SKY + (BRIGHT * bright * glint)[:, None]
