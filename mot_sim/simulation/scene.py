"""What can be run (a scene), and who drives where when it is run (a rollout)."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from mot_sim.simulation import random_numbers
from mot_sim.simulation.camera_looks import CameraLook, find_camera_look
from mot_sim.simulation.cars.vehicles import Models, VehicleSampler
from mot_sim.simulation.renderers import MeshInstances
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene_meshes import SceneMeshes
from mot_sim.simulation.scenery import Knobs as Surroundings
from mot_sim.simulation.scenery import Neighbourhood, Scenery, Spheres, Weather, find_weather
from mot_sim.simulation.sensors import Detector
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.roads import Roads
from mot_sim.simulation.traffic.traffic_state import DrivenAhead, Finite, Traffic, TrafficState
from tracker.errors import BadConfig

LOGGER = logging.getLogger(__name__)
Knob = int | float | str | bool  # the value of a knob


@dataclass(frozen=True, eq=False)
class Scene:
    """What can be run: who drives on which roads, and what watches them, for how many frames."""

    name: str
    """What it is called in tables and files."""
    make_traffic: Callable[[Models], Traffic]
    """Makes the traffic from the shapes that cars are chosen from, whose sizes it takes."""
    frame_count: int
    """Length of a run in frames of 0.1 s, >= 1."""
    roads: Roads = field(default_factory=Roads)
    """The painted ground; empty: the cars stand on a plain."""
    rig: Rig = field(default_factory=Rig.kitti)
    """The camera on the ego car."""
    detector: Detector = field(default_factory=Detector)
    """Noise model that turns the truth into detections."""
    vehicle_sampler: VehicleSampler = field(default_factory=VehicleSampler)
    """How shapes and paints of cars are chosen."""
    weather: Weather = field(default_factory=lambda: find_weather("noon"))
    """Light and air of the pictures; does not change the detections."""
    camera_look: CameraLook = field(default_factory=lambda: find_camera_look("kitti"))
    """What lens, exposure, tone curve and sensor make of the pictures; changes nothing else."""
    surroundings: Surroundings = field(default_factory=Surroundings)
    """How much stands beside the roads; more: more things that hide cars."""
    knobs: Mapping[str, Knob] = field(default_factory=dict)
    """What `mot_sim.simulation.registry.find_scene` made it from, together with its name."""

    def __post_init__(self) -> None:
        if self.frame_count < 1:
            raise BadConfig(f"scene {self.name}: {self.frame_count} frames; give 1 or more")


@dataclass(frozen=True, eq=False)
class Rollout:
    """One run of a scene before it is annotated or drawn; state i of the traffic is frame i."""

    scene: Scene
    """What is run."""
    seed: int
    """Random seed, from which everything follows."""
    traffic: RecordedTraffic
    """Who is where in every frame."""

    @classmethod
    def of(cls, scene: Scene, seed: int, traffic: RecordedTraffic | None = None) -> "Rollout":
        """The run of a seed; traffic: of this scene and seed, where it was recorded before."""
        return cls(scene, seed, traffic or record_scene_traffic(scene, seed))

    def __len__(self) -> int:
        return len(self.traffic)

    def until(self, count: int) -> "Rollout":
        """The first frames of it: what a scene of this length would have given."""
        if count == len(self):
            return self
        return Rollout(self.scene, self.seed, self.traffic.until(count))

    @cached_property
    def scene_meshes(self) -> SceneMeshes:
        """Who the cars are, and the camera."""
        vehicles = self.scene.vehicle_sampler.sample(self.traffic, self.seed)
        return SceneMeshes(vehicles, self.scene.rig, frozenset(self.traffic.parked_ids.tolist()))

    @cached_property
    def scenery(self) -> Scenery | None:
        """What stands beside the roads, and may hide cars; None where nothing does."""
        amounts = self.scene.surroundings
        is_empty = not any(
            (amounts.houses, amounts.trees, amounts.furniture, self.scene.roads.plots)
        )
        if is_empty or not self.scene.roads.surfaces:
            return None
        return Scenery.around(self.scene.roads, self.seed, self.scene.surroundings)

    @cached_property
    def neighbourhood(self) -> Neighbourhood | None:
        """The drawn world around the cars, made for the first picture; None without roads."""
        scene = self.scene
        if not scene.roads.surfaces:
            return None
        return Neighbourhood.build(scene.roads, self.seed, scene.weather.light, scene.surroundings)

    def scenery_in(self, state: TrafficState) -> MeshInstances | None:
        """The scenery that may hide a car from the camera in one of the states."""
        if self.scenery is None:
            return None
        rig = self.scene.rig
        cars = Spheres.of(rig.cuboids(state), rig.camera)
        return self.scenery.seen_from(state.ego, rig.camera_in(state), behind=cars)

    @cached_property
    def traffic_states(self) -> tuple[TrafficState, ...]:
        """The state of each frame."""
        return self.traffic.states


def record_scene_traffic(
    scene: Scene, seed: int, driven: Callable[[int], None] | None = None
) -> RecordedTraffic:
    """Who is where in a run of a scene; to be recorded once and used many times.

    driven: called with the number of frames that the traffic has been driven for, while that goes
    on; it counts anew where the traffic begins anew, since somebody crashed. The run is shorter
    than the scene where the road of the ego car ends before; a warning is logged.
    """
    traffic = scene.make_traffic(scene.vehicle_sampler.models_of(seed))
    if isinstance(traffic, DrivenAhead):
        traffic.driven = driven
    states = [traffic.reset(random_numbers.named_stream(seed, "traffic"))]
    while len(states) < scene.frame_count:
        state = traffic.step()
        if isinstance(traffic, Finite) and traffic.has_ended:
            LOGGER.warning(
                "scene %s, seed %d: the road of our car ends after %d frames; %d were asked for",
                scene.name, seed, len(states), scene.frame_count,
            )  # fmt: skip
            break
        states.append(state)
    return RecordedTraffic.of(states)
