"""The verdict on a method on a scene.

A method whose steps are consistent with the equations of motion, and depend on the state alone,
converges (Hairer, Nørsett & Wanner I, theorem II.3.4). Single steps test whether the steps are
consistent, and replays whether they depend on the state alone. The tails of both tests are compared
with the same level.
"""

from dataclasses import replace

from ...results.evidence import CONSISTENT
from ...results.verdict_words import VerdictWord
from ...results.verdicts import Verdict
from .expected_failures import compared_with_expected_failures
from .records import Records


def judge(records: Records) -> Verdict:
    """Judge a method by its records, and compare the verdict with the scene's expected failures.

    A verdict `unresolved` becomes `unsupported` if rounding of the body's moments of inertia
    changes its angular acceleration by more than `CONSISTENT`, relative.
    """
    word, quoted = _judged(records)
    if word == "unresolved" and records.rounding > CONSISTENT:
        precision = "single" if records.is_single else "double"
        word = "unsupported"
        quoted = (
            f"the body cannot be held in {precision} precision: rounding of its moments changes "
            f"its angular acceleration by {records.rounding:.1e}, relative"
        )
    evidence = records.evidence
    steps, own = (one and replace(one, curves=()) for one in (evidence.steps, evidence.own_steps))
    verdict = Verdict(evidence.key, word, quoted, steps, own, evidence.replays, records.unmet)
    verdict = replace(verdict, as_shipped=records.as_shipped)
    return compared_with_expected_failures(records.known, verdict)


def _judged(records: Records) -> tuple[VerdictWord, str]:
    """Return the verdict's word, and the text that the verdict quotes.

    The text is the ending of a run, or the words of the engine; it may be empty.
    """
    last, evidence = records.last, records.evidence
    if last is None and records.lacking:
        return "unsupported", records.lacking
    if last and last.outcome in ("failed", "unsupported"):
        # If a method cannot simulate a scene at one timestep, it cannot at any.
        return last.outcome, last.ending_in_words
    # A run as shipped says how the engine's model differs. With the cause `law`, the evidence does.
    quoted = last.reason if last and last.cause != "law" else ""
    faults = (one.fault for one in (evidence.steps, evidence.own_steps) if one)
    if any(faults):
        return "disagrees", quoted
    if evidence.steps and evidence.steps.is_of_low_order:
        return "disagrees", quoted
    # Replays of runs that blow up show nothing, so that they are not considered.
    if last and last.outcome == "diverged":
        return "diverges", last.ending_in_words
    if any(one.is_wrong for one in evidence.replays):
        return "disagrees", quoted
    if evidence.refusal:
        if evidence.is_of_failure:
            return "failed", f"when set to other states, it fails: {evidence.refusal}"
        return "unresolved", f"it cannot be examined from other states: {evidence.refusal}"
    if evidence.steps is None:
        return "unresolved", quoted or "no step could be taken from the states of the motion"
    if not evidence.steps.is_known:
        return "unresolved", quoted
    if not evidence.replays and records.is_replayed:
        return "unresolved", "; ".join(filter(None, (quoted, "no run could be run again")))
    return "converges", ""
