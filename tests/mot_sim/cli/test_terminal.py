"""The progress bar: lines where it cannot be drawn, and the time that is left; warnings."""

import warnings
from io import StringIO

import pytest
from rich.console import Console

from mot_sim.cli import terminal
from mot_sim.cli.terminal import Terminal
from tracker.errors import MotionWarning


class Clock:
    """Seconds that pass only when they are told to."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    monkeypatch.setattr(terminal, "perf_counter", found)
    return found


def told(clock: Clock, lines: bool, *, is_terminal: bool = False) -> str:
    """What stderr shows of one job in 40 s, five of ten in 80 s, and the first of three others."""
    err = StringIO()
    where = Terminal()
    where.err = Console(file=err, force_terminal=is_terminal, width=100)
    with where.progress(lines=lines) as advance:
        for seconds, words in (
            (0.0, ("trials", 0, 10)), (40.0, ("trials", 1, 10)), (41.0, ("trials", 2, 10)),
            (80.0, ("trials", 5, 10)), (90.0, ("films", 0, 3)), (120.0, ("films", 1, 3)),
        ):  # fmt: skip
            clock.now = seconds
            advance(*words)
    return err.getvalue()


def test_without_a_terminal_a_line_tells_now_and_then_how_far_it_is(clock: Clock) -> None:
    assert told(clock, lines=True).splitlines() == [
        "trials: 1 of 10, 360 s left",
        "trials: 5 of 10, 80 s left",
        "films: 1 of 3, 60 s left",
    ]


def test_a_line_of_work_without_a_known_end_tells_what_is_under_way(clock: Clock) -> None:
    err, where = StringIO(), Terminal()
    where.err = Console(file=err, width=100)
    with where.progress(lines=True) as advance:
        clock.now = 40.0
        advance("fitting a profile")
    assert err.getvalue() == "fitting a profile\n"


def test_without_a_terminal_and_lines_nothing_is_told(clock: Clock) -> None:
    assert told(clock, lines=False) == ""


def test_on_a_terminal_there_is_a_bar_and_no_lines(clock: Clock) -> None:
    shown = told(clock, lines=True, is_terminal=True)
    assert "1/3" in shown
    assert "60 s left" in shown
    assert "of 10" not in shown


def test_steps_are_counted_and_their_rate_is_shown(clock: Clock) -> None:
    err = StringIO()
    where = Terminal()
    where.err = Console(file=err, force_terminal=True, width=100)
    with where.progress(None, unit="frames") as advance:
        for seconds in (1.0, 2.0):
            clock.now = seconds
            advance("film", total=8)
    assert "2/8" in err.getvalue()
    assert "1 frames/s, 6 s left" in err.getvalue()


def test_motion_that_boxes_contradict_is_one_line_and_other_warnings_are_as_they_were() -> None:
    err, where = StringIO(), Terminal()
    where.err = Console(file=err, width=20)

    def two_warnings() -> None:
        usual = warnings.showwarning
        with where.logging(0):
            warnings.warn("in metres, or not at all?", MotionWarning, stacklevel=1)
            warnings.warn("something else", UserWarning, stacklevel=1)
        assert warnings.showwarning == usual

    with pytest.warns(UserWarning, match="something else") as others:
        two_warnings()
    assert [str(other.message) for other in others] == ["something else"]
    assert err.getvalue() == "warning: in metres, or not at all?\n"
