"""Titles and legends."""

import numpy as np

from mot_sim.plotting.canvas import text_width
from mot_sim.report.captions import (
    LEGEND_TEXT_PIXELS,
    Layers,
    legend,
    marks,
    title,
    title_words,
    wrap,
)


def test_the_title_names_drive_frame_time_and_switches() -> None:
    assert title_words("0005", 7, 0.7, None) == "0005   frame 007    0.7 s"
    assert title_words("0005", 7, 0.7, 1).endswith("1 switch so far")
    assert title_words("0005", 7, 0.7, 2).endswith("2 switches so far")


def test_the_trackers_name_gives_way_in_a_narrow_title() -> None:
    wide = title(1242, "0005", "default", detections=True)
    assert wide[:, 600:].std() > 1.0
    narrow = title(200, "0005   frame 007", "default", detections=True)
    alone = title(200, "0005   frame 007", "another", detections=False)
    assert (narrow == alone).all()


def test_lines_are_as_wide_as_allowed_and_lose_nothing() -> None:
    parts = [f"mark number {number}" for number in range(9)]
    lines = wrap(parts, 300)
    assert len(lines) > 1
    assert all(text_width(line, LEGEND_TEXT_PIXELS) <= 300 for line in lines)
    assert [part for line in lines for part in line.split("    ")] == parts
    assert wrap(["a mark that is longer than the line"], 10) == [
        "a mark that is longer than the line"
    ]
    assert legend(300, []).shape == (6, 300, 3)


def test_every_layer_has_its_mark() -> None:
    bare = Layers(top_view=False)
    assert marks(bare, outlines=False) == []
    for name in ("truth", "search_areas", "wireframes", "true_wireframes", "top_view"):
        named = Layers(**{"top_view": False, name: True})
        assert marks(named, outlines=False), name
    assert "true outlines" in marks(Layers(), outlines=True)[0]
    assert np.array_equal(legend(200, ["a"]), legend(200, ["a"]))
