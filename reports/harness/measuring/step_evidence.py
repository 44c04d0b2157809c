"""Puts steps and the series of their gains in the form in which evidence is stored.

A fault is described by the timestep and the state that show it, and by its size.
"""

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.rotation import norms
from ...results.evidence import (
    LEVEL,
    QUANTITIES,
    Explanation,
    FaultKind,
    GainCurve,
    Quantity,
    StepEvidence,
    StepFault,
    Vector,
)
from ..explaining.hypothesis import as_it_is
from ..explaining.readings import misreading
from .explained_gains import Gains, explanations
from .gain_series import fitted
from .look import Look
from .noise import SURE
from .places import Places
from .regression import LEAST


def evidence_of(look: Look, at: Places, order: int, *, explains: bool = True) -> StepEvidence:
    """Return the evidence from steps and the series of their gains.

    Parameters
    ----------
    look : the steps, their gains and the series
    at : the states from which the steps were taken
    order : the declared order; 0 in single precision
    explains : whether changes of the equations of motion that explain a fault are looked for
    """
    return StepEvidence(
        len(at.times),
        look.tail,
        *look.known_to,
        _order_shown(look, order),
        tuple(_curves(look)),
        _fault(look, at, explains=explains) if look.tail < LEVEL else None,
        look.settled,
        _changes_below(look),
        _beyond_from(look),
        order,
    )


def kind_of(look: Look) -> FaultKind:
    """Return the kind of the fault that is clearest in the steps of `look`.

    It says how the gains with the smallest tail fail to vanish (`_shape`).
    """
    return _shape(look, *_worst(look))[0]


def _order_shown(look: Look, declared: int) -> int:
    """Return the lower of the orders of the series of gains in attitude and in I ω.

    The gains are those of the steps in `look`. A quantity whose gains are not well above noise is
    ignored. If both are ignored, the declared order is returned.
    """
    shown = [
        series.order
        for q, series in enumerate(look.series[:2])
        if (np.abs(look.gains[:, :, q]).max(axis=2) > 1e3 * look.noise[:, :, q]).any()
    ]
    return min(shown, default=declared)


def _curves(look: Look) -> list[GainCurve]:
    """Return, for each quantity, the gains by timestep of the state with the smallest tail.

    The gains are those of the steps in `look`. Quantities whose gains are all zero are left out.
    """
    curves = []
    for q, (quantity, series) in enumerate(zip(QUANTITIES, look.series, strict=False)):
        if not look.gains[:, :, q].any():
            continue
        k = int(series.least_tails.argmin())
        sizes = np.linalg.norm(look.gains[:, :, q], axis=2)
        columns = (
            *(sizes[:, k], norms(series.predicted[:, k]), series.predicted_to[:, k]),
            sizes.max(axis=1),
        )
        relative = (tuple(map(float, column / look.sizes[q])) for column in columns)
        curves.append(GainCurve(quantity, tuple(map(float, look.steps.timesteps)), *relative))
    return curves


def _beyond_from(look: Look) -> float:
    """Return the shortest timestep in `look`, s, beyond a radius of convergence; 0 if none is."""
    count = max(int(one.beyond.max()) for one in look.series)
    return float(look.steps.timesteps[count - 1]) if count else 0.0


def _changes_below(look: Look) -> float:
    """Return the change point, s, below which steps in `look` follow a second series; else 0."""
    changes = np.concatenate([one.changes for one in look.series])
    return float(look.steps.timesteps[changes[changes > 0].min() - 1]) if changes.any() else 0.0


def _worst(look: Look) -> tuple[int, int]:
    """Return the indices of the quantity and the state with the smallest tail of gains in `look`.

    Among equal tails, such as zeros, that of a fault of the kind `leap` comes first, as the gains
    in the other quantities may follow from the leap.
    """
    tails = [one.tail for one in look.series]
    alike = [q for q, tail in enumerate(tails) if tail == min(tails)]
    pairs = [(q, int(look.series[q].least_tails.argmin())) for q in alike]
    return next((pair for pair in pairs if _shape(look, *pair)[0] == "leap"), pairs[0])


