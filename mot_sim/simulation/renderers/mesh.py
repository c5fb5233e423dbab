"""The OpenGL renderer: pyrender draws the objects, lit and anti-aliased; the road is raster's.

pyrender is loaded and mended here: 0.1.45 asks numpy for `infty`, which numpy 2 no longer has,
and pins PyOpenGL 3.1.0, which works with EGL but lacks what pyrender needs of OSMesa.
"""

import os
import warnings
from ctypes.util import find_library
from functools import lru_cache
from importlib import import_module
from types import ModuleType
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.simulation.renderers.raster import RasterRenderer
from mot_sim.simulation.renderers.triangles import NEAR_METRES
from mot_sim.simulation.renderers.view import NO_INSTANCE, Mesh, Rendered, View
from tracker.errors import BadConfig, NoOpenGL

PLATFORMS = {"egl": "EGL", "osmesa": "OSMesa"}  # PyOpenGL's name, and that of the library
OPENGL_CURE = (
    "install 'mot-sim[gl]' and a library, libegl1 with libegl-mesa0 or a GPU's driver "
    "(or libosmesa6 with PyOpenGL >= 3.1.7, which pyrender's pin keeps out: pip install "
    "--no-deps), or take the renderer 'raster'"
)
FAR_METRES = 2000.0  # metres; nothing farther is drawn
GAMMA = 2.2  # pyrender's: it lights linear colours and encodes the sum
SUN_INTENSITY = 3.0  # of the sun: about pi, by which a Lambertian face divides it
ROUGHNESS = 0.55
A_gl_cam = np.diag((1.0, -1.0, -1.0, 1.0))  # OpenGL's camera: y up, z backwards


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


class MeshRenderer:
    """Draws with OpenGL (EGL or OSMesa). Equal to `raster` but for light and edges.

    Edges are anti-aliased in the image (not by OSMesa), not in depth and ids, which come from a
    second draw.
    Frames may differ in bits between drivers. near: metres; what is nearer is cut off.
    """

    def __init__(self, near: float = NEAR_METRES, shadows: bool = True) -> None:
        self._backdrop = RasterRenderer(near, shadows)
        self._near = near
        self._pyrender = load_pyrender()
        self._target = offscreen(self._pyrender, 64, 64)
        self._parts = lru_cache(maxsize=512)(self._build_parts)

    def render(self, view: View) -> Rendered:
        """The frame of a view; its arrays are the caller's own."""
        rendered = self._backdrop.backdrop(view)
        scene, nodes, rows, semantics = self._scene(view)
        if not nodes:
            return rendered
        self._target.viewport_width, self._target.viewport_height = view.camera.image_size
        flags = self._pyrender.RenderFlags
        rgba, reached = self._target.render(scene, flags=flags.RGBA)
        if rgba.shape[2] == 3:  # OSMesa tells no alpha: whole pixels, no smooth edges
            rgba = np.dstack((rgba, np.where(reached > 0.0, 255, 0).astype(np.uint8)))
        seg_map = {node: _code(number + 1) for number, node in enumerate(nodes)}
        coded, depth = self._target.render(scene, flags=flags.SEG, seg_node_map=seg_map)
        codes = coded.astype(np.int64) @ (1, 1 << 8, 1 << 16)
        covered = (codes > 0).astype(np.uint8)
        instances = np.concatenate(([NO_INSTANCE], view.instances.ids[rows])).astype(np.int32)
        kinds = np.concatenate(([0], semantics)).astype(np.uint8)
        # The edges' colours come mixed with the black of nothing: add the backdrop's share.
        left = cv2.merge([cv2.bitwise_not(rgba[..., 3])] * 3)
        behind = cv2.multiply(rendered.image, left, scale=1.0 / 255.0)
        cv2.copyTo(depth.astype(np.float32), covered, rendered.depth)
        cv2.copyTo(kinds[codes], covered, rendered.semantics)
        image = cv2.add(np.ascontiguousarray(rgba[..., :3]), behind)
        seen, unlit = instances[codes], view.instances.unlit
        return Rendered(image, rendered.depth, seen, rendered.semantics, unlit)

    def close(self) -> None:
        """Give OpenGL's memory back; the renderer is of no use afterwards."""
        self._target.delete()

    def _scene(self, view: View) -> tuple[Any, list[Any], Int[Array, " k"], Int[Array, " k"]]:
        """pyrender's scene; its nodes, and the object and the semantic id of each."""
        K, pyrender = view.camera.K, self._pyrender
        if K[0, 1] != 0.0:
            raise BadConfig(f"K has a skew of {K[0, 1]:g}: OpenGL's camera has none; take 'raster'")
        ambient = np.full(3, view.sun.ambient**GAMMA)
        scene = pyrender.Scene(bg_color=np.zeros(4), ambient_light=ambient)
        middle = K[:2, 2] + 0.5  # OpenGL's pixel centres lie at halves
        scene.add(
            pyrender.IntrinsicsCamera(K[0, 0], K[1, 1], *middle, znear=self._near, zfar=FAR_METRES),
            pose=np.eye(4),
        )
        light = pyrender.DirectionalLight(color=np.ones(3), intensity=SUN_INTENSITY)
        towards = A_gl_cam[:3, :3] @ view.camera.T_cam_road[:3, :3] @ view.sun.direction
        scene.add(light, pose=_looking_from(towards))
        nodes, rows, semantics = [], [], []
        for row, mesh in enumerate(view.instances.meshes):
            pose = A_gl_cam @ view.instances.T_cam_object[row]
            for semantic, part in self._parts(mesh):
                nodes.append(scene.add(part, pose=pose))
                rows.append(row)
                semantics.append(semantic)
        return scene, nodes, np.array(rows, np.int64), np.array(semantics, np.int64)

    def _build_parts(self, mesh: Mesh) -> list[tuple[int, Any]]:
        """A pyrender mesh for each semantic id of a mesh, flat shaded, its back faces culled."""
        pyrender, parts = self._pyrender, []
        material = pyrender.MetallicRoughnessMaterial(
            metallicFactor=0.0, roughnessFactor=ROUGHNESS, doubleSided=False
        )
        for semantic in np.unique(mesh.semantics).tolist():
            faces = np.flatnonzero(mesh.semantics == semantic)
            colours = np.ones((3 * len(faces), 4))
            colours[:, :3] = np.repeat((mesh.colours[faces] / 255.0) ** GAMMA, 3, axis=0)
            primitive = pyrender.Primitive(
                positions=mesh.corners[faces].reshape(-1, 3),
                normals=np.repeat(mesh.normals[faces], 3, axis=0),
                color_0=colours,
                material=material,
            )
            parts.append((semantic, pyrender.Mesh([primitive])))
        return parts


def _code(number: int) -> tuple[int, int, int]:
    """A number as a colour."""
    return number & 255, (number >> 8) & 255, number >> 16


def _looking_from(towards: Float[Array, "3"]) -> Float[Array, "4 4"]:
    """The pose of a light whose rays come from a direction; it shines along its own -z."""
    side = np.cross((0.0, 0.0, 1.0) if abs(towards[2]) < 0.9 else (0.0, 1.0, 0.0), towards)
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, :3] = np.stack((side, np.cross(towards, side), towards), axis=1)
    return pose
