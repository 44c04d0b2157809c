"""Figures of the gains of single steps against the timestep, with the predictions of verdicts."""

from collections.abc import Iterator
from html import escape

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from ...results.evidence import LEVEL, QUANTITIES, GainCurve, Quantity
from ..analysis.report_data import MethodRuns, SceneRuns
from .plot import OFF_THE_CHART, Figure, Panel, Trace, drawing, line, method_style

#: Half width of the band of predicted gains, in standard deviations; and the band's opacity, as two
#: hexadecimal digits behind a colour.
BAND, OPACITY = 2.0, "30"
#: Distance of a gain from its prediction that chance exceeds with the probability `LEVEL`, in
#: standard deviations of one of the three components of a gain.
OFF = float(np.sqrt(chdtri(3, LEVEL)))
#: Number of gains, those at the longest timesteps, for which there is no prediction.
NOT_PREDICTED = 2
#: Factors of room beside the outermost timesteps and above the largest gain; and the least gain
#: that is drawn, as a fraction of the noise.
BESIDE, ABOVE, BELOW = 1.3, 3.0, 0.1
HEIGHT, MARKER, RING = 360, 6, 15
#: If fewer methods than this gain more than noise, the panel's heading names them.
FEW = 3


def gain_figures(scene: SceneRuns) -> list[Figure]:
    """Return a figure for each quantity in which steps of at least one method gain more than noise.

    The quantities are attitude, I ω, velocity and place.
    """
    return [
        _figure(scene, quantity)
        for quantity in QUANTITIES
        if any(_is_shown(curve) for _, curve in _curves(scene, quantity))
    ]


def _curves(scene: SceneRuns, quantity: Quantity) -> Iterator[tuple[MethodRuns, GainCurve]]:
    """Yield each method with its gains of a quantity, if longer timesteps predict any of them."""
    for runs in scene.methods:
        steps = runs.evidence.steps if runs.evidence else None
        for curve in steps.curves if steps else ():
            if curve.quantity == quantity and len(curve.timesteps) > NOT_PREDICTED:
                yield runs, curve


def _is_shown(curve: GainCurve) -> bool:
    """Whether a gain from any state exceeds noise, the least standard deviation of a prediction."""
    return max(curve.largest) > min(curve.predicted_to[NOT_PREDICTED:])


def _figure(scene: SceneRuns, quantity: Quantity) -> Figure:
    """Return the figure of a quantity, with the gains of the methods that gain more than noise."""
    shown = [(runs, curve) for runs, curve in _curves(scene, quantity) if _is_shown(curve)]
    examined = sum(bool(runs.evidence and runs.evidence.steps) for runs in scene.methods)
    is_few = len(shown) < min(FEW, examined)
    alone = f" of {' and '.join(runs.label for runs, _ in shown)} alone" if is_few else ""
    timesteps = [h for _, curve in shown for h in curve.timesteps]
    noise = min(min(curve.predicted_to[NOT_PREDICTED:]) for _, curve in shown)
    largest = max(max(curve.gains) for _, curve in shown)
    low, high = BELOW * noise, min(ABOVE * max(largest, noise), OFF_THE_CHART)
    panel = Panel(
        "timestep, s",
        "gain a second, relative",
        f"{quantity.capitalize()}{escape(alone, quote=False)}",
        log_x=True,
        x_range=(min(timesteps) / BESIDE, max(timesteps) * BESIDE),
        log_y=True,
        y_range=(low, high),
    )
    bands = [_band(runs, curve, low) for runs, curve in shown]
    traces = [trace for runs, curve in shown for trace in _gains(runs, curve, low)]
    return drawing([*bands, *traces], [panel], HEIGHT)


def _band(runs: MethodRuns, curve: GainCurve, low: float) -> Trace:
    """Return the band in which a method's gains are predicted to be, as a filled area.

    Parameters
    ----------
    curve : the gains and their predictions, at each timestep
    low : the least gain that is drawn
    """
    timesteps, predicted, known_to = (
        np.array(column[NOT_PREDICTED:])
        for column in (curve.timesteps, curve.predicted, curve.predicted_to)
    )
    top = np.maximum(predicted + BAND * known_to, low)
    bottom = np.maximum(predicted - BAND * known_to, low)
    return line(
        np.concatenate([timesteps, timesteps[::-1]]),
        np.concatenate([top, bottom[::-1]]),
        1,
        **method_style(runs.label, runs.style)
        | {
            "line": {"color": runs.style.colour, "width": 0},
            "fill": "toself",
            "fillcolor": f"{runs.style.colour}{OPACITY}",
            "hoverinfo": "skip",
        },
    )


def _gains(runs: MethodRuns, curve: GainCurve, low: float) -> Iterator[Trace]:
    """Yield a method's gains joined by a line, and rings around those that miss their prediction.

    Parameters
    ----------
    curve : the gains and their predictions, at each timestep
    low : the least gain that is drawn
    """
    timesteps, gains = np.array(curve.timesteps), np.array(curve.gains)
    drawn = np.where(gains > low, gains, np.nan)
    style = method_style(runs.label, runs.style)
    marker = {"color": runs.style.colour, "symbol": runs.style.symbol, "size": MARKER}
    said = f"{style['name']}<br>%{{x:.3g}} s: %{{y:.2e}}<extra></extra>"
    lines = {"mode": "lines+markers", "marker": marker, "hovertemplate": said}
    yield line(timesteps, drawn, 1, **style | lines)
    off = is_off(curve)
    if off.any():
        ring = {"color": runs.style.colour, "symbol": "circle-open", "size": RING}
        rings = {"mode": "markers", "marker": ring, "hoverinfo": "skip"}
        yield line(timesteps[off], drawn[off], 1, **style | rings)


def is_off(curve: GainCurve) -> NDArray[np.bool_]:
    """Return which of the J gains of a curve are too far from their prediction for chance, (J,)."""
    columns = (curve.gains, curve.predicted, curve.predicted_to)
    gains, predicted, known_to = map(np.array, columns)
    off = np.abs(gains - predicted) > OFF * known_to
    off[:NOT_PREDICTED] = False
    return np.asarray(off)
