"""A sheet of frames: every road in every weather, drawn with the full world.

    python -m benchmarks.gallery FOLDER [--roads street,merge] [--weathers noon,fog] [--steps 40]

Writes each frame at full size, and `sheet.png` with all of them, smaller.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from benchmarks.world import ROADS, cars_before, drive
from mot_sim.renderers import find_renderer
from mot_sim.report import write_image
from mot_sim.rig import Rig
from mot_sim.traffic.highway.paint import roads_of
from mot_sim.world import WEATHERS, Neighbourhood, find_weather, look

SMALL = (621, 188)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--roads", default=",".join(ROADS))
    parser.add_argument("--weathers", default=",".join(WEATHERS))
    parser.add_argument("--steps", type=int, default=40, help="of 0.1 s before the picture")
    parser.add_argument("--seed", type=int, default=3)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rig, renderer, rows = Rig.kitti(), find_renderer("raster"), []
    for road in arguments.roads.split(","):
        now = drive(road, arguments.seed, arguments.steps)[-1]
        roads, row = roads_of(road), []
        for name in arguments.weathers.split(","):
            weather = find_weather(name)
            world = Neighbourhood.build(roads, arguments.seed, weather.light)
            view = world.view(rig.camera, now.ego, cars_before(rig, now))
            image = look(weather, view, renderer.render(view), arguments.seed, 0)
            write_image(arguments.out / f"{road}_{name}.png", image)
            row.append(cv2.resize(image, SMALL, interpolation=cv2.INTER_AREA))
        rows.append(np.vstack(row))
    write_image(arguments.out / "sheet.png", np.hstack(rows))


if __name__ == "__main__":
    main()
