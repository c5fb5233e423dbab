"""The deformable fleet: shape coefficients in, meshes, keypoints and sizes out (eq. 1)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.cars.carshape import PAINTS, CarShape, choose
from mot_sim.simulation.cars.design import BODIES, BODY_SHARES
from mot_sim.simulation.cars.topology import EXTREMES, authors_keypoints, topology, whole
from mot_sim.simulation.random_numbers import normal, uniform
from tracker.errors import BadConfig, UnknownName
from tracker.shape import KEYPOINTS, KEYPOINTS_14

SHIPPED_FLEET = Path(__file__).with_name("fleet.npz")
MAX_COEFFICIENTS = 20  # the most coefficients that a fleet may use
MAX_SIGMAS = 4.0  # shapes further out are no cars any more
MAX_DRAWN_SIGMAS = 2.0  # within a body
MAX_NEAREST_SIGMAS = 3.0
VAN_HEIGHT_METRES = 1.95  # metres: higher than any other car's mean by far
SIZE_SIGMA_METRES = 0.01  # metres: how closely `nearest` follows a size before it stretches
ROWS_14 = [KEYPOINTS.index(name) for name in KEYPOINTS_14]
FLEET_ARRAYS = ("mean", "vectors", "std", "body_means", "body_roots")  # what the file holds


@dataclass(frozen=True, eq=False)
class Components:
    """Mean and principal components of the left halves of cars, and where the bodies lie."""

    mean: Float[Array, "h 3"]
    """Left half of the mean car: points in the `object` frame, metres."""
    vectors: Float[Array, "b h 3"]
    """How a coefficient of 1 moves each of these points, metres; one row per coefficient."""
    std: Float[Array, " b"]
    """Standard deviation of each coefficient over the population."""
    body_means: Float[Array, "m b"]
    """Mean coefficients of every body, in the order of BODIES."""
    body_roots: Float[Array, "m b b"]
    """A root of the covariance of the coefficients of every body, in the order of BODIES."""


@dataclass(frozen=True, eq=False)
class Cars:
    """Cars that were drawn, one row each."""

    coefficients: Float[Array, "n b"]
    """Of eq. 1."""
    bodies: Int[Array, " n"]
    """Number of the body in BODIES."""
    paints: tuple[str, ...]
    """Names of PAINTS."""


@dataclass(frozen=True, eq=False)
class Fleet:
    """All cars that coefficients can describe; what takes many cars works on arrays of any shape.

    Points are in the `object` frame, metres. They are mean + sum lambda_b V_b exactly wherever
    plates, roof and wheels are what reaches furthest, as in every car of the population. Far out,
    where a roof may overhang the tail, the car is shifted along x and y so that the origin stays
    in the middle of the bottom face of its tight box.
    """

    components: Components
    """The mean car and how cars differ from it."""

    @property
    def coefficients(self) -> int:
        """How many coefficients describe a car, B."""
        return len(self.components.std)

    @property
    def std(self) -> Float[Array, " b"]:
        """The standard deviation of each coefficient over the population."""
        return self.components.std

    def halves(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n h 3"]:
        """The left halves of cars (eq. 1)."""
        half = self._linear(coefficients)
        return half - _off_origin(half)[..., None, :]

    def vertices(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n v 3"]:
        """The points of the mesh; its faces are `topology().faces`."""
        return whole(self.halves(coefficients))

    def keypoints(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n 36 3"]:
        """The authors' 36 keypoints in their order."""
        return authors_keypoints(self.halves(coefficients))[..., :36, :]

    def keypoints_14(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n 14 3"]:
        """The 14 keypoints: wheels, lamps, door mirrors, roof corners; left before right."""
        return authors_keypoints(self.halves(coefficients))[..., ROWS_14, :]

    def size(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n 3"]:
        """Length, height, width of the tight boxes around the meshes."""
        half = self._linear(coefficients)
        size = np.ptp(half, axis=-2)
        size[..., 2] = 2.0 * half[..., 2].max(axis=-1)
        return size

    def car(self, coefficients: Float[Array, " b"]) -> CarShape:
        """The car of these coefficients; BadConfig outside the population."""
        self.check(coefficients[None])
        half, shared = self.halves(coefficients), topology()
        points = authors_keypoints(half)
        return CarShape(
            whole(half),
            shared.faces,
            shared.parts,
            shared.pieces,
            points[:36],
            points[ROWS_14],
            coefficients,
            np.ones(3),
        )

    def check(self, coefficients: Float[Array, "n b"]) -> None:
        """Raise BadConfig for coefficients that are no car of this fleet."""
        if coefficients.shape[-1] != self.coefficients:
            raise BadConfig(
                f"{coefficients.shape[-1]} shape coefficients: this fleet takes {self.coefficients}"
            )
        limits = MAX_SIGMAS * self.std
        outside = ~(np.abs(coefficients) <= limits)  # NaN is outside as well
        if outside.any():
            row, column = (int(index[0]) for index in np.nonzero(outside))
            raise BadConfig(
                f"shape coefficient {column} of car {row} is {coefficients[row, column]:g}: "
                f"the population reaches from {-limits[column]:g} to {limits[column]:g} "
                f"({MAX_SIGMAS:g} standard deviations)"
            )

    def sample(self, seed: int, ids: Int[Array, " n"], body: str | None = None) -> Cars:
        """A car for every id: shape, body and paint depend on (seed, id) alone.

        body: all of that body; otherwise the bodies of European streets. Equal ids give equal
        cars; see `look_alike_ids`.
        """
        if body is not None and body not in BODIES:
            raise UnknownName.of("body", body, BODIES)
        frames = np.zeros_like(ids)
        chosen = choose(
            [BODY_SHARES[name] for name in BODIES], uniform(seed, "car body", ids, frames)[:, 0]
        )
        bodies = chosen if body is None else np.full(len(ids), list(BODIES).index(body))
        paints = choose(
            [share for _, share in PAINTS.values()], uniform(seed, "car paint", ids, frames)[:, 0]
        )
        spread = normal(seed, "car shape", ids, frames, MAX_COEFFICIENTS)[:, : self.coefficients]
        names = list(PAINTS)
        return Cars(
            self._near_bodies(bodies, np.clip(spread, -MAX_DRAWN_SIGMAS, MAX_DRAWN_SIGMAS)),
            bodies,
            tuple(names[paint] for paint in paints),
        )

    def nearest(self, size: Float[Array, "3"], body: str | None = None) -> CarShape:
        """The likeliest shape of about this length, height and width, stretched to it exactly.

        body: the likeliest of that body; None: of all cars.
        """
        from scipy.optimize import lsq_linear

        if not (np.isfinite(size).all() and (size > 0.0).all()):
            raise BadConfig(f"car of size {size.tolist()}: give length, height, width > 0")
        if body is not None and body not in BODIES:
            raise UnknownName.of("body", body, BODIES)
        start, root, most = np.zeros(self.coefficients), np.diag(self.std), MAX_NEAREST_SIGMAS
        if body is not None:
            row, most = list(BODIES).index(body), MAX_DRAWN_SIGMAS
            start, root = self.components.body_means[row], self.components.body_roots[row]
        points, axes = EXTREMES
        change = self.components.vectors[:, points, axes].T * np.array([[2.0], [-1.0], [2.0]])
        missing = size - self.size(start)
        found = lsq_linear(  # the unknowns are counted in standard deviations
            np.concatenate((np.eye(self.coefficients), change @ root / SIZE_SIGMA_METRES)),
            np.concatenate((np.zeros(self.coefficients), missing / SIZE_SIGMA_METRES)),
            (-most, most),
        )
        limits = MAX_SIGMAS * self.std
        return self.car(np.clip(start + root @ found.x, -limits, limits)).scaled_to(size)

    def body_of(self, size: Float[Array, "3"], among: Sequence[str] = tuple(BODIES)) -> str:
        """The body whose mean car comes nearest to a length, height and width.

        Whatever is higher than TALL is a van, where that is among them.
        """
        if size[1] > VAN_HEIGHT_METRES and "van" in among:
            return "van"
        rows = [list(BODIES).index(body) for body in among]
        sizes = self.size(self.components.body_means[rows])
        return among[int(np.abs(np.log(sizes / size)).sum(axis=1).argmin())]

    def _linear(self, coefficients: Float[Array, "*n b"]) -> Float[Array, "*n h 3"]:
        """The left halves of cars as eq. 1 gives them."""
        return self.components.mean + np.tensordot(coefficients, self.components.vectors, axes=1)

    def _near_bodies(
        self, bodies: Int[Array, " n"], spread: Float[Array, "n b"]
    ) -> Float[Array, "n b"]:
        """Coefficients around the means of bodies, closer where a car would be out of range."""
        means = self.components.body_means[bodies]
        offsets = np.einsum("nij,nj->ni", self.components.body_roots[bodies], spread)
        rows = np.arange(len(bodies))
        for _ in range(6):
            cars = means[rows] + offsets[rows]
            bad = (np.abs(cars) > MAX_SIGMAS * self.std).any(axis=1)
            bad |= np.abs(_off_origin(self._linear(cars))).max(axis=1) > 1e-6
            rows = rows[bad]
            offsets[rows] *= 0.7
        return np.clip(means + offsets, -MAX_SIGMAS * self.std, MAX_SIGMAS * self.std)


def _off_origin(half: Float[Array, "*n h 3"]) -> Float[Array, "*n 3"]:
    """How far the middle of the bottom face of the tight box lies from the origin."""
    low, high = half.min(axis=-2), half.max(axis=-2)
    off = np.zeros_like(low)
    off[..., 0] = 0.5 * (low[..., 0] + high[..., 0])
    off[..., 1] = high[..., 1]
    return off


@cache
def load_fleet(coefficients: int = 5) -> Fleet:
    """The shipped fleet, its cars described by this number of coefficients (at most 20)."""
    return read_fleet(SHIPPED_FLEET, coefficients)


def read_fleet(path: Path, coefficients: int = 5) -> Fleet:
    """A fleet from a file that `mot_sim.simulation.cars.build` wrote."""
    if not 1 <= coefficients <= MAX_COEFFICIENTS:
        raise BadConfig(f"{coefficients} shape coefficients: give 1 to {MAX_COEFFICIENTS}")
    with np.load(path, allow_pickle=False) as file:
        mean, vectors, std, means, roots = (file[name] for name in FLEET_ARRAYS)
    b = slice(coefficients)
    return Fleet(Components(mean, vectors[b], std[b], means[:, b], roots[:, b, b]))


def look_alike_ids(
    seed: int, ids: Int[Array, " n"], share: float, groups: int = 1
) -> Int[Array, " n"]:
    """The ids to draw cars with so that about a `share` of them look like each other.

    Every car of a group gets the group's id (negative, so no car has it): same shape, same
    paint. The others keep their own.
    """
    if not 0.0 <= share <= 1.0 or groups < 1:
        raise BadConfig(f"look-alikes: share {share:g} in {groups} groups: give 0..1, 1 or more")
    draws = uniform(seed, "look-alikes", ids, np.zeros_like(ids), 2)
    group = -1 - np.minimum((draws[:, 1] * groups).astype(np.int64), groups - 1)
    return np.where(draws[:, 0] < share, group, ids)
