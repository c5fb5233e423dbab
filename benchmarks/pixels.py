"""What drawn pixels are like beside KITTI's: tone, colours, sharpness, noise; and weather's axes.

    python -m benchmarks.pixels --root KITTI [--scenes street,intersection,town] [--weathers noon]
    [--look kitti] [--renderer raster] [--seeds 3,4] [--frames 61] [--out FOLDER]
    python -m benchmarks.pixels --axes [--scenes street]

Each statistic of `mot_sim.simulation.camera_looks.image_statistics` is the mean over every tenth
frame of a scene's runs. KITTI's are of the given images of drives 0000, 0005 and 0009: `drives` is
from the least to the most of the three drives' means, `stretches` of all stretches of 16 frames.
After a value stands whether it is inside: `in` the drives' range, `~` the stretches', `-` neither.

--axes: what fog, rain, the sun's height and the exposure do to the contrast and how far one sees.
`law`: share of the contrast that Koschmieder's law leaves at a depth. `drawn`: share that is left
of the luma's standard deviation among what the renderer drew in that range of depths, without a
camera's look. `5 %`: metres at which the law leaves a twentieth, about what an eye needs.
"""

import argparse
import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from mot_sim.datasets.images import ImageFolder
from mot_sim.plotting import write_image
from mot_sim.simulation.camera_looks import PLAIN, find_camera_look
from mot_sim.simulation.camera_looks.fitting import StatisticsRange
from mot_sim.simulation.camera_looks.image_statistics import STATISTICS, mean_statistics
from mot_sim.simulation.imaging import RenderedImages, view_of
from mot_sim.simulation.look_frames import drawn_frames
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import find_renderer
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import WEATHERS, contrast_left, post_process

DRIVES = ("0000", "0005", "0009")
STRETCH = 16  # frames
EVERY = 10  # frames of a drive and of a scene; stretches take every third
DEPTHS = ((10.0, 20.0), (20.0, 40.0), (40.0, 80.0))  # metres
AXES = (
    *({"fog": metres} for metres in (4000.0, 1000.0, 300.0, 125.0, 50.0)),
    *({"rain": rate} for rate in (1.0, 4.0, 16.0, 50.0)),
    *({"sun_elevation": degrees} for degrees in (90.0, 30.0, 11.0, 5.0)),
    *({"exposure": stops} for stops in (-2.0, -1.0, 1.0, 2.0)),
)


def ranges(root: Path) -> tuple[StatisticsRange, StatisticsRange]:
    """Of the drives' means, and of those of all stretches."""
    drives, stretches = [], []
    for name in DRIVES:
        images = ImageFolder.require(root / "training" / "image_02" / name)
        frames = sorted(images.paths)
        step = EVERY if len(frames) > 2 * STRETCH else 1
        drives.append(mean_statistics(images.load(frame) for frame in frames[::step]))
        for first in range(0, len(frames) - STRETCH + 1, STRETCH):
            part = frames[first : first + STRETCH : 3]
            stretches.append(mean_statistics(images.load(frame) for frame in part))
    return StatisticsRange.of(drives), StatisticsRange.of([*drives, *stretches])


def compare(arguments: argparse.Namespace, weather: str) -> None:
    """Print the statistics of the scenes beside KITTI's."""
    look = find_camera_look(arguments.look)
    strict, wide = ranges(arguments.root)
    seeds = [int(seed) for seed in arguments.seeds.split(",")]
    seen = {}
    for name in arguments.scenes.split(","):
        frames = drawn_frames(
            name, seeds, EVERY, arguments.frames, arguments.renderer, weather=weather
        )
        images = (frame.developed(look) for frame in frames)
        if look.is_neutral:  # the weather's own noise and vignetting
            images = plain_images(name, seeds, arguments, weather)
        seen[name] = mean_statistics(images)
    print(f"\n{weather}, look {look.name}, renderer {arguments.renderer}")
    print(f"{'statistic':15s} {'KITTI drives':>17s} {'stretches':>17s}" + heads(seen))
    inside = 0
    for name in STATISTICS:
        cells = ""
        for statistics in seen.values():
            value = getattr(statistics, name)
            where = "in" if strict.holds(name, value) else "~" if wide.holds(name, value) else "-"
            inside += where == "in"
            cells += f"{value:12.2f} {where:2s}"
        print(f"{name:15s} {spread(strict, name):>17s} {spread(wide, name):>17s}{cells}")
    print(f"inside the drives' range: {inside} of {len(STATISTICS) * len(seen)}")


