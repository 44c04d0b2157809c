"""Error against timestep and against cost: every run of every method on one scene."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import chain

import numpy as np

from ....scenarios import FloatArray
from ...harness.observed_order import ABOVE_UNCERTAINTY, ASYMPTOTIC
from ...results.records import Row
from ..analysis.report_data import MethodRuns, SceneRuns
from ..analysis.wording import number
from ..analysis.work_precision import Signal, cost, curves, front
from .plot import (
    WIRE,
    Figure,
    Panel,
    Range,
    Trace,
    claimed,
    error_range,
    layout,
    line,
    method_style,
)

SIGNALS = {"omega": "ω error, relative", "attitude": "attitude error, rad"}
HEADINGS = {"omega": "Angular velocity", "attitude": "Attitude"}
#: A guide runs beside its curve: this factor below it, and over this factor of timesteps.
GUIDE_BELOW, GUIDE_SPAN = 4.0, 8.0
#: Enough that a guide ends close to where it is cut.
GUIDE_POINTS = 25
#: Room beside the outermost points of a log axis, as a factor.
BESIDE = 1.5

#: Broad enough to be seen behind the curves that touch it.
FRONT_WIDTH = 7.0

Abscissa = Callable[[Row], float | None]


def convergence(scene: SceneRuns) -> Figure:
    """ω and attitude errors against the timestep, with the slopes of the declared orders."""
    figure = _against(scene, lambda row: row.timestep, "timestep, s")
    for k, signal in enumerate(SIGNALS, start=1):
        figure["data"] += list(_guides(scene, signal, k))
    return figure


def work_precision(scene: SceneRuns) -> Figure:
    """The same errors against CPU seconds a simulated second, over the best of all methods."""
    figure = _against(scene, cost, "CPU seconds a simulated second")
    signals: tuple[Signal, ...] = ("omega", "attitude")
    fronts = [_front(scene, signal, k) for k, signal in enumerate(signals, start=1)]
    return figure | {"data": fronts + figure["data"]}


def _against(scene: SceneRuns, abscissa: Abscissa, x_title: str) -> Figure:
    assert scene.found is not None, "errors are drawn where there is a reference"
    limits = scene.found.solution.uncertainty
    traces: list[Trace] = []
    panels = []
    x_range = _x_range(scene, abscissa)
    for k, signal in enumerate(SIGNALS, start=1):
        floor = float(getattr(limits, signal))
        drawn = [_curves(runs, scene, signal, abscissa, k) for runs in scene.methods]
        traces += chain.from_iterable(drawn)
        values = [
            _claimed(scene, [row for row in runs.rows if row.outcome == "ok"], signal)
            for runs in scene.methods
        ]
        y_range = error_range(values, floor)
        heading = HEADINGS[signal]
        panels.append(Panel(x_title, SIGNALS[signal], heading, True, y_range, x_range, True, floor))
    return {"data": traces, "layout": layout([panels], height=520)}


def _front(scene: SceneRuns, signal: Signal, k: int) -> Trace:
    """The Pareto front as steps: what no cheaper run is as accurate as."""
    best = [point for _, point in front(curves(scene, signal))]
    return line(
        np.array([point.cost for point in best], dtype=float),
        np.array([point.error for point in best]),
        k,
        line={"color": WIRE, "width": FRONT_WIDTH, "shape": "hv"},
        name="Pareto front",
        hoverinfo="skip",
    )


def _curves(
    runs: MethodRuns, scene: SceneRuns, signal: str, abscissa: Abscissa, k: int
) -> Iterator[Trace]:
    """Finished runs joined by a line; crosses for those that diverged."""
    found = [(x, row) for row in runs.rows if row.errors and (x := abscissa(row)) is not None]
    for outcome, style in _STYLES.items():
        chosen = [(x, row) for x, row in found if row.outcome == outcome]
        if not chosen:
            continue
        rows = [row for _, row in chosen]
        yield line(
            np.array([x for x, _ in chosen]),
            _claimed(scene, rows, signal),
            k,
            **method_style(runs.label, runs.look)
            | {
                "text": [_hover(runs, row) for row in rows],
                "hovertemplate": "%{text}<br>off by %{y:.2e}<extra></extra>",
                "mode": style.mode,
                "marker": {
                    "color": runs.look.colour,
                    "symbol": style.symbol or runs.look.symbol,
                    "size": style.size,
                },
            },
        )


@dataclass(frozen=True)
class _Style:
    """How runs of one outcome are drawn; an empty symbol is the engine's own."""

    mode: str
    symbol: str
    size: int


