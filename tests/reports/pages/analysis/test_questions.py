"""Questions to the table of results, with answers that are known."""

import math
from dataclasses import replace

import pytest
from made_up import MadeUp, results
from spincheck.reports.pages.analysis.questions import Usual, at_stock
from spincheck.reports.pages.analysis.report_data import ReportData, report_data
from spincheck.reports.pages.overview import overview
from spincheck.reports.pages.overview.causes import why
from spincheck.reports.results.default_records import DefaultEffect, DefaultEffects
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Errors

EXACT = Errors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
OWN, COMMON = 0.002, 0.001
#: rad, by scene: what is off at the end, and by a turn; one blew up.
ATTITUDES = {"a": 0.1, "b": 0.4, "c": 0.2, "d": math.inf}


def run(scene: str, attitude: float, method: str = "default", timestep: float = OWN) -> Row:
    row = Row(Key(scene, "e", method), "1.0", timestep, "ok", stock=True)
    if attitude == math.inf:
        return replace(row, outcome="diverged", turns=3.0)
    turned = {"turns": 9.0, "turns_within_1deg": 10 * attitude, "attitude_a_turn": attitude / 8}
    return replace(row, errors=replace(EXACT, attitude=attitude), **turned)


@pytest.fixture(scope="module")
def gathered() -> ReportData:
    """An engine as shipped and a method on four scenes; the method is exact."""
    (made,) = results(methods=[MadeUp("e", "default", 1)]).methods.values()
    methods = {("e", "default"): replace(made, as_shipped=True), ("e", "RK4"): made}
    rows = [run(scene, attitude) for scene, attitude in ATTITUDES.items()]
    rows += [run(scene, 1.0, timestep=COMMON) for scene in ATTITUDES]
    rows += [run(scene, 0.0, "RK4") for scene in ATTITUDES]
    rows.append(replace(run("z", math.inf), outcome="unsupported"))
    words = dict(zip(ATTITUDES, ("converges", "disagrees", "disagrees", "diverges"), strict=True))
    verdicts = [Verdict(Key(s, "e", "default"), w, as_shipped=True) for s, w in words.items()]
    verdicts += [Verdict(Key(scene, "e", "RK4"), "converges") for scene in ATTITUDES]
    motor = (DefaultEffect("motor", EXACT, EXACT, acts=True),)
    defaults = [
        DefaultEffects(Key(scene, "e", "default"), OWN, EXACT, None, motor) for scene in "bd"
    ]
    return report_data(Results({}, {}, rows, verdicts, methods=methods, defaults=defaults))


def test_the_usual_runs_are_those_at_the_engines_own_timestep_over_scenes(
    gathered: ReportData,
) -> None:
    exact, default = sorted(at_stock(gathered), key=lambda one: one.shipped)
    assert (exact.method, exact.scenes, exact.middle, exact.unfinished) == ("RK4", 4, 0.0, 0)
    assert default == Usual(
        *("e", "default", OWN, True),
        scenes=4,
        unfinished=1,
        blew_up=1,
        failed=0,
        # Of two middle ones the larger; of 1, 2, 3 and 4 turns as well.
        middle=pytest.approx(math.degrees(0.4)),
        largest=math.inf,
        worst="d",
        worst_finished="b",
        largest_finished=pytest.approx(math.degrees(0.4)),
        turns=3.0,
        a_turn=pytest.approx(math.degrees(0.2 / 8)),
    )


def test_a_default_is_a_reason_where_steps_disagree_and_not_where_runs_blow_up(
    gathered: ReportData,
) -> None:
    default = next(one for one in at_stock(gathered) if one.shipped)
    assert why(gathered, default, ()) == (
        "e default does not converge on 2 of 4 scenes, however short the timestep (it blows up on "
        "1): the equations of motion are altered by its motor on 1, each alone"
    )


def test_engines_as_shipped_are_not_counted_among_the_methods(gathered: ReportData) -> None:
    assert "4 of these 4 runs" in overview.at_stock(gathered)
    headline = overview.headline(gathered)
    assert "5 scenes × 1 method. Of 4 pairs of a scene and a method, 4 converge" in headline
    assert "1 of 4 pairs converge" in headline
