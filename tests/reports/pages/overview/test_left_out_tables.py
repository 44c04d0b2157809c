"""Costs of passes left out: stored in the result file, and shown in the report."""

import pytest
from spincheck.reports.pages.cost_section import (
    BEYOND_NOISE,
    effects_table,
    harm_in_words,
    passes_table,
)
from spincheck.reports.results.cost_records import EffectsCost, PassCost, PassCosts, Ratio
from spincheck.reports.results.records import Key
from spincheck.reports.results.store import open_store

KEY = Key("box", "mujoco", "Euler")
NOISE = 0.01
WHOLE = EffectsCost(KEY, ("contact",), 1e-6, 1.2e-6, Ratio(1.2, 0.02), 1e-3, 1.0, 0.0)
HARMFUL = EffectsCost(KEY, ("contact",), 1e-6, 1.2e-6, Ratio(1.2, 0.02), 1e-3, 1.0, 3e-5)
BY_PASS = PassCosts(
    KEY,
    1e-6,
    NOISE,
    (PassCost("contact", 0.05, 0.08), PassCost("sensor", 0.5 * BEYOND_NOISE * NOISE, 0.0)),
)


@pytest.mark.parametrize("cost", [WHOLE, BY_PASS], ids=["as a whole", "pass by pass"])
def test_it_comes_back_from_the_result_file(tmp_path, cost):
    with open_store(tmp_path / "results.sqlite", create=True) as store:
        store.put(cost)
        results = store.read()
    assert [*results.effects, *results.passes] == [cost]


def test_the_ratio_is_reported_with_its_spread_and_what_it_did_to_the_motion():
    (row,) = effects_table([WHOLE]).rows
    assert row[1].text == "+20% ± 2%"
    assert row[1].detail == "motion identical to the last bit"


def test_a_motion_that_changed_is_reported():
    (row,) = effects_table([HARMFUL]).rows
    assert "motion off by" in row[1].detail
    assert harm_in_words([WHOLE, HARMFUL]) == "1 of 2 motions are identical to the last bit"


def test_a_pass_within_the_noise_is_called_noise():
    contact, sensor = passes_table(BY_PASS).rows
    assert [cell.text for cell in contact] == ["contact", "+5%", "+8%"]
    assert [cell.text for cell in sensor] == ["sensor", "noise", "noise"]
