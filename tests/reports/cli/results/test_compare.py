"""Changes between two result files are reported by name, and nothing else is."""

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import made_up
import pytest
from case_loops import each_case
from command_line import spincheck
from spincheck.reports.cli.results.compare import changes_as_json, exit_code, print_changes
from spincheck.reports.pages.analysis.changes import COST_FACTOR, ERROR_FACTOR, OUTCOMES, changes
from spincheck.reports.pages.analysis.observed_order import ASYMPTOTIC
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.reports.results.verdict_words import RANKS
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Errors, loads

KEY = Key("made-up-top", "mujoco", "Euler")
COST, SPREAD = made_up.SECONDS_PER_STEP, made_up.SECONDS_PER_STEP / 10


@pytest.fixture(scope="module")
def before() -> Results:
    return made_up.results()


def with_row(results: Results, **changed: object) -> Results:
    """With one run, the finest of a method, changed."""
    rows = list(results.rows)
    k = max(k for k, row in enumerate(rows) if row.key == KEY)
    if changed.get("outcome", "ok") != "ok":
        changed = {"errors": None} | changed
    rows[k] = replace(rows[k], **changed)
    return replace(results, rows=rows)


def with_omega_error(results: Results, error: float) -> Results:
    return with_row(results, errors=replace(row_of(results).errors, omega=error))


def with_cost(results: Results, seconds: float, spread: float) -> Results:
    rows = [
        replace(row, seconds_per_step=seconds, seconds_spread=spread) if row.key == KEY else row
        for row in results.rows
    ]
    return replace(results, rows=rows)


def with_verdict(results: Results, **changed: object) -> Results:
    verdicts = [replace(v, **changed) if v.key == KEY else v for v in results.verdicts]
    return replace(results, verdicts=verdicts)


def with_order(results: Results, word: str, order: int) -> Results:
    (verdict,) = (verdict for verdict in results.verdicts if verdict.key == KEY)
    return with_verdict(results, verdict=word, steps=replace(verdict.steps, order=order))


def with_text(results: Results, old: str, new: str) -> Results:
    scene = results.scenes[KEY.scenario]
    edited = replace(scene, scenario=loads(scene.scenario.text.replace(old, new), KEY.scenario))
    return replace(results, scenes=results.scenes | {KEY.scenario: edited})


def row_of(results: Results) -> Row:
    return [row for row in results.rows if row.key == KEY][-1]


def floor(results: Results) -> float:
    """Uncertainty of an error in ω, of both files together."""
    solution, row = results.scenes[KEY.scenario].solution, row_of(results)
    return 2 * (solution.uncertainty.omega + row.steps * solution.conditioning.omega)


def test_a_file_and_itself_do_not_differ(before, capsys):
    differences = changes(before, before)
    print_changes(differences)
    assert (differences, exit_code(differences)) == ([], 0)
    assert capsys.readouterr().out == "nothing changed\n"


def with_spins(results: Results) -> Results:
    """With a bound and errors in the signal that older files do not know, in every run."""
    scene = results.scenes[KEY.scenario]
    bounds = {
        what: replace(getattr(scene.solution, what), spins=1e-15)
        for what in ("uncertainty", "conditioning")
    }
    known = replace(scene, solution=replace(scene.solution, **bounds))
    rows = [
        replace(row, errors=row.errors and replace(row.errors, spins=1e-3)) for row in results.rows
    ]
    return replace(results, rows=rows, scenes=results.scenes | {KEY.scenario: known})


def test_a_signal_that_only_one_file_has_is_no_change(before):
    after = with_spins(before)
    assert (changes(before, after), changes(after, before)) == ([], [])


@each_case(("old", "new"), product(RANKS, RANKS))
def test_a_worse_verdict_is_a_regression_and_a_better_one_is_not(before, old, new):
    differences = changes(with_verdict(before, verdict=old), with_verdict(before, verdict=new))
    assert [change.kind for change in differences] == ["verdict"] * (old != new)
    assert exit_code(differences) == (RANKS[new] > RANKS[old])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [(2, 4, (2, 4, "better")), (4, 2, (4, 2, "worse")), (4, 4, None)],
)
def test_an_order_that_is_another_is_reported(before, old, new, words):
    found = [
        (change.old, change.new, change.direction)
        for change in changes(*(with_order(before, "converges", order) for order in (old, new)))
    ]
    assert found == ([words] if words else [])
    assert not changes(*(with_order(before, "unresolved", order) for order in (old, new)))


