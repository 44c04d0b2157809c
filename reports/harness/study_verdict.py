"""The verdict on a convergence study, with its reason in words."""

from typing import Any

from ...scenarios.signals import SIGNAL
from ..results.records import CONSISTENT, LocalCheck, Row, Verdict
from ..results.verdict_words import RANKS
from .convergence_study import ConvergenceStudy
from .expected_failures import compared_with_expected_failures
from .judging.contradictions import contradictions
from .judging.places import PIECES, rounding_of_body
from .ladder import COARSEST_TURN, Ladder
from .ladder_judge import RUNGS_OF_A_LIMIT


def verdict_on(study: ConvergenceStudy) -> Verdict:
    """Judge the ladder, and compare with the expected failures of the scene's file."""
    return compared_with_expected_failures(
        study.scenario.expected_failures, _judged(study), cut_short=study.cut_short
    )


def _judged(study: ConvergenceStudy) -> Verdict:
    last, local = study.last_row, study.local
    attributes: dict[str, Any] = {
        "unmet": tuple(study.unmet),
        "as_shipped": study.method.as_shipped,
    }
    if last is None and (lacking := study.engine.unsupported(study.scenario, study.method)):
        return Verdict(study.key, "unsupported", lacking, **attributes)
    if last and last.outcome in ("failed", "unsupported"):
        return Verdict(study.key, last.outcome, _with_time(last), **attributes)
    if local and local.reason and not (last and last.cause == "law"):
        return _of_signals(study, local.reason, is_wrong=True, **attributes)
    if last and last.outcome == "diverged":
        if sound := study.judge.blown_up_below:
            return Verdict(study.key, "disagrees", _grown_into(sound[-1], last), **attributes)
        return Verdict(study.key, "diverges", _with_time(last), **attributes)
    # For an engine as shipped: its differences from the scene.
    remark = last.reason if last else ""
    is_wrong = last is not None and last.cause in ("law", "precision")
    if not is_wrong and not study.method.as_shipped:
        slack = study.engine.slack
        if study.places:
            # Of a body whose moments differ much no engine holds the least.
            slack = max(slack, rounding_of_body(study.places.condition))
        times = study.solution.trajectory.t
        interval = float(times[-1]) / max(1, len(times) - 1)
        evidence = contradictions(study.judge.rows, study.judge.sequences, slack, interval)
        if wrong := next(evidence, ""):
            return _of_signals(study, wrong, is_wrong=True, **attributes)
        if local and (verdict := _by_pieces(study, local, attributes)):
            return verdict
    return _of_signals(study, remark, is_wrong=is_wrong, **attributes)


def _by_pieces(
    study: ConvergenceStudy, local: LocalCheck, attributes: dict[str, Any]
) -> Verdict | None:
    """The verdict where the whole window does not decide; None where it does, or nothing does."""
    word = study.judge.worst.judgement.word if study.judge.signals else "unresolved"
    worst = max(local.pieces, key=lambda one: RANKS[one.verdict])
    where = f"over 2 rad from exact states, {SIGNAL[worst.signal].label}: {worst.reason}"
    found = (worst.signal, worst.order, worst.limit_error, worst.tolerance, local.pieces)
    if worst.verdict == "disagrees":
        return Verdict(study.key, "disagrees", where, *found, **attributes)
    # Single timesteps are asked about as they are.
    if study.ladder is None or word != "unresolved" or not local.converges or study.remembers:
        return None
    reason = (
        f"steps from {local.states} exact states are consistent to {local.tolerance:.1e}; "
        f"{where}; over the whole window: {_over_all(study)}"
    )
    ground = f"in {local.states} steps and {PIECES} pieces"
    return Verdict(study.key, "converges", reason, *found, ground=ground, **attributes)


def _over_all(study: ConvergenceStudy) -> str:
    """How many steps would show it over the whole window."""
    if not study.judge.signals:
        return _no_verdict(study)
    needed = study.judge.worst.judgement.needed_timestep
    if needed is None:
        return "round-off or the uncertainty of the exact motion hides it at every timestep"
    return f"{float(study.solution.trajectory.t[-1]) / needed:.1e} steps would show it"


