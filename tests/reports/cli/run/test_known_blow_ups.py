"""Runs that scenes expect to blow up do so on real engines, as shipped too."""

import pytest
from scene_texts import FAST_TOP
from spincheck.engines import engines
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario, loads
from studies import verdict_of

pytestmark = pytest.mark.slow

#: Steps of a ladder, which is not run here.
BUDGET = 1 << 11

#: A fast heavy top, 40 rad/s: MuJoCo's Euler, and PyBullet's, lose it with a step of 10 ms.
TOP = (
    FAST_TOP.replace("40.0]", "{spin}]")
    + """\
[[expect]]
engine = "{engine}"
method = "{method}"
timestep = {timestep}
outcome = "diverges"
"""
)
COARSE, FINE = 0.01, 0.0005
#: rad/s; beyond 100 PyBullet as shipped clamps every velocity.
BEYOND_THE_CLAMP = 150.0
#: engine, method, timestep, spin: what blows up.
BLOW_UPS = [
    ("mujoco", "Euler", COARSE, 40.0),
    ("mujoco", "implicitfast", COARSE, 40.0),
    ("mujoco", "default", COARSE, 40.0),
    ("pybullet", "multibody", COARSE, 40.0),
    ("pybullet", "default", FINE, BEYOND_THE_CLAMP),
]
#: What does not: a good integrator; a stable one, however lost; a step fine enough; as shipped too.
NO_BLOW_UPS = [
    ("mujoco", "RK4", COARSE, 40.0),
    ("mujoco", "implicit", COARSE, 40.0),
    ("mujoco", "default", FINE, 40.0),
    ("pybullet", "default", FINE, 40.0),
]


def judged(scene: Scenario, engine: str, method: str, timestep: float) -> Verdict:
    """The verdict on the one timestep that the scene says something about."""
    tested = engines()[engine]
    prepared = prepare(scene, [timestep], BUDGET)
    return verdict_of(
        convergence_study_of(scene, tested, tested.method(method), prepared, [timestep])
    )


def top(engine: str, method: str, timestep: float, spin: float) -> str:
    return TOP.format(engine=engine, method=method, timestep=timestep, spin=spin)


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("case", BLOW_UPS + NO_BLOW_UPS, ids=lambda case: f"{case[0]}-{case[1]}")
def test_a_blow_up_that_is_known_passes_and_one_that_does_not_happen_is_reported_and_fails(case):
    engine, method, timestep, _ = case
    verdict = judged(loads(top(*case), "top"), engine, method, timestep)
    if case in BLOW_UPS:
        # A clamp shows in single steps, too.
        wrong = engine == "pybullet" and method == "default"
        assert (verdict.agrees, verdict.verdict) == (True, "disagrees" if wrong else "diverges")
        return
    assert not verdict.agrees
    (reason,) = verdict.unmet
    assert reason.startswith(f"outcome at {timestep:g} s: ok")
