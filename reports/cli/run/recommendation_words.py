"""What `recommend` prints: the choice, the cheapest of each other engine, and the checks."""

import math
from dataclasses import asdict
from textwrap import indent
from typing import Any

from ....scenarios import SIGNAL
from ...pages.analysis.best_choice import Candidate, ErrorBounds, as_cheap
from ...results.records import Row
from .recommend import Recommendation


def recommendation_as_json(recommendation: Recommendation) -> dict[str, Any]:
    """Return a recommendation as a JSON object; scripts rely on the names of the keys.

    These are the names of `Recommendation`'s attributes, with four exceptions: `recommended` and
    `methods` are the best candidate and all of them, `verified` says whether the last check is
    within the bounds, and `left_in_ratio` is the factor by which steps of the best candidate take
    longer if the adapter leaves nothing out.
    """
    methods = [_method(candidate) for candidate in recommendation.candidates]
    return {
        "scenario": recommendation.scenario,
        "bounds": dict(recommendation.bounds),
        "recommended": methods[0] if recommendation.best else None,
        "verified": recommendation.verified,
        "nothing": recommendation.nothing,
        "unchecked": recommendation.unchecked,
        "checks": [
            asdict(row.key)
            | {"timestep": row.timestep, "outcome": row.outcome, "reason": row.reason}
            | (asdict(row.errors) if row.errors else {})
            for row in recommendation.checks
        ],
        "setup": recommendation.setup,
        "left_in_ratio": _ratio(recommendation),
        "command": recommendation.command,
        "source": recommendation.source or None,
        "not_compared": recommendation.not_compared,
        "methods": methods,
    }


def _ratio(recommendation: Recommendation) -> float | None:
    """Return the factor by which a step takes longer if the adapter leaves no pass out of it.

    None is returned if that was not timed, or if the adapter leaves nothing out.
    """
    whole = recommendation.left_in
    return whole.cost.ratio.median if whole and whole.cost and whole.cost.ratio else None


def _with_unit(bound: float, unit: str) -> str:
    """Return a bound as text; a bound with a unit is an angle, shown in rad and in degrees."""
    return f"{bound:.3g} rad, {math.degrees(bound):.3g}°" if unit else f"{bound:g}"


def print_recommendation(recommendation: Recommendation) -> None:
    """Print methods that cannot reach the bounds, the choice, its checks, and how to repeat it."""
    bounds = ", ".join(
        f"{SIGNAL[signal].label} to {_with_unit(bound, SIGNAL[signal].unit)}"
        for signal, bound in recommendation.bounds.items()
    )
    print(f"{recommendation.scenario}: {bounds}")
    for candidate in recommendation.candidates:
        if candidate.timestep is None:
            words = candidate.reason.removeprefix(f"{candidate.label} ")
            print(f"{candidate.label}: {candidate.word}: {words}")
    if recommendation.not_compared:
        print(f"Not in {recommendation.source}, so not compared: {recommendation.not_compared}.")
    best = recommendation.best
    if best is None:
        print(f"Nothing is recommended: {recommendation.nothing}.")
        return
    print(f"Cheapest: {_priced(best)}.")
    if alike := as_cheap(recommendation.candidates):
        labels = ", ".join(candidate.label for candidate in alike)
        print(f"As cheap, within the spread of the timings: {labels}.")
    if others := recommendation.of_other_engines:
        print(f"Cheapest of other engines: {'; '.join(map(_priced, others))}.")
    for row in recommendation.checks:
        print(_check_line(row, recommendation.bounds))
    if recommendation.unchecked:
        print(f"Not checked: {recommendation.unchecked}.")
    if recommendation.setup:
        print(f"In {best.key.engine}:\n{indent(recommendation.setup, '  ')}")
    if ratio := _ratio(recommendation):
        assert recommendation.left_in is not None, "it has a ratio"
        print(
            f"With these lines alone a step takes {ratio:.2g} times as long: what the adapter "
            f"leaves out runs, too ({', '.join(recommendation.left_in.left_in)})."
        )
    print(f"To check it again:\n  {recommendation.command}")


def _priced(candidate: Candidate) -> str:
    """Return a candidate's method, timestep and cost in words."""
    finest = candidate.finest_useful
    floor = f"; finer than {finest:.3g} s makes it worse" if finest is not None else ""
    return (
        f"{candidate.label} with a timestep of {candidate.timestep!r} s, {candidate.cost:.3g} CPU "
        f"seconds a simulated second ({candidate.word}{floor})"
    )


def _method(candidate: Candidate) -> dict[str, Any]:
    """Return a candidate as a JSON object: names, timestep, cost, and how these are known."""
    return asdict(candidate.key) | {
        "timestep": candidate.timestep,
        "seconds_per_simulated_second": candidate.cost,
        "spread": candidate.spread,
        "known": candidate.word,
        "reason": candidate.reason,
        "decided_by": candidate.decided_by,
        "largest_stable_timestep": candidate.largest_stable,
        "finest_useful_timestep": candidate.finest_useful,
        "rounding_bias_ulp_a_step": candidate.bias,
    }


def _check_line(row: Row, bounds: ErrorBounds) -> str:
    """Return, in words, whether the errors of a check are within the bounds, and these errors."""
    run = f"{row.key.label} at {row.timestep!r} s"
    if row.errors is None:
        return f"Check of {run}: {row.outcome}: {row.reason}"
    errors_in_words = ", ".join(
        f"{SIGNAL[name].label} {error * SIGNAL[name].shown:.3g}{'°' if SIGNAL[name].unit else ''}"
        for name, error in row.errors
    )
    missed = [SIGNAL[name].label for name, bound in bounds.items() if not row.errors[name] <= bound]
    outcome = f"misses the bound on {' and '.join(missed)}" if missed else "within every bound"
    return f"Check of {run}: {outcome}: {errors_in_words}"
