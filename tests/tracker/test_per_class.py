"""Several classes at once: no track takes a box of another class, and ids differ."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tracker.samples import LEVEL
from tracker import Detections, Frame, PerClass, Tracker, Tracks
from tracker.errors import BadConfig, UnknownName
from tracker.frameworks import FRAMEWORKS, Delayed
from tracker.per_class import CLASS_PRIORS, for_kind

CAR, WALKER = [500.0, 180.0, 620.0, 250.0], [540.0, 170.0, 580.0, 260.0]


def frames(kinds: tuple[str, ...], count: int = 6) -> list[Frame]:
    """A car and, before it, a walker, who change places in the order of the rows."""
    boxes = {"Car": CAR, "Pedestrian": WALKER}
    made = []
    for index in range(count):
        order = kinds if index % 2 else kinds[::-1]
        found = Detections(
            np.array([boxes[kind] for kind in order]), np.full(len(order), 0.95),
            kinds=np.array(order),
        )  # fmt: skip
        made.append(Frame(index, index / 10.0, found, np.eye(4)))
    return made


def both(framework: str | None = None) -> PerClass:
    trackers = {kind: for_kind(Tracker.default(LEVEL), kind) for kind in ("Car", "Pedestrian")}
    if framework is not None:
        return PerClass({kind: FRAMEWORKS[framework](each) for kind, each in trackers.items()})
    return PerClass(trackers)


@pytest.mark.parametrize("framework", [None, "window", "network_flow"])
def test_each_class_keeps_its_own_ids(framework: str | None) -> None:
    tracker = both(framework)
    assert isinstance(tracker, Delayed)
    parts = [tracker.step(frame) for frame in frames(("Car", "Pedestrian"))]
    rows = Tracks.concatenate([*parts, tracker.finish()])
    assert len(rows) == 12
    assert (np.diff(rows.frames) >= 0).all()
    assert rows.kinds is not None
    assert rows.estimates is not None
    assert np.isfinite(rows.estimates.means).all()
    for kind, box in (("Car", CAR), ("Pedestrian", WALKER)):
        mine = rows.select(rows.kinds == kind)
        assert len(mine) == 6
        assert len(set(mine.ids.tolist())) == 1
        np.testing.assert_allclose(mine.boxes, [box] * 6, atol=3.0)
    assert len(set(rows.ids.tolist())) == 2
    assert tracker.counts.frames == 6
    tracker.reset()
    again = Tracks.concatenate(
        [*map(tracker.step, frames(("Car", "Pedestrian"))), tracker.finish()]
    )
    np.testing.assert_array_equal(again.ids, rows.ids)


def test_a_class_alone_is_what_its_tracker_makes_of_it() -> None:
    alone = for_kind(Tracker.default(LEVEL), "Pedestrian")
    one = PerClass({"Pedestrian": for_kind(Tracker.default(LEVEL), "Pedestrian")})
    for frame in frames(("Pedestrian",)):
        found = frame.found.replaced(kinds=None)
        expected = alone.step(replace(frame, detections=found))
        rows = one.step(frame)
        np.testing.assert_array_equal(rows.boxes, expected.boxes)
        np.testing.assert_array_equal(rows.ids, expected.ids)


def test_boxes_that_do_not_say_their_class_are_refused_where_there_are_several() -> None:
    frame = frames(("Car", "Pedestrian"))[0]
    unsaid = replace(frame, detections=frame.found.replaced(kinds=None))
    with pytest.raises(BadConfig, match="frame 0: the detections do not say their class"):
        both().step(unsaid)
    assert len(both().step(replace(frame, detections=None))) == 0


def test_another_class_has_its_own_size_and_speeds() -> None:
    tracker = Tracker.default(LEVEL)
    assert for_kind(tracker, "Car") is tracker
    walking = for_kind(tracker, "Pedestrian")
    assert walking.lift.car_size == CLASS_PRIORS["Pedestrian"].size
    assert walking.car_filter is not None
    assert walking.car_filter.size == CLASS_PRIORS["Pedestrian"].size
    assert walking.lift.speed_std[1] < tracker.lift.speed_std[1]
    assert walking.lifecycle.birth_score < tracker.lifecycle.birth_score
    paper = for_kind(Tracker.paper(LEVEL), "Pedestrian")
    assert (paper.lifecycle.birth_score, paper.lifecycle.max_gap) == (0.0, 0.0)
    with pytest.raises(UnknownName, match="class 'Tram'"):
        for_kind(tracker, "Tram")
    with pytest.raises(BadConfig, match="classes Tram"):
        PerClass({"Tram": tracker})
    with pytest.raises(BadConfig, match="classes none"):
        PerClass({})
