"""The OpenGL renderer: OpenGL finds what is seen, `raster` colours it.

pyrender is loaded and mended here: 0.1.45 asks numpy for `infty`, which numpy 2 no longer has,
and pins PyOpenGL 3.1.0, which works with EGL but lacks what pyrender needs of OSMesa.
"""

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32
from numpy import ndarray as Array

from mot_sim.simulation.renderers.filling import Fragments
from mot_sim.simulation.renderers.raster import RasterRenderer
from mot_sim.simulation.renderers.triangles import NEAR_METRES, Triangles
from tracker.errors import BadConfig, NoOpenGL
from tracker.types import Camera

PLATFORMS = {"egl": "EGL", "osmesa": "OSMesa"}  # PyOpenGL's name, and that of the library
OPENGL_CURE = (
    "install 'mot-sim[gl]' and a library, libegl1 with libegl-mesa0 or a GPU's driver "
    "(or libosmesa6 with PyOpenGL >= 3.1.7, which pyrender's pin keeps out: pip install "
    "--no-deps), or take the renderer 'raster'"
)
FAR_METRES = 2000.0  # metres; nothing farther is drawn
NEARER = 0.99  # of the near plane: where OpenGL cuts what has been cut there before
LEFT_GL_CAM = np.array((1.0, -1.0, -1.0))  # OpenGL's camera: y up, z backwards


class _OldNumpy:
    """numpy with the name that pyrender still uses."""

    infty = np.inf

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


def load_pyrender() -> ModuleType:
    """pyrender, ready to draw without a window. Raises NoOpenGL where that cannot be."""
    platform = os.environ.get("PYOPENGL_PLATFORM") or next(
        (name for name, library in PLATFORMS.items() if find_library(library)), None
    )
    if platform is None:
        raise NoOpenGL(f"neither libEGL nor libOSMesa is here: {OPENGL_CURE}")
    os.environ["PYOPENGL_PLATFORM"] = platform  # read when OpenGL is first imported
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pyrender = import_module("pyrender")
    except (ImportError, AttributeError, OSError, TypeError) as error:
        raise NoOpenGL(
            f"pyrender cannot be loaded over {platform} ({error}): {OPENGL_CURE}"
        ) from error
    pyrender.mesh.np = _OldNumpy()
    return pyrender


def offscreen(pyrender: ModuleType, width: int, height: int) -> Any:
    """A place to draw to. Raises NoOpenGL where the driver gives none."""
    errors = import_module("OpenGL.error")
    try:
        return pyrender.OffscreenRenderer(width, height)
    except (ImportError, AttributeError, OSError, ValueError, RuntimeError, errors.Error) as error:
        platform = os.environ["PYOPENGL_PLATFORM"]
        raise NoOpenGL(f"no OpenGL context over {platform} ({error}): {OPENGL_CURE}") from error


