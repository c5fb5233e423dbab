"""Who the cars of a run are: which shape, paint and class stands behind each id."""

from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.simulation.cars.carshape import CarShape, paint_colour
from mot_sim.simulation.cars.design import BODIES
from mot_sim.simulation.cars.fleet import Cars, Fleet, load_fleet, look_alike_ids
from mot_sim.simulation.traffic.recording import RecordedTraffic
from tracker.errors import BadConfig, UnknownName
from tracker.kernels import Kernel
from tracker.types import Rows

LOOK_AT_EYES = Kernel("mot_sim.simulation.kernels.layers", "look_at_eyes")

VAN_BODY = "van"
ON_FACE_METRES = 1e-4  # metres
VAN_MODEL = 1 << 40  # the id that parked vans are drawn with; no car has it


@dataclass(frozen=True, eq=False)
class Vehicles(Rows):
    """One row for each car of a run, by ascending id."""

    ids: Int[Array, " n"]
    """Id of the car, as in the traffic."""
    kinds: Shaped[Array, " n"]
    """KITTI's class: 'Car' or 'Van'."""
    bodies: Shaped[Array, " n"]
    """Names of BODIES."""
    paints: Shaped[Array, " n"]
    """Names of PAINTS."""
    coefficients: Float[Array, "n b"]
    """Of eq. 1."""
    size: Float[Array, "n 3"]
    """Length, height, width, metres; the shape of the coefficients is stretched to it, by nothing
    where the traffic took its sizes from the shapes."""

    @classmethod
    def empty(cls, coefficients: int = 5) -> "Vehicles":
        """No vehicle."""
        words = np.zeros(0, "<U9")
        return cls(
            np.zeros(0, np.int64),
            words,
            words,
            words,
            np.zeros((0, coefficients)),
            np.zeros((0, 3)),
        )

    def rows(self, ids: Int[Array, " m"]) -> Int[Array, " m"]:
        """The rows of some ids."""
        return np.searchsorted(self.ids, ids)

    @cached_property
    def shapes(self) -> tuple[CarShape, ...]:
        """The car of each row."""
        fleet = load_fleet(self.coefficients.shape[1])
        return tuple(
            fleet.car(row).scaled_to(size)
            for row, size in zip(self.coefficients, self.size, strict=True)
        )

    @cached_property
    def skins(self) -> Float[Array, "n p 4"]:
        """Around each keypoint, the planes of the faces it lies on: unit normals away from the
        car, and how far along them from the origin; see `keypoint_faces`."""
        faces = np.concatenate(keypoint_faces())
        planes = np.zeros((len(self), len(faces), 4))
        for row, shape in enumerate(self.shapes):
            a, b, c = shape.vertices[shape.faces[faces]].swapaxes(0, 1)
            planes[row, :, :3] = np.cross(b - a, c - a)
            planes[row, :, :3] /= np.linalg.norm(planes[row, :, :3], axis=1, keepdims=True)
            planes[row, :, 3] = (planes[row, :, :3] * a).sum(axis=1)
        return planes

    def faces_eye(self, rows: Int[Array, " m"], eyes: Float[Array, "m 3"]) -> Bool[Array, "m 36"]:
        """Which keypoints of some cars lie on a face that looks at a point of the object frame."""
        starts = face_starts()
        facing = np.empty((len(rows), len(starts) - 1), bool)
        LOOK_AT_EYES(self.skins, rows, np.ascontiguousarray(eyes, float), starts, facing)
        return facing

    @cached_property
    def keypoints(self) -> Float[Array, "n 36 3"]:
        """The keypoints of each car in its object frame, metres."""
        points = [shape.keypoints for shape in self.shapes if shape.keypoints is not None]
        return np.array(points).reshape(-1, 36, 3)


@cache
def keypoint_faces() -> tuple[Int[Array, " f"], ...]:
    """For each keypoint the faces of the fleet's mesh that it lies on, or is a corner of."""
    from trimesh.triangles import closest_point

    fleet = load_fleet(1)
    mean = fleet.car(np.zeros(1))
    corners = mean.vertices[mean.faces]
    assert mean.keypoints is not None
    found = []
    for point in mean.keypoints:
        nearest = closest_point(corners, np.tile(point, (len(corners), 1)))  # type: ignore[no-untyped-call]
        found.append(np.flatnonzero(np.linalg.norm(nearest - point, axis=1) < ON_FACE_METRES))
    return tuple(found)


@cache
def face_starts() -> Int[Array, "37"]:
    """Where the faces of each keypoint begin, laid one after the other, and the last ones end."""
    return np.cumsum([0, *(len(faces) for faces in keypoint_faces())])


@dataclass(frozen=True, eq=False)
class Models:
    """The shapes that a run's cars are taken from, one row each."""

    cars: Cars
    """Shape, body and paint of each model."""
    groups: Int[Array, " m"]
    """The negative id of the group of models that look alike, or the model's own number."""
    size: Float[Array, "m 3"]
    """Length, height, width of each model, metres."""
    van: Cars
    """The one model of parked vans."""
    van_size: tuple[float, float, float]
    """Its length, height, width, metres."""


