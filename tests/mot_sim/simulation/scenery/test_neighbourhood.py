"""The world around roads: the same for the same seed, off the road, rich in corners, small."""

import hashlib
import subprocess
import sys

import cv2
import numpy as np
import pytest

from mot_sim.simulation.renderers import NO_INSTANCE, MeshInstances, Semantic, find_renderer
from mot_sim.simulation.scenery import WEATHERS, Knobs, Light, Neighbourhood, Scenery, post_process
from mot_sim.simulation.scenery.ground import LEVEL_COUNT
from mot_sim.simulation.scenery.patches import Patches
from mot_sim.simulation.scenery.scenery import MAX_DISTANCE_METRES
from mot_sim.simulation.scenery.window import MAX_TILES
from mot_sim.simulation.traffic import Roads
from tests.mot_sim.simulation.scenery.places import CAMERA, EGOS, ego_on, neighbourhood, roads
from tracker.errors import BadConfig
from tracker.types import Camera

RASTER = find_renderer("raster")
HASH = """
import hashlib
from mot_sim.simulation.renderers import MeshInstances, find_renderer
from mot_sim.simulation.scenery import WEATHERS, post_process
from tests.mot_sim.simulation.scenery.places import CAMERA, ego_on, neighbourhood
view = neighbourhood("street").view(CAMERA, ego_on("street"), MeshInstances.empty())
image = post_process(WEATHERS["noon"], view, find_renderer("raster").render(view), 3, 5)
print(hashlib.sha256(image.tobytes()).hexdigest())
"""


def frame(place: Neighbourhood, ego: np.ndarray) -> np.ndarray:
    return RASTER.render(place.view(CAMERA, ego, MeshInstances.empty())).image


@pytest.mark.parametrize("road", sorted(EGOS))
def test_feature_odometry_finds_enough_corners(road: str) -> None:
    view = neighbourhood(road).view(CAMERA, ego_on(road), MeshInstances.empty())
    image = post_process(WEATHERS["noon"], view, RASTER.render(view), 1, 0)
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    assert len(cv2.ORB_create(2000).detect(grey)) >= 300


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    ego = ego_on("street")
    first = frame(neighbourhood("street"), ego)
    again = frame(Neighbourhood.build(roads("street"), 3, WEATHERS["noon"].light), ego)
    other = frame(Neighbourhood.build(roads("street"), 4, WEATHERS["noon"].light), ego)
    assert first.tobytes() == again.tobytes()
    assert np.count_nonzero((first != other).any(axis=2)) > 0.3 * first.shape[0] * first.shape[1]


def test_two_processes_give_the_same_bytes() -> None:
    run = subprocess.run(
        [sys.executable, "-c", HASH], capture_output=True, text=True, check=True, timeout=120
    )
    view = neighbourhood("street").view(CAMERA, ego_on("street"), MeshInstances.empty())
    image = post_process(WEATHERS["noon"], view, RASTER.render(view), 3, 5)
    assert run.stdout.strip() == hashlib.sha256(image.tobytes()).hexdigest()


def test_a_place_looks_the_same_on_whatever_way_one_gets_there() -> None:
    ego = ego_on("intersection")
    place = Neighbourhood.build(roads("intersection"), 3, WEATHERS["noon"].light)
    for turn in (2.0, 1.0, 0.4):
        place.view(CAMERA, ego + (3.0, -1.0, turn), MeshInstances.empty())
    assert frame(place, ego).tobytes() == frame(neighbourhood("intersection"), ego).tobytes()


@pytest.mark.parametrize("road", sorted(EGOS))
def test_nothing_stands_where_cars_drive(road: str) -> None:
    asphalt = [s.corners for s in roads(road).surfaces if s.paint == "asphalt"]
    driven = Patches(tuple(asphalt), ((255,),) * len(asphalt))
    items = neighbourhood(road).scenery.items
    assert len(items) > 20
    for item in items:
        if item.kind == "wire":
            assert item.make(0).corners[..., 2].min() > 4.5  # above all cars
            continue
        low = item.base.min(axis=0) - 0.2
        size = np.ceil((np.ptp(item.base, axis=0) + 0.4) / 0.1).astype(int)
        under = driven.fill(np.zeros((size[1], size[0]), np.uint8), low, 0.1)
        foot = Patches((item.base,), ((255,),)).fill(np.zeros_like(under), low, 0.1)
        assert not (under & foot).any(), item.kind


@pytest.mark.parametrize("road", ["intersection", "highway"])
def test_scenery_is_nobodys_and_near_enough(road: str) -> None:
    instances = neighbourhood(road).scenery_at(ego_on(road), CAMERA)
    assert 3 < len(instances) < 60
    assert (instances.ids == NO_INSTANCE).all()
    assert not any(mesh.casts for mesh in instances.meshes)  # their shadows lie in the texture
    assert (
        np.linalg.norm(instances.T_cam_object[:, :3, 3], axis=1).max() < MAX_DISTANCE_METRES + 50.0
    )


