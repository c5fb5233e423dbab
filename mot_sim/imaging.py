"""From a frame of a take to what a renderer draws, and its pictures when somebody asks."""

from dataclasses import dataclass
from functools import cached_property

from jaxtyping import UInt8
from numpy import ndarray as Array

from mot_sim.renderers import RENDERERS, Rendered, Renderer, View, find_renderer
from mot_sim.scene import Take


def view_of(take: Take, frame: int) -> View:
    """All that stands before the camera in a frame."""
    return View(take.scene.rig.camera, take.stage.placed(take.worlds[frame]))


@dataclass(frozen=True, eq=False)
class Drawn:
    """The frames of a take, drawn one by one when somebody asks; satisfies `ImageSource`.

    renderer: a name of RENDERERS, or `auto`. Raises UnknownName and NoOpenGL at once.
    """

    take: Take
    renderer: str = "raster"

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
        """Image, depth, instances and semantics of a frame."""
        return self.drawing.render(view_of(self.take, frame))

    def load(self, frame: int) -> UInt8[Array, "h w 3"] | None:
        """The RGB image of a frame; None beyond the take."""
        return self.render(frame).image if 0 <= frame < len(self.take) else None


def renderer_name(renderer: Renderer) -> str:
    """The name in RENDERERS of what draws; for one that is not registered, its class's."""
    kind = type(renderer)
    place = f"{kind.__module__}:{kind.__qualname__}"
    return next((name for name, where in RENDERERS.items() if where == place), kind.__qualname__)