@dataclass(frozen=True)
class VehicleSampler:
    """How cars are chosen: a number of models (shapes) is drawn, and every car is one of them."""

    models: int = 24
    """Number of models, >= 1; more: fewer cars share a shape."""
    body: str | None = None
    """Body of all cars, one of BODIES; None: drawn as on European streets."""
    paint: str | None = None
    """Paint of all cars, one of PAINTS; None: drawn."""
    alike: float = 0.0
    """Share of the models that look the same (shape and paint) as others, 0 to 1; more: appearance
    and shape tell fewer cars apart."""
    groups: int = 1
    """Number of groups, >= 1, that look alike within; more: fewer cars look the same."""
    coefficients: int = 5
    """Number of shape coefficients of eq. 1, 1 to 20; more: shapes differ in finer details."""

    def __post_init__(self) -> None:
        if self.models < 1:
            raise BadConfig(f"{self.models} models of cars: give 1 or more")
        if self.body is not None and self.body not in BODIES:
            raise UnknownName.of("body", self.body, BODIES)
        if self.paint is not None:
            paint_colour(self.paint)
        load_fleet(self.coefficients)
        look_alike_ids(0, np.zeros(0, np.int64), self.alike, self.groups)

    @property
    def fleet(self) -> Fleet:
        """The cars that can be chosen from."""
        return load_fleet(self.coefficients)

    def models_of(self, seed: int) -> Models:
        """The models of a run."""
        own = np.arange(self.models)
        drawn = look_alike_ids(seed, own, self.alike, self.groups)
        cars = self.fleet.sample(seed, drawn, self.body)
        van = self.fleet.sample(seed, np.array([VAN_MODEL]), VAN_BODY)
        length, height, width = self.fleet.size(van.coefficients)[0].tolist()
        sizes = self.fleet.size(cars.coefficients)
        return Models(cars, np.where(drawn == own, own, drawn), sizes, van, (length, height, width))

    def sample(self, traffic: RecordedTraffic, seed: int) -> Vehicles:
        """All cars of the traffic. How a car looks depends on (seed, id, size) alone."""
        ids, (sizes, kinds) = traffic.ids, _everybody(traffic)
        if not len(ids):
            return Vehicles.empty(self.coefficients)
        models = self.models_of(seed)
        known = np.concatenate((models.size, [models.van_size]))
        coefficients = np.concatenate((models.cars.coefficients, models.van.coefficients))
        bodies = np.concatenate((models.cars.bodies, models.van.bodies))
        same = (sizes[:, None] == known).all(axis=2)
        model, is_model = same.argmax(axis=1), same.any(axis=1)
        lambdas, body = coefficients[model], bodies[model]
        for row in np.flatnonzero(~is_model).tolist():
            lambdas[row], body[row] = self._like(sizes[row], str(kinds[row]))
        names = np.array(list(BODIES))[body]
        by_body = np.where(names == VAN_BODY, "Van", "Car")
        return Vehicles(
            ids,
            np.where(kinds == "", by_body, kinds),
            names,
            self._paints(models, model, is_model, ids, seed),
            lambdas,
            sizes,
        )

    def _like(self, size: Float[Array, "3"], kind: str) -> tuple[Float[Array, " b"], int]:
        """Coefficients and body of a car of this size: a 'Van' is a van, a 'Car' is none."""
        return car_like(self.coefficients, tuple(size.tolist()), kind)

    def _paints(
        self,
        models: Models,
        model: Int[Array, " n"],
        is_model: Bool[Array, " n"],
        ids: Int[Array, " n"],
        seed: int,
    ) -> Shaped[Array, " n"]:
        """A paint each: the one that is asked for, the group's, or the car's own."""
        if self.paint is not None:
            return np.full(len(ids), self.paint)
        own = np.array(self.fleet.sample(seed, ids).paints)
        groups = np.append(models.groups, 0)  # the van is in no group
        paints = np.array((*models.cars.paints, "white"))
        return np.where(is_model & (groups[model] < 0), paints[model], own)


@lru_cache(maxsize=1024)
def car_like(
    coefficients: int, size: tuple[float, float, float], kind: str
) -> tuple[Float[Array, " b"], int]:
    """Coefficients and body of the likeliest car of a size, see `Fleet.nearest`; not to be changed.

    kind: a 'Van' is a van, a 'Car' is none, others may be anything.
    """
    fleet, names = load_fleet(coefficients), list(BODIES)
    others = [name for name in names if name != VAN_BODY]
    body = fleet.body_of(np.array(size), {"Van": [VAN_BODY], "Car": others}.get(kind, names))
    found = fleet.nearest(np.array(size), body).coefficients
    assert found is not None
    return found, names.index(body)


def _everybody(traffic: RecordedTraffic) -> tuple[Float[Array, "n 3"], Shaped[Array, " n"]]:
    """The sizes of the first sight of each id, and the kinds ('' where it is not given)."""
    first = traffic.present.argmax(axis=0)
    count = len(traffic.ids)
    kinds = np.zeros(count, "<U16") if traffic.kinds is None else traffic.kinds
    return traffic.size[first, np.arange(count)], kinds