def _of_signals(
    study: ConvergenceStudy, remark: str, *, is_wrong: bool, **attributes: Any
) -> Verdict:
    """The verdict of the worst signal; `disagrees` if a run was of another model or precision."""
    if not study.judge.signals:
        open_ended = () if is_wrong else (_no_verdict(study), _undecided_by_pieces(study))
        reason = "; ".join(part for part in (*open_ended, remark) if part)
        return Verdict(study.key, "disagrees" if is_wrong else "unresolved", reason, **attributes)
    worst = study.judge.worst
    judgement = worst.judgement
    word, reason = judgement.word, f"{worst.sequence.signal.label}: {judgement.reason}"
    if word == "unresolved" and not is_wrong:
        reason = "; ".join(filter(None, (reason, _undecided_by_pieces(study))))
    # What single steps show, and the body that an engine holds of a user's file, explain the
    # motion: they are named first.
    explains = study.engine.of_file or is_wrong
    parts = [remark, reason] if explains else [reason, remark]
    if word == "converges" and not is_wrong:
        # Then the effects that an engine as shipped adds do not alter the motion.
        parts = [reason]
    return Verdict(
        study.key,
        "disagrees" if is_wrong else word,
        "; ".join(part for part in parts if part),
        worst.sequence.signal.name,
        judgement.order,
        judgement.limit_error,
        judgement.tolerance,
        study.judge.records(),
        ground="over the whole window" if word == "converges" and not is_wrong else "",
        **attributes,
    )


def _undecided_by_pieces(study: ConvergenceStudy) -> str:
    """Why steps and pieces do not decide either; empty where they were not asked."""
    local = study.local
    if local is None or study.ladder is None:
        return ""
    if study.remembers:
        return (
            "pieces do not decide: a run goes on otherwise than if restarted from its own states, "
            "so that a step depends on more than the state"
        )
    if local.is_open:
        return "pieces do not decide: where next to nothing acts, steps leave what may add up"
    if local.tolerance > CONSISTENT:
        return (
            f"pieces do not decide: steps are known to be consistent to {local.tolerance:.1e} of "
            f"the largest terms only, and {CONSISTENT:g} is needed"
        )
    return "pieces do not decide: over 2 rad from exact states it is unresolved, too"


def _no_verdict(study: ConvergenceStudy) -> str:
    """Why the ladder cannot be judged."""
    if study.ladder is None:
        return "no ladder was run, only single timesteps"
    if not study.ladder.rungs:
        return _no_ladder(study, study.ladder)
    finished = study.judge.finished
    return f"only {finished} timesteps ran to the end; {RUNGS_OF_A_LIMIT} make a verdict"


def _no_ladder(study: ConvergenceStudy, ladder: Ladder) -> str:
    """Why the scene has no ladder, and how many steps one would take."""
    if not ladder.least_steps:
        return (
            "the motion is known up to a time before the first sample only"
            f"{': ' if study.solution.ending else ''}{study.solution.ending}"
        )
    return (
        f"at {COARSEST_TURN:g} rad a step a run takes {ladder.least_steps:.1e} steps, which is "
        f"above the limit; {RUNGS_OF_A_LIMIT} timesteps, which make a verdict, would take "
        f"{ladder.least_steps * (2**RUNGS_OF_A_LIMIT - 1):.1e}"
    )


def _with_time(row: Row) -> str:
    when = f" at {row.stopped_at:.4g} s" if row.stopped_at is not None else ""
    return f"{row.reason}{when}, with a timestep of {row.timestep:.3g} s"


def _grown_into(sound: Row, last: Row) -> str:
    return (
        f"errors grow as the timestep shrinks: a run ends well at {sound.timestep:.3g} s, while "
        f"{_with_time(last)}"
    )
