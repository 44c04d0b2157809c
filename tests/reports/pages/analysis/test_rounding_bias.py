"""Rounding that goes one way is told from rounding at random, and from a method's own error."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from case_loops import each_case
from ladders import chosen, errors_of, straight, with_law
from made_up import TIMESTEPS
from spincheck.reports.cli.run.short_summary import short_summary
from spincheck.reports.cli.run.summary import verdict_records
from spincheck.reports.pages.analysis.finest_timesteps import NAMED, Finest, finest_in_words
from spincheck.reports.pages.analysis.rounding_bias import ULP
from spincheck.reports.results.results import Results

#: Law of a drift by the number of steps, in ulp.
Drift = Callable[[float], float]


def with_drift(law: Drift, name: str = "L_norm") -> Results:
    """Runs of Euler whose errors grow at short timesteps, with a drift by the number of steps."""
    rounding = 16 * straight(TIMESTEPS[-1]) * TIMESTEPS[-1]
    stored = with_law(lambda timestep: straight(timestep) + rounding / timestep)
    counts = {timestep: 1000 * 2**rung for rung, timestep in enumerate(TIMESTEPS)}
    rows = [
        replace(
            row,
            steps=counts[row.timestep],
            drifts={"energy": 1.0, name: law(counts[row.timestep]) * ULP},
            stock=False,
        )
        if row.key.method == "Euler"
        else row
        for row in stored.rows
    ]
    return replace(stored, rows=rows)


def bias_of(stored: Results) -> float | None:
    (bias,) = (
        one["rounding_bias_ulp_a_step"]
        for one in verdict_records(stored)
        if one["method"] == "Euler"
    )
    return bias


def printed(stored: Results) -> str:
    return " ".join(" ".join(short_summary(stored, Path("results.sqlite"))).split())


def test_a_bias_is_said_where_the_floor_is() -> None:
    stored = with_drift(lambda steps: 1.3 * steps)
    assert bias_of(stored) == pytest.approx(1.3)
    worse = "Finer than this makes it worse: mujoco Euler 2.5 ms, biased by 1.3 ulp a step."
    assert worse in printed(stored)
    assert "biased" not in printed(with_drift(lambda steps: steps**0.5))


def test_a_bias_is_said_before_it_makes_errors_grow() -> None:
    stored = with_drift(lambda steps: 1.3 * steps)
    still_falling = [
        replace(row, errors=row.errors and errors_of(straight, row.timestep)) for row in stored.rows
    ]
    words = printed(replace(stored, rows=still_falling))
    assert "Rounding adds up step by step: mujoco Euler biased by 1.3 ulp a step." in words
    assert "worse" not in words


def test_only_the_first_of_many_methods_are_named() -> None:
    shown = [Finest(f"made-up {k}", (0.01,), 1, None) for k in range(NAMED + 2)]
    (words,) = finest_in_words(shown)
    assert words.count("10 ms") == NAMED
    assert words.endswith("; and 2 other methods")
    assert "other" not in finest_in_words(shown[:NAMED])[0]


@pytest.mark.parametrize(("share", "is_said"), [(0.5, True), (1.1, False)])
def test_a_bias_is_said_where_it_puts_a_bound_out_of_reach(share: float, is_said: bool) -> None:
    stored = with_drift(lambda steps: 1.3 * steps)
    least = min(row.errors.omega for row in stored.rows if row.key.method == "Euler" and row.errors)
    found = chosen(stored, "Euler", omega=share * least)
    assert found.bias == pytest.approx(1.3)
    assert ("biased by 1.3 ulp a step" in found.reason) == is_said


@each_case(
    ("law", "name"),
    [
        (lambda steps: 8 * steps**0.5, "L_norm"),  # at random
        (lambda steps: 1e9 / steps, "L_norm"),  # a method's own error, of first order
        (lambda steps: 2.0, "L_norm"),
        (lambda steps: 0.001 * steps, "L_norm"),  # less than rounding at random
        (lambda steps: 1e4 * steps, "L_norm"),  # no rounding is so large
        (lambda steps: 1.3 * steps, "L_world"),  # not of a momentum's size
    ],
)
def test_no_other_drift_is_called_biased_rounding(law: Drift, name: str) -> None:
    assert bias_of(with_drift(law, name)) is None
