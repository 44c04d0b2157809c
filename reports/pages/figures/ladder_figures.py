"""Figures of error against timestep and against cost, with every run on one scene."""

from collections.abc import Callable, Iterator, Sequence
from html import escape

import numpy as np

from ....scenarios import FloatArray, Signal
from ...results.records import Row
from ..analysis.observed_order import ABOVE_UNCERTAINTY, ASYMPTOTIC
from ..analysis.report_data import MethodRuns, SceneRuns
from ..analysis.wording import ended, number
from ..analysis.work_precision import cost, curves, front
from .plot import (
    WHOLE,
    WIRE,
    Figure,
    Panel,
    Range,
    Trace,
    claimed,
    drawing,
    error_range,
    line,
    method_style,
)

#: A guide line is a dotted line with the slope of an order. These are the factor by which it is
#: drawn below its curve, and the factor by which it extends to longer and to shorter timesteps.
GUIDE_BELOW, GUIDE_SPAN = 4.0, 8.0
#: Number of points of a guide line.
GUIDE_POINTS = 25
#: Factor of room beside the outermost points of a log axis.
BESIDE = 1.5

#: Line width of the Pareto front: so wide that it is visible behind the curves that touch it.
FRONT_WIDTH = 7.0

#: Domains (`Panel.domain`) of the panel of errors, and of the strip below it, which has the runs
#: without errors.
ERRORS, STRIP = ((0.0, 1.0), (0.26, 1.0)), ((0.0, 1.0), (0.0, 0.12))
HEIGHT = 520
#: Plotly's markers of runs without errors, by outcome.
ENDED = {"diverged": "x-thin-open", "failed": "triangle-down-open"}
#: Size of the rings around runs at stock timesteps, and size of the markers above, pixels.
RING_SIZE, MARK_SIZE = 14, 9

#: A function that returns the abscissa of a run, its timestep or its cost; None if it has none.
Abscissa = Callable[[Row], float | None]


def convergence(scene: SceneRuns) -> list[Figure]:
    """Return, for each signal, a figure of errors against the timestep.

    Guide lines show the slopes of the declared orders of accuracy.
    """
    return [
        _with(figure, [], [*_guides(scene, signal)])
        for signal, figure in _against(scene, lambda row: row.timestep, "timestep, s")
    ]


def work_precision(scene: SceneRuns) -> list[Figure]:
    """Return, for each signal, a figure of errors against CPU seconds a simulated second.

    Each figure also shows the Pareto front.
    """
    return [
        _with(figure, [_front(scene, signal)], [])
        for signal, figure in _against(scene, cost, "CPU seconds a simulated second")
    ]


def _with(figure: Figure, below: list[Trace], above: list[Trace]) -> Figure:
    """Return a figure with further curves: `below` behind its own curves, and `above` over them."""
    return figure | {"data": [*below, *figure["data"], *above]}


def _against(scene: SceneRuns, abscissa: Abscissa, x_title: str) -> Iterator[tuple[Signal, Figure]]:
    """Yield each signal, with a figure of the errors in it.

    Parameters
    ----------
    abscissa : returns what a run's error is drawn against, such as its timestep; None if the run
        has no such number
    x_title : name of that number, with its unit
    """
    x_range = _x_range(scene, abscissa)
    ended = list(_ended(scene, abscissa))
    for signal in scene.signals:
        floor = scene.exact.solution.uncertainty[signal.name] * signal.shown
        traces = [
            trace for runs in scene.methods for trace in _curves(runs, scene, signal, abscissa)
        ]
        values = [_claimed(scene, _finished(runs), signal) for runs in scene.methods]
        y_range = error_range(values, floor)
        panels = [
            Panel(
                "" if ended else x_title,
                signal.error_title,
                signal.quantity.capitalize(),
                log_x=True,
                y_range=y_range,
                x_range=x_range,
                log_y=True,
                floor=floor,
                domain=ERRORS if ended else WHOLE,
            )
        ]
        if ended:
            panels.append(_strip(x_title, x_range))
        figure = drawing([*traces, *ended], panels, HEIGHT)
        if ended:
            figure["layout"]["xaxis2"]["matches"] = "x"
            figure["layout"]["yaxis2"] |= {"showticklabels": False, "fixedrange": True}
        yield signal, figure