@each_case(("old", "new"), product(OUTCOMES, OUTCOMES))
def test_a_worse_outcome_is_a_regression_and_a_better_one_is_not(before, old, new):
    differences = changes(with_row(before, outcome=old), with_row(before, outcome=new))
    assert [change.kind for change in differences] == ["outcome"] * (old != new)
    assert exit_code(differences) == (OUTCOMES.index(new) > OUTCOMES.index(old))


def test_an_error_that_grew_is_a_regression_and_names_signal_and_timestep(before):
    row = row_of(before)
    error = row.errors.omega
    (change,) = changes(before, with_omega_error(before, 2 * error))
    assert (change.kind, change.name, change.timestep) == ("error", "omega", row.timestep)
    assert (change.old, change.new, change.regression) == (error, 2 * error, True)
    (change,) = changes(before, with_omega_error(before, error / 2))
    assert (change.direction, change.regression) == ("better", False)
    for share, changed in ((0.99, 0), (1.01, 1)):
        grown = with_omega_error(before, share * ERROR_FACTOR * error)
        assert len(changes(before, grown)) == changed


def test_errors_too_small_to_be_known_or_too_large_to_mean_anything_have_not_changed(before):
    small = with_omega_error(before, floor(before) / 100)
    for share, changed in ((0.99, 0), (1.01, 1)):
        grown = with_omega_error(before, (0.01 + share) * floor(before))
        assert len(changes(small, grown)) == changed
    large = with_omega_error(before, 1.01 * ASYMPTOTIC)
    assert changes(large, with_omega_error(before, 2 * ASYMPTOTIC)) == []
    assert exit_code(changes(before, large)) == 1
    # One without a base is compared too.
    for error in (float("inf"), 0.0):
        planted = with_omega_error(before, error)
        assert changes(planted, planted) == []
        assert len(changes(planted, before)) == 1


def test_an_expectation_broken_is_a_regression_and_one_kept_again_is_not(before):
    kept = with_verdict(before, unmet=())
    assert [(c.kind, c.regression) for c in changes(kept, before)] == [("expectation", True)]
    assert [(c.kind, c.regression) for c in changes(before, kept)] == [("expectation", False)]
    broken, by_another_margin = (
        with_verdict(before, unmet=(f"ω error at 0.01 s: {error} exceeds the expected 1e-3",))
        for error in ("1e-2", "2e-2")
    )
    assert changes(broken, by_another_margin) == []


def test_a_dearer_step_is_a_regression_on_the_same_processor_alone(before):
    dear = with_cost(before, 2 * COST, SPREAD)
    (change,) = changes(before, dear)
    assert (change.kind, change.direction, change.regression) == ("cost", "worse", True)
    elsewhere = replace(dear, environment=before.environment | {"processor": "another"})
    machine, cost = changes(before, elsewhere)
    assert (machine.kind, cost.direction, cost.regression) == ("environment", "worse", False)
    # One within the noise has not changed.
    beyond_the_factor_alone = with_cost(before, 2 * COST, COST)
    beyond_the_spreads_alone = with_cost(before, 0.99 * COST_FACTOR * COST, 0.0)
    assert changes(before, beyond_the_factor_alone) == []
    assert changes(before, beyond_the_spreads_alone) == []


def test_a_scene_and_a_method_added_or_gone_are_reported_and_are_no_regression(before):
    without_scene = replace(
        before,
        rows=[row for row in before.rows if row.key.scenario != "made-up-brick"],
        verdicts=[v for v in before.verdicts if v.key.scenario != "made-up-brick"],
        scenes={KEY.scenario: before.scenes[KEY.scenario]},
    )
    fewer = made_up.results(methods=made_up.METHODS[1:])
    assert [(c.kind, c.name, c.new) for c in changes(before, without_scene)] == [
        ("scene", "made-up-brick", None)
    ]
    assert ("method", "elsewhere plain") not in [(c.kind, c.name) for c in changes(before, fewer)]
    added = changes(made_up.results(methods=made_up.METHODS[:-1]), before)
    assert [(c.kind, c.name, c.old) for c in added] == [("method", "elsewhere plain", None)]
    assert exit_code(added) == 0
    # Nor is a verdict that is not there yet.
    missing = [verdict for verdict in before.verdicts if verdict.key != KEY]
    (change,) = changes(before, replace(before, verdicts=missing))
    assert (change.kind, change.new, change.regression) == ("verdict", None, False)


