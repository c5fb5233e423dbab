"""From a frame of a rollout to what a renderer draws, and its pictures on request."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.simulation.cores import frame_by_frame
from mot_sim.simulation.renderers import RENDERERS, Rendered, Renderer, View, find_renderer
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import post_process


def view_of(rollout: Rollout, frame: int) -> View:
    """All that stands before the camera in a frame; without roads the cars stand on a plain."""
    state = rollout.traffic_states[frame]
    camera = rollout.scene.rig.camera_in(state)
    cars = rollout.scene_meshes.instances(state)
    if rollout.neighbourhood is None:
        return View(camera, cars)
    return rollout.neighbourhood.view(camera, state.ego, cars)


def motion_at(rollout: Rollout, frame: int) -> tuple[float, float]:
    """Metres ahead and radians to the right that the camera moves up to a frame, at first 0."""
    before, now = (rollout.traffic_states[at].ego for at in (max(frame - 1, 0), frame))
    x, y, turned = (now - before).tolist()
    return x * float(np.cos(now[2])) + y * float(np.sin(now[2])), turned


@dataclass(frozen=True, eq=False)
class RenderedImages:
    """The frames of a rollout, drawn one by one on request; satisfies `ImageSource`.

    Raises UnknownName and NoOpenGL at once.
    """

    rollout: Rollout
    """What is drawn."""
    renderer: str = "raster"
    """A name of RENDERERS, or `auto`."""

    def __post_init__(self) -> None:
        _ = self.drawing

    @cached_property
    def drawing(self) -> Renderer:
        """What draws."""
        return find_renderer(self.renderer)

    @property
    def renderer_name(self) -> str:
        """The name of what draws: what `auto` came to."""
        return renderer_name(self.drawing)

    def render(self, frame: int) -> Rendered:
        """Image, depth, instances and semantics of a frame, in the scene's weather and look."""
        rollout, scene = self.rollout, self.rollout.scene
        view = view_of(rollout, frame)
        drawn = self.drawing.render(view)
        motion = motion_at(rollout, frame)
        image = post_process(
            scene.weather, view, drawn, rollout.seed, frame, motion, scene.camera_look
        )
        return replace(drawn, image=image)

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None beyond the rollout."""
        return self.render(frame).image if 0 <= frame < len(self.rollout) else None


class ImagesAhead:
    """Images of the next frames, drawn by several processes before they are asked for.

    Satisfies `ImageSource`: in order from frame 0 on, any other frame is drawn when it is asked
    for. To be closed.
    """

    def __init__(self, images: RenderedImages, jobs: int = -1) -> None:
        self._images, self._next = images, 0
        self._ahead = frame_by_frame(images.load, len(images.rollout), jobs)

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None beyond the rollout."""
        if frame == self._next < len(self._images.rollout):
            self._next += 1
            return next(self._ahead)
        return self._images.load(frame)

    def close(self) -> None:
        """End the processes."""
        self._ahead.close()


def renderer_name(renderer: Renderer) -> str:
    """The name in RENDERERS of what draws; for one that is not registered, its class's."""
    kind = type(renderer)
    place = f"{kind.__module__}:{kind.__qualname__}"
    return next((name for name, where in RENDERERS.items() if where == place), kind.__qualname__)
