"""Titles and legends."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from mot_sim.plotting.canvas import text_width
from mot_sim.plotting.colours import (
    SKY_COLOUR,
    SWITCH_COLOUR,
    WRONG_COLOUR,
    colour_of_id,
)
from mot_sim.report import Film
from mot_sim.report.error_strip import STRIP_PIXELS
from mot_sim.report.film import LEGEND_TEXT_PIXELS, Layers, legend, marks, title, title_words, wrap
from tests.mot_sim.report.small import FRAMES, SIZE, drive, exact_tracks
from tracker.types import CarEstimates, Tracks


def test_the_title_names_drive_frame_time_and_switches() -> None:
    assert title_words("0005", 7, 0.7, None) == "0005   frame 007    0.7 s"
    assert title_words("0005", 7, 0.7, 1).endswith("1 switch so far")
    assert title_words("0005", 7, 0.7, 2).endswith("2 switches so far")


def test_the_trackers_name_gives_way_in_a_narrow_title() -> None:
    wide = title(1242, "0005", "default", detections=True)
    assert wide[:, 600:].std() > 1.0
    narrow = title(200, "0005   frame 007", "default", detections=True)
    alone = title(200, "0005   frame 007", "another", detections=False)
    assert (narrow == alone).all()


def test_lines_are_as_wide_as_allowed_and_lose_nothing() -> None:
    parts = [f"mark number {number}" for number in range(9)]
    lines = wrap(parts, 300)
    assert len(lines) > 1
    assert all(text_width(line, LEGEND_TEXT_PIXELS) <= 300 for line in lines)
    assert [part for line in lines for part in line.split("    ")] == parts
    assert wrap(["a mark that is longer than the line"], 10) == [
        "a mark that is longer than the line"
    ]
    assert legend(300, []).shape == (6, 300, 3)


def test_every_layer_has_its_mark() -> None:
    bare = Layers(top_view=False)
    assert marks(bare, outlines=False) == []
    for name in ("truth", "search_areas", "cuboids", "wireframes", "true_wireframes", "top_view"):
        named = Layers(**{"top_view": False, name: True})
        assert marks(named, outlines=False), name
    assert "white: truth" in marks(Layers(), outlines=True)[0]
    assert np.array_equal(legend(200, ["a"]), legend(200, ["a"]))


WIDTH, HEIGHT = SIZE
TITLE, TOP_VIEW = 32, 313
BARE = Layers(detections=False, top_view=False)


def film(layers: Layers = BARE, tracks: Tracks | None = None, **more: object) -> Film:
    truth = drive().truth if layers.truth else None
    return Film(drive(), exact_tracks() if tracks is None else tracks, "exact", layers, truth,
                **more)  # fmt: skip


def view(shown: Film, index: int = 3) -> np.ndarray:
    """The camera's part of a frame."""
    ((found, frame),) = shown.frames(index, index + 1)
    assert found == index
    return frame[TITLE : TITLE + HEIGHT]


def test_a_frame_is_title_view_and_top_view() -> None:
    frames = list(film(Layers()).frames())
    assert [index for index, _ in frames] == list(range(FRAMES))
    assert {frame.shape for _, frame in frames} == {(TITLE + HEIGHT + TOP_VIEW, WIDTH, 3)}
    ((_, alone),) = film().frames(0, 1)
    assert alone.shape[0] < TITLE + HEIGHT + 50


def test_the_view_is_the_image_with_the_tracks_on_it() -> None:
    image = drive().images.load(3)
    changed = (view(film()) != image).any(axis=2)
    assert 0.02 < changed.mean() < 0.3
    assert (view(film()) == colour_of_id(10)).all(axis=2).sum() > 50
    assert (view(film(tracks=Tracks.empty())) == image).all()


@pytest.mark.parametrize("layer", ["detections", "truth", "search_areas", "true_wireframes"])
def test_every_layer_draws_something_near_the_cars_only(layer: str) -> None:
    plain, more = view(film()), view(film(replace(BARE, **{layer: True})))
    changed = (plain != more).any(axis=2)
    assert changed.any()
    assert not changed[:20].any()


def test_missed_false_and_switched_boxes_are_marked() -> None:
    tracks = exact_tracks()
    later = (tracks.ids == 10) & (tracks.frames >= 3)
    anew = replace(tracks, ids=np.where(later, 77, tracks.ids))
    layers = replace(BARE, truth=True)
    assert not (view(film(layers, anew), 2) == SWITCH_COLOUR).all(axis=2).any()
    assert (view(film(layers, anew), 3) == SWITCH_COLOUR).all(axis=2).sum() > 50
    missed = view(film(layers, tracks.select(tracks.ids != 10)), 2)
    assert (missed == WRONG_COLOUR).all(axis=2).sum() > 30
    moved = replace(tracks, boxes=tracks.boxes + np.array([70.0, 0.0, 70.0, 0.0]))
    assert (view(film(layers, moved), 2) == WRONG_COLOUR).all(axis=2).sum() > 30
    assert not (view(film(layers), 2) == WRONG_COLOUR).all(axis=2).any()


