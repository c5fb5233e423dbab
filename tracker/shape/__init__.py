"""Single-view shape: the deformable car (eq. 1) and the priors it comes from."""

from tracker.shape.basis import ShapeBasis
from tracker.shape.crops import (
    CROP_MARGIN,
    CROP_SIDE,
    cut_crops,
    from_shares,
    to_shares,
    windows_of,
)
from tracker.shape.fit import FittedCars, ShapeFit, no_car_fits
from tracker.shape.keypoints import (
    SHIPPED_HOURGLASS,
    Hourglass,
    SeenKeypoints,
    decode,
    network_input,
)
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
    "CROP_MARGIN",
    "CROP_SIDE",
    "KEYPOINTS",
    "KEYPOINTS_14",
    "KEYPOINTS_36",
    "SHIPPED_HOURGLASS",
    "SHIPPED_PRIOR",
    "CarModel",
    "FittedCars",
    "Hourglass",
    "SeenKeypoints",
    "ShapeBasis",
    "ShapeFit",
    "cut_crops",
    "decode",
    "from_shares",
    "load_prior",
    "metric",
    "network_input",
    "no_car_fits",
    "save_prior",
    "to_shares",
    "windows_of",
]
