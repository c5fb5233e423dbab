"""Random views for training: cars anywhere before a camera, any place, light and weather."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.cars import BODIES, Cars, Fleet, Vehicles, load_fleet
from mot_sim.simulation.random_numbers import named_stream, uniform
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import View
from mot_sim.simulation.rig import KITTI_HEIGHT_METRES, KITTI_IMAGE_SIZE, KITTI_K, Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.scenery import Knobs, Light, Neighbourhood, Weather
from mot_sim.simulation.traffic import Roads, TrafficState, colliding_pairs
from tracker.types import Camera

PLACE_SCENES = ("street", "intersection", "roundabout", "t_junction", "merge", "highway")
VIEWS_PER_PLACE = 64  # its ground and houses are made once
VIEWS_PER_VIEWPOINT = 4  # before the camera moves on
SHAPE_COEFFICIENTS = 20
CARS_PER_VIEW = (14, 26)  # before those that overlap others are removed
# Resolution over KITTI's camera, and nearest and farthest cars in metres: far cars are drawn finer
# than they are shown, so that their edges are averaged as a lens does.
RESOLUTIONS = ((1.0, (4.5, 32.0)), (2.0, (9.0, 62.0)))
FINE_IMAGE_SIZE = (1242, 440)  # pixels; the finer view is a part of the image
DAY_SHARE = 0.95
FOG_SHARE = 0.12
ALIGNED_SHARE = 0.35  # of cars that head along the road
# Of cars that are made vans beside those that the fleet has: the network has to learn from many
# that their fronts and rears differ by little; and of these how many are white, as on streets.
MORE_VANS_SHARE = 0.2
WHITE_VANS_SHARE = 0.35


@dataclass(frozen=True, eq=False)
class Place:
    """A neighbourhood, and the random numbers of the views there."""

    seed: int
    """Seed that decides the place and all its views."""
    roads: Roads
    """Its roads."""
    neighbourhood: Neighbourhood
    """What stands beside and lies on the roads, ready to be drawn."""
    rng: np.random.Generator
    """Random numbers; every view takes the next ones."""

    @classmethod
    def of(cls, seed: int) -> "Place":
        """The place of a seed."""
        rng = named_stream(seed, "training place")
        roads = find_scene(PLACE_SCENES[int(rng.integers(len(PLACE_SCENES)))]).roads
        knobs = Knobs(
            wear=float(rng.uniform()),
            houses=float(rng.uniform(0.5, 2.5)),
            trees=float(rng.uniform(0.3, 2.5)),
            furniture=float(rng.uniform(0.5, 3.0)),
        )
        return cls(seed, roads, Neighbourhood.build(roads, seed, light_of(rng), knobs), rng)

    def somewhere(self) -> Float[Array, "3"]:
        """A pose x, y, heading near the middle of a lane."""
        lane = self.roads.lanes[int(self.rng.integers(len(self.roads.lanes)))].centre
        leg = int(self.rng.integers(len(lane) - 1))
        point = lane[leg] + self.rng.uniform() * (lane[leg + 1] - lane[leg])
        ahead = lane[leg + 1] - lane[leg]
        heading = np.arctan2(ahead[1], ahead[0]) + self.rng.normal(0.0, 0.15)
        return np.array([*(point + self.rng.normal(0.0, 0.8, 2)), heading])


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """Where the camera is."""

    ego: Float[Array, "3"]
    """Pose of the car that carries the camera: x, y in metres, heading in radians; world frame."""
    rig: Rig
    """The camera and its mounting."""
    depths: tuple[float, float]
    """Distances of the nearest and the farthest car ahead, metres."""
    finer: float
    """Resolution of the camera over that of KITTI's."""


@dataclass(frozen=True, eq=False)
class RandomView:
    """A view that is drawn: cars, camera, light and weather."""

    scene_meshes: SceneMeshes
    """The cars' meshes, and the camera."""
    traffic_state: TrafficState
    """Where the cars are."""
    view: View
    """What the renderer draws."""
    weather: Weather
    """Weather, applied to the drawn image."""
    finer: float
    """Resolution of the camera over that of KITTI's."""


def viewpoint(place: Place) -> Viewpoint:
    """A random viewpoint in a place."""
    finer, depths = RESOLUTIONS[int(place.rng.integers(len(RESOLUTIONS)))]
    return Viewpoint(place.somewhere(), Rig(camera_of(place.rng, finer)), depths, finer)


def random_view(place: Place, here: Viewpoint) -> RandomView:
    """New cars and new light at a viewpoint."""
    rng, rig, ego = place.rng, here.rig, here.ego
    traffic_state, vehicles = cars_before(rig, ego, here.depths, rng)
    meshes = SceneMeshes(vehicles, rig)
    view = place.neighbourhood.view(rig.camera, ego, meshes.instances(traffic_state))
    view = replace(view, sun=light_of(rng).sun(float(ego[2])))
    return RandomView(meshes, traffic_state, view, weather_of(rng), here.finer)


