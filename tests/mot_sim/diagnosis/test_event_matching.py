"""Breaks and happenings: who is around whom, and sums that come out."""

import numpy as np

from mot_sim.diagnosis.context_events import KINDS, ContextEvents, EventRow
from mot_sim.diagnosis.event_matching import NO_EVENT, EventCounts, at_risk, events_around, tally
from mot_sim.metrics.breaks import Breaks
from tests.mot_sim.metrics.test_breaks import tracks

NAN = float("nan")


def breaks_at(*rows: tuple[int, int, int, bool, bool]) -> Breaks:
    """Rows (before, frame, car, switched, broken)."""
    before, frames, cars, switched, broken = (np.array(c) for c in zip(*rows, strict=True))
    ones = np.ones(len(rows), np.int64)
    return Breaks(before, frames, cars, ones, ones + 1, switched, broken, ones)


def test_a_break_is_around_what_touches_it_in_time() -> None:
    rows: list[EventRow] = [
        ("occlusion", 10, 19, 1, 2, 3.0),  # of this car, touching
        ("occlusion", 40, 50, 1, 2, 3.0),  # too late
        ("crossing", 18, 25, 3, 1, NAN),  # as the second car
        ("car turns", 10, 30, 7, -2, NAN),  # another car
    ]
    table = ContextEvents.of(rows)
    (found,) = events_around(breaks_at((12, 21, 1, True, False)), table, 10.0)
    assert {kind: int(table.firsts[row]) for kind, row in found.items()} == {
        "occlusion": 10, "crossing": 18,
    }  # fmt: skip


def test_of_two_of_a_kind_the_one_that_shares_most_frames_is_taken() -> None:
    table = ContextEvents.of([("occlusion", 0, 8, 1, 2, 1.0), ("occlusion", 11, 20, 1, 2, 9.0)])
    (found,) = events_around(breaks_at((7, 21, 1, True, True)), table, 10.0)
    assert int(table.firsts[found["occlusion"]]) == 11


def test_shares_add_up_to_the_switches_and_fragments() -> None:
    rng = np.random.default_rng(3)
    rows: list[EventRow] = [
        (str(rng.choice(KINDS)), first, first + int(rng.integers(0, 30)), int(rng.integers(0, 4)),
         -2, NAN)
        for first in rng.integers(0, 90, 40).tolist()
    ]  # fmt: skip
    table = ContextEvents.of(rows)
    breaks = breaks_at(
        *(
            (frame, frame + 3, int(rng.integers(0, 4)), bool(number % 2), bool(number % 3))
            for number, frame in enumerate(rng.integers(0, 90, 30).tolist())
        )
    )
    around = events_around(breaks, table, 10.0)
    cars = tracks([(frame, car, 0.0) for frame in (0, 130) for car in range(4)])
    found = tally(breaks, table, around, at_risk(table, cars, around))
    parts = [found.get(name, EventCounts()) for name in (*KINDS, NO_EVENT)]
    assert np.isclose(sum(each.switch_share for each in parts), breaks.switched.sum())
    assert np.isclose(sum(each.fragment_share for each in parts), breaks.broken.sum())
    for kind in ("occlusion", "detector gap"):
        lengths = [
            c for n, c in found.items() if n.startswith(f"{kind}, ") and n.endswith((" s", "frame"))
        ]
        assert sum(each.events for each in lengths) == found[kind].events
        assert sum(each.switches for each in lengths) == found[kind].switches


def test_only_a_car_with_a_name_to_lose_is_exposed() -> None:
    rows: list[EventRow] = [
        ("occlusion", 3, 6, 1, 2, 1.0),
        ("occlusion", 3, 6, 9, 2, 1.0),
        ("occlusion", 8, 12, 1, 2, 1.0),
        ("crossing", 4, 6, 9, 1, NAN),
    ]
    table = ContextEvents.of(rows)
    cars = tracks([(frame, 1, 0.0) for frame in range(10)])
    could = at_risk(table, cars, [])
    named = zip(table.firsts.tolist(), table.ids.tolist(), could.tolist(), strict=True)
    assert sorted(named) == [(3, 1, True), (3, 9, False), (4, 9, True), (8, 1, False)]
    # Where a name was lost, there was one to lose.
    late = int(np.flatnonzero(table.firsts == 8)[0])
    assert at_risk(table, cars, [{"occlusion": late}])[late]


def test_nothing_is_around_nothing() -> None:
    none = ContextEvents.of([])
    breaks = breaks_at((1, 2, 1, True, False))
    assert events_around(breaks, none, 10.0) == [{}]
    assert tally(breaks, none, [{}], np.zeros(0, bool)) == {
        NO_EVENT: EventCounts(0, 1, 1.0, 0, 0.0)
    }
