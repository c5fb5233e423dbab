"""OpenGL without a window: pyrender is loaded here, and mended in this one place.

pyrender 0.1.45 asks numpy for `infty`, which numpy 2 no longer has, and pins PyOpenGL 3.1.0:
that one works with EGL but lacks what pyrender needs of OSMesa.
"""

import os
import warnings
from ctypes.util import find_library
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from tracker.errors import NoOpenGL

PLATFORMS = {"egl": "EGL", "osmesa": "OSMesa"}  # PyOpenGL's name, and that of the library
CURE = (
    "install 'mot-sim[gl]' and a library, libegl1 with libegl-mesa0 or a GPU's driver "
    "(or libosmesa6 with PyOpenGL >= 3.1.7, which pyrender's pin keeps out: pip install "
    "--no-deps), or take the renderer 'raster'"
)


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
        raise NoOpenGL(f"neither libEGL nor libOSMesa is here: {CURE}")
    os.environ["PYOPENGL_PLATFORM"] = platform  # read when OpenGL is first imported
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pyrender = import_module("pyrender")
    except (ImportError, AttributeError, OSError, TypeError) as error:
        raise NoOpenGL(f"pyrender cannot be loaded over {platform} ({error}): {CURE}") from error
    pyrender.mesh.np = _OldNumpy()
    return pyrender


def offscreen(pyrender: ModuleType, width: int, height: int) -> Any:
    """A place to draw to. Raises NoOpenGL where the driver gives none."""
    errors = import_module("OpenGL.error")
    try:
        return pyrender.OffscreenRenderer(width, height)
    except (ImportError, AttributeError, OSError, ValueError, RuntimeError, errors.Error) as error:
        platform = os.environ["PYOPENGL_PLATFORM"]
        raise NoOpenGL(f"no OpenGL context over {platform} ({error}): {CURE}") from error
