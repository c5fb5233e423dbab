"""Pictures that looks are compared by: photographs of folders, and drawn frames of scenes."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.datasets.images import ImageFolder
from mot_sim.simulation.camera_looks.fitting import DrawnFrame
from mot_sim.simulation.imaging import motion_at, view_of
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import find_renderer
from mot_sim.simulation.scene import Knob, Rollout
from mot_sim.simulation.scenery import post_process
from tracker.errors import BadConfig

FIRST_FRAME = 10  # that is taken of a run, so that cars have come into sight


def photographs(folder: Path, count: int) -> list[UInt8[Array, "h w 3"]]:
    """Images of a folder, RGB, evenly spread over it, at most so many.

    Raises DatasetNotFound where there are none, BadFile for what is no image.
    """
    if count < 1:
        raise BadConfig(f"{count} photographs of a folder: give 1 or more")
    found = ImageFolder.require(folder)
    numbers = sorted(found.paths)
    chosen = np.unique(np.linspace(0, len(numbers) - 1, min(count, len(numbers))).round())
    images = (found.load(numbers[int(at)]) for at in chosen)
    return [image for image in images if image is not None]


def drawn_frames(
    scene: str,
    seeds: Sequence[int],
    every: int = 10,
    frames: int = 61,
    renderer: str = "raster",
    progress: Callable[[], None] | None = None,
    **knobs: Knob,
) -> list[DrawnFrame]:
    """Every so manieth frame of a scene's runs as it reaches the camera, under its weather.

    Raises as `find_scene` and `find_renderer`.
    """
    drawing, found = find_renderer(renderer), []
    for seed in seeds:
        rollout = Rollout.of(find_scene(scene, frames=frames, **knobs), seed)
        weather = replace(rollout.scene.weather, noise=0.0, vignetting=0.0, jpeg=100.0)
        for frame in range(min(FIRST_FRAME, len(rollout) - 1), len(rollout), every):
            view, motion = view_of(rollout, frame), motion_at(rollout, frame)
            image = post_process(weather, view, drawing.render(view), seed, frame, motion)
            found.append(DrawnFrame(image, view.camera, seed, frame))
            if progress is not None:
                progress()
    return found