def test_a_scene_that_describes_another_motion_has_its_verdicts_compared_alone(before):
    edited = with_omega_error(with_text(before, "40.0]", "41.0]"), ASYMPTOTIC)
    assert [change.kind for change in changes(before, edited)] == ["scene"]
    worse = with_verdict(edited, verdict="failed")
    assert [change.kind for change in changes(before, worse)] == ["scene", "verdict"]
    assert changes(before, with_text(before, "[body]", "# as in the book\n[body]")) == []
    unsolved = replace(edited, scenes={})
    assert not {change.kind for change in changes(before, unsolved)} & {"error", "verdict"}


def test_versions_are_reported_and_dates_are_not(before):
    other = {"date": "2027-01-01T00:00:00+00:00", "mujoco": "5.0"}
    (change,) = changes(before, replace(before, environment=before.environment | other))
    found = (change.kind, change.name, change.old, change.new)
    assert found == ("environment", "mujoco", None, "5.0")


def test_errors_of_a_method_that_went_the_same_way_are_one_line(before, capsys):
    rows = [
        replace(row, errors=replace(row.errors, omega=3 * row.errors.omega))
        if row.key == KEY and row.errors.omega < ASYMPTOTIC / 3
        else row
        for row in before.rows
    ]
    differences = changes(before, replace(before, rows=rows))
    print_changes(differences)
    out = capsys.readouterr().out
    assert len(differences) > 1
    assert out.count("mujoco Euler") == 1
    assert f"the most of {len(differences)}" in out
    assert f"{len(differences)} changes, of which {len(differences)} regressions" in out


def test_json_holds_every_change_and_the_rules(before):
    error = row_of(before).errors.omega
    printed = changes_as_json(changes(before, with_omega_error(before, 2 * error)))
    assert (printed["regressions"], printed["error_factor"]) == (1, ERROR_FACTOR)
    assert printed["changes"][0]["scenario"] == KEY.scenario


@pytest.fixture
def stored(tmp_path):
    """Write verdicts into a result file; returns its path."""

    def write(name: str, word: str) -> Path:
        scene = made_up.results().scenes[KEY.scenario]
        with open_store(tmp_path / name, create=True) as store:
            store.put_scene(scene.scenario, scene.solution)
            store.put_verdict(Verdict(KEY, word, ""))
            store.put(Row(KEY, "1", 0.01, errors=Errors(*[1e-6] * 6), outcome="ok"))
        return tmp_path / name

    return write


def test_the_command_exits_with_1_on_a_regression_and_0_without(stored):
    old, new = stored("old.sqlite", "diverges"), stored("new.sqlite", "failed")
    pairs = ((old, new), (new, old))
    assert [spincheck("compare", *pair).returncode for pair in pairs] == [1, 0]
    assert json.loads(spincheck("compare", old, new, "--json").stdout)["regressions"] == 1


def test_a_file_that_cannot_be_used_is_one_message_and_exit_code_2(stored, tmp_path):
    other = tmp_path / "none.sqlite"
    done = spincheck("compare", stored("old.sqlite", "failed"), other)
    assert (done.returncode, done.stderr) == (
        2,
        f"spincheck: {other}: no such result file; 'spincheck run fast-top' writes one of a scene, "
        "'spincheck run' of the whole library\n",
    )


def test_a_path_with_a_version_or_an_encoding_in_it_is_that_of_a_file(stored, tmp_path):
    stored("spincheck.sqlite", "failed")
    there, none = stored("as it was@home.sqlite", "failed").name, "me@home/none.sqlite"
    for names in ((there, none), (none, there), (none, "b")):
        done = spincheck("compare", *names, cwd=tmp_path)
        assert done.returncode == 2
        assert done.stderr.startswith(f"spincheck: {none}: no such result file")
    # An engine has no folder before it.
    done = spincheck("compare", "mujoco@3.3.0", "mujoco", cwd=tmp_path)
    assert done.stderr.startswith("spincheck: mujoco@3.3.0: no result of it is in the file")


def test_an_engine_in_place_of_a_file_is_one_message():
    done = spincheck("compare", "mujoco", "pybullet")
    message = "spincheck: mujoco: no such result file; an engine is compared with another version"
    assert (done.returncode, done.stderr.startswith(message)) == (2, True)
