"""Faults planted in MuJoCo are detected by the verdict, and described with their numbers."""

from dataclasses import replace

import numpy as np
import pytest
from faulty_mujoco import FaultyMuJoCo, PlantedFault
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from spincheck.reports.results.verdicts import Verdict
from studies import verdict_of as judged
from top_scenes import scene

pytestmark = pytest.mark.slow

#: Of the longest run: short ladders are to tell as well.
MOST_STEPS = 1 << 13


def verdict_of(
    name: str,
    method: str,
    fault: PlantedFault | None,
    most_steps: int = MOST_STEPS,
    **declared: int,
) -> Verdict:
    engine, scenario = FaultyMuJoCo(fault), library_scene(name)
    used = replace(engine.method(method), **declared)
    engine.methods = (used,)
    return judged(convergence_study_of(scenario, engine, used, prepare(scenario, [], most_steps)))


TOP, BOOK = "nutation-loops", "book-middle-axis"


#: A scene, a fault, and the quantities that may tell of it.
FAULTS = [
    # A pivot that sags by half the arm.
    (TOP, "reading of the com", 0.05, {"place"}),
    # A free body that drifts unasked.
    (BOOK, "drift", 1.0, {"place", "velocity"}),
    (TOP, "reading of the velocity", 0.5, {"velocity"}),
    (BOOK, "reading of ω", 1e-3, {"attitude", "angular momentum"}),
    ("wheel-in-a-box", "reading of the spins", 1e-3, None),
    (TOP, "gravity", 0.1, {"angular momentum"}),
    ("lopsided-body", "gravity", 0.1, {"velocity", "angular momentum"}),
    (BOOK, "clock", 1e-3, None),
]


@pytest.mark.parametrize(("name", "kind", "size", "quantities"), FAULTS)
def test_a_planted_fault_disagrees_in_a_quantity_that_it_is_about(name, kind, size, quantities):
    verdict = verdict_of(name, "Euler", PlantedFault(kind, size))
    assert not verdict.agrees
    fault = verdict.steps and verdict.steps.fault
    assert not (quantities and fault) or fault.quantity in quantities


def test_what_the_first_steps_show_is_evidence_however_coarse_the_ladder():
    verdict = verdict_of(TOP, "Euler", PlantedFault("gravity", 1e-3))
    assert verdict.verdict == "disagrees"
    assert "as if gravity were 1.001 times as strong" in verdict.reason
    # It is named before what they are: that line is all that the terminal may show.
    verdict = verdict_of("lopsided-body", "Euler", PlantedFault("gravity", 0.1))
    assert verdict.reason.startswith("behaves as if gravity were 1.")


def test_an_undeclared_single_precision_is_named_as_nothing_else():
    """Its rounding is noise of the first steps, and no gravity, frames or clock of another kind."""
    verdict = verdict_of("hammer", "Euler", PlantedFault("float32", float(np.finfo("f4").eps)))
    assert verdict.verdict == "disagrees"
    assert verdict.reason.startswith("behaves as if the state were held in 24 bits")
    assert "at the start" not in verdict.reason


@pytest.mark.parametrize("fault", [None, PlantedFault("gravity", 0.1)], ids=["honest", "heavier"])
def test_no_reason_of_a_convergence_contradicts_it(fault):
    """A body that falls faster is told by single steps, whatever its ladder shows."""
    verdict = verdict_of("hammer", "Euler", fault)
    assert (verdict.verdict == "converges") == ("behaves as if" not in verdict.reason)
    assert verdict.agrees == (fault is None)


#: A wobble of 0.05 rad/s, which first-order methods damp away before the second of its samples.
DISC = scene(
    "mass = 1.0\ninertia = [0.5, 0.5, 1.0]",
    "quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [0.05, 0.0, 50.0]",
    *("", "duration = 400.0\nsamples = 11"),
)
#: A spinning bead at the end of a light rod, whose swing coarse rungs damp away, and finer ones do
#: not: what each commits from one sample to the next is larger where more is left. Its error in ω
#: is small beside the spin.
BEAD = scene(
    "mass = 1.0\ninertia = [1e-6, 1e-6, 1e-6]\ncom = [0.0, 0.0, 1.0]",
    "euler_zyz_deg = [0.0, 30.0, 0.0]\nomega_body = [0.1, 0.0, 300.0]",
    window="duration = 2.0\nsamples = 101",
)
LONG_LADDER = 1 << 17


@pytest.mark.parametrize(
    ("name", "method", "body"),
    [
        ("mujoco", "implicit", DISC),
        pytest.param("pybullet", "maximal", DISC, marks=pytest.mark.needs_pybullet),
        ("mujoco", "implicit", BEAD),
    ],
)
def test_a_wobble_that_rungs_have_damped_away_is_no_other_motion(name, method, body):
    engine, prepared = engines()[name], prepare(body, [], LONG_LADDER)
    verdict = judged(convergence_study_of(body, engine, engine.method(method), prepared))
    assert verdict.verdict == "converges", verdict.reason


def test_a_first_order_method_declared_of_fourth_order_disagrees():
    assert verdict_of(BOOK, "Euler", None, order=4, attitude_order=4).verdict == "disagrees"


#: Scenes and kinds of faults: of a com, sizes are relative to the radius of gyration, which is a
#: four-hundredth of the hammer's way.
SMALLEST = {
    TOP: ("reading of ω", "reading of the velocity", "clock", "moment"),
    BOOK: ("reading of ω", "clock", "moment"),
    "hammer": ("reading of the com", "drift"),
}


@pytest.mark.parametrize(("name", "kind"), [(name, k) for name in SMALLEST for k in SMALLEST[name]])
def test_fourth_order_detects_a_fault_of_a_hundred_millionth(name, kind):
    assert not verdict_of(name, "RK4", PlantedFault(kind, 1e-8), QUICK_STEPS).agrees
