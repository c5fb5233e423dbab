"""Side by side: scores, speed, and those that fail."""

from pathlib import Path

import pytest

from mot_sim.datasets import RecordedSequence
from mot_sim.experiments.guests import (
    Entry,
    ExternalSequenceTracker,
    Failure,
    find_sequence_tracker,
    run_comparison,
)
from tests.mot_sim.experiments.guests.conftest import truth_of
from tests.mot_sim.experiments.guests.programs import guest
from tracker.errors import BadConfig
from tracker.types import Tracks


def truths(drives: list[RecordedSequence]) -> dict[str, Tracks]:
    """The labels by drive."""
    return {drive.name: truth_of(drive) for drive in drives}


def test_quality_and_speed_come_from_one_run(
    drives: list[RecordedSequence], programs: Path
) -> None:
    contestants = [find_sequence_tracker("iou"), ExternalSequenceTracker(guest(programs, "good"))]
    contest = run_comparison(contestants, drives, truths(drives))
    assert contest.failures == {}
    good, iou = contest.entries["good"], contest.entries["iou"]
    assert isinstance(good, Entry)
    assert isinstance(iou, Entry)
    assert good.frames_per_second == 7.0  # 7 frames in the 2 x 0.5 s that it told
    assert iou.frames_per_second is not None
    for entry in (good, iou):
        assert entry.evaluation.combined["MOTA"] == 1.0
        assert entry.evaluation.combined["CLR_TP"] == 14


def test_one_that_fails_does_not_stop_the_others(
    drives: list[RecordedSequence], programs: Path
) -> None:
    bad = [
        ExternalSequenceTracker(guest(programs, "crashes")),
        ExternalSequenceTracker(guest(programs, "rubbish", "0 0 5 5 9 9 0.5")),
    ]
    contest = run_comparison([*bad, find_sequence_tracker("iou")], drives, truths(drives))
    assert list(contest.failures) == ["crashes", "rubbish"]
    assert "an id twice in a frame: frame 0, id 0" in contest.failures["rubbish"].reason
    assert isinstance(contest.entries["iou"], Entry)
    table = contest.table("title")
    assert table.rows[0] == ("crashes", *[None] * 10)
    assert table.rows[2][:3] == ("iou", 0.3, 1.0)
    told = contest.as_dict()["crashes"]
    assert isinstance(told, dict)
    assert "no such weights" in told["stderr"]


def test_what_the_rules_do_not_know_stays_empty(
    drives: list[RecordedSequence], programs: Path
) -> None:
    contest = run_comparison([find_sequence_tracker("iou")], drives, truths(drives), "devkit2018")
    (row,) = contest.table().as_records()
    assert (row["MOTA"], row["HOTA"], row["IDF1"]) == (1.0, None, None)


def test_tracks_are_passed_on_of_those_that_came_through(
    drives: list[RecordedSequence], programs: Path
) -> None:
    kept = {}
    contestants = [
        ExternalSequenceTracker(guest(programs, "crashes")),
        find_sequence_tracker("iou"),
    ]
    run_comparison(contestants, drives, truths(drives), keep=kept.__setitem__)
    assert list(kept) == ["iou"]
    assert len(kept["iou"]["a"]) == 8


def test_an_error_that_is_not_ours_is_not_swallowed(drives: list[RecordedSequence]) -> None:
    class Broken:
        name = "broken"

        def track(self, drives: object) -> object:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_comparison([Broken()], drives, truths(drives))


def test_nothing_to_compare_on_is_refused() -> None:
    with pytest.raises(BadConfig, match="nothing to compare on"):
        run_comparison([find_sequence_tracker("iou")], [], {})


def test_a_failure_without_stderr_has_none(drives: list[RecordedSequence], programs: Path) -> None:
    contest = run_comparison(
        [
            ExternalSequenceTracker(
                guest(programs, "none", program="good"), programs / "good.py" / "x"
            )
        ],
        drives, truths(drives),
    )  # fmt: skip
    assert isinstance(contest.entries["none"], Failure)
    assert contest.entries["none"].stderr == ""