def _shape(look: Look, q: int, k: int) -> tuple[FaultKind, int]:
    """Return the kind of a fault, and the index of a timestep that shows it.

    It is a `leap` if the error of the shortest steps does not depend on the timestep, `timestep` if
    one timestep deviates, `shorter` if only gains at shorter timesteps do not vanish, else `limit`.

    Parameters
    ----------
    look : the steps with their gains
    q, k : the indices of the quantity and of the state that show the fault
    """
    series, timesteps = look.series[q], look.steps.timesteps
    gains, noise, last = look.gains[:, :, q], look.noise[:, :, q], len(timesteps) - 1
    bad = np.flatnonzero(series.tails[:, k] * series.tests < look.level)
    leaps = norms(gains[-LEAST:, k]) * timesteps[-LEAST:]
    if len(bad) and np.ptp(leaps) < leaps.min() / 2:
        return "leap", last
    if series.lone_timestep is not None:
        return "timestep", series.lone_timestep
    if len(bad) and bad[0] >= LEAST:
        longer = slice(None, int(bad[0]))
        part = fitted(timesteps[longer], gains[longer], noise[longer], 0.0)
        off, off_before = (norms(one.limit)[k] for one in (series, part))
        if SURE * part.limit_error[k] < off and 2 * off_before < off:
            return "shorter", int(bad[0])
    return "limit", last


def _fault(look: Look, at: Places, *, explains: bool) -> StepFault:
    """Return the fault that the gains with the smallest tail show.

    Parameters
    ----------
    look : the steps with their gains
    at : the states from which the steps were taken
    explains : whether changes of the equations that explain a limit are looked for
    """
    q, k = _worst(look)
    series, quantity = look.series[q], QUANTITIES[q]
    kind, j = _shape(look, q, k)
    timestep, wanted = float(look.steps.timesteps[j]), np.zeros(3)
    changes: tuple[Explanation, ...] = ()
    if kind == "limit":
        k = int((norms(series.limit) / series.limit_error).argmax())
    off = series.limit[k] if kind == "limit" else look.gains[j, k, q]
    if kind == "leap":
        off = off * timestep
    elif quantity != "parts":
        limits = _limits(look)
        wanted = limits.exact[k, q]
        changes = explanations(limits) if explains and kind == "limit" else ()
    if kind != "limit":
        shortest = slice(-look.gains.shape[1], None)
        ends = look.steps.after.rows(shortest), look.steps.exact.rows(shortest)
        changes = misreading(*ends, is_single=look.is_single)
    time = None if np.isnan(at.times[k]) else float(at.times[k])
    return StepFault(
        kind, quantity, time, timestep, _vector(wanted + off), _vector(wanted), changes
    )


def random_fault(
    at: Places, k: int, quantity: Quantity, timestep: float, apart: FloatArray
) -> StepFault:
    """Return the fault of steps that end differently when they are taken twice from one state.

    Parameters
    ----------
    at : the states
    k : index of the one state
    quantity : the quantity that differs
    timestep : s
    apart : by how much the gain in the quantity differs, in the units of `step_gains`, (3,)
    """
    time = None if np.isnan(at.times[k]) else float(at.times[k])
    return StepFault("random", quantity, time, timestep, _vector(apart), (0.0, 0.0, 0.0))


def _limits(look: Look) -> Gains:
    """Return the limits of gains in `look`, of all states, but not those of rotors' momenta."""
    of_the_body = look.series[: QUANTITIES.index("parts")]
    limits, errors = (
        np.stack([getattr(one, name) for one in of_the_body], axis=1)
        for name in ("limit", "limit_error")
    )
    states = look.steps.before.rows(slice(-look.steps.repeats * look.gains.shape[1], None))
    base = as_it_is(look.equations.scenario)
    return Gains(base, look.equations, states, limits, SURE * errors)


def _vector(values: FloatArray) -> Vector:
    x, y, z = map(float, values)
    return x, y, z
