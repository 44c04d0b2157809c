"""A method's runs at the timesteps that users have, and the largest timestep that it survives.

A run survives if it reaches its end and is better than no motion (`Row.survived`).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile
from typing import Literal

from ...harness.timesteps.stock import COMMON_TIMESTEP
from ...results.records import Row
from .report_data import MethodRuns
from .wording import NOTHING, number


@dataclass(frozen=True)
class Survival:
    """The largest timestep at which a method's runs survive.

    Attributes
    ----------
    timestep : the largest timestep, s, such that the runs at that and at all shorter timesteps
        survived; None if the finest run did not survive
    turn : angle turned in a step of that length at the fastest rate, rad; None if `timestep` is
        None
    at_least : whether all runs survived, so that the method may survive a larger timestep, too
    """

    timestep: float | None
    turn: float | None
    at_least: bool


def survival(rows: Iterable[Row], fastest_rate: float | None) -> Survival | None:
    """Return the largest timestep at which a method survives a scene.

    Parameters
    ----------
    rows : the method's runs on the scene
    fastest_rate : fastest rate of the scene, rad/s; None if the scene could not be solved

    Returns
    -------
    The timestep as a `Survival`; None if nothing was run, if the method cannot simulate the scene,
    or if the scene could not be solved.
    """
    tried = sorted((row for row in rows if row.timestep and row.made), key=lambda row: row.timestep)
    if fastest_rate is None or all(row.outcome == "unsupported" for row in tried):
        return None
    survived = list(takewhile(lambda row: row.survived, tried))
    if not survived:
        return Survival(None, None, at_least=False)
    largest = survived[-1].timestep
    return Survival(largest, largest * fastest_rate, at_least=len(survived) == len(tried))


def in_words(survived: Survival | None) -> tuple[str, str]:
    """Return the largest survived timestep, s, and its turn, rad a step, as texts for two columns.

    Both begin with "≥" if all runs survived. Both are `NOTHING` if `survived` is None. If the
    finest run did not survive, the texts are "at none tested" and `NOTHING`.
    """
    if survived is None:
        return NOTHING, NOTHING
    if survived.timestep is None:
        return "at none tested", NOTHING
    bound = "≥ " if survived.at_least else ""
    return f"{bound}{number(survived.timestep)}", f"{bound}{number(survived.turn)}"


#: Names of three runs of a method: at the engine's own stock timestep, at the stock timestep that
#: is common to all engines, and the finest run with the outcome `ok`.
At = Literal["stock", "common", "finest"]
AT: tuple[At, ...] = ("stock", "common", "finest")


def row_at(runs: MethodRuns, at: At, stock_timestep: float) -> Row | None:
    """Return a method's run at its stock timestep, at 1 ms, or its finest run that is `ok`.

    Parameters
    ----------
    at : which of these runs: "stock", "common" (1 ms) or "finest"
    stock_timestep : the engine's own stock timestep, s

    Returns
    -------
    The run; None if there is no such run.
    """
    if at == "finest":
        return next((row for row in reversed(runs.rows) if row.outcome == "ok"), None)
    timestep = stock_timestep if at == "stock" else COMMON_TIMESTEP
    return next((row for row in runs.rows if row.stock and row.timestep == timestep), None)
