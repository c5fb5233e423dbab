"""Renderers: image, depth, instance and semantic ids of a view, all from one pass."""

from logging import getLogger
from typing import Protocol, runtime_checkable

from mot_sim.files.named_objects import NameRegister
from mot_sim.simulation.renderers.silhouettes import (
    Hidden,
    Layer,
    Scan,
    Silhouettes,
    scan_view,
    silhouettes,
)
from mot_sim.simulation.renderers.surroundings import Cover, Road, Sky, Sun, Texture
from mot_sim.simulation.renderers.triangles import NEAR_METRES
from mot_sim.simulation.renderers.view import (
    NO_INSTANCE,
    Material,
    Mesh,
    MeshInstances,
    Pattern,
    Rendered,
    Semantic,
    Skin,
    View,
    cross,
)
from tracker.errors import TrackingError, UnknownName

__all__ = [
    "AUTO",
    "NEAR_METRES",
    "NO_INSTANCE",
    "RENDERERS",
    "RENDERER_NAMES",
    "Cover",
    "Hidden",
    "Layer",
    "Material",
    "Mesh",
    "MeshInstances",
    "Pattern",
    "Rendered",
    "Renderer",
    "Road",
    "Scan",
    "Semantic",
    "Silhouettes",
    "Skin",
    "Sky",
    "Sun",
    "Texture",
    "View",
    "cross",
    "find_renderer",
    "scan_view",
    "silhouettes",
]
# The name of a renderer: the module and the class that hold it, imported when asked for.
RENDERERS: dict[str, str] = {
    "raster": "mot_sim.simulation.renderers.raster:RasterRenderer",
    "smooth": "mot_sim.simulation.renderers.raster:SmoothRenderer",
    "mesh": "mot_sim.simulation.renderers.mesh:MeshRenderer",
}
RENDERER_NAMES = NameRegister("renderer", RENDERERS)
AUTO = "auto"  # mesh where there is OpenGL, else raster


@runtime_checkable
class Renderer(Protocol):
    """What draws views. Objects stand on the road; nothing is kept between two frames."""

    def render(self, view: View) -> Rendered:
        """The frame of a view; its arrays are the caller's own."""
        ...


def find_renderer(name: str = "raster") -> Renderer:
    """The renderer of a name; `auto` takes what works, and says so where that is not `mesh`.

    Raises UnknownName, and for `mesh` without OpenGL a TrackingError that says what to install.
    """
    if name == AUTO:
        try:
            return find_renderer("mesh")
        except TrackingError as error:
            getLogger(__name__).warning("drawing with 'raster': %s", error)
            return find_renderer("raster")
    if ":" not in name and name not in RENDERERS:
        raise UnknownName.of("renderer", name, [*RENDERERS, AUTO])
    renderer: Renderer = RENDERER_NAMES.make(name, Renderer)
    return renderer
