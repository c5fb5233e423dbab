"""Mistakes frame by frame: a case by hand, and the same counts as the scores."""

import numpy as np
import pytest

from mot_sim.metrics import evaluate_sequence
from mot_sim.testing import Mistakes, SeededEpisode, follow
from tracker import Tracks

CAR = [100.0, 100.0, 200.0, 180.0]
FAR = [600.0, 100.0, 700.0, 180.0]


def tracks(*rows: tuple[int, int, list[float]]) -> Tracks:
    """Rows of frame, id and box."""
    frames, ids, boxes = zip(*rows, strict=True) if rows else ((), (), ())
    return Tracks(
        np.array(frames, np.int64), np.array(ids, np.int64), np.array(boxes, float).reshape(-1, 4)
    )


def test_a_switch_a_miss_and_a_false_positive_by_hand() -> None:
    truth = tracks(*((frame, 5, CAR) for frame in range(4)))
    shifted = [box + 90.0 * (place % 2 == 0) for place, box in enumerate(CAR)]
    output = tracks((0, 31, CAR), (1, 31, shifted), (3, 32, CAR), (3, 40, FAR))
    found = Mistakes.of(truth, output, 4).found
    assert [(each.frame, each.kind) for each in found] == [
        (1, "miss"), (1, "false positive"), (2, "miss"), (3, "switch"), (3, "false positive")
    ]  # fmt: skip
    missed, invented, _, switched, ghost = found
    assert missed.car == 5
    assert missed.near == (31, pytest.approx(10.0 / 190.0))
    assert "id 31 overlaps it by 0.05" in str(missed)
    assert invented.near == (5, pytest.approx(10.0 / 190.0))
    assert (switched.car, switched.name, switched.before) == (5, 32, (31, 0))
    assert "car 5 was id 31 in frame 0 and is id 32 now" in str(switched)
    assert "[100.0 100.0 200.0 180.0]" in str(switched)
    assert (ghost.name, ghost.near) == (40, None)
    assert str(ghost).startswith("false positive: id 40 [600.0")


def test_nothing_at_all_is_no_mistake() -> None:
    assert len(Mistakes.of(tracks(), tracks(), 3)) == 0
    assert Mistakes.of(tracks(), tracks(), 3).first() is None
    assert Mistakes.of(tracks((1, 5, CAR)), tracks(), 3).counts() == {"miss": 1}
    assert Mistakes.of(tracks(), tracks((1, 5, CAR)), 3).counts() == {"false positive": 1}


@pytest.mark.parametrize("tracker", ["default", "paper", "paper:lifecycle.max_gap=0"])
def test_mistakes_are_what_the_scores_count(episode: SeededEpisode, tracker: str) -> None:
    output = follow(tracker, episode)
    scores = evaluate_sequence(episode.truth, output, episode.frame_count)
    mistakes = Mistakes.of(episode.truth, output, episode.frame_count)
    counts = mistakes.counts()
    assert counts["miss"] == scores["CLR_FN"]
    assert scores["CLR_FN"] > 0 or tracker == "default"  # who may miss nothing in a short run
    assert counts["false positive"] == scores["CLR_FP"]
    assert counts["switch"] == scores["IDSW"]
    frames = [each.frame for each in mistakes.found]
    assert frames == sorted(frames)
