"""Crops of rendered cars."""

from pathlib import Path

import numpy as np
import pytest

from mot_sim.simulation.random_numbers import named_stream
from mot_sim.simulation.registry import find_scene
from mot_sim.simulation.renderers import Semantic, find_renderer
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.scenery import Knobs, Light, Neighbourhood
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import exact_crops
from mot_sim.training.keypoint_crops import (
    ANY_CAR_MARK,
    CROP_PIXELS,
    CROP_ROOM,
    MIN_CROP_VISIBLE_SHARE,
    OWN_CAR_MARK,
    Crops,
    crops_of,
    gather_crops,
    load_crops,
    save_crops,
    shard_path,
)
from mot_sim.training.learning import score_keypoints
from mot_sim.training.random_views import (
    PLACE_SCENES,
    Place,
    camera_of,
    cars_before,
    random_view,
    viewpoint,
)
from tests.mot_sim.training.made_up import made_up
from tracker.errors import BadFile, DatasetNotFound
from tracker.shape import CROP_MARGIN, Hourglass, decode


@pytest.fixture(scope="module")
def drawn() -> tuple[Crops, Crops]:
    """The crops of one moment, drawn twice, in a place without houses, which is made sooner."""
    roads = find_scene(PLACE_SCENES[0]).roads
    bare = Neighbourhood.build(roads, 2, Light(), Knobs(houses=0.0, trees=0.3, furniture=0.3))
    place = Place(2, roads, bare, named_stream(2, "bare place"))
    now, renderer = random_view(place, viewpoint(place)), find_renderer("raster")
    return crops_of(now, renderer, 2, 0), crops_of(now, renderer, 2, 0)


def test_the_same_moment_gives_the_same_crops(drawn: tuple[Crops, Crops]) -> None:
    first, second = drawn
    assert len(first) >= 2
    assert (first.images == second.images).all()
    assert (first.keypoints == second.keypoints).all()
    assert (first.parts == second.parts).all()


def test_a_crop_shows_its_car_in_the_middle(drawn: tuple[Crops, Crops]) -> None:
    crops = drawn[0]
    assert crops.images.shape[1:] == (CROP_PIXELS, CROP_PIXELS, 3)
    longer = (crops.boxes[:, 2:] - crops.boxes[:, :2]).max(axis=1)
    assert longer == pytest.approx(1.0 / (CROP_ROOM * CROP_MARGIN))
    own = crops.parts >= OWN_CAR_MARK
    assert own.any(axis=(1, 2)).all()
    assert (crops.parts[own] >= OWN_CAR_MARK | ANY_CAR_MARK).all()
    assert (crops.visible >= MIN_CROP_VISIBLE_SHARE).all()


def test_visible_keypoints_lie_on_their_car(drawn: tuple[Crops, Crops]) -> None:
    crops = drawn[0]
    rows, columns = np.nonzero(crops.states == KeypointVisibility.VISIBLE)
    assert len(rows) > 10
    at = np.round(crops.keypoints[rows, columns] * CROP_PIXELS - 0.5).astype(int)
    around = np.array([(du, dv) for du in (-2, 0, 2) for dv in (-2, 0, 2)])
    near = np.clip(at[:, None] + around, 0, CROP_PIXELS - 1)
    own = crops.parts[rows[:, None], near[..., 1], near[..., 0]] >= OWN_CAR_MARK
    assert own.any(axis=1).mean() > 0.95


def test_parts_tell_cars_from_what_stands_around(drawn: tuple[Crops, Crops]) -> None:
    kinds = np.unique(drawn[0].parts & (ANY_CAR_MARK - 1))
    assert {Semantic.CAR, Semantic.TYRE} <= set(kinds.tolist())
    ground = drawn[0].parts & (ANY_CAR_MARK - 1) == Semantic.ROAD
    assert not (drawn[0].parts[ground] & OWN_CAR_MARK).any()


@pytest.mark.parametrize("finer", [1.0, 2.0])
def test_cars_hang_on_the_random_numbers_alone_and_none_stands_in_another(finer: float) -> None:
    rig = Rig(camera_of(named_stream(1, "camera"), finer))
    ego = np.array([3.0, -2.0, 0.7])
    (world, cast), (again, _) = (
        cars_before(rig, ego, (9.0, 40.0), named_stream(5, "cars")) for _ in range(2)
    )
    assert (world.x == again.x).all()
    assert (world.heading == again.heading).all()
    assert len(world) == len(cast) > 3
    depth = rig.cuboids(world).base[:, 2]
    assert ((depth > 8.9) & (depth < 40.1)).all()
    apart = np.hypot(world.x[:, None] - world.x, world.y[:, None] - world.y)
    assert apart[~np.eye(len(world), dtype=bool)].min() > 1.0


def test_crops_come_back_from_disk(tmp_path: Path) -> None:
    crops, path = made_up(3), shard_path(tmp_path, 7)
    save_crops(crops, path)
    again = load_crops(path)
    assert (again.images == crops.images).all()
    assert (again.keypoints == crops.keypoints).all()
    assert [path.name for path in tmp_path.iterdir()] == ["crops_0000007.npz"]


def test_crops_that_are_there_are_not_drawn_again(tmp_path: Path) -> None:
    for seed in (20, 21):
        save_crops(made_up(4, seed), shard_path(tmp_path, seed))
    told = []
    crops = gather_crops(tmp_path, 20, 6, lambda *what: told.append(what))
    assert len(crops) == 6
    assert (crops.images[:4] == made_up(4, 20).images).all()
    assert told == [("crops", 4, 6), ("crops", 6, 6)]


def test_a_file_without_crops_is_named(tmp_path: Path) -> None:
    path = shard_path(tmp_path, 0)
    with pytest.raises(DatasetNotFound, match="no crops at"):
        load_crops(path)
    path.write_bytes(b"PK\x03\x04 half a file")
    with pytest.raises(BadFile, match=r"crops_0000000\.npz"):
        gather_crops(tmp_path, 0, 3)
    np.savez(path, images=np.zeros(3))
    with pytest.raises(BadFile, match="delete it"):
        load_crops(path)


def test_the_shipped_network_finds_the_keypoints_of_drawn_cars(drawn: tuple[Crops, Crops]) -> None:
    crops = drawn[0].select((drawn[0].visible > 0.6) & (drawn[0].truncation < 0.05))
    shown = exact_crops(crops)
    found = decode(Hourglass.load().run(shown.images)[0])
    longer = np.full(len(crops), 1.0 / CROP_MARGIN)
    judged = score_keypoints(found, shown.keypoints, shown.states, longer)
    assert judged.seen.sum() > 10
    assert judged.pck > 0.8
