"""Cars from designs: closed, as large as designed, symmetric; volumes and rays as oracles."""

import numpy as np
import pytest
import trimesh

from mot_sim.simulation.cars.design import (
    BODIES,
    BODY_SHARES,
    COMMON_RANGES,
    MIN_ROOF_METRES,
    draw_designs,
    greenhouse,
)
from mot_sim.simulation.cars.shell import SPOKES, TYRE_WIDTH_METRES
from mot_sim.simulation.cars.topology import (
    HALF_POINTS,
    KEYPOINTS,
    PARTS,
    half_points,
    topology,
    whole,
)
from tests.mot_sim.simulation.cars.rays import hits
from tracker.shape import KEYPOINTS_36

CARS = 4


def drawn(body: str, count: int = CARS) -> dict[str, np.ndarray]:
    return draw_designs(body, count, np.random.default_rng(7))


def test_bodies_only_change_measures_that_there_are() -> None:
    assert set(BODIES) == set(BODY_SHARES)
    assert sum(BODY_SHARES.values()) == pytest.approx(1.0)
    for ranges in (COMMON_RANGES, *BODIES.values()):
        assert set(ranges) <= set(COMMON_RANGES)
        assert all(low < high for low, high in ranges.values())


@pytest.mark.parametrize("body", BODIES)
def test_windows_leave_a_roof(body: str) -> None:
    cowl, front, rear, foot = greenhouse(drawn(body, 200))
    assert (front - rear > MIN_ROOF_METRES - 1e-9).all()
    assert (cowl > front).all()
    assert (rear > foot).all()


def test_the_mesh_has_between_600_and_2000_faces_of_every_part() -> None:
    shared = topology()
    assert 600 <= len(shared.faces) <= 2000
    assert set(shared.parts) == set(range(len(PARTS)))
    assert set(shared.pieces) == set(range(9))
    assert set(shared.faces.ravel()) == set(range(len(shared.twins)))


def test_keypoints_are_named_as_the_tracker_names_them() -> None:
    assert KEYPOINTS_36[:18] == tuple(f"left_{name}" for name in list(KEYPOINTS)[:18])


@pytest.mark.parametrize("body", BODIES)
def test_every_piece_is_closed_and_the_box_is_the_design(body: str) -> None:
    designs, shared = drawn(body), topology()
    for car, vertices in enumerate(whole(half_points(designs))):
        for piece in range(9):
            mesh = trimesh.Trimesh(vertices, shared.faces[shared.pieces == piece])
            assert mesh.is_watertight
            assert mesh.is_winding_consistent
            assert mesh.volume > 1e-4
        length, height, width = (designs[name][car] for name in ("length", "height", "width"))
        box = [[-length / 2, -height, -width / 2], [length / 2, 0.0, width / 2]]
        np.testing.assert_allclose([vertices.min(0), vertices.max(0)], box, atol=1e-9)


def test_a_wheel_has_the_volume_of_its_prism() -> None:
    designs, shared = drawn("sedan", 1), topology()
    wheel = trimesh.Trimesh(whole(half_points(designs))[0], shared.faces[shared.pieces == 1])
    area = 0.5 * SPOKES * np.sin(2 * np.pi / SPOKES) * designs["wheel"][0] ** 2
    assert area * (TYRE_WIDTH_METRES - 0.025) < wheel.volume < area * TYRE_WIDTH_METRES


def test_the_right_half_mirrors_the_left() -> None:
    vertices, shared = whole(half_points(drawn("van")))[0], topology()
    left = vertices[:HALF_POINTS]
    np.testing.assert_array_equal(
        vertices[HALF_POINTS:], left[shared.twins[HALF_POINTS:]] * (1, 1, -1)
    )
    assert (left[:, 2] >= 0.0).all()


def test_no_design_gives_no_car() -> None:
    assert whole(half_points(drawn("suv", 0))).shape == (0, len(topology().twins), 3)


@pytest.mark.parametrize("body", ["sedan", "van", "pickup"])
def test_vertical_rays_measure_the_volume_of_the_shell(body: str) -> None:
    shared = topology()
    vertices = whole(half_points(drawn(body, 1)))[0]
    faces = shared.faces[shared.pieces == 0]
    (x_low, _, z_low), (x_high, _, z_high) = vertices.min(0), vertices.max(0)
    columns, rows = 48, 20
    x = x_low + (x_high - x_low) * (np.arange(columns) + 0.503) / columns
    z = z_low + (z_high - z_low) * (np.arange(rows) + 0.497) / rows
    chords = 0.0
    for start in np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2):
        depths, _ = hits(vertices[faces], np.array([start[0], 1.0, start[1]]), np.array([0, -1, 0]))
        assert len(depths) % 2 == 0
        chords += (depths[1::2] - depths[::2]).sum()
    measured = chords * (x_high - x_low) / columns * (z_high - z_low) / rows
    volume = trimesh.Trimesh(vertices, faces).volume
    assert measured == pytest.approx(volume, rel=0.02)


def test_rays_meet_roof_glass_and_tyres_where_a_car_has_them() -> None:
    designs, shared = drawn("sedan", 1), topology()
    vertices = whole(half_points(designs))[0]
    triangles = vertices[shared.faces]
    _, roof, rear, _ = (place[0] for place in greenhouse(designs))
    middle = 0.5 * (roof + rear)
    depths, faces = hits(triangles, np.array([middle, -3.0, 0.01]), np.array([0, 1, 0]))
    assert 3.0 - depths[0] == pytest.approx(designs["height"][0], abs=0.01)
    assert PARTS[shared.parts[faces[0]]] == "paint"
    window = -0.8 * designs["height"][0]
    _, faces = hits(triangles, np.array([middle + 0.2, window, 3.0]), np.array([0, 0, -1]))
    assert PARTS[shared.parts[faces[0]]] == "glass"
    hub = vertices[KEYPOINTS["front_wheel"][0]]
    below = np.array([hub[0] + 0.01, -0.02, 3.0])
    _, faces = hits(triangles, below, np.array([0, 0, -1]))
    assert PARTS[shared.parts[faces[0]]] == "tyre"
