"""How well a profile fits: real beside made, as rows of figures, as curves and as one picture."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from mot_sim.plotting.canvas import draw_line, draw_text
from mot_sim.simulation.sensors.fitting.fit_false import are_twins
from mot_sim.simulation.sensors.fitting.fit_suppression import (
    overlapping_boxes,
    recall_behind,
)
from mot_sim.simulation.sensors.fitting.measure import DetectorMeasurements, Found
from mot_sim.simulation.sensors.fitting.statistics import (
    DEPTH_BINS,
    HEIGHT_BINS,
    OCCLUSION_BINS,
    gap_lengths,
    lag_correlation,
    lagged,
    lives,
    rates_in_bins,
)
from tracker.geometry import box_iou

REPORTED_LAGS = (1, 2, 5, 10)
REPORTED_GAPS = (1, 2, 3, 5, 10)
REPORTED_SCORES = (0.1, 0.25, 0.5, 0.75)
REPORTED_JUMPS = (0.7, 0.8, 0.9)
PAIR_BINS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 1.0)  # of the IoU of two labels
MIN_PAIR_IOU = 0.5
SURE_SCORE = 0.9
EDGE_NAMES = ("left", "upper", "right", "lower")
PANEL_PIXELS = (420, 300)  # width, height in pixels
MARGIN_PIXELS = 44
PANEL_COLUMNS = 3
REAL_COLOUR = (31, 90, 180)
MADE_COLOUR = (226, 110, 20)
INK_COLOUR = (60, 60, 60)
PAPER_COLOUR = (255, 255, 255)


@dataclass(frozen=True)
class FitComparison:
    """One figure of the real detections beside that of the made ones."""

    what: str
    """What the figure measures."""
    real: float
    """Of the real detections; NaN where there is nothing to count."""
    made: float
    """Of the simulated ones; NaN where there is nothing to count."""


def fit_lines(real: DetectorMeasurements, made: DetectorMeasurements) -> list[FitComparison]:
    """Every figure that a profile is judged by; made: several simulations pooled."""
    lines = [
        FitComparison(what, getattr(real, name), getattr(made, name))
        for what, name in (
            ("recall", "recall"),
            ("precision", "precision"),
            ("false positives a frame", "false_per_frame"),
        )
    ]
    for what, value, edges, unit in (
        ("height", "height", HEIGHT_BINS, "px"),
        ("depth", "depth", DEPTH_BINS, "m"),
        ("visible part", "visible", OCCLUSION_BINS, ""),
    ):
        pairs = [_recalls(each, value, edges) for each in (real, made)]
        lines += [
            FitComparison(f"recall, {what} {low:g}-{high:g} {unit}".strip(), a, b)
            for low, high, a, b in zip(edges[:-1], edges[1:], *pairs, strict=True)
            if not np.isnan(a)
        ]
    lines += _pair_lines(real, made) + _gap_lines(real, made)
    return lines + _box_lines(real, made) + _life_lines(real, made)


def _recalls(measured: DetectorMeasurements, value: str, edges: tuple[float, ...]) -> list[float]:
    found = measured.found.select(measured.found.counted)
    values = getattr(found.sightings, value)
    return [rate for _, rate in rates_in_bins(values, found.hit, edges)]


def _pair_lines(real: DetectorMeasurements, made: DetectorMeasurements) -> list[FitComparison]:
    """What the detector's own suppression leaves of cars close behind others."""
    both = real, made
    pairs = [overlapping_boxes(m.found) for m in both]
    near = [each.select(each.iou > MIN_PAIR_IOU) for each in pairs]
    per = [1000.0 * len(n) / max(m.detection_count, 1) for n, m in zip(near, both, strict=True)]
    sure = [float((n.weaker > SURE_SCORE).mean()) if len(n) else float("nan") for n in near]
    lines = [
        FitComparison(f"pairs of cars with IoU > {MIN_PAIR_IOU:g} in 1000 detections", *per),
        FitComparison(f"of these both scores above {SURE_SCORE:g}", *sure),
    ]
    behind = [recall_behind(m.found, PAIR_BINS) for m in both]
    for low, high, (count, a), (_, b) in zip(PAIR_BINS, PAIR_BINS[1:], *behind, strict=False):
        if count:
            lines.append(FitComparison(f"recall, {low:g}-{high:g} IoU with a nearer one", a, b))
    return lines