def _strip(x_title: str, x_range: Range) -> Panel:
    """Return the panel for runs without errors, which is below the panel of errors.

    `x_title` and `x_range` are title and range of its horizontal axis.
    """
    heading = "Ended without an error to compare"
    return Panel(x_title, "", heading, True, (0.0, 1.0), x_range, domain=STRIP)


def _finished(runs: MethodRuns) -> list[Row]:
    """Return a method's runs that have errors."""
    return [row for row in runs.rows if row.errors]


def _ended(scene: SceneRuns, abscissa: Abscissa) -> Iterator[Trace]:
    """Yield markers for the runs that diverged or failed; each method has its own height.

    `abscissa` returns what a run's error is drawn against, such as its timestep; runs for which it
    returns None are left out.
    """
    for k, runs in enumerate(scene.methods):
        height = 1 - (k + 0.5) / len(scene.methods)
        for outcome, symbol in ENDED.items():
            ended_runs = [
                (x, row)
                for row in runs.rows
                if row.outcome == outcome and row.timestep and (x := abscissa(row)) is not None
            ]
            if ended_runs:
                yield line(
                    np.array([x for x, _ in ended_runs]),
                    np.full(len(ended_runs), height),
                    2,
                    **method_style(runs.label, runs.style)
                    | {
                        "text": [_hover(runs, row) for _, row in ended_runs],
                        "hovertemplate": "%{text}<extra></extra>",
                        "mode": "markers",
                        "marker": {
                            "color": runs.style.colour,
                            "symbol": symbol,
                            "size": MARK_SIZE,
                        },
                    },
                )


def _front(scene: SceneRuns, signal: Signal) -> Trace:
    """Return the Pareto front of all methods on a scene, in errors of a signal, drawn as steps."""
    best = [point for _, point in front(curves(scene, signal.name))]
    return line(
        np.array([point.cost for point in best], dtype=float),
        np.array([point.error * signal.shown for point in best]),
        1,
        line={"color": WIRE, "width": FRONT_WIDTH, "shape": "hv"},
        name="Pareto front",
        hoverinfo="skip",
    )


def _curves(
    runs: MethodRuns, scene: SceneRuns, signal: Signal, abscissa: Abscissa
) -> Iterator[Trace]:
    """Yield a line through the errors of a method's runs, and rings at its stock timesteps.

    `abscissa` returns what a run's error is drawn against, such as its timestep. Runs without
    errors, or for which it returns None, are left out.
    """
    rows = [row for row in _finished(runs) if abscissa(row) is not None]
    stock = [row for row in rows if row.stock]
    line_style = method_style(runs.label, runs.style)
    marker = {"color": runs.style.colour, "symbol": runs.style.symbol, "size": 6}
    if rows:
        hover = {
            "text": [_hover(runs, row) for row in rows],
            "hovertemplate": "%{text}<br>off by %{y:.2e}<extra></extra>",
        }
        style = line_style | hover | {"mode": "lines+markers", "marker": marker}
        yield line(_places(rows, abscissa), _claimed(scene, rows, signal), 1, **style)
    if stock:
        ring = {"color": runs.style.colour, "symbol": "circle-open", "size": RING_SIZE}
        style = line_style | {"mode": "markers", "marker": ring, "hoverinfo": "skip"}
        yield line(_places(stock, abscissa), _claimed(scene, stock, signal), 1, **style)


def _places(rows: Sequence[Row], abscissa: Abscissa) -> FloatArray:
    """Return the abscissas of n runs, (n,); `abscissa` must return a number for each of them."""
    return np.array([abscissa(row) for row in rows], dtype=float)


