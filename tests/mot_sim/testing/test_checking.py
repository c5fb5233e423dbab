"""`assert_tracks`: what passes, what fails, and what a failure shows."""

import pytest

from mot_sim.testing import SeededEpisode, assert_tracks, follow
from tests.mot_sim.experiments import odd
from tracker import Tracker, Tracks
from tracker.errors import BadConfig, UnknownName
from tracker.types import Frame


class EveryBoxIsNew:
    """Gives every box a new id, so that every car is switched in every frame."""

    def __init__(self) -> None:
        self.next = 0

    def step(self, frame: Frame) -> Tracks:
        rows = odd.rows(frame, range(self.next, self.next + len(frame.detections)))
        object.__setattr__(rows, "boxes", frame.detections.boxes)
        self.next += len(rows)
        return rows


def test_scores_that_keep_the_bounds_are_given_back(episode: SeededEpisode) -> None:
    scores = assert_tracks(Tracker.default, episode, mota=-1.0, idsw=1000, HOTA=0.0, CLR_FP=1000)
    assert scores["HOTA"] > 0.3
    value = float(scores["MOTA"])
    assert_tracks(Tracker.default, episode, mota=value, idsw=scores["IDSW"])


def test_a_failure_names_bound_frame_car_ids_and_boxes(episode: SeededEpisode) -> None:
    with pytest.raises(AssertionError) as caught:
        assert_tracks(EveryBoxIsNew, episode, idsw=3, recall=0.0)
    told = str(caught.value)
    output = follow(EveryBoxIsNew, episode)
    lines = told.split("\n")
    assert lines[0].startswith("EveryBoxIsNew on crossing, seed 1")
    assert lines[1].startswith("  IDSW ")
    assert lines[1].endswith(", must be at most 3")
    assert lines[2].startswith("first bad frame: ")
    frame = int(lines[2].split()[-1])
    assert lines[3].startswith("  switch: car ")
    words = lines[3].split()
    names = output.select(output.frames == frame).ids.tolist()
    assert int(words[words.index("is") + 2]) in names
    assert int(words[2]) in episode.truth.select(episode.truth.frames == frame).ids.tolist()
    assert told.count("must be") == 1
    assert lines[-1].startswith("in all 12 frames: ")


def test_a_failing_rate_shows_the_first_mistake_of_every_kind(episode: SeededEpisode) -> None:
    with pytest.raises(AssertionError, match=r"MOTA .*, must be at least 1\b") as caught:
        assert_tracks(EveryBoxIsNew, episode, mota=1.0)
    told = str(caught.value)
    for kind in ("switch", "miss", "false positive"):
        assert f"{kind}: " in told


def test_only_boxes_that_lie_badly_are_said_to(episode: SeededEpisode) -> None:
    with pytest.raises(AssertionError, match="MOTP"):
        assert_tracks("default", episode, motp=1.0)


@pytest.mark.parametrize(
    ("bounds", "error", "told"),
    [
        ({}, BadConfig, "no bound"),
        ({"moda_": 1.0}, UnknownName, "unknown score 'moda_'"),
        ({"mota": 85.0}, BadConfig, "fractions, 0.85"),
        ({"mota": float("nan")}, BadConfig, "give a number"),
        ({"PT": 3}, BadConfig, "bound PT: neither more nor less of it is better"),
    ],
)
def test_bounds_that_cannot_be_are_refused_before_anything_is_tracked(
    episode: SeededEpisode, bounds: dict, error: type[Exception], told: str
) -> None:
    with pytest.raises(error, match=told):
        assert_tracks(odd.Raises, episode, **bounds)


def test_cuboids_have_bounds_too(episode: SeededEpisode) -> None:
    scores = assert_tracks(Tracker.default, episode, **{"mota3d@2m": -9.0, "centre_median": 99.0})
    with pytest.raises(AssertionError, match=r"centre_median .*, must be at most 0\.001"):
        assert_tracks(Tracker.default, episode, centre_median=0.001)
    assert scores["HOTA3D"] > 0.0