def test_memory_is_bounded() -> None:
    place = neighbourhood("street")
    for x in np.arange(60.0, 100.0, 8.0).tolist():
        place.road_at(np.array([x, 1.75, 0.0]), CAMERA)
    windows, ground = place.windows, place.windows.ground
    tile = next(iter(windows.tiles.values())).nbytes
    window = next(iter(windows.now.values())).pixels.nbytes
    grain = sum(one.nbytes for one in (*ground.grain.stones, *ground.grain.blades))
    assert len(windows.tiles) <= MAX_TILES
    assert MAX_TILES * tile + LEVEL_COUNT * window + grain < 300e6


def test_the_road_tells_where_cars_drive() -> None:
    rendered = RASTER.render(
        neighbourhood("highway").view(CAMERA, ego_on("highway"), MeshInstances.empty())
    )
    assert rendered.semantics[370, 620] == Semantic.ROAD
    kinds = set(np.unique(rendered.semantics).tolist())
    assert {Semantic.SKY, Semantic.ROAD, Semantic.GROUND, Semantic.VEGETATION} <= kinds


def test_no_roads_at_all_give_a_meadow() -> None:
    place = Neighbourhood.build(Roads(), 3)
    rendered = RASTER.render(place.view(CAMERA, np.zeros(3), MeshInstances.empty()))
    assert not (rendered.semantics == Semantic.ROAD).any()


def test_a_camera_that_looks_up_sees_no_ground() -> None:
    upwards = Camera.mounted(CAMERA.K, CAMERA.image_size, 1.65, pitch=1.2)
    view = neighbourhood("street").view(upwards, ego_on("street"), MeshInstances.empty())
    assert (RASTER.render(view).semantics != Semantic.ROAD).all()


def test_two_groups_of_objects_become_one() -> None:
    some = neighbourhood("street").scenery_at(ego_on("street"), CAMERA)
    both = some.beside(some)
    assert len(both) == 2 * len(some)
    assert len(MeshInstances.empty().beside(MeshInstances.empty())) == 0


@pytest.mark.parametrize(
    ("knobs", "told"),
    [
        ({"wear": 1.5}, "wear of a neighbourhood is 1.5: give 0 to 1"),
        ({"trees": -1.0}, "trees of a neighbourhood is -1: give 0 to 3"),
        ({"houses": float("nan")}, "houses of a neighbourhood is nan"),
    ],
)
def test_knobs_out_of_range_are_refused(knobs: dict[str, float], told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        Knobs(**knobs)


def test_a_sun_below_the_horizon_is_refused() -> None:
    with pytest.raises(BadConfig, match="elevation of 5 to 90"):
        Light(elevation=-3.0)
    with pytest.raises(BadConfig, match="shade of the light is 2"):
        Light(shade=2.0)


def test_an_ego_pose_that_is_not_finite_is_refused() -> None:
    with pytest.raises(BadConfig, match="ego pose"):
        neighbourhood("street").view(CAMERA, np.array([np.nan, 0.0, 0.0]), MeshInstances.empty())


def test_the_sun_turns_against_the_ego() -> None:
    light = Light(azimuth=90.0, elevation=45.0)  # on the right of who looks along +x
    assert np.allclose(light.sun(0.0).direction, np.array([1.0, -1.0, 0.0]) / 2**0.5)
    assert np.allclose(light.sun(np.pi / 2).direction, np.array([0.0, -1.0, 1.0]) / 2**0.5)


def test_scenery_alone_is_what_is_drawn() -> None:
    alone = Scenery.around(roads("street"), 3, Knobs())
    drawn = Neighbourhood.build(roads("street"), 3, Light(azimuth=10.0)).scenery_at
    one, other = alone.seen_from(ego_on("street"), CAMERA), drawn(ego_on("street"), CAMERA)
    assert len(one) == len(other) > 0
    assert np.array_equal(one.T_cam_object, other.T_cam_object)
    for mesh, same in zip(one.meshes, other.meshes, strict=True):
        assert np.array_equal(mesh.vertices, same.vertices)
        assert np.array_equal(mesh.colours, same.colours)


def test_scenery_is_made_again_the_same() -> None:
    first = Scenery.around(roads("street"), 3)
    again = Scenery.around(Roads(roads("street").surfaces, roads("street").lanes), 3)
    assert again is not first
    places = zip(first.items, again.items, strict=True)
    assert all(np.array_equal(one.base, other.base) for one, other in places)


def test_a_window_that_moves_on_shows_what_a_new_one_would() -> None:
    place = Neighbourhood.build(roads("street"), 3, WEATHERS["noon"].light)
    for x in (0.0, 7.0, 9.0, 30.0):
        moved = frame(place, ego_on("street") + (x, 0.0, 0.1))
    again = frame(neighbourhood("street"), ego_on("street") + (30.0, 0.0, 0.1))
    assert moved.tobytes() == again.tobytes()