def _claimed(scene: SceneRuns, rows: Sequence[Row], signal: Signal) -> FloatArray:
    """Return the errors in a signal of those n runs that have errors, as they are drawn, (n,).

    They are in the figure's unit. Errors below the reference's uncertainty are raised to it, and
    infinite ones are NaN.
    """
    errors = [
        max(row.errors[signal.name], scene.uncertainty(row)[signal.name])
        for row in rows
        if row.errors
    ]
    return claimed(np.array(errors) * signal.shown, 0.0)


def _hover(runs: MethodRuns, row: Row) -> str:
    """Return the text that the page shows where a reader points at a run."""
    took = cost(row)
    parts = [
        f"{escape(runs.label, quote=False)}, timestep {number(row.timestep)} s",
        f"{number(took)} CPU s a simulated second" if took is not None else "",
        "a stock timestep" if row.stock else "",
        "" if row.outcome == "ok" else ended(row),
    ]
    return "<br>".join(part for part in parts if part)


def _x_range(scene: SceneRuns, abscissa: Abscissa) -> Range:
    """Return the range of abscissas over all runs that are drawn, with a margin on both sides.

    `abscissa` returns that of a run; None if it has none.
    """
    values = [
        x
        for runs in scene.methods
        for row in runs.rows
        if (row.errors or row.outcome in ENDED)
        and row.timestep
        and (x := abscissa(row)) is not None
    ]
    return min(values) / BESIDE, max(values) * BESIDE


def _guides(scene: SceneRuns, signal: Signal) -> Iterator[Trace]:
    """Yield a dotted line for each declared order, below the curves of the methods of that order.

    In the logarithms of error and timestep, the slope of the line is the order.
    """
    orders = {
        runs.label: signal.declared_order(runs.declared.order, runs.declared.attitude_order)
        for runs in scene.methods
        if runs.declared
    }
    for order in sorted(set(orders.values())):
        points = [
            (row.timestep, row.errors[signal.name])
            for runs in scene.methods
            if orders.get(runs.label) == order
            for row in runs.rows
            if row.errors and _readable(scene, row, signal)
        ]
        if points:
            middle = sorted(timestep for timestep, _ in points)[len(points) // 2]
            lowest = min(error / timestep**order for timestep, error in points)
            yield _guide((middle, lowest * middle**order), order, scene, signal)


def _readable(scene: SceneRuns, row: Row, signal: Signal) -> bool:
    """Whether a run's error in a signal is in the asymptotic range and far above uncertainty."""
    assert row.errors is not None, "only a run with errors is drawn"
    uncertainty = scene.uncertainty(row)[signal.name]
    return ABOVE_UNCERTAINTY * uncertainty < row.errors[signal.name] < ASYMPTOTIC


def _guide(anchor: tuple[float, float], order: int, scene: SceneRuns, signal: Signal) -> Trace:
    """Return a dotted line that falls as Δtᵖ, p being an order, drawn below a point of a curve.

    Parameters
    ----------
    anchor : timestep of the point, s, and its error, relative, or in rad for the attitude
    """
    floor = scene.exact.solution.uncertainty[signal.name]
    taken = [row.timestep for runs in scene.methods for row in runs.rows if row.errors]
    timestep, error = anchor
    timesteps = timestep * np.geomspace(GUIDE_SPAN, 1 / GUIDE_SPAN, num=GUIDE_POINTS)
    errors = error / GUIDE_BELOW * (timesteps / timestep) ** order
    inside = (errors > floor) & (min(taken) <= timesteps) & (timesteps <= max(taken))
    timesteps, errors = timesteps[inside], errors[inside]
    labels = [*[""] * (len(errors) - 1), f"order {order}"]
    return line(
        timesteps,
        errors * signal.shown,
        1,
        mode="lines+text",
        text=labels,
        textposition="bottom right",
        line={"color": "rgba(128,128,128,0.9)", "width": 1.5, "dash": "dot"},
        hoverinfo="skip",
        name=f"order {order}",
    )
