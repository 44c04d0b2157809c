"""Compares what acted on the body in a run with what the scene calls for, after the last step."""

from dataclasses import dataclass

from ...scenarios import Scenario
from ..fault import ENVIRONMENTAL
from ..sampling import Sampled
from ..session import Session
from .read_back import EngineError


@dataclass(frozen=True)
class Audit:
    """The effects that acted, and how they differ from the scene.

    Attributes
    ----------
    active : as returned by `Session.active`
    differs : in words; empty if exactly what the scene calls for acted
    """

    active: frozenset[str] = frozenset()
    differs: str = ""


def audit(session: Session, scenario: Scenario, sampled: Sampled) -> Audit:
    """Audit a session whose run has ended; `differs` is empty unless the run is ok.

    Raises
    ------
    EngineError
        If it cannot be audited and the machine is to blame.
    """
    if sampled.outcome == "failed":
        return Audit()
    try:
        active = session.active()
    except EngineError as error:
        if error.cause in ENVIRONMENTAL:
            raise
        # After a blow-up the engine may not be usable any more.
        return Audit(differs=f"cannot be audited: {error}" if sampled.outcome == "ok" else "")
    return Audit(active, _differs(active, scenario.called_for) if sampled.outcome == "ok" else "")


def _differs(active: frozenset[str], called_for: frozenset[str]) -> str:
    parts = []
    if extra := sorted(active - called_for):
        parts.append(f"active though the scene does not call for it: {', '.join(extra)}")
    if absent := sorted(called_for - active):
        parts.append(f"called for but not active: {', '.join(absent)}")
    return "; ".join(parts)
