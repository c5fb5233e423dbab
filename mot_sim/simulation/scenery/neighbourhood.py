"""A world around roads, built once: ground, scenery, sky and sun for every pose of the camera."""

from dataclasses import dataclass

from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Cover, MeshInstances, Road, Sky, Sun, View
from mot_sim.simulation.renderers.triangles import NEAR_METRES
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scenery.ground import Ground
from mot_sim.simulation.scenery.panorama import panorama_of
from mot_sim.simulation.scenery.placing import Knobs
from mot_sim.simulation.scenery.scenery import Scenery, checked, feet_of, shadows_of
from mot_sim.simulation.scenery.weather import Light
from mot_sim.simulation.scenery.window import Windows
from mot_sim.simulation.traffic.roads import Roads
from tracker.types import Camera


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """What is drawn around the cars. A place looks the same whenever and however one gets there."""

    windows: Windows
    """The painted ground."""
    scenery: Scenery
    """The houses, trees and other things beside the roads."""
    seed: int
    """Random seed; the panorama in the sky is drawn from it."""
    light: Light
    """The sun and the clouds."""

    @classmethod
    def build(
        cls, roads: Roads, seed: int, light: Light | None = None, knobs: Knobs | None = None
    ) -> "Neighbourhood":
        """The neighbourhood of roads; light: of a `SensorWeather`, by default a clear noon's."""
        light, knobs = light or Light(), knobs or Knobs()
        scenery = Scenery.around(roads, seed, knobs)
        shadows = shadows_of(scenery.items, light.towards_world, light.shade)
        ground = Ground.of(roads, seed, knobs.wear, shadows, feet_of(scenery.items))
        return cls(Windows(ground), scenery, seed, light)

    def road_at(self, ego: Float[Array, "3"], camera: Camera) -> Road:
        """The painted road plane before the camera, for an ego pose x, y, heading."""
        return self.windows.road(checked(ego), Rig(camera).T_world_road(ego), camera)

    def cover_at(self, ego: Float[Array, "3"], camera: Camera) -> Cover | None:
        """The static shadows that cars before the camera may stand in; None without a sun."""
        ground = self.windows.ground
        if not (ground.shadows.corners or ground.canopy.corners):
            return None
        return self.windows.cover(checked(ego), Rig(camera).T_world_road(ego))

    def scenery_at(
        self, ego: Float[Array, "3"], camera: Camera, near: float = NEAR_METRES
    ) -> MeshInstances:
        """The houses, trees and other things that the camera may see; their ids: NO_INSTANCE."""
        return self.scenery.seen_from(ego, camera, near)

    def sky_at(self, ego: Float[Array, "3"]) -> Sky:
        """The sky along the ego's heading."""
        return Sky(panorama=panorama_of(self.seed, self.light.clouds), heading=float(ego[2]))

    def sun_at(self, ego: Float[Array, "3"]) -> Sun:
        """The sun as the ego sees it."""
        return self.light.sun(float(ego[2]))

    def view(self, camera: Camera, ego: Float[Array, "3"], cars: MeshInstances) -> View:
        """Everything before the camera: the cars, and the world around them."""
        return View(
            camera,
            cars.beside(self.scenery_at(ego, camera)),
            self.road_at(ego, camera),
            self.sky_at(ego),
            self.sun_at(ego),
            self.cover_at(ego, camera),
        )
