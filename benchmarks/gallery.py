"""A sheet of frames: every scene in every weather, drawn with the full world.

    python -m benchmarks.gallery FOLDER [--scenes street,merge] [--weathers noon,fog] [--steps 40]
    [--columns 2] [--width 414] [--look plain]

Writes each frame at full size, and `sheet.jpg` with all of them, smaller: scenes side by side, or
in so many columns, weathers below one another.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from mot_sim.plotting import write_image
from mot_sim.simulation.camera_looks import find_camera_look
from mot_sim.simulation.registry import SCENES, find_scene
from mot_sim.simulation.renderers import find_renderer
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import WEATHERS, Neighbourhood, find_weather, post_process

HEIGHT_SHARE = 125 / 414  # of the width, of a small picture


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--weathers", default=",".join(WEATHERS))
    parser.add_argument("--steps", type=int, default=40, help="of 0.1 s before the picture")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--columns", type=int, help="of scenes; by default all side by side")
    parser.add_argument("--width", type=int, default=414, help="of a small picture, pixels")
    parser.add_argument("--look", default="kitti", help="of the camera: a name or a TOML file")
    arguments = parser.parse_args()
    look = find_camera_look(arguments.look)
    arguments.out.mkdir(parents=True, exist_ok=True)
    renderer, columns = find_renderer("raster"), []
    small = arguments.width, round(HEIGHT_SHARE * arguments.width)
    for name in arguments.scenes.split(","):
        scene, row = find_scene(name, frames=arguments.steps + 1), []
        take = Rollout.of(scene, arguments.seed)
        now = take.traffic_states[-1]
        for sky in arguments.weathers.split(","):
            weather = find_weather(sky)
            world = Neighbourhood.build(scene.roads, arguments.seed, weather.light)
            view = world.view(scene.rig.camera, now.ego, take.scene_meshes.instances(now))
            image = post_process(weather, view, renderer.render(view), arguments.seed, 0, look=look)
            write_image(arguments.out / f"{name}_{sky}.png", image)
            row.append(cv2.resize(image, small, interpolation=cv2.INTER_AREA))
        columns.append(np.vstack(row))
    count = arguments.columns or len(columns)
    columns += [np.full_like(columns[0], 255)] * (-len(columns) % count)
    rows = [np.hstack(columns[at : at + count]) for at in range(0, len(columns), count)]
    write_image(arguments.out / "sheet.jpg", np.vstack(rows))


if __name__ == "__main__":
    main()
