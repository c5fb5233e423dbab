"""Charts as Plotly wants them: traces and layout in plain values; the page's script draws them."""

import html
from typing import Any

from mot_sim.plotting.charts import COLOURS, DASHES, SYMBOLS, Chart, Series
from mot_sim.tables import show_value

CHART_PIXELS = 340  # height of a chart over levels
ROW_PIXELS = 24  # of a row of words and series
BAND_OPACITY = 0.15  # of intervals


def plot_of(chart: Chart) -> dict[str, Any]:
    """`data` and `layout` of a chart. Text is escaped: Plotly reads some HTML in it."""
    many = len(chart.series) > 1
    traces: list[dict[str, Any]] = []
    for each in chart.series:
        if chart.kind == "lines":
            traces += [band for band in [_band(each)] if band is not None]
        traces.append(_trace(chart, each, many))
    return {"data": traces, "layout": _layout(chart, many)}


def _trace(chart: Chart, series: Series, many: bool) -> dict[str, Any]:
    """The values with what is said about them under the pointer."""
    points = list(series.points())
    places = [_text(point[0]) if isinstance(point[0], str) else point[0] for point in points]
    values = [_short(point[1]) for point in points]
    colour = COLOURS[series.place % len(COLOURS)]
    trace: dict[str, Any] = {
        "name": _text(series.name),
        "legendgroup": _text(series.name),
        "customdata": [_text(show_value(*point[1:])) for point in points],
        "hovertemplate": "%{customdata}",
        "showlegend": many,
    }
    if chart.kind == "rows":
        rows = [chart.words.index(str(point[0])) + chart.shift(series) for point in points]
        trace |= {"y": [_short(row) for row in rows], "x": values}
    elif chart.is_sideways:
        trace |= {"y": places, "x": values, "orientation": "h"}
    else:
        trace |= {"x": places, "y": values}
    if chart.kind != "lines" and any(low != high for _, _, low, high in points):
        trace["error_x" if chart.is_sideways else "error_y"] = {
            "type": "data",
            "symmetric": False,
            "thickness": 1.4,
            "width": 4,
            "array": [_short(max(high - y, 0.0)) for _, y, _, high in points],
            "arrayminus": [_short(max(y - low, 0.0)) for _, y, low, _ in points],
        }
    if chart.kind == "bars":
        return trace | {"type": "bar", "marker": {"color": colour}}
    symbol = SYMBOLS[series.place % len(SYMBOLS)]
    trace |= {"type": "scatter", "marker": {"color": colour, "symbol": symbol, "size": 7}}
    if series.is_limit:
        trace["marker"] |= {"symbol": "line-ns", "size": 20, "line": {"width": 3, "color": colour}}
    if chart.kind != "lines":
        return trace | {"mode": "markers"}
    dash = DASHES[series.dash % len(DASHES)]
    width = chart.width(series)
    trace["marker"]["size"] = 5.0 + width
    line = {"color": colour, "width": width, "dash": dash}
    return trace | {"mode": "lines+markers", "line": line}


def _band(series: Series) -> dict[str, Any] | None:
    """The band between the ends of the intervals; None if there are none."""
    points = list(series.points())
    if all(low == high for _, _, low, high in points):
        return None
    colour = COLOURS[series.place % len(COLOURS)].lstrip("#")
    red, green, blue = (int(colour[k : k + 2], 16) for k in (0, 2, 4))
    there_and_back = [*points, *reversed(points)]
    ends = [point[3] for point in points] + [point[2] for point in reversed(points)]
    return {
        "type": "scatter",
        "mode": "lines",
        "x": [point[0] for point in there_and_back],
        "y": [_short(end) for end in ends],
        "fill": "toself",
        "line": {"width": 0},
        "fillcolor": f"rgba({red},{green},{blue},{BAND_OPACITY})",
        "hoverinfo": "skip",
        "showlegend": False,
        "legendgroup": _text(series.name),
    }


def _layout(chart: Chart, many: bool) -> dict[str, Any]:
    """Axes and room; colours come from the page's style."""
    value: dict[str, Any] = {"title": {"text": _text(chart.y_title)}, "automargin": True}
    other: dict[str, Any] = {"title": {"text": _text(chart.x_title)}, "automargin": True}
    if chart.span is not None and (chart.kind == "rows" or chart.y_range is not None):
        value["range"] = [_short(end) for end in chart.span]
    if chart.is_logarithmic:
        other["type"] = "log"
    layout: dict[str, Any] = {
        "height": CHART_PIXELS,
        "margin": {"l": 60, "r": 16, "t": 34 if many else 12, "b": 52},
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
        "hovermode": "closest" if chart.is_sideways or chart.kind == "points" else "x unified",
    }
    if chart.is_sideways:
        words = [_text(each) for each in chart.words]
        if chart.kind == "bars":
            other |= {"type": "category", "categoryorder": "array", "categoryarray": words}
            other["autorange"] = "reversed"
        else:
            other |= {"tickvals": list(range(len(words))), "ticktext": words, "zeroline": False}
            other["range"] = [len(words) - 0.5, -0.5]
        beside = max(1.0, 0.6 * len(chart.series))
        layout |= {
            "xaxis": value,
            "yaxis": other,
            "height": round(110 + ROW_PIXELS * len(words) * beside),
            "barmode": "group",
            "bargap": 0.3,
        }
    else:
        layout |= {"xaxis": other, "yaxis": value}
    return layout


def _short(value: float) -> float:
    """Six digits are more than a screen shows."""
    return float(f"{value:.6g}")


def _text(value: object) -> str:
    return html.escape(str(value), quote=False)


__all__ = ["plot_of"]