def camera_of(rng: np.random.Generator, finer: float) -> Camera:
    """KITTI's camera, mounted a little differently; a finer one sees a part of the image."""
    K = np.array(KITTI_K)
    K[:2] *= finer
    size = KITTI_IMAGE_SIZE
    if finer > 1.0:
        size = FINE_IMAGE_SIZE
        K[0, 2] = rng.uniform(0.0, 1.0) * size[0]
        K[1, 2] = 150.0
    height = KITTI_HEIGHT_METRES + float(rng.normal(0.0, 0.06))
    pitch, roll = rng.normal(0.0, (0.015, 0.012)).tolist()
    return Camera.mounted(K, size, height, pitch, roll)


def cars_before(
    rig: Rig, ego: Float[Array, "3"], depths: tuple[float, float], rng: np.random.Generator
) -> tuple[TrafficState, Vehicles]:
    """Cars of any shape in the view, near ones as often as far ones; no two overlap."""
    n = int(rng.integers(*CARS_PER_VIEW))
    fleet, camera = load_fleet(SHAPE_COEFFICIENTS), rig.camera
    cars = cars_of(fleet, int(rng.integers(1 << 40)), n)
    size = fleet.size(cars.coefficients)
    z = np.exp(rng.uniform(np.log(depths[0]), np.log(depths[1]), n))
    spread = (rng.permutation(n) + rng.uniform(size=n)) / n  # side by side rather than behind
    u = (1.04 * spread - 0.02) * camera.image_size[0]
    x = z * (u - camera.K[0, 2]) / camera.K[0, 0]
    c, s = np.cos(ego[2]), np.sin(ego[2])
    heading = rng.uniform(-np.pi, np.pi, n)
    road = ego[2] + np.pi * rng.integers(0, 2, n) + rng.normal(0.0, 0.1, n)
    heading = np.where(rng.uniform(size=n) < ALIGNED_SHARE, road, heading)
    crowd = TrafficState(
        0.0,
        np.arange(n),
        ego[0] + c * z - s * x,
        ego[1] + s * z + c * x,
        heading,
        np.zeros(n),
        size,
        ego,
        np.array([4.4, 1.45, 1.8]),
    )
    stays = np.ones(n, bool)
    poses = np.stack((crowd.x, crowd.y, heading), axis=1)
    for first, second in colliding_pairs(poses, size).tolist():
        if stays[first]:
            stays[second] = False
    rows = np.flatnonzero(stays)
    ids = np.arange(len(rows))
    world = replace(
        crowd,
        ids=ids,
        x=crowd.x[rows],
        y=crowd.y[rows],
        heading=heading[rows],
        speed=np.zeros(len(rows)),
        size=size[rows],
    )
    names = np.array(list(BODIES))[cars.bodies[rows]]
    paints = np.array(cars.paints)[rows]
    kinds = np.where(names == "van", "Van", "Car")
    return world, Vehicles(ids, kinds, names, paints, cars.coefficients[rows], size[rows])


def cars_of(fleet: Fleet, seed: int, count: int) -> Cars:
    """Cars of a fleet, more of them vans than on a street."""
    ids = np.arange(count)
    cars, vans = fleet.sample(seed, ids), fleet.sample(seed, ids, "van")
    draws = uniform(seed, "training vans", ids, np.zeros_like(ids), 2)
    is_van = draws[:, 0] < MORE_VANS_SHARE
    is_white = is_van & (draws[:, 1] < WHITE_VANS_SHARE)
    return Cars(
        np.where(is_van[:, None], vans.coefficients, cars.coefficients),
        np.where(is_van, vans.bodies, cars.bodies),
        tuple(np.where(is_white, "white", cars.paints).tolist()),
    )


def light_of(rng: np.random.Generator) -> Light:
    """Any sun, any clouds."""
    return Light(
        azimuth=float(rng.uniform(0.0, 360.0)),
        elevation=float(rng.uniform(10.0, 80.0)),
        ambient=float(rng.uniform(0.25, 0.95)),
        shade=float(rng.uniform(0.1, 0.75)),
        clouds=float(rng.uniform()),
    )


def weather_of(rng: np.random.Generator) -> Weather:
    """Any weather by day, seldom dusk; noise and blur are added later, by `camera_image`."""
    dark = rng.uniform() > DAY_SHARE
    foggy = rng.uniform() < FOG_SHARE
    grey = rng.integers(150, 240)
    air = tuple(int(one) for one in np.clip(grey + rng.integers(-12, 13, 3), 0, 255))
    return Weather(
        visibility=float(np.exp(rng.uniform(np.log(60.0), np.log(2000.0)))) if foggy else 1500.0,
        air=(air[0], air[1], air[2]),
        overcast=float(rng.uniform()) if rng.uniform() < 0.4 else 0.0,
        rain=float(rng.uniform(0.0, 0.8)) if rng.uniform() < 0.05 else 0.0,
        night=float(rng.uniform(0.2, 0.7)) if dark else 0.0,
        warmth=float(rng.uniform(-0.5, 0.7)),
        exposure=float(np.exp(rng.uniform(-0.4, 0.5))),
        vignetting=0.15,
    )
