"""The sentence and the table on each default's effect, from made-up measurements."""

from dataclasses import replace

import pytest
from made_up import STOCK, results
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.scene.default_tables import NEGLIGIBLE, default_tables
from spincheck.reports.results.default_records import DefaultEffect, DefaultEffects
from spincheck.reports.results.records import Key
from spincheck.scenarios import Errors

NONE = Errors(1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4)
MOTOR, DAMPING = replace(NONE, omega=1.0), replace(NONE, omega=0.2)


def table_of(*each: DefaultEffect, none: Errors | None = NONE):
    """What the page of a made-up scene says of these defaults."""
    measured = DefaultEffects(Key("made-up-top", "pybullet", "default"), STOCK[0], none, None, each)
    gathered = report_data(replace(results(), defaults=[measured]))
    (one,) = (effects for scene in gathered.scenes for effects in default_tables(scene))
    return one


@pytest.mark.parametrize(
    ("alone", "sentence"),
    [
        ((DAMPING, MOTOR), "The second alters ω most, then the first."),
        ((NONE, MOTOR), "The second alters ω most; the first by no more than the timestep does."),
        ((NONE, None), "The second alters ω most; the first by no more than the timestep does."),
        ((NONE, NONE), "None of them alone alters the motion by more than the timestep does."),
    ],
    ids=["both", "one", "blown up", "none"],
)
def test_the_sentence_says_which_default_does_most(alone, sentence):
    names = ("first", "second")
    each = (DefaultEffect(name, one, NONE) for name, one in zip(names, alone, strict=True))
    assert table_of(*each).sentence == sentence


def test_an_error_that_is_negligible_is_no_effect_however_small_that_without_is():
    exact = replace(NONE, omega=0.0)
    tiny = replace(NONE, omega=NEGLIGIBLE / 2)
    table = table_of(DefaultEffect("damping", tiny, exact), none=exact)
    assert table.sentence.startswith("None of")


def test_the_table_has_a_row_a_default_and_one_of_none_and_all():
    table = table_of(DefaultEffect("damping", DAMPING, None)).table
    damping, ends = [[cell.text for cell in row] for row in table.rows]
    assert damping == ["damping", "5.73×10⁻³", "0.200", "1.00×10⁻⁴", "diverged", "—", "—"]
    assert ends[0] == "no default, and all"
    assert ends[4:] == ["diverged", "—", "—"]
