"""Costs of passes left out, shown in the report."""

from dataclasses import replace

from spincheck.reports.pages.cost_section import left_out_section
from spincheck.reports.results.cost_records import MethodCost, Ratio, StepCost
from spincheck.reports.results.records import Key, variation

KEY = Key("box", "mujoco", "Euler")
SPREAD = 0.02


def cost(*left_in: str, ratio: float) -> MethodCost:
    timed = StepCost(1e-6, 1e-7, 1e-6, ratio=Ratio(ratio, SPREAD))
    return MethodCost(KEY, "a processor", timed, variation({"left_in": left_in}))


WHOLE = replace(cost("contact", "sensor", ratio=1.2), difference=0.0, compared_until=1.0)
HARMFUL = replace(WHOLE, difference=3e-5, key=replace(KEY, scenario="top"))


def test_the_ratio_is_reported_with_its_spread_and_what_it_did_to_the_motion():
    every, harm = left_out_section([WHOLE, HARMFUL])
    whole, harmful = (row[1] for row in every.rows)
    assert whole.text == "+20% ± 2%"
    assert whole.detail == "motion identical to the last bit"
    assert "motion off by" in harmful.detail
    assert harm == "1 of 2 motions are identical to the last bit"