def _gap_lines(real: DetectorMeasurements, made: DetectorMeasurements) -> list[FitComparison]:
    gaps = [gap_lengths(each.found) for each in (real, made)]
    per = [1000.0 * len(g) / m.frame_count for g, m in zip(gaps, (real, made), strict=True)]
    lines = [FitComparison("gaps in 1000 frames", *per)]
    for length in REPORTED_GAPS:
        shares = [float((g <= length).mean()) if len(g) else float("nan") for g in gaps]
        lines.append(FitComparison(f"gaps of at most {length} frames", *shares))
    return lines


def _box_lines(real: DetectorMeasurements, made: DetectorMeasurements) -> list[FitComparison]:
    lines = []
    both = [each.found.select(each.found.hit) for each in (real, made)]
    for column, name in enumerate(EDGE_NAMES):
        errors = [each.edges[:, column] for each in both]
        lines.append(FitComparison(f"{name} edge, bias", *(float(x.mean()) for x in errors)))
        lines.append(FitComparison(f"{name} edge, std", *(float(x.std()) for x in errors)))
        for lag in REPORTED_LAGS:
            rho = [
                lag_correlation(x, each.ids, each.frames, lag)
                for x, each in zip(errors, both, strict=True)
            ]
            lines.append(FitComparison(f"{name} edge, autocorrelation at {lag}", *rho))
    moved = [_changes(each) for each in both]
    for least in REPORTED_JUMPS:
        shares = [float((each < least).mean()) if len(each) else 0.0 for each in moved]
        lines.append(FitComparison(f"boxes that jump: IoU below {least:g}", *shares))
    per = [1000.0 * are_twins(m).sum() / max(m.found.hit.sum(), 1) for m in (real, made)]
    lines.append(FitComparison("twins of 1000 right boxes", *(float(each) for each in per)))
    for score in REPORTED_SCORES:
        odds = np.log(score / (1.0 - score))
        shares = [float((each.log_odds < odds).mean()) for each in both]
        lines.append(FitComparison(f"right boxes with a score below {score:g}", *shares))
    return lines


def _changes(hits: Found) -> Float[Array, " k"]:
    """IoU of each box with that of a frame before, the car's own motion aside."""
    before, after = lagged(hits.ids, hits.frames, 1)
    unit = np.array([0.0, 0.0, 1.0, 1.0])
    return box_iou(unit + hits.edges[before], unit + hits.edges[after])


def _life_lines(real: DetectorMeasurements, made: DetectorMeasurements) -> list[FitComparison]:
    lived = [lives(each.false) for each in (real, made)]
    mean = [float(each.mean()) if len(each) else 0.0 for each in lived]
    once = [float((each == 1).mean()) if len(each) else 0.0 for each in lived]
    return [
        FitComparison("life of false positives, frames", *mean),
        FitComparison("false positives of one frame", *once),
    ]


def curves(
    real: DetectorMeasurements, made: DetectorMeasurements
) -> dict[str, tuple[Array, Float[Array, "2 k"]]]:
    """What is plotted: by title, x and the two curves (real, made)."""
    both = (real, made)
    found: dict[str, tuple[Array, Float[Array, "2 k"]]] = {}
    for title, value, edges in (
        ("recall by box height, px", "height", HEIGHT_BINS[:-1]),
        ("recall by depth, m", "depth", DEPTH_BINS),
    ):
        middle = 0.5 * (np.array(edges[1:]) + np.array(edges[:-1]))
        found[title] = middle, np.array([_recalls(each, value, edges) for each in both])
    middle = 0.5 * (np.array(PAIR_BINS[1:]) + np.array(PAIR_BINS[:-1]))
    behind = [[rate for _, rate in recall_behind(m.found, PAIR_BINS)] for m in both]
    found["recall by IoU with a nearer one"] = middle, np.array(behind)
    gaps = np.arange(1, 16)
    found["gap lengths, cumulative"] = gaps, _shares([gap_lengths(m.found) for m in both], gaps)
    hits = [m.found.select(m.found.hit) for m in both]
    error = np.linspace(-0.15, 0.15, 61)
    found["lower edge error, cumulative"] = error, _shares([h.edges[:, 3] for h in hits], error)
    score = np.linspace(0.0, 1.0, 41)
    found["scores of right boxes, cumulative"] = (
        score,
        _shares([1.0 / (1.0 + np.exp(-h.log_odds)) for h in hits], score),
    )
    lags = np.arange(1, 16)
    rho = [[lag_correlation(h.edges[:, 3], h.ids, h.frames, int(t)) for t in lags] for h in hits]
    found["autocorrelation of the lower edge, frames"] = lags, np.array(rho)
    life = np.arange(1, 11)
    found["life of false positives, cumulative"] = (
        life,
        _shares([lives(m.false) for m in both], life),
    )
    return found


