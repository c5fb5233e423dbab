"""Keypoints in the image, and why each one is seen or not: a depth test against every layer."""

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array

from mot_sim.simulation.renderers import NO_INSTANCE, Layer, Scan
from mot_sim.simulation.renderers.triangles import NEAR
from mot_sim.simulation.truth.table import KeypointVisibility
from tracker.types import Camera

# How far behind its own car's drawn surface a point may seem to lie and still be on it: metres,
# and besides the slant of a surface over a pixel at grazing angles, in pixels of that depth.
THICKNESS = 0.04
SLANT = 3.0
AROUND = np.array([(du, dv) for dv in (-1, 0, 1) for du in (-1, 0, 1)])


def seen_keypoints(
    points_cam: Float[Array, "n k 3"],
    faces_us: Bool[Array, "n k"],
    ids: Int[Array, " n"],
    scanned: Scan,
    camera: Camera,
) -> tuple[Float[Array, "n k 2"], UInt8[Array, "n k"]]:
    """The pixels of the keypoints of cars, and a `KeypointVisibility` of each.

    faces_us: which points lie on a face of their car that looks at the camera. All others are
    self-occluded, and so are points where their own car, drawn alone, is nearer in all nine pixels
    around; occluded are points at whose pixel another object is seen.
    """
    pixels = camera.project(points_cam)
    depth = points_cam[..., 2]
    width, height = camera.image_size
    nearest = np.floor(np.where(depth[..., None] > NEAR, pixels, -9.0) + 0.5).astype(np.int64)
    inside = ((nearest >= 0) & (nearest < (width, height))).all(axis=2) & (depth > NEAR)
    states = np.full(depth.shape, KeypointVisibility.TRUNCATED, np.uint8)
    layers = {layer.instance: layer for layer in scanned.layers}
    for row, number in enumerate(ids.tolist()):
        here = np.flatnonzero(inside[row])
        u, v = nearest[row, here].T
        shown = scanned.numbers[v, u] + NO_INSTANCE
        others = (shown != number) & (scanned.nearness[v, u] > 0.0)
        state = np.where(others, KeypointVisibility.OCCLUDED, KeypointVisibility.VISIBLE)
        state[~faces_us[row, here]] = KeypointVisibility.SELF_OCCLUDED
        tested = np.flatnonzero(faces_us[row, here])
        if number in layers and len(tested):
            points = nearest[row, here[tested]], depth[row, here[tested]]
            own = behind_itself(layers[number], scanned, *points, camera)
            state[tested[own]] = KeypointVisibility.SELF_OCCLUDED
        states[row, here] = state
    return pixels, states


def behind_itself(
    layer: Layer,
    scanned: Scan,
    pixels: Int[Array, "m 2"],
    depth: Float[Array, " m"],
    camera: Camera,
) -> Bool[Array, " m"]:
    """Which points their own car hides: all that is drawn around them is nearer than they are."""
    left, top, _, _ = layer.box
    rows, columns = layer.nearness.shape
    u, v = (pixels[:, None] + AROUND - (left, top)).transpose(2, 0, 1)
    inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
    nearness = np.zeros(inside.shape, np.float32)
    nearness[inside] = layer.nearness[v[inside], u[inside]]
    drawn = nearness > 0.0
    surface = np.where(drawn, scanned.metres(nearness), 0.0).max(axis=1)
    allowed = THICKNESS + SLANT * depth / camera.K[0, 0]
    return drawn.any(axis=1) & (surface < depth - allowed)
