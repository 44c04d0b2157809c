"""A run that is not ok has no errors, in records and wherever it is shown."""

import csv
import io
import json
from dataclasses import replace

import pytest
from ladders import only, scene_of
from made_up import TIMESTEPS, MadeUp, results
from spincheck.reports.cli.results.result_commands import csv_text
from spincheck.reports.cli.run.summary import row_record
from spincheck.reports.cli.terminal import to_json
from spincheck.reports.pages.analysis.cost_to_reach import reach
from spincheck.reports.pages.analysis.work_precision import curves, front
from spincheck.reports.results.records import Row

ERRORS = ("omega_error", "attitude_error", "angular_momentum_error", "energy_error")


@pytest.fixture(scope="module")
def row() -> Row:
    return next(r for r in results().rows if r.outcome == "ok")


@pytest.mark.parametrize("outcome", ["diverged", "failed", "unsupported"])
def test_a_run_that_did_not_end_ok_cannot_have_errors(row, outcome):
    with pytest.raises(ValueError, match="a run that is not ok has no errors"):
        replace(row, outcome=outcome)


def test_in_json_its_errors_are_null_in_csv_empty_and_its_end_is_reported(row):
    record = row_record(replace(row, outcome="diverged", errors=None, stopped_at=0.25))
    (in_json,) = json.loads(to_json([record]))
    (in_csv,) = csv.DictReader(io.StringIO(csv_text([record])))
    assert {in_json[name] for name in ERRORS} == {None}
    assert {in_csv[name] for name in ERRORS} == {""}
    assert in_json["stopped_at"] == 0.25


def test_it_is_on_no_pareto_front_and_reaches_no_error():
    # Cheaper than all others, and of the best order: it would be first everywhere.
    tried = (MadeUp("mujoco", "Euler", 1), MadeUp("mujoco", "RK4", 4, "diverges", "blew up"))
    stored = results(methods=tried)
    rows = [
        replace(r, seconds_per_step=1e-9) if r.key.method == "RK4" and r.timestep else r
        for r in stored.rows
    ]
    drawn = curves(scene_of(only(replace(stored, rows=rows))), "omega")
    assert {curve.method for curve, _ in front(drawn)} == {"Euler"}
    blown = next(curve for curve in drawn if curve.method == "RK4")
    assert reach(blown, 1.0).cost is None
    assert len(front(drawn)) == len(TIMESTEPS)