class OpenGLFiller:
    """Finds the nearest triangles with OpenGL: each has its number for a colour.

    Raises NoOpenGL where there is none, or where it mixes the colours of neighbours.
    """

    def __init__(self, near: float) -> None:
        self._near = near
        self._pyrender = load_pyrender()
        self._target = offscreen(self._pyrender, 64, 64)
        if not self.keeps_colours():
            self.close()
            raise NoOpenGL(f"OpenGL mixes the colours of neighbours here: {OPENGL_CURE}")

    def fill(self, triangles: Triangles, camera: Camera) -> Fragments:
        """The nearest triangle at each pixel's centre; of several at one depth, the first."""
        pyrender, K = self._pyrender, camera.K
        scene = pyrender.Scene(bg_color=np.zeros(4))
        middle = K[:2, 2] + 0.5  # OpenGL's pixel centres lie at halves
        lens = pyrender.IntrinsicsCamera(
            K[0, 0], K[1, 1], *middle, znear=NEARER * self._near, zfar=FAR_METRES
        )
        scene.add(lens, pose=np.eye(4))
        corners = LEFT_GL_CAM * triangles.corners.reshape(-1, 3)
        corners[:, 0] -= K[0, 1] / K[0, 0] * corners[:, 1]  # skew, which OpenGL's camera has not
        primitive = pyrender.Primitive(
            positions=corners,
            color_0=np.repeat(_codes(len(triangles)), 3, axis=0),
            material=pyrender.MetallicRoughnessMaterial(doubleSided=True),  # culled already
        )
        scene.add(pyrender.Mesh([primitive]), pose=np.eye(4))
        self._target.viewport_width, self._target.viewport_height = camera.image_size
        with _one_sample(pyrender):
            coded, depth = self._target.render(scene, flags=pyrender.RenderFlags.FLAT)
        numbers = coded.astype(np.int32) @ np.array((1, 1 << 8, 1 << 16), np.int32)
        nearness = np.zeros(depth.shape, np.float32)
        np.divide(1.0, depth, out=nearness, where=depth > 0.0)
        return Fragments(np.ascontiguousarray(numbers), nearness)

    def fill_apart(
        self, triangles: Triangles, camera: Camera, leaves: Bool[Array, " t"]
    ) -> tuple[Fragments, Fragments | None]:
        """`fill` of the triangles that are no leaves, and of those that are, if there are any."""
        others = self._fill_some(triangles, camera, ~leaves)
        return others, self._fill_some(triangles, camera, leaves) if leaves.any() else None

    def _fill_some(
        self, triangles: Triangles, camera: Camera, some: Bool[Array, " t"]
    ) -> Fragments:
        """`fill` of some of the triangles, with their numbers among all."""
        if some.all():
            return self.fill(triangles, camera)
        rows = np.flatnonzero(some)
        if not len(rows):
            shape = camera.image_size[::-1]
            return Fragments(np.zeros(shape, np.int32), np.zeros(shape, np.float32))
        found = self.fill(triangles.at(rows), camera)
        return Fragments(np.append(0, 1 + rows).astype(np.int32)[found.numbers], found.nearness)

    def close(self) -> None:
        """Give OpenGL's memory back."""
        self._target.delete()

    def keeps_colours(self) -> bool:
        """Whether triangles side by side have their own numbers at every pixel."""
        K = np.array([[32.0, 0.0, 15.5], [0.0, 32.0, 15.5], [0.0, 0.0, 1.0]])
        square = np.array([[-0.4, -0.4, 1], [0.4, -0.3, 1], [-0.3, 0.4, 1], [0.4, 0.4, 1]])
        corners = 2.0 * self._near * square[[[0, 1, 2]] * 200 + [[2, 1, 3]]]
        rows = np.zeros(len(corners), np.int64)
        found = self.fill(Triangles(corners, rows, rows), Camera.mounted(K, (32, 32), 1.0))
        return np.unique(found.numbers).tolist() == [0, 1, len(corners)]


class MeshRenderer(RasterRenderer):
    """Finds what is seen with OpenGL (EGL or OSMesa); light, materials and edges are `raster`'s.

    Edges of objects are smooth in the image, not in depth and ids. Pixels at edges may differ
    between drivers. near: metres; what is nearer is cut off. shadows: on the road. Raises NoOpenGL.
    """

    def __init__(self, near: float = NEAR_METRES, shadows: bool = True) -> None:
        super().__init__(near, shadows, antialias=True)
        self._opengl = OpenGLFiller(near)
        self.filler = self._opengl

    def close(self) -> None:
        """Give OpenGL's memory back; the renderer is of no use afterwards."""
        self._opengl.close()


@contextmanager
def _one_sample(pyrender: ModuleType) -> Iterator[None]:
    """Without several samples a pixel, which pyrender switches on for every picture."""
    names = pyrender.renderer
    switch_on = names.glEnable

    def switch(what: Any) -> None:
        (names.glDisable if what == names.GL_MULTISAMPLE else switch_on)(what)

    names.glEnable = switch
    try:
        yield
    finally:
        names.glEnable = switch_on


def _codes(count: int) -> Float32[Array, "n 4"]:
    """1, 2, ... as colours, in bytes from the lowest on, opaque."""
    if count >= 1 << 24:
        raise BadConfig(f"{count} triangles before the camera: OpenGL tells 16,777,215 apart")
    codes = np.ones((count, 4), np.float32)
    for band in range(3):
        codes[:, band] = ((np.arange(1, count + 1) >> 8 * band) & 255) / 255.0
    return codes
