"""What steps and the series of their gains show, in the form in which it is stored."""

import numpy as np

from ....scenarios.rotation import norms
from ...results.evidence import QUANTITIES, GainCurve, StepEvidence
from .look import Look
from .places import Places
from .shapes import fault_of


def evidence_of(look: Look, at: Places, order: int, *, explains: bool) -> StepEvidence:
    """What steps and their series show, as it is stored.

    Parameters
    ----------
    order : the declared one
    explains : whether changes that explain a fault are looked for
    """
    known_to, of_an_effect = look.known_to
    return StepEvidence(
        len(at.times),
        look.tail,
        known_to,
        of_an_effect,
        _order_shown(look, order),
        tuple(_curves(look)),
        fault_of(look, at, explains=explains),
        look.settled,
        _changes_below(look),
        _beyond_from(look),
        order,
    )


def _order_shown(look: Look, declared: int) -> int:
    """The lower of the orders of attitude and angular momentum, where gains are above noise."""
    shown = [
        series.order
        for q, series in enumerate(look.series[:2])
        if (np.abs(look.gains[:, :, q]).max(axis=2) > 1e3 * look.noise[:, :, q]).any()
    ]
    return min(shown, default=declared)


def _curves(look: Look) -> list[GainCurve]:
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
        timesteps = tuple(map(float, look.steps.timesteps))
        curves.append(GainCurve(quantity, timesteps, *relative))
    return curves


def _beyond_from(look: Look) -> float:
    """The shortest timestep, s, beyond the radius of convergence of some state; 0 if none is."""
    count = max(int(one.beyond.max()) for one in look.series)
    return float(look.steps.timesteps[count - 1]) if count else 0.0


def _changes_below(look: Look) -> float:
    """The timestep, s, below which steps follow a second series; 0 where they follow one."""
    first = [
        one.changes[one.changes > 0].min(initial=len(look.steps.timesteps)) for one in look.series
    ]
    longest = int(min(first))
    is_none = longest == len(look.steps.timesteps)
    return 0.0 if is_none else float(look.steps.timesteps[longest - 1])
