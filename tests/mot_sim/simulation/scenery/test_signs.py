"""Traffic signs: each stands on its post, and shows its face the right way round."""

import numpy as np
import pytest

from mot_sim.simulation.renderers import MeshInstances, Semantic, View, find_renderer
from mot_sim.simulation.scenery.road_damage import LaneWays, damage_of
from mot_sim.simulation.scenery.signs import BLACK, SIGN_FACES, lettered, sign
from tests.mot_sim.simulation.renderers.shapes import KITTI
from tests.mot_sim.simulation.scenery.places import neighbourhood, roads

KINDS = range(len(SIGN_FACES))


@pytest.mark.parametrize("kind", KINDS)
def test_a_sign_stands_on_the_ground(kind: int) -> None:
    corners = sign(kind).corners.reshape(-1, 3)
    assert corners[:, 2].min() == 0.0
    assert 2.5 < corners[:, 2].max() < 3.0
    assert np.abs(corners[:, :2]).max() < 0.5


@pytest.mark.parametrize("kind", KINDS)
def test_all_of_a_face_but_the_back_looks_the_same_way(kind: int) -> None:
    mesh = sign(kind).mesh(np.zeros(2))
    plate = mesh.semantics == Semantic.OTHER
    x = mesh.normals[plate, 0]
    assert (x < -0.99).any()
    assert ((x < -0.99) | (x > 0.99)).all()


def test_signs_differ_and_any_number_gives_one() -> None:
    assert len({sign(kind).corners.tobytes() for kind in KINDS}) == len(SIGN_FACES)
    assert sign(3 + len(SIGN_FACES)).corners.tobytes() == sign(3).corners.tobytes()


def test_digits_lie_beside_each_other() -> None:
    strokes = np.array(lettered("30", 0.4))
    assert np.isclose(strokes[:, 0].min(), -strokes[:, 2].max())
    assert (strokes[:, 3] > strokes[:, 1]).all()
    three, nought = strokes[:5], strokes[5:]
    assert three[:, 2].max() < nought[:, 0].min()


def test_a_speed_limit_reads_from_left_to_right() -> None:
    T = np.eye(4)
    T[:3] = [[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 2.4], [1.0, 0.0, 0.0, 3.0]]
    view = View(KITTI, MeshInstances((sign(1).mesh(np.zeros(2)),), T[None], np.array([-1])))
    image = find_renderer("raster").render(view).image
    u, v = KITTI.K[:2, 2].astype(int)
    ink = (image.max(axis=2) < 45)[v - 60 : v + 60, u - 60 : u + 60]
    columns = np.flatnonzero(ink.any(axis=0))
    five, nought = np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1)
    shares = ink[:, nought].sum(axis=0)
    assert np.count_nonzero(shares != shares[::-1]) <= 4  # a 0 is the same either way
    rows = np.flatnonzero(ink.any(axis=1))
    upper, lower = np.array_split(ink[rows][:, five[:3]], 2)
    assert upper.sum() > 1.5 * lower.sum()  # of a 5 the upper half is closed on the left
    assert max(BLACK) < 45


@pytest.mark.parametrize("road", ["street", "intersection"])
def test_signs_face_those_who_drive_on_their_side(road: str) -> None:
    ways, facing = LaneWays.of(roads(road)), []
    for item in neighbourhood(road).scenery.items:
        if item.kind == "sign":
            solid = item.make(0)
            front = solid.corners[solid.semantics == Semantic.OTHER][
                -1
            ]  # of the face, not the back
            across = np.cross(front[1] - front[0], front[2] - front[0])
            away = -across[:2] / np.linalg.norm(across)  # x, y and height are left-handed
            facing.append(float(away @ ways.at(item.base.mean(axis=0))))
    assert len(facing) > 3
    assert np.mean(np.array(facing) < -0.8) > 0.75  # near junctions another lane may be nearer


@pytest.mark.parametrize("road", ["street", "roundabout"])
def test_patches_of_asphalt_lie_along_lanes(road: str) -> None:
    ways = LaneWays.of(roads(road))
    marks, _ = damage_of(roads(road), 3, 1.0)
    patches = [mark.corners for mark in marks if len(mark.corners) == 4]
    sized = [each for each in patches if np.ptp(each, axis=0).max() > 0.5]  # no bars of covers
    assert len(sized) > 5
    for corners in sized:
        along = corners[1] - corners[0]
        way = ways.at(corners.mean(axis=0))
        assert abs(along @ way) > 0.999 * np.hypot(*along)
