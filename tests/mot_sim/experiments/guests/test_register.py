"""Guests by name, and as the command line spells them."""

import sys
from pathlib import Path

import pytest

from mot_sim.experiments.guests import (
    GUESTS,
    Environment,
    ExternalTracker,
    ExternalTrackerFailed,
    parse_scores,
    with_scores,
)
from tracker.errors import BadConfig, UnknownName


def test_a_command_gets_its_folders_and_interpreter_even_inside_words() -> None:
    guest = ExternalTracker("mine", ("{python}", "run.py", "--in={detections}", "{results}/all"))
    words = guest.words(Path("/in put"), Path("/out"))
    assert words == [sys.executable, "run.py", "--in=/in put", "/out/all"]


def test_a_guest_is_read_from_a_command_line() -> None:
    guest = ExternalTracker.parse("my-own=python 'my tracker.py' {detections} {results}")
    assert guest.name == "my-own"
    assert guest.command == ("python", "my tracker.py", "{detections}", "{results}")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("python run.py", "write NAME=COMMAND"),
        ("mine=", "write NAME=COMMAND"),
        ("a/b=run {detections} {results}", "write NAME=COMMAND"),
        ("mine=run {detections}", "has no {results}"),
        ("mine=run {results}", "has no {detections}"),
        ("mine=run 'open {detections} {results}", "No closing quotation"),
    ],
)
def test_what_is_no_guest_is_refused(text: str, told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        ExternalTracker.parse(text)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"min_score": 30.0}, "score 30; give a probability"),
        ({"min_score": float("nan")}, "score nan"),
        ({"timeout": 0.0}, "timeout 0 s"),
        ({"timeout": float("inf")}, "timeout inf s"),
    ],
)
def test_numbers_outside_their_range_are_refused(more: dict[str, float], told: str) -> None:
    with pytest.raises(BadConfig, match=told):
        ExternalTracker("mine", ("run", "{detections}", "{results}"), **more)


def test_one_score_is_for_all_and_a_named_one_wins() -> None:
    chosen = with_scores(GUESTS, parse_scores("0.5,sort=0.25"))
    scores = {name: guest.min_score for name, guest in chosen.items()}
    assert scores.pop("sort") == 0.25
    assert scores == dict.fromkeys(GUESTS.keys() - {"sort"}, 0.5)


@pytest.mark.parametrize("text", ["", "sort=", "=0.3", "0.3,0.4", "high", "sort=nan"])
def test_scores_that_nobody_can_read_are_refused(text: str) -> None:
    with pytest.raises(BadConfig, match=r"write 0\.3, or sort"):
        parse_scores(text)


def test_a_score_for_nobody_is_answered_with_the_nearest_name() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'bytetrack'"):
        with_scores(GUESTS, parse_scores("bytetrak=0.3"))


def test_a_guest_without_its_environment_says_how_to_make_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MOT_SIM_GUESTS", str(tmp_path))
    with pytest.raises(
        ExternalTrackerFailed, match=r"no environment in .*compare --setup sort` makes it"
    ):
        GUESTS["sort"].words(tmp_path, tmp_path)


def test_other_requirements_are_another_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOT_SIM_GUESTS", "/somewhere")
    old, new = Environment("x", ("a==1",)), Environment("x", ("a==2",))
    assert old.path.parent == Path("/somewhere")
    assert old.path != new.path
    assert old.path == Environment("x", ("a==1",)).path
