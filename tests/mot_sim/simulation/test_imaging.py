"""Images of an episode, drawn when somebody asks."""

import sys

import numpy as np
import pytest

from mot_sim.datasets import ImageSource
from mot_sim.simulation.episode import record
from mot_sim.simulation.imaging import RenderedImages, motion_at, renderer_name, view_of
from mot_sim.simulation.renderers import Rendered, View, find_renderer
from mot_sim.simulation.scene import Rollout
from mot_sim.simulation.scenery import post_process
from tests.mot_sim.simulation.episodes.small import FRAMES, small
from tracker.errors import NoOpenGL, UnknownName


class Blank:
    """A renderer of one's own."""

    def render(self, view: View) -> Rendered:
        """Nothing."""
        raise NotImplementedError


def test_frames_carry_the_image_of_their_view() -> None:
    episode = record(small(), 1, renderer="raster")
    rollout = Rollout.of(small(), 1)
    assert isinstance(episode.images, ImageSource)
    for frame in episode:
        view = view_of(rollout, frame.index)
        drawn = find_renderer("raster").render(view)
        motion = motion_at(rollout, frame.index)
        weather, look = rollout.scene.weather, rollout.scene.camera_look
        seen = post_process(weather, view, drawn, 1, frame.index, motion, look)
        np.testing.assert_array_equal(frame.image, seen)
    assert all(frame.image is None for frame in record(small(), 1))


def test_a_subset_draws_its_frames_alone() -> None:
    drawn = record(small(), 1, renderer="raster").subset([4])
    (frame,) = drawn
    np.testing.assert_array_equal(frame.image, RenderedImages(Rollout.of(small(), 1)).load(4))


def test_there_is_no_image_beyond_the_take() -> None:
    drawn = RenderedImages(Rollout.of(small(), 1))
    assert drawn.load(FRAMES) is None
    assert drawn.load(-1) is None


def test_the_view_holds_the_cars_of_the_frame() -> None:
    rollout = Rollout.of(small(), 1)
    assert view_of(rollout, 0).instances.ids.tolist() == rollout.traffic_states[0].ids.tolist()
    assert view_of(rollout, 0).camera is rollout.scene.rig.camera


def test_a_cut_take_has_the_same_cars_as_a_short_one() -> None:
    whole, cut = Rollout.of(small(), 1), Rollout.of(small(), 1).until(1)
    assert len(cut) == 1
    assert len(cut.scene_meshes.vehicles) == 1  # the second car comes later
    assert len(whole.scene_meshes.vehicles) == 2
    assert whole.scene_meshes.vehicles.paints[0] == cut.scene_meshes.vehicles.paints[0]


def test_renderers_have_the_names_of_the_register() -> None:
    assert (
        renderer_name(find_renderer("raster"))
        == RenderedImages(Rollout.of(small(), 1)).renderer_name
    )
    assert renderer_name(find_renderer("raster")) == "raster"
    assert renderer_name(Blank()) == "Blank"


def test_an_unknown_renderer_and_a_missing_library_are_told_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(UnknownName, match="unknown renderer 'rastr'"):
        record(small(), 1, renderer="rastr")
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    monkeypatch.setitem(sys.modules, "pyrender", None)
    with pytest.raises(NoOpenGL, match=r"install 'mot-sim\[gl\]'"):
        record(small(), 1, renderer="mesh")
