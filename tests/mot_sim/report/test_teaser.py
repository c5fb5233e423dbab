"""The paper's first figure."""

from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from mot_sim.datasets import DetectionLog
from mot_sim.report.teaser import cuboid_outlines, draw_teaser, save_teaser, track_two_frames
from mot_sim.simulation.rig import Rig
from mot_sim.simulation.truth import boxes_around, project_edges
from tests.mot_sim.report.small import drive
from tracker.errors import BadConfig, BadDetections, DatasetNotFound
from tracker.types import Cuboids, Detections


def test_each_car_is_expected_where_it_is_seen_again() -> None:
    two = track_two_frames(drive(), 2)
    assert len(two.before) == len(two.carried) == len(two.seen) == 2
    assert set(two.seen.ids.tolist()) == set(two.before.ids.tolist())
    for row, track_id in enumerate(two.carried.ids.tolist()):
        (found,) = np.flatnonzero(two.seen.ids == track_id)
        off = two.seen.cuboids.base[found] - two.carried.cuboids.base[row]
        assert np.hypot(off[0], off[2]) < 2.0
        assert two.compared[row, found]
        outline = two.outlines[row]
        middle = two.boxes_seen[found].reshape(2, 2).mean(axis=0)
        assert (outline.min(axis=0) < middle).all()
        assert (middle < outline.max(axis=0)).all()


def test_doubt_grows_from_one_frame_to_the_next() -> None:
    two = track_two_frames(drive(), 2)
    before, after = (np.linalg.det(places.cov) for places in (two.before, two.carried))
    assert (after > before).all()
    assert (two.regions.size[:, ::2] > two.carried.cuboids.size[:, ::2]).all()


def test_a_car_that_was_not_there_has_an_id_of_its_own() -> None:
    log = drive().log
    first_left = ~((log.frames == 2) & (log.detections.boxes[:, 0] < 150.0))
    fewer = DetectionLog(log.frames[first_left], log.detections.select(first_left))
    two = track_two_frames(replace(drive(), log=fewer), 2)
    assert (len(two.before), len(two.seen)) == (1, 2)
    assert len(set(two.seen.ids.tolist())) == 2
    assert two.compared.shape == (1, 2)


def test_silhouettes_are_as_wide_and_high_as_the_boxes_around_cuboids() -> None:
    camera = Rig.kitti().camera
    cuboids = Cuboids(np.array([[1.0, 0, 12], [0, 0, -20], [-4, 0, 30]]), np.array([0.3, 1, 2]),
                      np.tile([4.0, 1.5, 1.7], (3, 1)))  # fmt: skip
    outlines = cuboid_outlines(cuboids, camera)
    around = boxes_around(project_edges(cuboids, camera))
    assert not len(outlines[1])  # behind the camera
    for row in (0, 2):
        box = np.concatenate((outlines[row].min(axis=0), outlines[row].max(axis=0)))
        np.testing.assert_allclose(box, around[row])


def test_frames_without_images_cars_or_successor_are_told() -> None:
    blind, empty = replace(drive(), images=None), DetectionLog(np.zeros(0, np.int64),
                                                              Detections.empty())  # fmt: skip
    with pytest.raises(DatasetNotFound, match="no image of frame 2"):
        track_two_frames(blind, 2)
    with pytest.raises(BadDetections, match=r"no box with a score of 0\.5 or more"):
        track_two_frames(replace(drive(), log=empty), 2)
    for index in (-1, 5, 99):
        with pytest.raises(BadConfig, match="has the frames 0 to 5"):
            track_two_frames(drive(), index)


@pytest.mark.parametrize("ending", ["jpg", "svg"])
def test_the_figure_is_written(tmp_path, ending: str) -> None:
    path = save_teaser(draw_teaser(track_two_frames(drive(), 2)), tmp_path / f"teaser.{ending}")
    if ending == "svg":
        text = path.read_text()
        assert text.lstrip().startswith("<?xml")
        assert text.count("<image") >= 2
    else:
        image = matplotlib.image.imread(path)
        assert image.shape[1] == 2000
        assert image.std() > 0.1


def test_the_areas_are_drawn_in_the_second_image_alone() -> None:
    two = track_two_frames(drive(), 2)
    figure = draw_teaser(two)
    names = [axes.get_title(loc="left") for axes in figure.axes]
    assert names[0] == "near, frame 2: boxes, lifted to 3D"
    compared = int(two.compared.sum())
    assert names[1].endswith(f"{compared} of 4 pairs are compared")
    dashed = [sum(patch.get_linestyle() in ("--", "dashed") for patch in axes.patches)
              for axes in figure.axes]  # fmt: skip
    assert dashed == [0, 2, 0, 2]
