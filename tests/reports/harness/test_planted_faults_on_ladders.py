"""Faults planted in MuJoCo are detected by the verdict, and described with their numbers."""

import pytest
from faulty_mujoco import FaultyMuJoCo, PlantedFault
from library_scenes import library_scene
from spincheck.engines import Method
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.study import convergence_study_of, prepare, run_rungs
from spincheck.reports.harness.study_verdict import verdict_on
from spincheck.reports.results.records import Verdict

pytestmark = pytest.mark.slow

#: Of the longest run: short ladders are to tell as well.
MOST_STEPS = 1 << 13


def verdict_of(name: str, method: str, fault: PlantedFault | None, **declared: int) -> Verdict:
    engine = FaultyMuJoCo(fault)
    prepared = prepare(library_scene(name), [], MOST_STEPS)
    used: Method = engine.method(method)
    for key, value in declared.items():
        object.__setattr__(used := Method(**vars(used)), key, value)
    study = convergence_study_of(library_scene(name), engine, used, prepared)
    for _ in run_rungs(study, InProcess()):
        pass
    return verdict_on(study)


@pytest.mark.parametrize("name", ["nutation-loops", "book-middle-axis"])
def test_without_a_fault_every_signal_converges(name):
    verdict = verdict_of(name, "RK4", None)
    assert {signal.verdict for signal in verdict.signals} == {"converges"}


@pytest.mark.parametrize("name", ["nutation-loops", "book-middle-axis"])
def test_without_a_fault_a_short_ladder_of_first_order_disagrees_in_nothing(name):
    verdict = verdict_of(name, "Euler", None)
    assert "disagrees" not in {signal.verdict for signal in verdict.signals}


#: A scene, a fault, and the signals that may tell of it.
FAULTS = [
    # A pivot that sags by half the arm.
    (
        "nutation-loops",
        PlantedFault("reading of the com", 0.05),
        {"com", "energy", "angular_momentum"},
    ),
    # A free body that drifts unasked.
    ("book-middle-axis", PlantedFault("drift", 1.0), {"com", "velocity", "energy"}),
    ("nutation-loops", PlantedFault("reading of the velocity", 0.5), {"velocity", "energy"}),
    (
        "book-middle-axis",
        PlantedFault("reading of ω", 1e-3),
        {"omega", "angular_momentum", "energy"},
    ),
    ("nutation-loops", PlantedFault("gravity", 0.1), None),
    ("lopsided-body", PlantedFault("gravity", 0.1), None),
    ("book-middle-axis", PlantedFault("clock", 1e-3), None),
]


@pytest.mark.parametrize(("name", "fault", "signals"), FAULTS)
def test_a_planted_fault_disagrees_in_a_signal_that_it_is_about(name, fault, signals):
    verdict = verdict_of(name, "Euler", fault)
    assert not verdict.agrees
    disagreeing = {signal.signal for signal in verdict.signals if signal.verdict == "disagrees"}
    # What the first steps tell already has no ladder.
    assert not verdict.signals or signals is None or disagreeing & signals


def test_what_the_first_steps_show_is_evidence_however_coarse_the_ladder():
    verdict = verdict_of("nutation-loops", "Euler", PlantedFault("gravity", 1e-3))
    assert verdict.verdict == "disagrees"
    assert "as if gravity were 1.001 times as strong" in verdict.reason


def test_a_first_order_method_declared_of_fourth_order_disagrees():
    verdict = verdict_of("book-middle-axis", "Euler", None, order=4, attitude_order=4)
    assert verdict.verdict == "disagrees"


@pytest.mark.parametrize("name", ["nutation-loops", "book-middle-axis"])
@pytest.mark.parametrize("kind", ["reading of ω", "reading of the velocity", "clock", "moment"])
def test_fourth_order_detects_a_fault_of_a_hundred_millionth(name, kind):
    if (name, kind) == ("book-middle-axis", "reading of the velocity"):
        pytest.skip("a body that does not fly has no velocity to read")
    assert not verdict_of(name, "RK4", PlantedFault(kind, 1e-8)).agrees
