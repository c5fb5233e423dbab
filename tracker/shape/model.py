"""A shape prior made ready for fitting: in metres on the road, with visibility and size.

Any `ShapeBasis` with named points becomes a `CarModel`. Which points a car hides itself follows
from where they lie on it, not from what they are called.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.shape.basis import ShapeBasis
from tracker.shape.prior import KEYPOINTS, load_prior

# Length, height, width of the shipped prior's mean car: its body reaches beyond its keypoints,
# by 0.49 +- 0.05 m, 0.115 +- 0.002 m and 0.010 +- 0.002 m over 500 cars of the fleet.
MEAN_SIZE = np.array([4.388, 1.529, 1.786])
DIRECTION_BINS = 72  # directions from which a car is seen, 5 degrees each
# A point counts as half visible when the side, or the front or tail, that it lies on is seen at
# this cosine; it is all or nothing within about SOFT_COSINE of it. From rays cast at the fleet's
# meshes.
SIDE_GRAZING_COSINE = 0.15
END_GRAZING_COSINE = 0.4
SOFT_COSINE = 0.06
END_SHARE = 0.82  # of half the length: points further out belong to the car's front or tail
UPPER_SHARE = 0.55  # of the height: points above it are seen over bonnet and boot


@dataclass(frozen=True, eq=False)
class CarModel:
    """What the fit knows of cars."""

    basis: ShapeBasis
    """Mean car and its variation: metres, `object` frame, origin on the road, `std` known and >
    0."""
    scale_std: float = 0.0
    """How far a car may be from the scale of the basis, std as a share, 0 <= s < 1; 0 where the
    coefficients tell the size. More: less certain sizes."""

    def __post_init__(self) -> None:
        mean, std = self.basis.mean, self.basis.std
        if std is None or not (np.isfinite(std).all() and (std > 0.0).all()):
            raise BadConfig(
                "the shape prior does not tell the deviations of its coefficients: "
                "see tracker.shape.metric"
            )
        if not (-1.0 < mean[:, 1].max() < 0.2 and 2.0 < np.ptp(mean[:, 0]) < 8.0):
            raise BadConfig(
                f"the shape prior's mean car is {np.ptp(mean[:, 0]):.3g} long and its lowest "
                f"point lies at {mean[:, 1].max():.3g}: it must be in metres and stand on the "
                "road at y = 0, see tracker.shape.metric"
            )
        if not 0.0 <= self.scale_std < 1.0:
            raise BadConfig(f"scale_std {self.scale_std:g}: give a fraction from 0 to below 1")

    @cached_property
    def std(self) -> Float[Array, " b"]:
        """The prior's deviations of the coefficients."""
        assert self.basis.std is not None
        return self.basis.std

    @cached_property
    def point_var(self) -> Float[Array, " k"]:
        """How much each point varies between cars, m^2 along one axis."""
        spread = (self.std[:, None, None] * self.basis.vectors) ** 2
        along = spread.sum(axis=(0, 2)) / 3.0
        return along + self.scale_std**2 * (self.basis.mean**2).sum(axis=1) / 3.0

    @cached_property
    def margin(self) -> Float[Array, "3"]:
        """How much longer, higher and wider the body is than its points reach, metres.

        Known for points that the shipped prior has too; otherwise 0.
        """
        if not set(self.basis.points) <= set(KEYPOINTS):
            return np.zeros(3)
        return MEAN_SIZE - extent(load_prior(points=self.basis.points).mean)

    def size(self, lambdas: Float[Array, "n b"], scale: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Length, height, width of cars."""
        return (extent(self.basis.shape(lambdas)) + self.margin) * scale[:, None]

    @cached_property
    def visibility(self) -> Float[Array, "bins k"]:
        """The share of each point that is seen from the middle of each direction's bin.

        Direction 0: from ahead of the car; counted about the `object` frame's +y, so that a
        quarter turn is from its right (-z). No other car stands before it.
        """
        mean = self.basis.mean
        x, height = mean[:, 0] - mean[:, 0].mean(), -mean[:, 1]
        half, top = 0.5 * np.ptp(x), height.max()
        angle = (np.arange(DIRECTION_BINS) + 0.5) * (2.0 * np.pi / DIRECTION_BINS)
        ahead, left = np.cos(angle)[:, None], -np.sin(angle)[:, None]
        side = left * np.sign(mean[:, 2])
        has_end = (np.abs(x) > END_SHARE * half) | (height > UPPER_SHARE * top)
        end = np.where(has_end, ahead * np.sign(x), -1.0)
        excess = np.maximum(side - SIDE_GRAZING_COSINE, end - END_GRAZING_COSINE)
        return 1.0 / (1.0 + np.exp(-excess / SOFT_COSINE))


def extent(points: Float[Array, "*n k 3"]) -> Float[Array, "*n 3"]:
    """How long, high (above the road) and wide points reach."""
    reach = np.ptp(points, axis=-2)
    reach[..., 1] = -points[..., 1].min(axis=-1)
    return reach


def metric(basis: ShapeBasis) -> ShapeBasis:
    """A centred prior in its own scale, such as the authors', in metres and on the road.

    Every axis is stretched and shifted so that the mean car comes nearest to the shipped prior's
    in the points that both have. Deviations that a file does not tell are those that the shipped
    prior's cars have along its vectors. BadConfig with fewer than four points in common.
    """
    shared = [name for name in basis.points if name in KEYPOINTS]
    if len(shared) < 4:
        raise BadConfig(
            f"{len(shared)} of the prior's points are among the {len(KEYPOINTS)} named ones: "
            "at least four are needed to find its scale"
        )
    ours, theirs = load_prior(points=shared), basis.select(shared)
    middle = theirs.mean.mean(axis=0)
    off = theirs.mean - middle
    stretch = (off * ours.mean).sum(axis=0) / (off**2).sum(axis=0)
    mean = (basis.mean - middle) * stretch + ours.mean.mean(axis=0)
    placed = ShapeBasis(basis.points, mean, basis.vectors * stretch, basis.std)
    if basis.std is not None:
        return placed
    assert ours.std is not None
    along = placed.select(shared)
    changes = along.project(along.mean + ours.vectors * ours.std[:, None, None])
    return ShapeBasis(basis.points, mean, placed.vectors, np.sqrt((changes**2).sum(axis=0)))
