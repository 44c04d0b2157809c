"""The largest surviving timestep, from made-up runs."""

from dataclasses import replace

import pytest
from ladders import only
from made_up import TOP, results
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.timesteps import in_words, survival
from spincheck.reports.pages.overview.overview import (
    TURNS,
    hard_scenes,
    headline,
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


@pytest.mark.parametrize("end", ["diverged", "failed", "lost", "unsupported"])
def test_the_largest_is_the_one_below_the_finest_that_does_not_survive(end):
    """In whatever order; its turn is that of the fastest rate."""
    rows = runs("ok", end, "ok", "ok")
    survived = survival(rows, PACE)
    assert (survived.timestep, survived.turn) == (0.25, 0.25 * PACE)
    assert survival(reversed(rows), PACE) == survived


def test_a_finest_run_that_does_not_survive_leaves_none():
    survived = survival(runs("ok", "ok", "diverged"), PACE)
    assert (survived.timestep, survived.turn, survived.at_least) == (None, None, False)
    assert in_words(survived)[0] == "at none tested"
    # What cannot be simulated neither survives nor fails.
    assert survival(runs("unsupported"), PACE) is None
    assert survival([], PACE) is None


def test_where_all_survive_the_largest_is_a_lower_bound():
    survived = survival(runs("ok", "ok"), PACE)
    assert (survived.timestep, survived.at_least) == (1.0, True)
    assert in_words(survived) == ("≥ 1.00", "≥ 5.00")


def hardened() -> Results:
    """The made-up results, one of the two scenes tagged as hard."""
    stored = results()
    scene = stored.scenes["made-up-top"]
    hard = loads(TOP.replace('tags = ["heavy"', 'tags = ["hard"'), "made-up-top")
    return replace(stored, scenes=stored.scenes | {"made-up-top": replace(scene, scenario=hard)})


def test_hard_scenes_are_those_that_are_tagged_so_and_counted_separately():
    gathered = report_data(hardened())
    assert [scene.name for scene in hard_scenes(gathered)] == ["made-up-top"]
    assert hard_scenes(report_data(results())) == ()
    assert "made-up-top" not in [scene.name for scene in gathered.plain.scenes]
    assert len(gathered.plain.scenes) == len(gathered.scenes) - 1
    assert "Hard scenes (1) are counted separately" in headline(gathered)
    assert "hard" not in headline(report_data(results()))


def test_where_all_scenes_are_hard_nothing_is_left_out():
    gathered = report_data(only(hardened()))
    assert gathered.plain.scenes == gathered.scenes != ()
    assert headline(gathered).startswith("1 scene ")


def test_each_method_has_a_line_that_counts_what_it_survives():
    gathered = report_data(hardened())
    listed = survivors_table(gathered)
    lines = {(row[0].text, row[1].text): [cell.text for cell in row[2:]] for row in listed.rows}
    assert lines["mujoco", "Euler"][:-1] == ["1", "1", "1", "1", "1", "1"]
    assert lines["pybullet", "multibody"][:-1] == ["1", "0", "0", "0", "0", "0"]
    assert lines["elsewhere", "plain"][0] == "0"
    assert len(lines["mujoco", "Euler"]) == 4 + len(TURNS)