def test_without_images_it_is_drawn_on_plain_ground() -> None:
    shown = film()
    blind = replace(shown, drive=replace(drive(), images=None))
    assert (view(blind)[35:40] == SKY_COLOUR).all(axis=2).any()


def test_the_scale_is_that_of_the_finished_frame() -> None:
    ((_, whole),) = film(Layers()).frames(2, 3)
    ((_, half),) = film(Layers(), scale=0.5).frames(2, 3)
    assert half.shape == (round(whole.shape[0] / 2), WIDTH // 2, 3)
    small = cv2.resize(whole, (half.shape[1], half.shape[0]), interpolation=cv2.INTER_AREA)
    assert np.abs(half.astype(int) - small).mean() < 3.0  # the height is odd: not quite the same


def test_the_top_view_follows_us_or_stays() -> None:
    def above(follow: bool, index: int) -> np.ndarray:
        layers = Layers(detections=False, follow=follow)
        ((_, frame),) = film(layers, Tracks.empty()).frames(index, index + 1)
        return frame[TITLE + HEIGHT : -30]

    assert (above(True, 0) == above(True, 5)).all()  # rings around us, and nobody drawn
    assert (above(False, 0) != above(False, 5)).any()


def test_trails_grow_as_tracks_go() -> None:
    tracks, layers = stated(exact_tracks()), Layers(detections=False)
    whole = dict(film(layers, tracks).frames())
    sizes = []
    for index in (0, 2, 5):
        ((_, alone),) = film(layers, tracks.select(tracks.frames == index)).frames(index, index + 1)
        above = slice(TITLE + HEIGHT, None)
        sizes.append(int((whole[index][above] != alone[above]).any(axis=2).sum()))
    assert sizes[2] > sizes[1] > sizes[0] == 0


def test_frames_that_are_not_delivered_are_not_shown() -> None:
    sparse = replace(film(), drive=drive().subset([0, 2, 5]))
    assert [index for index, _ in sparse.frames()] == [0, 2, 5]
    assert [index for index, _ in sparse.frames(1, 5)] == [2]


def stated(tracks: Tracks, off: float = 0.0) -> Tracks:
    """The tracks with the true cuboids, `off` metres too far, as their states."""
    truth = drive().truth
    cuboids = truth.select(truth.ids >= 0).cuboids
    assert cuboids is not None
    known = np.array([0.0, 0.0, off])
    means = np.column_stack([
        cuboids.base + known, cuboids.yaw, np.zeros(len(tracks)), np.log(cuboids.size),
        np.zeros(len(tracks)),
    ])  # fmt: skip
    covs = np.tile(np.eye(9), (len(tracks), 1, 1))
    states = CarEstimates(means, covs, np.ones(len(tracks)))
    return tracks.replaced(cuboids=states.cuboids(), estimates=states)


def test_the_view_from_above_shows_what_tracks_state() -> None:
    def mine(off: float) -> float:
        """How far right the track's outline is."""
        tracks = stated(exact_tracks(), off)
        ((_, frame),) = film(Layers(detections=False), tracks).frames(3, 4)
        above = (frame[TITLE + HEIGHT : -30] == colour_of_id(10)).all(axis=2)
        return float(np.flatnonzero(above.any(axis=0)).max())

    assert mine(2.0) - mine(0.0) == pytest.approx(2.0 * 7.8, abs=2.0)


def test_errors_over_time_stand_below_where_labels_and_tracks_have_cuboids() -> None:
    layers = Layers(detections=False, truth=True)
    ((_, without),) = film(layers).frames(3, 4)
    ((_, frame),) = film(layers, stated(exact_tracks(), 2.0)).frames(3, 4)
    assert frame.shape[0] == without.shape[0] + STRIP_PIXELS
    ((_, shown),) = film(layers, stated(exact_tracks(), 0.0)).frames(3, 4)
    assert (shown != frame).any()


def test_cuboids_stand_in_the_image_in_place_of_boxes() -> None:
    tracks = stated(exact_tracks())
    boxes, cuboids = view(film(tracks=tracks)), view(film(replace(BARE, cuboids=True), tracks))
    assert (cuboids == colour_of_id(10)).all(axis=2).sum() > 50
    left = round(float(tracks.boxes[(tracks.frames == 3) & (tracks.ids == 10)][0, 0]))
    column = (slice(40, 60), left)
    assert (boxes[column] == colour_of_id(10)).all(axis=1).mean() > 0.9
    assert (boxes != cuboids).any(axis=2).mean() > 0.01


def test_pedestrians_are_judged_where_pedestrians_are_tracked() -> None:
    truth = drive().truth
    walkers = truth.replaced(kinds=np.where(truth.ids >= 0, "Pedestrian", "DontCare"))
    tracks = exact_tracks()
    kinds = np.full(len(tracks), "Pedestrian")
    tracks = tracks.replaced(kinds=kinds).select(tracks.ids != 10)
    shown = film(replace(BARE, truth=True), tracks)
    assert (view(replace(shown, truth=walkers), 2) == WRONG_COLOUR).all(axis=2).sum() > 30
