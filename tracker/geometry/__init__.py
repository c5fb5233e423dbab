"""Pure functions on plain arrays: transforms, the road plane, overlaps."""

from tracker.geometry.ground import road_contact
from tracker.geometry.overlap import (
    box_area,
    box_intersection,
    box_iou,
    convex_intersection,
    covered_share,
    polygon_area,
)
from tracker.geometry.transforms import (
    adjoint_of,
    cross_matrix,
    homogeneous,
    invert,
    propagate_covariance,
    rotation_x,
    rotation_y,
    rotation_z,
    transform,
    wrap_angle,
)
from tracker.geometry.validity import covariance_fault, intrinsics_fault, rigid_fault

__all__ = [
    "adjoint_of",
    "box_area",
    "box_intersection",
    "box_iou",
    "convex_intersection",
    "covariance_fault",
    "covered_share",
    "cross_matrix",
    "homogeneous",
    "intrinsics_fault",
    "invert",
    "polygon_area",
    "propagate_covariance",
    "rigid_fault",
    "road_contact",
    "rotation_x",
    "rotation_y",
    "rotation_z",
    "transform",
    "wrap_angle",
]
