"""What glass and paint mirror: the sky at flat angles, the sun where it meets the eye."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.renderers.surroundings import Sun
from mot_sim.renderers.view import Mesh, Semantic

SKY = np.array([196.0, 208.0, 220.0])
GROUND = 0.3  # of the sky's light, what comes from below the horizon
BRIGHT = 120.0  # grey levels of the sun in a face that mirrors it
# By semantic id: the share of light mirrored straight on, the share more at flat angles, and
# how narrow the sun's image is. The first two are near Fresnel's for glass and clear coat.
SHINE = np.zeros((256, 3))
SHINE[Semantic.CAR] = 0.02, 0.5, 18.0
SHINE[Semantic.GLASS] = 0.16, 0.7, 40.0


def mirrored(
    mesh: Mesh,
    R_road_object: Float[Array, "3 3"],
    eye: Float[Array, "3"],
    sun: Sun,
    faces: Int[Array, " k"],
) -> Float[Array, "k 3"]:
    """The light that faces mirror into the camera, to be added; eye: in the object's frame."""
    straight, flat, narrow = SHINE[mesh.semantics[faces]].T
    view = eye - mesh.corners[faces, 0]
    view /= np.sqrt(np.einsum("ki,ki->k", view, view))[:, None]
    normals = mesh.normals[faces]
    towards = np.einsum("ki,ki->k", normals, view).clip(0.0, 1.0)
    out = 2.0 * towards[:, None] * normals - view
    axes = np.stack((-R_road_object[1], R_road_object.T @ sun.direction), axis=1)
    up, to_sun = (out @ axes).T
    sky = GROUND + (1.0 - GROUND) * np.clip(2.0 * up + 0.35, 0.0, 1.0)
    share = straight + flat * (1.0 - towards) ** 4
    glint = np.where(narrow > 0.0, np.maximum(to_sun, 1e-3) ** narrow, 0.0)
    light = (share * sky)[:, None] * SKY
    light += (BRIGHT * sun.shade * (glint * (narrow > 0.0)))[:, None]
    return light
