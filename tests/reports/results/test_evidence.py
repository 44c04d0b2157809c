"""Evidence from a file may be anybody's: what no judging can have made is refused."""

import json
from dataclasses import replace
from typing import get_args

import pytest
import small_result_file
from forging import forge
from spincheck.reports.results.change_words import KINDS
from spincheck.reports.results.evidence import Explanation, FaultKind, StepEvidence
from spincheck.reports.results.reasons import fault_in_words
from spincheck.reports.results.result_file import ResultFileError
from spincheck.reports.results.store import open_store
from spincheck.reports.results.tables import EVIDENCE


@pytest.fixture
def path(tmp_path):
    return small_result_file.write(tmp_path / "forged.sqlite")


def steps(path, **changed: object) -> None:
    """Forge the steps of the one piece of evidence."""
    as_json = json.loads(EVIDENCE.columns(small_result_file.EVIDENCE)["record"])["steps"]
    forge(path, [("evidence", "record.steps")], as_json | changed)


def is_refused(path) -> bool:
    try:
        with open_store(path) as store:
            store.read()
    except ResultFileError as error:
        return "cannot be read" in str(error)
    return False


def test_it_comes_back(path):
    steps(path)
    with open_store(path) as store:
        assert store.read().evidence == [small_result_file.EVIDENCE]


CURVE = {"quantity": "attitude", "timesteps": [2e-3, 1e-3]}
COLUMNS = ("gains", "predicted", "predicted_to", "largest")


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("values", [[], [1.0], [1.0] * 3, [1.0, -1.0], [1.0, "1"]], ids=str)
def test_a_curve_has_a_size_a_timestep_in_each_column(path, column, values):
    steps(path, curves=[CURVE | {name: [1.0, 0.5] for name in COLUMNS} | {column: values}])
    assert is_refused(path)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), 1e300])
def test_what_a_fault_gains_is_a_number(path, number):
    for field in ("got", "wanted"):
        fault = {"kind": "limit", "quantity": "attitude", "time": 1.0, "timestep": 1e-3}
        fault |= {"got": [0.0] * 3, "wanted": [0.0] * 3, field: [0.0, number, 0.0]}
        steps(path, fault=fault)
        assert is_refused(path)


def test_a_change_has_all_its_numbers(path):
    """They are put in words: what is missing would end the report."""
    fault = {"kind": "limit", "quantity": "attitude", "time": 1.0, "timestep": 1e-3}
    fault |= {"got": [0.0] * 3, "wanted": [0.0] * 3}
    for kind, count in {name: kind.count for name, kind in KINDS.items()}.items():
        for other in {0, count - 1, count + 1} - {count, -1}:
            steps(path, fault=fault | {"changes": [{"kind": kind, "numbers": [1.0] * other}]})
            assert is_refused(path)
        steps(path, fault=fault | {"changes": [{"kind": kind, "numbers": [1.0] * count}]})
        assert not is_refused(path)


def test_any_fault_that_is_accepted_can_be_put_in_words():
    """The largest and the smallest numbers, whichever is wanted."""
    steps: StepEvidence = small_result_file.EVIDENCE.steps
    for got in (0.0, 1e-300, 1.0, 1e150):
        for wanted in (0.0, 1e-300, 1.0, 1e150):
            for kind in get_args(FaultKind):
                vectors = {"got": (got, 0.0, -got), "wanted": (0.0, wanted, -wanted)}
                changes = (Explanation("decays", (got, -wanted)),)
                fault = replace(steps.fault, kind=kind, changes=changes, **vectors)
                assert fault_in_words(fault).isprintable()
