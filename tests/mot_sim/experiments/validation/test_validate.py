"""Drives are re-enacted, trackers run on both kinds, and what is done is not done again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.datasets import KittiSequence, kitti_sequence
from mot_sim.experiments.guests import GUESTS
from mot_sim.experiments.validation import (
    find_contestant,
    find_contestants,
    made_world,
    real_world,
    reenact,
)
from mot_sim.experiments.validation.validate import Plan, validate
from mot_sim.experiments.validation.worlds import halves_of
from mot_sim.simulation.sensors import find_profile
from tests.mot_sim.cli.conftest import LABELLED, NAMES, tree
from tracker.errors import BadConfig, UnknownName
from tracker.geometry import transform

OURS = ("iou", "iou-greedy", "paper")

__all__ = ["tree"]


@pytest.fixture
def drives(tree: Path) -> list[KittiSequence]:
    """Two drives of two cars."""
    return [kitti_sequence(tree, name) for name in LABELLED]


def test_a_car_is_drawn_where_its_label_stands(drives: list[KittiSequence], tmp_path: Path) -> None:
    made = reenact(drives[0], tmp_path)
    labels = drives[0].truth
    assert labels is not None
    assert (made.truth.ids == labels.ids).all()
    assert labels.cuboids is not None
    camera, centre = drives[0].camera, labels.cuboids.base - [0.0, 0.75, 0.0]
    middle = camera.project(transform(camera.T_cam_road, centre))
    boxes = made.truth.boxes
    assert ((middle > boxes[:, :2]) & (middle < boxes[:, 2:])).all()
    assert list(tmp_path.iterdir())
    again = reenact(drives[0], tmp_path)
    assert (again.sightings.boxes == made.sightings.boxes).all()
    assert (again.sightings.visible == made.sightings.visible).all()


def test_a_made_world_has_the_drives_of_the_real_one(drives: list[KittiSequence]) -> None:
    stages = [reenact(drive) for drive in drives]
    world = made_world(stages, [find_profile("perfect")] * 2, 3)
    assert [drive.name for drive in world.drives] == ["0030-3", "0031-3"]
    assert set(real_world(drives).truths) == set(LABELLED)
    log, truth = world.drives[0].log, world.truths["0030-3"]
    assert np.allclose(log.detections.boxes, truth.boxes)


def test_what_is_done_is_not_done_again(drives: list[KittiSequence], tmp_path: Path) -> None:
    plan = Plan(find_contestants(OURS), 1, "rrc", folder=tmp_path)
    told: list[str] = []
    first = validate(plan, drives, told.append)
    assert first.reenacted is not None
    assert first.reenacted.names == OURS
    assert any(line.startswith("paper: ") for line in told)
    told.clear()
    again = validate(plan, drives, told.append)
    assert not any(line.startswith("paper: ") for line in told)
    assert again.reenacted is not None
    for metric in ("MOTA", "HOTA"):
        assert (again.reenacted.made_scores(metric) == first.reenacted.made_scores(metric)).all()


def test_a_guest_that_is_missing_is_named_and_the_others_go_on(
    drives: list[KittiSequence], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOT_SIM_GUESTS", str(tmp_path))
    found = validate(Plan(find_contestants((*OURS, "sort")), 1, "rrc"), drives, lambda _: None)
    assert set(found.failures) == {"sort"}
    assert "mot-sim compare --setup sort" in found.failures["sort"].reason
    assert found.reenacted is not None
    assert found.reenacted.names == OURS


def test_scenes_are_ranked_beside_real_drives(drives: list[KittiSequence]) -> None:
    plan = Plan(find_contestants(OURS), 2, "rrc", ("crossing",), frames=6, scenes_only=True)
    told: list[str] = []
    found = validate(plan, drives, told.append)
    assert found.scenes["crossing"].worlds == ("crossing, seed 0", "crossing, seed 1")
    assert found.reenacted is None
    assert not any("re-enacted" in line or "drawing" in line for line in told)
    with pytest.raises(BadConfig, match="name some with --scenes"):
        replace(plan, scenes=())


@pytest.mark.parametrize(
    ("names", "told"),
    [(("iou", "paper"), "ranks need 3"), (("iou", "paper", "srot"), "Did you mean 'sort'")],
)
def test_too_few_trackers_and_unknown_ones(names: tuple[str, ...], told: str) -> None:
    with pytest.raises((BadConfig, UnknownName), match=told):
        find_contestants(names)


def test_drives_that_cannot_be_foretold(drives: list[KittiSequence], tree: Path) -> None:
    names = find_contestants(OURS)
    with pytest.raises(BadConfig, match="no half to fit a profile to"):
        validate(Plan(names), drives[:1], lambda _: None)
    unlabelled = kitti_sequence(tree, NAMES[2])
    with pytest.raises(BadConfig, match=f"{NAMES[2]} has no labels"):
        validate(Plan(names, profile="rrc"), [unlabelled], lambda _: None)
    walking = replace(drives[0], kinds=("Pedestrian",))
    with pytest.raises(BadConfig, match="detections of Pedestrian"):
        validate(Plan(names, profile="rrc"), [walking], lambda _: None)
    with pytest.raises(BadConfig, match="--seeds 0"):
        Plan(names, 0)


def test_every_other_drive_is_in_a_half(drives: list[KittiSequence]) -> None:
    assert halves_of(drives * 2 + drives[:1]) == ((0, 2, 4), (1, 3))


def test_all_fifteen_are_known() -> None:
    every = find_contestants(())
    assert len(every) == 15
    assert {each.name for each in every if each.guest is not None} == set(GUESTS)
    assert find_contestant("no-ego").tracker.uses_motion is False
