"""Rounding that goes one way is told from rounding at random, and from a method's own error."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from case_loops import each_case
from ladders import straight, with_law
from made_up import TIMESTEPS
from spincheck.reports.cli.run.short_summary import short_summary
from spincheck.reports.cli.run.summary import verdict_records
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


def test_a_bias_is_said_where_the_floor_is() -> None:
    stored = with_drift(lambda steps: 1.3 * steps)
    assert bias_of(stored) == pytest.approx(1.3)
    words = " ".join(" ".join(short_summary(stored)).split())
    assert "biased by 1.3 ulp a step" in words
    assert "biased" not in " ".join(short_summary(with_drift(lambda steps: steps**0.5)))


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
