"""Following an episode: what counts as a tracker, and what its failures are called."""

import warnings
from typing import Any

import numpy as np
import pytest
from numpy import ndarray as Array

from mot_sim.experiments.guests import ExternalOnlineTracker
from mot_sim.testing import SeededEpisode, TrackerFailed, follow
from tests.mot_sim.experiments import odd
from tracker import FRAMEWORKS, Camera, Frame, Tracker, Tracks
from tracker.errors import BadConfig, MotionWarning


def rows_of(tracks: Tracks) -> list[tuple]:
    return sorted(
        zip(tracks.frames.tolist(), tracks.ids.tolist(), tracks.boxes.tolist(), strict=True)
    )


class OddPairs:
    """Answers with more ids than boxes."""

    def update(self, boxes: Array, scores: Array) -> tuple[Array, Array]:
        return np.arange(len(boxes) + 1), boxes


class Resets:
    """Refuses to go back in time unless it is reset."""

    def __init__(self) -> None:
        self.frames: list[int] = []

    def reset(self) -> None:
        self.frames.clear()

    def step(self, frame: Frame) -> Tracks:
        assert not self.frames or self.frames[-1] < frame.index
        self.frames.append(frame.index)
        return Tracks.empty()


class Warns:
    """Finds the motion wrong, as a tracker may where odometry is disturbed on purpose."""

    def step(self, frame: Frame) -> Tracks:
        warnings.warn("the boxes contradict the motion", MotionWarning, stacklevel=1)
        return Tracks.empty()


def test_wrong_motion_is_no_failure(episode: SeededEpisode) -> None:
    """Even where warnings are errors, as in this test run and in many others'."""
    assert len(follow(Warns(), episode)) == 0


def test_all_ways_to_name_our_tracker_give_the_same_rows(episode: SeededEpisode) -> None:
    ready = Tracker.default(episode.camera)
    wanted = rows_of(follow(ready, episode))
    assert len(wanted) > 20
    for same in (ready, Tracker.default, "default", odd.built, odd.Later):
        assert rows_of(follow(same, episode)) == wanted


def test_a_tracker_with_reset_is_used_again(episode: SeededEpisode) -> None:
    tracker = Resets()
    follow(tracker, episode)
    follow(tracker, episode)
    assert tracker.frames == list(range(12))


def test_trackers_of_boxes_and_scores_may_answer_in_two_ways(episode: SeededEpisode) -> None:
    seen = sum(len(frame.detections) for frame in episode.frames)
    assert len(follow(odd.Updates, episode)) == seen
    assert len(follow(odd.Pairs(), episode)) == seen


@pytest.mark.parametrize("name", FRAMEWORKS)
def test_delayed_frameworks_are_finished(episode: SeededEpisode, name: str) -> None:
    def made(camera: Camera) -> Any:
        return FRAMEWORKS[name](Tracker.default(camera))

    assert len(follow(made, episode)) > 20


def test_a_guest_is_a_tracker_whose_failure_is_named(
    episode: SeededEpisode, monkeypatch: pytest.MonkeyPatch
) -> None:
    from mot_sim.experiments.guests import ExternalTracker

    words = ("{python}", "-c", "print()", "{detections}", "{results}")
    live = (
        "{python}",
        "-u",
        "-c",
        "for n, line in enumerate(open(0)): n and print([[4, 1, 1, 9, 9, 1]])",
    )
    output = follow(ExternalOnlineTracker(ExternalTracker("own", words, live=live)), episode)
    assert set(output.ids.tolist()) == {4}
    assert len(output) == 12
    live = ("{python}", "-c", "raise SystemExit('no model')")
    with pytest.raises(
        TrackerFailed,
        match=r"ExternalOnlineTracker failed in frame 0: ExternalTrackerFailed.*ended",
    ):
        follow(ExternalOnlineTracker(ExternalTracker("own", words, live=live)), episode)


@pytest.mark.parametrize(
    ("tracker", "told", "frame"),
    [
        (odd.Raises, "Raises failed in frame 2: ZeroDivisionError: no car at all", 2),
        (odd.Leaves, "in frame 0: SystemExit: 3", 0),
        (odd.GivesNaN, r"in frame 0: boxes that are not finite, of ids \[4\]", 0),
        (odd.Twice, r"ids that stand twice in a frame: \[7\]", 0),
        (odd.WrongShape, r"wrong shape: .*\(2, 5\)", 0),
        (odd.Negative, r"ids below 0: \[-1\]", 0),
        (odd.Late, r"rows of another frame: \[-1\]", 0),
        (odd.GivesNothing, "gave a NoneType, not Tracks", 0),
        (OddPairs, "in frame 0: ids of shape", 0),
        (lambda camera: odd.Later(camera, twice=True), "twice in a frame", None),
    ],
)
def test_what_a_tracker_does_wrong_is_named_and_never_scored(
    episode: SeededEpisode, tracker: Any, told: str, frame: int | None
) -> None:
    with pytest.raises(TrackerFailed, match=told) as caught:
        follow(tracker, episode)
    assert caught.value.frame == frame


@pytest.mark.parametrize(
    ("tracker", "told"),
    [
        (odd.NoTracker, "neither step"),
        (7, "tracker int: a int is no tracker"),
        (lambda model: None, "cannot be built"),
        ("defualt", "unknown tracker 'defualt'"),
    ],
)
def test_what_is_no_tracker_is_refused(episode: SeededEpisode, tracker: Any, told: str) -> None:
    with pytest.raises(BadConfig if "unknown" not in told else Exception, match=told):
        follow(tracker, episode)
