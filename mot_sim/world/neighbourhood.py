"""A world around roads, built once: ground, scenery, sky and sun for every pose of the camera."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.renderers import Placed, Road, Sky, Sun, View
from mot_sim.renderers.triangles import NEAR
from mot_sim.rig import Rig
from mot_sim.traffic.roads import Roads
from mot_sim.world.ground import Ground
from mot_sim.world.light import Light
from mot_sim.world.panorama import panorama_of
from mot_sim.world.placing import Density, Item, place
from mot_sim.world.scenery import Scenery, shadows_of
from mot_sim.world.terrain import Terrain
from mot_sim.world.window import Windows
from tracker.errors import BadConfig
from tracker.types import Camera

MOST = 3.0  # times a usual town's density


@dataclass(frozen=True)
class Knobs:
    """What a neighbourhood looks like; wear: of asphalt and paint, 0 to 1.

    houses, trees, furniture (lamps, signs, fences): 0 = none, 1 = as in a usual town, at most 3.
    """

    wear: float = 0.5
    houses: float = 1.0
    trees: float = 1.0
    furniture: float = 1.0

    def __post_init__(self) -> None:
        for name, most in (("wear", 1.0), ("houses", MOST), ("trees", MOST), ("furniture", MOST)):
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise BadConfig(f"{name} of a neighbourhood is {value:g}: give 0 to {most:g}")


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """What is drawn around the cars. A place looks the same whenever and however one gets there."""

    windows: Windows
    scenery: Scenery
    items: tuple[Item, ...]
    seed: int
    light: Light

    @classmethod
    def build(
        cls, roads: Roads, seed: int, light: Light | None = None, knobs: Knobs | None = None
    ) -> "Neighbourhood":
        """The neighbourhood of roads; light: of a `Weather`, by default a clear noon's."""
        light, knobs = light or Light(), knobs or Knobs()
        terrain = Terrain.of(roads)
        items = place(terrain, seed, Density(knobs.houses, knobs.trees, knobs.furniture))
        shadows = shadows_of(items, light.towards_world, light.shade)
        ground = Ground.of(roads, seed, knobs.wear, shadows)
        return cls(Windows(ground), Scenery.of(items), tuple(items), seed, light)

    def road_at(self, ego: Float[Array, "3"], camera: Camera) -> Road:
        """The painted road plane before the camera, for an ego pose x, y, heading."""
        return self.windows.road(_checked(ego), Rig(camera).T_world_road(ego), camera)

    def scenery_at(self, ego: Float[Array, "3"], camera: Camera, near: float = NEAR) -> Placed:
        """The houses, trees and other things that the camera may see; all of them NOBODY's."""
        return self.scenery.placed(_checked(ego), Rig(camera).T_world_cam(ego), camera, near)

    def sky_at(self, ego: Float[Array, "3"]) -> Sky:
        """The sky along the ego's heading."""
        return Sky(panorama=panorama_of(self.seed, self.light.clouds), heading=float(ego[2]))

    def sun_at(self, ego: Float[Array, "3"]) -> Sun:
        """The sun as the ego sees it."""
        return self.light.sun(float(ego[2]))

    def view(self, camera: Camera, ego: Float[Array, "3"], cars: Placed) -> View:
        """Everything before the camera: the cars, and the world around them."""
        return View(
            camera,
            together(cars, self.scenery_at(ego, camera)),
            self.road_at(ego, camera),
            self.sky_at(ego),
            self.sun_at(ego),
        )


def together(first: Placed, second: Placed) -> Placed:
    """The objects of both."""
    return Placed(
        first.meshes + second.meshes,
        np.concatenate((first.T_cam_object, second.T_cam_object)),
        np.concatenate((first.instances, second.instances)),
    )


def _checked(ego: Float[Array, "3"]) -> Float[Array, "3"]:
    if not np.isfinite(ego).all():
        raise BadConfig(f"the ego pose (x, y, heading) is not finite: {ego.tolist()}")
    return ego
