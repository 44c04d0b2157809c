"""The verdict on a method on a scene, with its reason in words."""

from dataclasses import replace
from math import degrees
from typing import Any

from ....scenarios.signals import SIGNAL
from ...results.evidence import LocalEvidence
from ...results.records import Row, Verdict
from ...results.verdict_words import RANKS
from ..ladder import COARSEST_TURN
from .contradictions import contradictions
from .expected_failures import compared_with_expected_failures
from .ladder import RUNGS_OF_A_LIMIT
from .ladder_end import cut_short
from .local import CONSISTENT, SEEN, LocalJudgement
from .records import Records


def judge(records: Records) -> Verdict:
    """Judge a method by what is stored of it, and compare with the scene's expected failures."""
    verdict = _judged(records)
    if records.rounding > CONSISTENT and _may_be_rounding(verdict, records):
        precision = "single" if records.is_single else "double"
        reason = (
            f"the body cannot be held in {precision} precision: rounding of its moments changes "
            f"its angular acceleration by {records.rounding:.1e}, relative"
        )
        reason = "; ".join(filter(None, (reason, verdict.reason)))
        attributes: dict[str, Any] = {"unmet": verdict.unmet, "as_shipped": verdict.as_shipped}
        verdict = Verdict(verdict.key, "unsupported", reason, **attributes)
    if verdict.verdict == "converges" and records.local and records.local.evidence.remark:
        reason = f"{verdict.reason}; {records.local.evidence.remark}"
        verdict = replace(verdict, reason=reason)
    return compared_with_expected_failures(records.known, verdict, cut_short=cut_short(records))


def _may_be_rounding(verdict: Verdict, records: Records) -> bool:
    """Whether nothing is decided, or only that the ladder's limit is off by what rounding may make.

    Over the window an angular acceleration that is off by ε, relative, turns a body that turns by φ
    further by about ε φ.
    """
    if verdict.verdict == "unresolved":
        return records.least_steps is not None
    has_finding = records.local is None or bool(records.local.evidence.finding)
    if verdict.verdict != "disagrees" or records.as_shipped or has_finding:
        return False
    if not records.ladder.signals or verdict.limit_error is None:
        return False
    worst = records.ladder.worst
    turned = worst.sequence.rate * worst.sequence.duration
    is_limit = worst.word == "disagrees"
    return is_limit and verdict.limit_error <= records.rounding * turned


def _judged(records: Records) -> Verdict:
    key, last, local = records.evidence.key, records.last, records.local
    attributes: dict[str, Any] = {"unmet": records.unmet, "as_shipped": records.as_shipped}
    if last is None and records.lacking:
        return Verdict(key, "unsupported", records.lacking, **attributes)
    if last and last.outcome in ("failed", "unsupported"):
        # What a method cannot simulate it cannot at any timestep.
        reason = last.reason if last.cause == "effects" else _with_time(last)
        return Verdict(key, last.outcome, reason, **attributes)
    is_clean = not records.as_shipped
    if is_clean and local and local.evidence.finding and not (last and last.cause == "law"):
        return _of_signals(records, local.evidence.finding, is_wrong=True, **attributes)
    if last and last.outcome == "diverged":
        if sound := records.blown_up_below:
            return Verdict(key, "disagrees", _grown_into(sound[-1], last), **attributes)
        return Verdict(key, "diverges", _with_time(last), **attributes)
    # For an engine as shipped: its differences from the scene.
    remark = last.reason if last else ""
    is_wrong = last is not None and last.cause in ("law", "precision")
    if not is_wrong:
        worst_first = sorted(records.ladder.signals, key=lambda one: one.severity, reverse=True)
        sequences = [one.sequence for one in worst_first]
        found = contradictions(records.judged_rows, sequences, records.slack, records.interval)
        wrong = next(found, "")
        if wrong and is_clean:
            return _of_signals(records, wrong, is_wrong=True, **attributes)
        if not wrong and local and (verdict := _by_pieces(records, local, attributes)):
            return verdict
    return _of_signals(records, remark, is_wrong=is_wrong, **attributes)


def _by_pieces(
    records: Records, local: LocalJudgement, attributes: dict[str, Any]
) -> Verdict | None:
    """The verdict where the whole window does not decide; None where it does, or nothing does."""
    ladder, key, found = records.ladder, records.evidence.key, local.evidence
    word = ladder.worst.word if ladder.signals else "unresolved"
    pieces = local.pieces.records()
    if not pieces:
        return None
    worst = max(pieces, key=lambda one: RANKS[one.verdict])
    where = f"over 115° from exact states, {SIGNAL[worst.signal].label}: {worst.reason}"
    numbers = (worst.signal, worst.order, worst.limit_error, worst.tolerance, pieces)
    if worst.verdict == "disagrees" and not records.as_shipped:
        return Verdict(key, "disagrees", where, *numbers, **attributes)
    # Single timesteps are asked about as they are.
    is_decided = records.least_steps is None or word != "unresolved"
    if is_decided or not local.converges or records.remembers:
        return None
    reason = (
        f"steps from {found.states} exact states are consistent to {found.tolerance:.1e} of the "
        f"largest terms{_of_an_effect(found)}; {where}; over the whole window: {_over_all(records)}"
    )
    ground = f"in {found.states} steps and {found.starts} pieces"
    return Verdict(key, "converges", reason, *numbers, ground=ground, **attributes)


