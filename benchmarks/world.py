"""How fast frames are drawn with the full world, and how many corners they have.

    python -m benchmarks.world [--scenes street,highway] [--frames 40] [--look plain]
        [--update-baseline]

One core, 1242 x 375 pixels, the nearest 20 cars in sight before a moving camera. `bare` is the
same cars on a plain plane, nothing else. CPU milliseconds, medians; `mean` is of view, render and
noon together, with all that the moving camera paints and makes anew. Machines are shared:
beside it stands its ratio to a yardstick measured in turn with it, the bare call of OpenCV's
triangleRasterize on 20 cars (see `benchmarks.renderers`), and those that were kept (see
`benchmarks.baseline`).
"""

import argparse
from statistics import median
from time import process_time

import cv2
import numpy as np

from benchmarks.baseline import Ratios
from benchmarks.renderers import bare_opencv
from mot_sim.simulation.camera_looks import CameraLook, find_camera_look
from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.renderers import NEAR_METRES, MeshInstances, View, find_renderer
from mot_sim.simulation.renderers.triangles import sphere_in_view
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import WEATHERS, Neighbourhood, post_process
from mot_sim.simulation.traffic.traffic_state import TrafficState
from tests.mot_sim.simulation.renderers.shapes import street

CARS, SEED = 20, 3


def cars_before(take: Rollout, world: TrafficState, most: int = CARS) -> MeshInstances:
    """The nearest cars that the camera may see."""
    instances = take.scene_meshes.instances(world)
    depth = instances.T_cam_object[:, 2, 3]
    rows = np.flatnonzero(sphere_in_view(instances, take.scene.rig.camera, NEAR_METRES))
    rows = rows[np.argsort(depth[rows], kind="stable")][:most]
    meshes = tuple(instances.meshes[row] for row in rows)
    return MeshInstances(meshes, instances.T_cam_object[rows], instances.ids[rows])


def measure(name: str, frames: int, most: int, look: CameraLook, ratios: Ratios) -> None:
    """Print the CPU times of a drive and the corners in every weather."""
    rig, renderer, yard = Rig.kitti(), find_renderer("raster"), street()
    scene = find_scene(name, frames=frames + 1)
    take = Rollout.of(scene, SEED)
    began = process_time()
    place = Neighbourhood.build(scene.roads, SEED, WEATHERS["noon"].light)
    built = process_time() - began
    began = process_time()
    view = place.view(rig.camera, take.traffic_states[0].ego, MeshInstances.empty())
    post_process(WEATHERS["noon"], view, renderer.render(view), SEED, 0, look=look)
    first = process_time() - began
    times: dict[str, list[float]] = {"yard": [], "bare": [], "view": [], "render": [], "noon": []}
    cars = []
    for number, world in enumerate(take.traffic_states[1:]):
        instances = cars_before(take, world, most)
        ticks = [process_time()]
        bare_opencv(yard)
        ticks.append(process_time())
        renderer.render(View(rig.camera, instances))
        ticks.append(process_time())
        view = place.view(rig.camera, world.ego, instances)
        ticks.append(process_time())
        rendered = renderer.render(view)
        ticks.append(process_time())
        image = post_process(WEATHERS["noon"], view, rendered, SEED, number, look=look)
        ticks.append(process_time())
        for one, took in zip(times, np.diff(ticks).tolist(), strict=True):
            times[one].append(1e3 * took)
        cars.append(len(np.unique(rendered.instances)) - 1)
    middle = {one: median(all_) for one, all_ in times.items()}
    total = sum(float(np.mean(times[one])) for one in ("view", "render", "noon"))
    ratio = ratios.add(name, total, float(np.mean(times["yard"])))
    print(
        f"{name:13s} {np.mean(cars):4.0f} {built:7.1f} {first:7.1f}"
        + "".join(f"{value:8.1f}" for value in middle.values())
        + f"{total:8.1f} {1e3 / total:6.1f} {ratio:12.2f}"
    )
    orb, counts = cv2.ORB_create(3000), []
    for each, weather in WEATHERS.items():
        image = post_process(weather, view, rendered, SEED, 0, look=look)
        scenery = (rendered.instances < 0).astype(np.uint8) * 255
        found = orb.detect(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), scenery)
        counts.append(f"{each} {len(found)}")
    print("   corners off the cars: " + ", ".join(counts))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--cars", type=int, default=CARS, help="at most so many, the nearest")
    parser.add_argument("--look", default="kitti", help="of the camera: a name or a TOML file")
    Ratios.add_option(parser)
    arguments = parser.parse_args()
    ratios = Ratios("world")
    cv2.setNumThreads(1)
    print(
        "scene         seen build s first s    yard    bare    view  render    noon"
        "    mean    fps  x yardstick"
    )
    look = find_camera_look(arguments.look)
    for name in arguments.scenes.split(","):
        measure(name, arguments.frames, arguments.cars, look, ratios)
    ratios.tell(arguments.update_baseline)


if __name__ == "__main__":
    main()
