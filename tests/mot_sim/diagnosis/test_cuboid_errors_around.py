"""Which rows of a car are around an event, and what is wrong with their cuboids."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mot_sim.diagnosis.context_events import NO_PARTNER, ContextEvents
from mot_sim.diagnosis.cuboid_errors_around import CuboidCounts, counts_around
from mot_sim.diagnosis.findings import Findings, read_findings, write_findings
from mot_sim.diagnosis.tables import cuboid_table, tables_of
from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors
from tests.mot_sim.metrics.cuboid_cases import AHEAD, scene, two_cars

FRAMES = 10


def errors() -> CuboidErrors:
    """Two cars over ten frames; car 1 is 3 m too far and backwards in frames 4 to 6."""
    truth = scene(two_cars(FRAMES))
    off = [
        (f, car, x, z + 3.0, -AHEAD) if car and 4 <= f <= 6 else (f, car, x, z, yaw)
        for f, car, x, z, yaw in two_cars(FRAMES)
    ]
    return cuboid_errors(truth, scene(off).replaced(boxes=truth.boxes), FRAMES)


def event(kind: str, car: int, first: int, last: int, other: int = NO_PARTNER) -> ContextEvents:
    return ContextEvents.of([(kind, first, last, car, other, np.nan)], 10.0)


def test_rows_of_the_car_from_before_to_after_the_event_are_around_it() -> None:
    around = counts_around(errors(), event("car turns", 1, 5, 5), margin=2)
    assert around["car turns"] == CuboidCounts(5, 2, pytest.approx(9.0), 3, 3)
    assert around["all"] == CuboidCounts(20, 17, pytest.approx(9.0), 3, 3)
    assert around["none of these"] == CuboidCounts(15, 15, 0.0, 0, 0)


def test_a_crossing_is_as_much_about_the_other_car_an_occlusion_is_not() -> None:
    crossing = counts_around(errors(), event("crossing", 0, 5, 5, other=1), margin=0)
    assert (crossing["crossing"].rows, crossing["crossing"].wrong) == (2, 1)
    hidden = counts_around(errors(), event("occlusion", 0, 5, 5, other=1), margin=0)
    assert (hidden["occlusion"].rows, hidden["occlusion"].wrong) == (1, 0)


def test_no_event_leaves_all_rows_to_the_others() -> None:
    around = counts_around(errors(), ContextEvents.of([], 10.0), margin=5)
    assert around["all"] == around["none of these"]
    assert counts_around(errors().select([]), ContextEvents.of([], 10.0), 5)["all"].rows == 0


def test_counts_are_kept_and_shown(tmp_path: Path) -> None:
    found = Findings("a", FRAMES, 2, ("car turns",))
    found = replace(found, cuboids=counts_around(errors(), event("car turns", 1, 5, 5), margin=2))
    write_findings(tmp_path / "a.json", found)
    assert read_findings(tmp_path / "a.json") == found
    table = cuboid_table([found, found])
    assert table is not None
    rows = {str(row[0]): row[1:] for row in table.rows}
    assert rows["car turns"] == (10, pytest.approx(1.8), 0.4, 0.6, 0.6)
    assert list(rows)[-1] == "all"
    assert [each.name for each in tables_of([found], False)][1] == "cuboids"


def test_a_tracker_without_cuboids_has_no_such_table() -> None:
    assert cuboid_table([Findings("a", 3, 1, ())]) is None
