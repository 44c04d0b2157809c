"""How large a timestep a method survives on a scene, from all of its runs there.

A run survives if it comes to its end and is better than no motion (`Row.survived`).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile

from ...results.records import Row
from .wording import NOTHING, number


@dataclass(frozen=True)
class Survival:
    """How far up a method survives.

    Attributes
    ----------
    timestep : s, the largest from which on down every run survived; None where the finest did not
    turn : rad a step that it makes where the motion is fastest; likewise
    at_least : whether no larger one was tried: all survived
    """

    timestep: float | None
    turn: float | None
    at_least: bool

    def reaches(self, turn: float) -> bool:
        """Whether the method survives steps of so many rad, or all that the scene has room for."""
        return self.turn is not None and (self.at_least or self.turn >= turn)

    def __str__(self) -> str:
        if self.timestep is None or self.turn is None:
            return "survives none tried"
        bound = "≥ " if self.at_least else ""
        return f"{bound}{number(self.timestep)} s, {number(self.turn)} rad"


def survival(rows: Iterable[Row], fastest_rate: float | None) -> Survival | None:
    """Of one method on one scene; None where it cannot simulate the scene, or was not run.

    Parameters
    ----------
    fastest_rate : the scene's, rad/s; None where it could not be solved, and nothing was run
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
    """The timestep, s, and the turn, rad a step, for two columns of a table."""
    if survived is None:
        return NOTHING, NOTHING
    if survived.timestep is None:
        return "none tried", NOTHING
    bound = "≥ " if survived.at_least else ""
    return f"{bound}{number(survived.timestep)}", f"{bound}{number(survived.turn)}"
