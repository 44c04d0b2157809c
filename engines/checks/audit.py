"""Compares the effects that acted on the body with those of the scene, after a run's last step."""

from ...scenarios import Scenario
from ..fault import ENVIRONMENTAL
from ..sampling import Sampled
from ..session import Session
from .read_back import EngineError


def audit(session: Session, scenario: Scenario, sampled: Sampled) -> tuple[frozenset[str], str]:
    """Audit a session whose run has ended as `sampled` says.

    Returns
    -------
    What acted on the body, as returned by `Session.active`, and a text on how this differs from the
    effects that the scene calls for. The text is empty if there is no difference, or if the run
    is not ok. If the run failed or the session cannot be audited, the set is empty; for a run that
    is ok the text then says why it cannot be audited.

    Raises
    ------
    EngineError
        If the session cannot be audited and the machine is to blame.
    """
    if sampled.outcome == "failed":
        return frozenset(), ""
    try:
        active = session.active()
    except EngineError as error:
        if error.cause in ENVIRONMENTAL:
            raise
        # An engine that blew up may no longer be usable.
        return frozenset(), f"cannot be audited: {error}" if sampled.outcome == "ok" else ""
    return active, _difference(active, scenario.called_for) if sampled.outcome == "ok" else ""


def _difference(active: frozenset[str], called_for: frozenset[str]) -> str:
    """Return, in words, how two sets of effects differ; empty if they do not."""
    parts = []
    if extra := sorted(active - called_for):
        parts.append(f"active though the scene does not call for it: {', '.join(extra)}")
    if absent := sorted(called_for - active):
        parts.append(f"called for but not active: {', '.join(absent)}")
    return "; ".join(parts)