def _of_an_effect(found: LocalEvidence) -> str:
    """How well steps are known relative to the weakest effect, in words, where that says more."""
    if found.of_an_effect <= found.tolerance:
        return ""
    return f", to {found.of_an_effect:.1e} of the weakest effect"


def _over_all(records: Records) -> str:
    """How many steps would show it over the whole window."""
    if not records.ladder.signals:
        return _no_verdict(records)
    worst = records.ladder.worst
    if worst.needed_timestep is None:
        return "round-off or the uncertainty of the exact motion hides it at every timestep"
    return f"{worst.sequence.duration / worst.needed_timestep:.1e} steps would show it"


def _of_signals(records: Records, remark: str, *, is_wrong: bool, **attributes: Any) -> Verdict:
    """The verdict of the worst signal; `disagrees` if a run was of another model or precision."""
    key = records.evidence.key
    if not records.ladder.signals:
        open_ended = () if is_wrong else (_no_verdict(records), _undecided_by_pieces(records))
        reason = "; ".join(part for part in (*open_ended, remark) if part)
        return Verdict(key, "disagrees" if is_wrong else "unresolved", reason, **attributes)
    worst = records.ladder.worst
    word, reason = worst.word, f"{worst.sequence.signal.label}: {worst.reason}"
    if word == "unresolved" and not is_wrong:
        reason = "; ".join(filter(None, (reason, _undecided_by_pieces(records))))
    # What single steps show, and the body that an engine holds of a user's file, explain the
    # motion: they are named first.
    explains = records.of_file or is_wrong
    parts = [remark, reason] if explains else [reason, remark]
    if word == "converges" and not is_wrong:
        # Then the effects that an engine as shipped adds do not alter the motion.
        parts = [reason]
    return Verdict(
        key,
        "disagrees" if is_wrong else word,
        "; ".join(part for part in parts if part),
        worst.sequence.signal.name,
        *worst.numbers,
        records.ladder.records(),
        ground="over the whole window" if word == "converges" and not is_wrong else "",
        **attributes,
    )


def _undecided_by_pieces(records: Records) -> str:
    """Why steps and pieces do not decide either; empty where they were not asked."""
    if records.local is None or records.least_steps is None:
        return ""
    found = records.local.evidence
    if records.remembers:
        return (
            "pieces do not decide: a run goes on otherwise than if restarted from its own states, "
            "so that a step depends on more than the state"
        )
    if found.finding:
        return f"steps from exact states do not decide: {found.finding}"
    if found.is_open:
        return "pieces do not decide: where next to nothing acts, steps leave what may add up"
    if found.tolerance > CONSISTENT:
        return (
            f"pieces do not decide: steps are known to be consistent to {found.tolerance:.2e} of "
            f"the largest terms only, and {CONSISTENT:g} is needed"
        )
    if found.of_an_effect > SEEN:
        return (
            f"pieces do not decide: steps are known to be consistent to {found.of_an_effect:.2e} "
            f"of the weakest effect only, and {SEEN:g} is needed"
        )
    return "pieces do not decide: over 115° from exact states it is unresolved, too"


def _no_verdict(records: Records) -> str:
    """Why the ladder cannot be judged."""
    if records.least_steps is None:
        return "no ladder was run, only single timesteps"
    if not records.finest:
        return _no_ladder(records.least_steps, records.ending)
    finished = len(records.judged_rows)
    return f"a verdict needs {RUNGS_OF_A_LIMIT} timesteps that run to the end, got {finished}"


def _no_ladder(least_steps: float, ending: str) -> str:
    """Why the scene has no ladder, and how many steps one would take."""
    if not least_steps:
        return (
            "the motion is known up to a time before the first sample only"
            f"{': ' if ending else ''}{ending}"
        )
    return (
        f"at {degrees(COARSEST_TURN):.3g}° a step a run takes {least_steps:.1e} steps, which is "
        f"above the limit; {RUNGS_OF_A_LIMIT} timesteps, which make a verdict, would take "
        f"{least_steps * (2**RUNGS_OF_A_LIMIT - 1):.1e}"
    )


def _with_time(row: Row) -> str:
    when = f" at {row.stopped_at:.4g} s" if row.stopped_at is not None else ""
    return f"{row.reason}{when}, with a timestep of {row.timestep:.3g} s"


def _grown_into(sound: Row, last: Row) -> str:
    return (
        f"errors grow as the timestep shrinks: a run ends well at {sound.timestep:.3g} s, while "
        f"{_with_time(last)}"
    )
