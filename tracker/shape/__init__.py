"""Single-view shape: the deformable car (eq. 1) and the priors it comes from."""

from tracker.shape.basis import ShapeBasis
from tracker.shape.fit import ShapeFit
from tracker.shape.fitted import FittedCars, no_car_fits
from tracker.shape.model import CarModel, metric
from tracker.shape.prior import (
    KEYPOINTS,
    KEYPOINTS_14,
    KEYPOINTS_36,
    SHIPPED_PRIOR,
    load_prior,
    save_prior,
)

__all__ = [
    "KEYPOINTS",
    "KEYPOINTS_14",
    "KEYPOINTS_36",
    "SHIPPED_PRIOR",
    "CarModel",
    "FittedCars",
    "ShapeBasis",
    "ShapeFit",
    "load_prior",
    "metric",
    "no_car_fits",
    "save_prior",
]
