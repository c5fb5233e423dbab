"""How fast frames are drawn with the full world, and how many corners they have.

    python -m benchmarks.world [--roads street,highway] [--frames 40]

One core, 1242 x 375 pixels, cars of the fleet before a moving camera. `bare` is the same cars on
a plain plane, nothing else. CPU milliseconds, medians; machines are shared, so compare the
columns with each other. `tiles` is what the moving camera has painted anew, a mean per frame.
"""

import argparse
from statistics import median
from time import process_time

import cv2
import numpy as np

from mot_sim.cars import PARTS, load_fleet
from mot_sim.renderers import Mesh, Placed, Semantic, View, find_renderer
from mot_sim.rig import Rig
from mot_sim.traffic.highway import ROADS, HighwayTraffic
from mot_sim.traffic.highway.paint import roads_of
from mot_sim.traffic.world import World
from mot_sim.world import WEATHERS, Neighbourhood, look
from tracker.geometry import homogeneous, rotation_y

CARS, BEYOND = 20, 90.0
KINDS = {
    "paint": Semantic.CAR, "glass": Semantic.GLASS, "trim": Semantic.TRIM, "tyre": Semantic.TYRE,
    "headlight": Semantic.LIGHT, "taillight": Semantic.LIGHT, "plate": Semantic.PLATE,
    "rim": Semantic.TYRE,
}  # fmt: skip


def drive(road: str, seed: int, steps: int) -> list[World]:
    """The worlds of some traffic, 0.1 s apart."""
    traffic = HighwayTraffic(road, cars=14, parked=0.6, crashes="label")
    worlds = [traffic.reset(np.random.default_rng(seed))]
    return worlds + [traffic.step() for _ in range(steps)]


def car_mesh(number: int) -> Mesh:
    """The car of an id."""
    fleet = load_fleet(5)
    drawn = fleet.sample(1, np.array([number]))
    shape = fleet.car(drawn.coefficients[0])
    semantics = np.array([KINDS[part] for part in PARTS], np.uint8)[shape.parts]
    return Mesh(shape.vertices, shape.faces, shape.colours(drawn.paints[0]), semantics)


def cars_before(rig: Rig, world: World, most: int = CARS) -> Placed:
    """The nearest cars before the camera."""
    cuboids = rig.cuboids(world)
    order = np.argsort(np.hypot(*cuboids.base[:, [0, 2]].T))
    rows = [row for row in order if 1.0 < cuboids.base[row, 2] < BEYOND][:most]
    poses = [
        rig.camera.T_cam_road @ homogeneous(rotation_y(cuboids.yaw[row]), cuboids.base[row])
        for row in rows
    ]
    meshes = tuple(car_mesh(int(world.ids[row])) for row in rows)
    return Placed(meshes, np.array(poses).reshape(-1, 4, 4), world.ids[rows].astype(np.int64))


def measure(road: str, frames: int) -> None:
    """Print the CPU times of a drive and the corners in every weather."""
    rig, renderer = Rig.kitti(), find_renderer("raster")
    worlds = drive(road, 3, frames + 20)[20:]
    began = process_time()
    place = Neighbourhood.build(roads_of(road), 3, WEATHERS["noon"].light)
    built = process_time() - began
    began = process_time()
    place.view(rig.camera, worlds[0].ego, Placed.empty())
    first = process_time() - began
    times: dict[str, list[float]] = {"bare": [], "view": [], "render": [], "noon": []}
    pieces, cars = 0, 0
    for number, world in enumerate(worlds[1:]):
        placed = cars_before(rig, world)
        start = process_time()
        renderer.render(View(rig.camera, placed))
        bare = process_time()
        view = place.view(rig.camera, world.ego, placed)
        viewed = process_time()
        rendered = renderer.render(view)
        drawn = process_time()
        image = look(WEATHERS["noon"], view, rendered, 3, number)
        ends = (bare - start, viewed - bare, drawn - viewed, process_time() - drawn)
        for name, took in zip(times, ends, strict=True):
            times[name].append(1e3 * took)
        pieces, cars = len(view.placed) - len(placed), len(placed)
    middle = {name: median(all_) for name, all_ in times.items()}
    total = sum(float(np.mean(times[name])) for name in ("view", "render", "noon"))
    print(
        f"{road:13s} {cars:4d} {pieces:6d} {built:7.1f} {first:7.1f}"
        + "".join(f"{value:8.1f}" for value in middle.values())
        + f"{total:9.1f} {1e3 / total:9.1f}"
    )
    orb, counts = cv2.ORB_create(3000), []
    for name, weather in WEATHERS.items():
        image = look(weather, view, rendered, 3, 0)
        scenery = (rendered.instances < 0).astype(np.uint8) * 255
        found = orb.detect(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), scenery)
        counts.append(f"{name} {len(found)}")
    print("   corners off the cars: " + ", ".join(counts))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--roads", default=",".join(ROADS))
    parser.add_argument("--frames", type=int, default=40)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    print("road          cars pieces build s first s    bare    view  render    noon mean sum  fps")
    for road in arguments.roads.split(","):
        measure(road, arguments.frames)


if __name__ == "__main__":
    main()
