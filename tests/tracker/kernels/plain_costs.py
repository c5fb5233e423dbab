"""What pairs cost in plain NumPy."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.costs import GatedPairs, ShapeAndPose
from tracker.geometry import box_area, box_intersection, convex_intersection, wrap_angle


def plain_volume(pairing: GatedPairs) -> Float[Array, " k"]:
    """1 - the share of observed regions that expected ones cover."""
    rows, columns = pairing.pairs
    expected, observed = pairing.expected_regions, pairing.observed_regions
    shared = convex_intersection(expected.footprint()[rows], observed.footprint()[columns])
    share = shared / (observed.size[:, 0] * observed.size[:, 2])[columns]
    return 1.0 - np.minimum(share, 1.0)


def plain_reprojection(pairing: GatedPairs) -> Float[Array, " k"]:
    """1 - the share of boxes inside the search areas."""
    rows, columns = pairing.pairs
    boxes = pairing.boxes_in_image[columns]
    with np.errstate(invalid="ignore"):
        return 1.0 - box_intersection(pairing.search_areas[rows], boxes) / box_area(boxes)


def plain_image_distance(pairing: GatedPairs) -> Float[Array, " k"]:
    """d / (d + diagonal) of the boxes' centres."""
    rows, columns = pairing.pairs
    expected, observed = pairing.expected.boxes[rows], pairing.observed.boxes[columns]
    off = 0.5 * (expected[:, :2] + expected[:, 2:] - observed[:, :2] - observed[:, 2:])
    sides = observed[:, 2:] - observed[:, :2]
    distance = np.hypot(off[:, 0], off[:, 1])
    with np.errstate(invalid="ignore"):
        return distance / (distance + np.hypot(sides[:, 0], sides[:, 1]))


def plain_square_distances(pairing: GatedPairs) -> Float[Array, " k"]:
    """Squared distances of descriptors."""
    rows, columns = pairing.pairs
    assert pairing.expected.embedding is not None
    assert pairing.observed.embedding is not None
    before, now = pairing.expected.embedding.descriptor, pairing.observed.embedding.descriptor
    return ((now[columns] - before[rows]) ** 2).sum(axis=1)


def plain_looks(
    cost: ShapeAndPose, pairing: GatedPairs
) -> tuple[Float[Array, " k"], Float[Array, " k"]]:
    """Squared differences of shape and of pose in units of their variances."""
    rows, columns = pairing.pairs
    assert pairing.expected.shape_pose is not None
    assert pairing.observed.shape_pose is not None
    before = pairing.expected.shape_pose.take(rows)
    now = pairing.observed.shape_pose.take(columns)
    off, cov = now.shape - before.shape, before.cov + now.cov
    shape_cov = cov[:, 1:, 1:] + cost.shape_floor**2 * np.eye(off.shape[1])
    known = np.isfinite(off).all(axis=1) & np.isfinite(cov).all(axis=(1, 2))
    shape = np.full(len(off), np.nan)
    solved = np.linalg.solve(shape_cov[known], off[known][:, :, None])[:, :, 0]
    shape[known] = (off[known] * solved).sum(axis=1)
    angle = wrap_angle(now.yaw - before.yaw)
    return shape, angle**2 / (cov[:, 0, 0] + cost.yaw_floor**2)