_STYLES = {
    "ok": _Style("lines+markers", "", 6),
    "diverged": _Style("markers", "x-thin-open", 9),
}


def _claimed(scene: SceneRuns, rows: Sequence[Row], signal: str) -> FloatArray:
    errors = [
        max(float(getattr(row.errors, signal)), getattr(scene.uncertainty(row), signal))
        for row in rows
        if row.errors
    ]
    return claimed(np.array(errors), 0.0)


def _hover(runs: MethodRuns, row: Row) -> str:
    took = cost(row)
    parts = [
        f"{escape(runs.label, quote=False)}, timestep {number(row.timestep)} s",
        f"{number(took)} CPU s a simulated second" if took is not None else "",
        f"{row.outcome} at {number(row.stopped_at)} s" if row.stopped_at is not None else "",
    ]
    return "<br>".join(part for part in parts if part)


def _x_range(scene: SceneRuns, abscissa: Abscissa) -> Range:
    values = [
        x
        for runs in scene.methods
        for row in runs.rows
        if row.errors and (x := abscissa(row)) is not None
    ]
    return min(values) / BESIDE, max(values) * BESIDE


def _guides(scene: SceneRuns, signal: str, k: int) -> Iterator[Trace]:
    """One dotted line an order declared, below the lowest curve that declares it."""
    attribute = {"omega": "order", "attitude": "attitude_order"}[signal]
    orders = {getattr(runs.declared, attribute) for runs in scene.methods if runs.declared}
    for order in sorted(orders):
        points = [
            (row.timestep, float(getattr(row.errors, signal)))
            for runs in scene.methods
            if runs.declared and getattr(runs.declared, attribute) == order
            for row in runs.rows
            if row.errors and row.outcome == "ok" and _readable(scene, row, signal)
        ]
        if points:
            middle = sorted(timestep for timestep, _ in points)[len(points) // 2]
            lowest = min(error / timestep**order for timestep, error in points)
            yield _guide((middle, lowest * middle**order), order, scene, signal, k)


def _readable(scene: SceneRuns, row: Row, signal: str) -> bool:
    error = float(getattr(row.errors, signal))
    uncertainty = float(getattr(scene.uncertainty(row), signal))
    return ABOVE_UNCERTAINTY * uncertainty < error < ASYMPTOTIC


def _guide(anchor: tuple[float, float], order: int, scene: SceneRuns, signal: str, k: int) -> Trace:
    assert scene.found is not None, "a guide runs beside a curve of errors"
    floor = float(getattr(scene.found.solution.uncertainty, signal))
    taken = [row.timestep for runs in scene.methods for row in runs.rows if row.errors]
    timestep, error = anchor
    timesteps = timestep * np.geomspace(GUIDE_SPAN, 1 / GUIDE_SPAN, num=GUIDE_POINTS)
    errors = error / GUIDE_BELOW * (timesteps / timestep) ** order
    inside = (errors > floor) & (min(taken) <= timesteps) & (timesteps <= max(taken))
    timesteps, errors = timesteps[inside], errors[inside]
    labels = [*[""] * (len(errors) - 1), f"order {order}"]
    return line(
        timesteps,
        errors,
        k,
        mode="lines+text",
        text=labels,
        textposition="bottom right",
        line={"color": "rgba(128,128,128,0.9)", "width": 1.5, "dash": "dot"},
        hoverinfo="skip",
        name=f"order {order}",
    )
