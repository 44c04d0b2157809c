"""Describes a fault that gains show: with which timesteps, in which state, and by how much."""

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.rotation import norms
from ...results.evidence import (
    LEVEL,
    QUANTITIES,
    Explanation,
    FaultKind,
    StepFault,
    Vector,
)
from .explanations import explanations, gains_of
from .gain_series import fitted
from .look import Look
from .places import Places
from .readings import misreading
from .regression import LEAST

#: An explanation must come within so many standard errors of a limit.
SURE = 8.0


def _worst(look: Look) -> tuple[int, int]:
    """The indices of the quantity and the state with the smallest tail.

    Several tails may be zero: then a state whose error in a step is the same at all timesteps comes
    first, as its gains in other quantities may follow from it.
    """
    tails = [one.tail for one in look.series]
    alike = [q for q, tail in enumerate(tails) if tail == min(tails)]
    pairs = [(q, int(look.series[q].least_tails.argmin())) for q in alike]
    return next((pair for pair in pairs if _shape(look, *pair)[0] == "leap"), pairs[0])


def kind_of(look: Look) -> FaultKind:
    """How the least likely gains are off."""
    return _shape(look, *_worst(look))[0]


def fault_of(look: Look, at: Places, *, explains: bool) -> StepFault | None:
    """The fault that gains show; None if they are those of a method that converges.

    Parameters
    ----------
    explains : whether changes that explain a limit are looked for
    """
    if look.tail >= LEVEL:
        return None
    q, k = _worst(look)
    series = look.series[q]
    kind, j = _shape(look, q, k)
    if kind == "limit":
        k = int((norms(series.limit) / series.limit_error).argmax())
    wanted, changes = _explained(look, k, q, explains=explains and kind == "limit")
    off = series.limit[k] if kind == "limit" else look.gains[j, k, q]
    if kind == "leap":
        wanted, off = np.zeros(3), off * look.steps.timesteps[j]
    if kind != "limit":
        shortest = slice(-look.gains.shape[1], None)
        ends = look.steps.after.rows(shortest), look.steps.exact.rows(shortest)
        changes = misreading(*ends, look.equations.reach, is_single=look.is_single)
    time = None if np.isnan(at.times[k]) else float(at.times[k])
    timestep = float(look.steps.timesteps[j])
    return StepFault(
        kind, QUANTITIES[q], time, timestep, _vector(wanted + off), _vector(wanted), changes
    )


def _shape(look: Look, q: int, k: int) -> tuple[FaultKind, int]:
    """How the gains of state k in quantity q are off, and the index of a timestep that shows it."""
    series, timesteps = look.series[q], look.steps.timesteps
    gains, noise, count = look.gains[:, :, q], look.noise[:, :, q], len(timesteps)
    bad = np.flatnonzero(series.tails[:, k] * series.tests < look.level)
    leaps = norms(gains[-LEAST:, k]) * timesteps[-LEAST:]
    if len(bad) and np.ptp(leaps) < leaps.min() / 2:
        return "leap", count - 1
    if series.lone_timestep is not None:
        return "timestep", series.lone_timestep
    if len(bad) and bad[0] >= LEAST:
        longer = slice(None, int(bad[0]))
        part = fitted(timesteps[longer], gains[longer], noise[longer], 0.0)
        off = float(norms(series.limit[k : k + 1])[0])
        if SURE * part.limit_error[k] < off and 2 * norms(part.limit[k : k + 1])[0] < off:
            return "shorter", int(bad[0])
    return "limit", count - 1


def _explained(
    look: Look, k: int, q: int, *, explains: bool
) -> tuple[FloatArray, tuple[Explanation, ...]]:
    """What state k should gain in quantity q, (3,), and the changes that explain all limits.

    Parameters
    ----------
    explains : whether such changes are looked for
    """
    if QUANTITIES[q] == "parts":
        return np.zeros(3), ()
    limits, errors = (
        np.stack([getattr(one, name) for one in look.series[: QUANTITIES.index("parts")]], axis=1)
        for name in ("limit", "limit_error")
    )
    last = slice(-look.steps.repeats * look.gains.shape[1], None)
    gains = gains_of(look.equations, look.steps.before.rows(last), limits, SURE * errors)
    return gains.exact[k, q], explanations(gains) if explains else ()


def _vector(values: FloatArray) -> Vector:
    x, y, z = map(float, values)
    return x, y, z