def plain_images(
    name: str, seeds: Iterable[int], arguments: argparse.Namespace, weather: str
) -> Iterable[np.ndarray]:
    """Frames without a look, the same ones."""
    for seed in seeds:
        scene = find_scene(name, frames=arguments.frames, weather=weather, camera_look="plain")
        images = RenderedImages(Rollout.of(scene, seed), arguments.renderer)
        for frame in range(EVERY, arguments.frames, EVERY):
            image = images.load(frame)
            if image is not None:
                yield image


def spread(found: StatisticsRange, name: str) -> str:
    return f"{getattr(found.least, name):.2f} to {getattr(found.most, name):.2f}"


def heads(names: Iterable[str]) -> str:
    return "".join(f"{name[:12]:>12s}   " for name in names)


def show_axes(name: str) -> None:
    """Print what each axis, and each named weather, does to the contrast at some depths."""
    weathers = [(weather, {}) for weather in WEATHERS if weather != "clear"]
    weathers += [("noon", axis) for axis in AXES]
    clear = contrasts(name, "clear", {})[0]
    print(f"\n{name}: contrast that is left, law and drawn, at metres of depth")
    depths = "".join(f"{f'{near:g}-{far:g} m':>14s}" for near, far in DEPTHS)
    print(
        f"{'weather':24s} {'visibility':>10s} {'5 %':>7s}{depths}{'mean luma':>11s}{'clipped':>9s}"
    )
    for weather, axis in weathers:
        drawn, visibility, mean, clipped = contrasts(name, weather, axis)
        cells = "".join(
            f"{contrast_left(0.5 * (near + far), visibility):7.2f} {one / all_:6.2f}"
            for (near, far), one, all_ in zip(DEPTHS, drawn, clear, strict=True)
        )
        label = weather + "".join(f", {knob} {value:g}" for knob, value in axis.items())
        eye = visibility * np.log(20.0) / np.log(50.0)
        print(f"{label:24s} {visibility:8.0f} m {eye:5.0f} m{cells}{mean:11.1f}{clipped:8.1f}%")


def contrasts(
    name: str, weather: str, axis: dict[str, float]
) -> tuple[list[float], float, float, float]:
    """Contrast in each range of depths, visibility, and with the look: mean luma, share clipped."""
    scene = find_scene(name, frames=41, weather=weather, **axis)
    rollout = Rollout.of(scene, 3)
    view = view_of(rollout, 40)
    rendered = find_renderer("raster").render(view)
    air = replace(scene.weather, noise=0.0, vignetting=0.0)
    seen, developed = (
        cv2.cvtColor(post_process(air, view, rendered, 3, 40, look=look), cv2.COLOR_RGB2GRAY)
        for look in (PLAIN, scene.camera_look)
    )
    near = [(rendered.depth >= least) & (rendered.depth < most) for least, most in DEPTHS]
    drawn = [float(seen[inside].astype(float).std()) for inside in near]
    clipped = 100.0 * float((developed >= 250).mean())
    return drawn, scene.weather.visibility, float(developed.mean()), clipped


def write_frames(arguments: argparse.Namespace, weather: str) -> None:
    """Write one frame of each scene at full size: as drawn, and with the look."""
    look = find_camera_look(arguments.look)
    seed = int(arguments.seeds.split(",")[0])
    for name in arguments.scenes.split(","):
        scene = find_scene(name, frames=41, weather=weather)
        rollout = Rollout.of(scene, seed)
        for each in (PLAIN, look):
            seen = Rollout(replace(scene, camera_look=each), seed, rollout.traffic)
            image = RenderedImages(seen, arguments.renderer).load(len(rollout) - 1)
            if image is not None:
                write_image(arguments.out / f"{name}_{weather}_{each.name}.png", image)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    root = os.environ.get("MOT_SIM_KITTI_ROOT")
    parser.add_argument("--root", type=Path, default=Path(root) if root else None)
    parser.add_argument("--scenes", default="street,intersection,town")
    parser.add_argument("--weathers", default="noon")
    parser.add_argument("--look", default="kitti", help="of the camera: a name or a TOML file")
    parser.add_argument("--renderer", default="raster")
    parser.add_argument("--seeds", default="3,4")
    parser.add_argument("--frames", type=int, default=61)
    parser.add_argument("--axes", action="store_true", help="what the axes of weather do")
    parser.add_argument("--out", type=Path, help="write a frame of each, and print nothing")
    arguments = parser.parse_args()
    if arguments.axes:
        for name in arguments.scenes.split(","):
            show_axes(name)
        return
    for weather in arguments.weathers.split(","):
        if arguments.out is not None:
            arguments.out.mkdir(parents=True, exist_ok=True)
            write_frames(arguments, weather)
        elif arguments.root is None:
            parser.error("give --root KITTI, or set MOT_SIM_KITTI_ROOT")
        else:
            compare(arguments, weather)


if __name__ == "__main__":
    main()
