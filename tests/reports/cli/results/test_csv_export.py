"""What a result file holds, as CSV and JSON: the names of the JSON of `run`, every digit."""

import csv
import io
import json
import math
from dataclasses import replace

import made_up
import pytest
from command_line import spincheck
from spincheck.reports.cli.results.result_commands import csv_text
from spincheck.reports.cli.run.summary import results_as_json, row_record, verdict_record
from spincheck.reports.results.cost_records import MethodCost, StepCost
from spincheck.reports.results.store import open_store

RESULTS = made_up.results(samples=11)


def records(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_no_text_is_a_formula_of_a_spreadsheet():
    for text in ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\n=1"):
        written = csv_text([{"reason": text, "unmet": [text], "drifts": {"energy": text}}])
        assert set(records(written)[0].values()) == {f"'{text}"}
    (record,) = records(csv_text([{"at": -1.5, "reason": "a = b"}]))
    assert record == {"at": "-1.5", "reason": "a = b"}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A result file of made-up results."""
    path = tmp_path_factory.mktemp("export") / "results.sqlite"
    with open_store(path, create=True) as store:
        made_up.put(store, RESULTS)
        for row in RESULTS.rows:
            store.put(MethodCost(row.key, "a processor", StepCost(1e-6, 1e-7, 2e-6)))
    return path


def printed(*arguments: object) -> str:
    done = spincheck(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_numbers_read_back_to_the_last_bit():
    rows = [row_record(row) for row in RESULTS.rows]
    back = records(csv_text(rows))
    assert [float(record["timestep"]) for record in back] == [row["timestep"] for row in rows]
    errors = [float(record["omega_error"]) for record in back if record["omega_error"]]
    assert errors == [row["omega_error"] for row in rows if row["omega_error"] is not None]


def test_an_error_without_a_base_is_infinite_and_what_is_not_there_is_empty():
    row = next(row for row in RESULTS.rows if row.errors)
    endless = replace(row, errors=replace(row.errors, energy=math.inf))
    unsolved = next(row for row in RESULTS.rows if row.key.scenario == "unsolved")
    first, second = records(csv_text([row_record(endless), row_record(unsolved)]))
    assert float(first["energy_error"]) == math.inf
    assert (second["omega_error"], second["outcome"]) == ("", "failed")


def test_a_table_that_some_records_lack_has_no_column_of_its_own():
    text = csv_text([{"drifts": {"energy": {"p50": 1.0}}}, {"drifts": None}, {"drifts": {}}])
    assert text == 'drifts.energy.p50\n1.0\n""\n""\n'


def test_drifts_have_a_column_each_and_unmet_expectations_are_joined():
    sampled = next(row for row in RESULTS.rows if row.drifts)
    (row,) = records(csv_text([row_record(sampled)]))
    assert float(row["drifts.energy"]) == sampled.drifts["energy"]
    twice = replace(RESULTS.verdicts[0], unmet=("one, with a comma", "two"))
    (verdict,) = records(csv_text([verdict_record(twice)]))
    assert verdict["unmet"] == "one, with a comma; two"


@pytest.mark.parametrize("printing", [["rows"], ["rows", "--verdicts"]])
def test_a_command_prints_what_run_prints_as_json_and_csv_with_the_same_names(path, printing):
    with open_store(path) as store:
        expected = results_as_json(store.read())[printing[-1].removeprefix("--")]
    in_json = json.loads(printed(*printing, path, "--json"))
    assert in_json == json.loads(json.dumps(expected))
    # A field of a record within a record has its name after a dot; an empty one has no column.
    names = {name.partition(".")[0] for name in records(printed(*printing, path, "--csv"))[0]}
    assert {name for name, value in in_json[0].items() if value != {}} == names
    assert not any(" " in name for name in in_json[0])


def test_what_a_step_takes_is_printed_in_cpu_time_and_on_the_wall_in_one_format(path):
    (record, *_) = records(printed("rows", path, "--csv"))
    names = ("seconds_per_step", "seconds_spread", "wall_seconds_per_step")
    assert [float(record[name]) for name in names] == [1e-6, 1e-7, 2e-6]
    done = spincheck("rows", path, "--csv", "--json")
    assert (done.returncode, done.stderr) == (2, "spincheck: takes '--csv' or '--json', not both\n")


def test_a_command_prints_every_verdict_and_every_run_below_its_method(path):
    with open_store(path) as store:
        found = store.read()
    table = printed("rows", path, "--verdicts").splitlines()
    named = sum(line.startswith(("made-up", "unsolved")) for line in table)
    assert named == len(found.verdicts)
    headings = 2 * len({row.key for row in found.rows})
    assert len(printed("rows", path).splitlines()) == headings + len(found.rows)
