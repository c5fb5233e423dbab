"""Cars in and out of mesh files."""

import logging
from pathlib import Path

import numpy as np
import pytest
import trimesh

from mot_sim.simulation.cars import PARTS, export_car, load_car, load_fleet
from tracker.errors import BadConfig, BadFile, BadOutput, UnknownName

FLEET = load_fleet()


def a_box(path: Path, size: tuple[float, float, float]) -> Path:
    trimesh.creation.box(size).export(path)
    return path


def test_a_car_of_the_fleet_comes_back_from_its_glb(tmp_path: Path) -> None:
    coefficients = FLEET.sample(6, np.arange(1)).coefficients[0]
    path = export_car(coefficients, tmp_path / "car.glb", "red")
    car, again = FLEET.car(coefficients), load_car(path)
    np.testing.assert_allclose(again.size, car.size, atol=1e-5)
    assert again.mesh().is_watertight
    assert again.mesh().volume == pytest.approx(car.mesh().volume, rel=1e-4)
    assert len(again.faces) == len(car.faces)
    nose = car.vertices[:, 0].argmax()  # forward stays forward, up stays up, left stays left
    gaps = np.linalg.norm(again.vertices - car.vertices[nose], axis=1)
    assert gaps.min() < 1e-5


def test_the_glb_holds_a_mesh_a_part_in_its_colour(tmp_path: Path) -> None:
    path = export_car(np.zeros(5), tmp_path / "car.glb", (10, 20, 30))
    scene = trimesh.load_scene(path)
    assert set(scene.geometry) == set(PARTS)
    paint = scene.geometry["paint"]
    assert paint.visual.vertex_colors[0].tolist() == [10, 20, 30, 255]


@pytest.mark.parametrize("ending", ["obj", "glb", "ply", "stl", "off"])
def test_a_users_mesh_is_turned_scaled_and_stood_on_the_road(tmp_path: Path, ending: str) -> None:
    path = a_box(tmp_path / f"box.{ending}", (2.0, 4.0, 1.0))  # drives along y, stands on z
    car = load_car(path, forward="+y", up="+z", length=5.0)
    np.testing.assert_allclose(car.size, (5.0, 1.25, 2.5), atol=1e-6)
    np.testing.assert_allclose(car.vertices.max(axis=0), (2.5, 0.0, 1.25), atol=1e-6)
    assert car.mesh().is_watertight
    assert car.mesh().volume == pytest.approx(5.0 * 1.25 * 2.5)
    assert car.keypoints is None
    small = car.scaled_to(np.array([3.0, 1.0, 2.0]))
    np.testing.assert_allclose(small.size, (3.0, 1.0, 2.0), atol=1e-6)


def test_the_axes_lead_forward_down_and_left(tmp_path: Path) -> None:
    corner = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 4]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    corner.export(tmp_path / "corner.obj")
    car = load_car(tmp_path / "corner.obj", forward="-x", up="+z")  # so left is -y
    assert car.size.tolist() == [1.0, 4.0, 2.0]
    expected = np.array([[0.5, 0, 1], [-0.5, 0, 1], [0.5, 0, -1], [0.5, -4, 1]])
    for point in expected:
        assert np.linalg.norm(car.vertices - point, axis=1).min() < 1e-9
    assert car.mesh().volume > 0.0  # turned, not mirrored


def test_a_mesh_with_a_hole_is_taken_and_the_log_says_so(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    box = trimesh.creation.box((1, 1, 3))
    trimesh.Trimesh(box.vertices, box.faces[1:]).export(tmp_path / "open.obj")
    with caplog.at_level(logging.WARNING):
        load_car(tmp_path / "open.obj")
    assert "open.obj is not watertight" in caplog.text


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("car.obj", b"", "holds no faces|is no obj mesh"),
        ("car.obj", b"v 0 0 0\nv 1 0 0\n", "holds no faces|is no obj mesh"),
        ("car.glb", b"glTF, but not really", "is no glb mesh"),
        ("car.glb", b"", "is no glb mesh"),
        ("car.ply", b"\x00\x01\x02", "is no ply mesh"),
        ("car.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a flat mesh"),
        ("car.step", b"ISO-10303", "not a format of meshes known here"),
    ],
)
def test_files_that_hold_no_car_are_refused(
    tmp_path: Path, name: str, content: bytes, told: str
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadFile, match=told):
        load_car(tmp_path / name)


def test_what_cannot_be_meant_is_said(tmp_path: Path) -> None:
    path = a_box(tmp_path / "box.obj", (1.0, 1.0, 1.0))
    with pytest.raises(BadFile, match="no mesh file"):
        load_car(tmp_path / "none.obj")
    with pytest.raises(UnknownName, match="unknown axis 'front'"):
        load_car(path, forward="front")
    with pytest.raises(BadConfig, match="are one axis"):
        load_car(path, forward="+z", up="-z")
    with pytest.raises(BadConfig, match="a car -1 m long"):
        load_car(path, length=-1.0)
    with pytest.raises(UnknownName, match=r"unknown colour 'rod'.*Did you mean 'red'"):
        export_car(np.zeros(5), tmp_path / "car.glb", "rod")
    with pytest.raises(BadConfig, match="shape coefficient 0 of car 0 is 50"):
        export_car(np.full(5, 50.0), tmp_path / "car.glb")
    with pytest.raises(BadOutput, match=r"end the name in .glb"):
        export_car(np.zeros(5), tmp_path / "car.stl")
    with pytest.raises(BadOutput, match="No such file"):
        export_car(np.zeros(5), tmp_path / "nowhere" / "car.glb")
