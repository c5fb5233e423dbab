"""Finding renderers by name, with and without OpenGL."""

import logging
import sys

import pytest

from mot_sim.simulation.renderers import RENDERERS, Renderer, find_renderer
from mot_sim.simulation.renderers import mesh as gl
from mot_sim.simulation.renderers.raster import RasterRenderer
from tracker.errors import TrackingError, UnknownName


@pytest.fixture
def no_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine on which no OpenGL library is installed."""
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr(gl, "find_library", lambda name: None)


@pytest.fixture
def no_pyrender(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine with OpenGL, but without the extra `gl`."""
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    monkeypatch.setitem(sys.modules, "pyrender", None)


def test_the_embedded_renderer_is_the_default() -> None:
    assert isinstance(find_renderer(), RasterRenderer)
    assert isinstance(find_renderer("raster"), Renderer)
    assert list(RENDERERS) == ["raster", "smooth", "mesh"]


def test_an_unknown_renderer_is_named_with_its_neighbour() -> None:
    with pytest.raises(UnknownName, match=r"unknown renderer 'rastr'.*Did you mean 'raster'\?"):
        find_renderer("rastr")


@pytest.mark.usefixtures("no_opengl")
def test_without_an_opengl_library_it_says_what_to_install() -> None:
    with pytest.raises(TrackingError, match=r"neither libEGL nor libOSMesa .* 'mot-sim\[gl\]'"):
        find_renderer("mesh")


@pytest.mark.usefixtures("no_pyrender")
def test_without_pyrender_it_says_what_to_install() -> None:
    with pytest.raises(TrackingError, match=r"pyrender cannot be loaded .* 'mot-sim\[gl\]'"):
        find_renderer("mesh")


@pytest.mark.usefixtures("no_opengl")
def test_only_auto_falls_back_and_says_so(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert isinstance(find_renderer("auto"), RasterRenderer)
    assert "drawing with 'raster': neither libEGL" in caplog.text
