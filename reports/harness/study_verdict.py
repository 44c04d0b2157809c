"""The verdict on a convergence study, with its reason in words."""

from typing import Any

from ...reference.solution import MAX_UNCERTAINTY
from ..results.records import Row, Verdict
from .convergence_study import ConvergenceStudy
from .expected_failures import compared_with_expected_failures
from .ladder import COARSEST_TURN, Ladder
from .ladder_judge import RUNGS_OF_A_LIMIT


def verdict_on(study: ConvergenceStudy) -> Verdict:
    """Judge the ladder, and compare with the expected failures of the scene's file."""
    return compared_with_expected_failures(
        study.scenario.expected_failures, _judged(study), cut_short=study.cut_short
    )


def _judged(study: ConvergenceStudy) -> Verdict:
    last = study.last_row
    attributes: dict[str, Any] = {
        "unmet": tuple(study.unmet),
        "as_shipped": study.method.as_shipped,
    }
    if last is None and (lacking := study.engine.unsupported(study.scenario, study.method)):
        return Verdict(study.key, "unsupported", lacking, **attributes)
    if last and last.outcome in ("failed", "diverged", "unsupported"):
        if last.outcome == "diverged" and (sound := study.judge.blown_up_below):
            return Verdict(study.key, "disagrees", _grown_into(sound[-1], last), **attributes)
        word = "diverges" if last.outcome == "diverged" else last.outcome
        return Verdict(study.key, word, _with_time(last), **attributes)
    # For an engine as shipped: its differences from the scene.
    remark = last.reason if last else ""
    is_wrong = last is not None and last.cause in ("law", "precision")
    if study.judge.signals:
        return _of_signals(study, remark, is_wrong=is_wrong, **attributes)
    reason = "; ".join(part for part in (_no_verdict(study), remark) if part)
    return Verdict(study.key, "disagrees" if is_wrong else "unresolved", reason, **attributes)


def _of_signals(
    study: ConvergenceStudy, remark: str, *, is_wrong: bool, **attributes: Any
) -> Verdict:
    """The verdict of the worst signal; `disagrees` if a run was of another model or precision."""
    worst = study.judge.worst
    judgement = worst.judgement
    word, reason = judgement.word, f"{worst.sequence.signal.label}: {judgement.reason}"
    # What the first steps show, and the body that an engine holds of a user's file, explain the
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
        **attributes,
    )


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
            f"the motion is known to {MAX_UNCERTAINTY:g} up to {study.solution.horizon:g} s "
            "only, before the first sample"
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