def _shares(samples: Sequence[Array], limits: Array) -> Float[Array, "2 k"]:
    """The part of each sample up to each limit."""
    return np.array(
        [np.searchsorted(np.sort(x), limits, side="right") / max(len(x), 1) for x in samples]
    )


def fit_picture(curves: Mapping[str, tuple[Array, Float[Array, "2 k"]]]) -> UInt8[Array, "h w 3"]:
    """A panel a title, three in a row; see `curves`."""
    rows = -(-len(curves) // PANEL_COLUMNS)
    width, height = PANEL_PIXELS
    picture = np.full((rows * height, PANEL_COLUMNS * width, 3), PAPER_COLOUR, np.uint8)
    for number, (title, (x, pair)) in enumerate(curves.items()):
        left, top = number % PANEL_COLUMNS * width, number // PANEL_COLUMNS * height
        _panel(picture[top : top + height, left : left + width], title, x, pair)
    return picture


def _panel(image: UInt8[Array, "h w 3"], title: str, x: Array, pair: Float[Array, "2 k"]) -> None:
    """Axes with the numbers at their ends, and both curves."""
    width, height = PANEL_PIXELS
    known = pair[np.isfinite(pair)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    low, high = min(low, 0.0) if low < 0.5 else low, max(high, low + 1e-6)
    first, last = float(x[0]), float(x[-1])
    across, down = width - 2 * MARGIN_PIXELS, height - 2 * MARGIN_PIXELS

    canvas = image.copy()
    axes = np.array(
        [
            [MARGIN_PIXELS, MARGIN_PIXELS],
            [MARGIN_PIXELS, MARGIN_PIXELS + down],
            [MARGIN_PIXELS + across, MARGIN_PIXELS + down],
        ]
    )
    draw_line(canvas, axes.astype(float), INK_COLOUR)
    for colour, y in ((REAL_COLOUR, pair[0]), (MADE_COLOUR, pair[1])):
        there = np.isfinite(y)
        u = MARGIN_PIXELS + across * (x[there] - first) / max(last - first, 1e-9)
        v = MARGIN_PIXELS + down * (1.0 - (y[there] - low) / (high - low))
        draw_line(canvas, np.stack((u, v), axis=1), colour, 2)
    draw_text(canvas, title, (MARGIN_PIXELS, MARGIN_PIXELS - 22), INK_COLOUR, 14)
    draw_text(canvas, "real", (width - 120, MARGIN_PIXELS - 6), REAL_COLOUR, 13)
    draw_text(canvas, "made", (width - 80, MARGIN_PIXELS - 6), MADE_COLOUR, 13)
    draw_text(canvas, f"{first:.3g}", (MARGIN_PIXELS, height - MARGIN_PIXELS + 18), INK_COLOUR, 12)
    draw_text(
        canvas,
        f"{last:.3g}",
        (width - MARGIN_PIXELS - 20, height - MARGIN_PIXELS + 18),
        INK_COLOUR,
        12,
    )
    draw_text(canvas, f"{low:.2f}", (4, height - MARGIN_PIXELS), INK_COLOUR, 12)
    draw_text(canvas, f"{high:.2f}", (4, MARGIN_PIXELS + 6), INK_COLOUR, 12)
    image[:] = canvas
