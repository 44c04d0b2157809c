"""Costs of passes left out, shown in the report."""

from dataclasses import replace

from spincheck.reports.pages.cost_section import (
    BEYOND_NOISE,
    effects_table,
    harm_in_words,
    passes_table,
)
from spincheck.reports.results.cost_records import EffectsCost, PassCost, PassCosts, Ratio
from spincheck.reports.results.records import Key

KEY = Key("box", "mujoco", "Euler")
NOISE = 0.01
WHOLE = EffectsCost(KEY, ("contact",), 1e-6, 1.2e-6, Ratio(1.2, 0.02), 1e-3, 1.0, 0.0)
HARMFUL = replace(WHOLE, difference=3e-5)
BY_PASS = PassCosts(
    KEY,
    1e-6,
    NOISE,
    (PassCost("contact", 0.05, 0.08), PassCost("sensor", 0.5 * BEYOND_NOISE * NOISE, 0.0)),
)


def test_the_ratio_is_reported_with_its_spread_and_what_it_did_to_the_motion():
    whole, harmful = (effects_table([cost]).rows[0][1] for cost in (WHOLE, HARMFUL))
    assert whole.text == "+20% ± 2%"
    assert whole.detail == "motion identical to the last bit"
    assert "motion off by" in harmful.detail
    assert harm_in_words([WHOLE, HARMFUL]) == "1 of 2 motions are identical to the last bit"


def test_a_pass_within_the_noise_is_called_noise():
    contact, sensor = passes_table(BY_PASS).rows
    assert [cell.text for cell in contact] == ["contact", "+5%", "+8%"]
    assert [cell.text for cell in sensor] == ["sensor", "noise", "noise"]
