"""The largest surviving timestep, from made-up runs."""

from dataclasses import replace

import pytest
from made_up import TIMESTEPS, TOP, results
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.timesteps import in_words, survival
from spincheck.reports.pages.analysis.wording import number
from spincheck.reports.pages.overview.overview import (
    TURNS,
    hard_scenes,
    headline,
    survivors,
    survivors_table,
)
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results
from spincheck.scenarios import loads

PACE = 5.0
KEY = Key("scene", "engine", "method")


def runs(*outcomes: str) -> list[Row]:
    """Rows at timesteps of 1 s, 1/2 s, … that ended so, or are lost, coarse to fine."""
    return [
        Row(KEY, "1", 2.0**-k, "ok", without_skill=True)
        if outcome == "lost"
        else Row(KEY, "1", 2.0**-k, outcome)
        for k, outcome in enumerate(outcomes)
    ]


def largest(*outcomes: str) -> float | None:
    survived = survival(runs(*outcomes), PACE)
    assert survived is not None
    return survived.timestep


@pytest.mark.parametrize("end", ["diverged", "failed", "lost", "unsupported"])
def test_the_largest_is_the_one_below_the_finest_that_does_not_survive(end):
    assert largest("ok", end, "ok", "ok") == 0.25


def test_a_finest_run_that_does_not_survive_leaves_none():
    survived = survival(runs("ok", "ok", "diverged"), PACE)
    assert (survived.timestep, survived.turn, survived.at_least) == (None, None, False)
    assert in_words(survived)[0] == "at none tested"


def test_where_all_survive_the_largest_is_a_lower_bound():
    survived = survival(runs("ok", "ok"), PACE)
    assert (survived.timestep, survived.at_least) == (1.0, True)
    assert in_words(survived) == ("≥ 1.00", "≥ 5.00")


def test_the_turn_is_that_of_the_fastest_rate():
    assert survival(runs("diverged", "ok"), PACE).turn == 0.5 * PACE


def test_the_order_of_the_runs_does_not_matter():
    rows = runs("ok", "lost", "ok", "ok")
    assert survival(reversed(rows), PACE) == survival(rows, PACE)


def test_what_cannot_be_simulated_neither_survives_nor_fails():
    assert survival(runs("unsupported"), PACE) is None
    assert survival([], PACE) is None


def hardened() -> Results:
    """The made-up results, one of the two scenes tagged as hard."""
    stored = results()
    scene = stored.scenes["made-up-top"]
    hard = loads(TOP.replace('tags = ["heavy"', 'tags = ["hard"'), "made-up-top")
    return replace(stored, scenes=stored.scenes | {"made-up-top": replace(scene, scenario=hard)})


def test_hard_scenes_are_those_that_are_tagged_so():
    assert [scene.name for scene in hard_scenes(report_data(hardened()))] == ["made-up-top"]
    assert hard_scenes(report_data(results())) == ()


def test_hard_scenes_are_counted_separately():
    gathered = report_data(hardened())
    assert "made-up-top" not in [scene.name for scene in gathered.plain.scenes]
    assert len(gathered.plain.scenes) == len(gathered.scenes) - 1
    assert "Hard scenes (1) are counted separately" in headline(gathered)
    assert "hard" not in headline(report_data(results()))


def test_where_all_scenes_are_hard_nothing_is_left_out():
    stored = hardened()
    alone = replace(
        stored,
        scenes={"made-up-top": stored.scenes["made-up-top"]},
        rows=[row for row in stored.rows if row.key.scenario == "made-up-top"],
        verdicts=[v for v in stored.verdicts if v.key.scenario == "made-up-top"],
    )
    gathered = report_data(alone)
    assert gathered.plain.scenes == gathered.scenes != ()
    assert headline(gathered).startswith("1 scene ")


def test_each_method_has_a_line_that_counts_what_it_survives():
    listed = survivors_table(report_data(hardened()))
    lines = {(row[0].text, row[1].text): [cell.text for cell in row[2:]] for row in listed.rows}
    assert lines["mujoco", "Euler"][:-1] == ["1", "1", "1", "1", "1", "1"]
    assert lines["pybullet", "multibody"][:-1] == ["1", "0", "0", "0", "0", "0"]
    assert lines["elsewhere", "plain"][0] == "0"
    assert len(lines["mujoco", "Euler"]) == 4 + len(TURNS)


def test_each_cell_has_verdict_and_largest_timestep():
    gathered = report_data(hardened())
    fastest_rate = hard_scenes(gathered)[0].fastest_rate
    matrix = survivors(gathered)
    _, ((_, cells),) = matrix.groups[0]
    euler = next(c for c, name in zip(cells, matrix.methods, strict=True) if name == "Euler")
    assert euler.kind == "converges"
    assert euler.detail == f"≥ 0.0200 s, {number(TIMESTEPS[0] * fastest_rate)} rad"
