"""Means, intervals and paired differences; the tables that show them."""

import pyarrow as pa
import pytest

from mot_sim.experiments.sweep.summary import (
    difference_table,
    failure_lines,
    mean_table,
    summary,
    summary_content,
    words,
)
from mot_sim.tables import NO_INTERVAL, Interval, mean_column


def made_table(errors: bool = False) -> pa.Table:
    """Two levels, two trackers, three seeds; HOTA of the second is .1 below, seed by seed."""
    rows = [
        {
            "point": point, "noise": level, "seed": seed, "tracker": name,
            "HOTA": 0.9 - 0.2 * point + 0.05 * seed - lower, "IDF1": 0.5, "error": None,
        }
        for point, level in enumerate((0.0, 2.0))
        for seed in range(3)
        for name, lower in (("a", 0.0), ("b", 0.1))
    ]  # fmt: skip
    if errors:
        rows[1] |= {"HOTA": None, "IDF1": None, "error": "frame 3: it broke"}
    table = pa.Table.from_pylist(rows)
    return table.replace_schema_metadata({"mot-sim sweep": '{"design": {"axes": {"noise": 0}}}'})


def test_differences_are_paired_by_seed() -> None:
    lines = summary(made_table())
    assert [(line.point, line.tracker) for line in lines] == [
        (0, "a"), (0, "b"), (1, "a"), (1, "b"),
    ]  # fmt: skip
    assert lines[0].less is None
    assert lines[1].less is not None
    less = lines[1].less["HOTA"]
    assert less.mean == pytest.approx(-0.1)
    assert less.high is not None
    assert less.high + 0.1 == pytest.approx(0.0, abs=1e-12)  # no spread is left
    own = lines[1].metrics["HOTA"]
    assert own.high is not None
    assert own.mean is not None
    assert own.high - own.mean > 0.05
    assert "MOTA" not in own.__dict__


def test_failed_trials_are_counted_named_and_in_no_mean() -> None:
    table = made_table(errors=True)
    line = summary(table)[1]
    assert (line.failed, line.first_error) == (1, "frame 3: it broke")
    assert line.metrics["HOTA"].count == 2
    assert line.less is not None
    assert line.less["HOTA"].count == 2
    assert failure_lines(table) == ["b: 1 trial failed: frame 3: it broke"]
    assert failure_lines(made_table()) == []


def test_tables_show_percent_and_half_the_interval() -> None:
    lines = summary(made_table(errors=True))
    assert mean_column("HOTA").show(*Interval(0.5, 0.4, 0.6, 9).cells) == "50.00 ±10.00"
    assert (
        mean_column("IDSW", is_signed=True).show(*Interval(3.0, 1.0, 5.0, 9).cells) == "+3.0 ±2.0"
    )
    assert mean_column("HOTA").show(*Interval(0.5, None, None, 1).cells) == "50.00"
    assert mean_column("HOTA").show(*NO_INTERVAL.cells) == ""
    rows = mean_table(lines, ("HOTA",), is_printed=True).shown_rows()
    assert rows[1][:2] == ("noise=0", "b")
    assert rows[1][3:] == ("2", "1")
    different = difference_table(lines, ("HOTA",), is_printed=True)
    assert different is not None
    assert different.shown_rows()[1] == ("noise=2", "b", "-10.00 ±0.00", "3")
    assert difference_table([line for line in lines if line.tracker == "a"]) is None
    assert summary_content(lines)[1]["metrics"]["HOTA"]["count"] == 2


def test_axes_are_called_by_the_last_part_of_their_names_where_that_is_enough() -> None:
    assert words({"detector.jitter": 0.5, "rig.height": None}) == "jitter=0.5"
    assert words({"jitter.left.spread": 0.5, "jitter.upper.spread": 1}) == (
        "jitter.left.spread=0.5, jitter.upper.spread=1"
    )


def test_intervals_are_possible_and_two_seeds_are_called_too_few() -> None:
    rows = [
        {"point": 0, "noise": 0.0, "seed": seed, "tracker": name, "HOTA": hota, "IDSW": switches,
         "error": None}
        for name, less in (("a", 0.0), ("b", 0.1))
        for seed, (hota, switches) in enumerate(((1.0, 0), (0.6 - less, 4)))
    ]  # fmt: skip
    about = {"mot-sim sweep": '{"design": {"axes": {"noise": 0}}}'}
    lines = summary(pa.Table.from_pylist(rows).replace_schema_metadata(about))
    means, less = mean_table(lines), difference_table(lines)
    assert means.column("HOTA low") == (0.0, 0.0)
    assert means.column("HOTA high") == (1.0, 1.0)
    assert means.column("IDSW low") == (0.0, 0.0)
    assert less is not None
    assert less.column("HOTA low")[0] == pytest.approx(-0.05 - 12.7062 * 0.05)
    told = "too few for an interval to mean much; 5 or more are better."
    assert means.note.endswith(f"2 seeds: {told}")
    printed, pairs = (table(lines, is_printed=True) for table in (mean_table, difference_table))
    assert printed.note == f"2 seeds: {told}"
    assert pairs.note == f"2 pairs: {told}"
    assert printed.shown_rows()[0][2] == "80.00 [0.00, 100.00]"
    assert "3 seeds" in mean_table(summary(made_table()), is_printed=True).note
