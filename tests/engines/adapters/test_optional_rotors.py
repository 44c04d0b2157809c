"""Rotors in optional engines: they converge to the exact motion, and planted faults are found.

That engines hold, step and restart rotors of every kind is verified by the contract (`free-rotors`,
`pivot-rotors`).
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import why_missing
from library_scenes import library_scene
from spincheck.engines import Engine, engines
from spincheck.reference import solve
from spincheck.scenarios import Scenario, errors_between
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

#: A free rotor and a locked one off the com, four on a falling body, a driven one on a pivot.
ROTORS = ("brake-on-one-wheel", "quadrotor-body", "gyroscope-in-its-frame")
METHODS = {"mjx": "Euler", "pin": "RK4", "drake": "runge_kutta3", "dartpy": "semi-implicit"}
#: The fastest rate times the step, of the coarser of two runs; and how many steps it takes.
TURN, STEPS = 0.1, 64
#: How far an order may fall short of the declared one, as in the contract.
ORDER_SLACK = 0.25


def installed(name: str) -> Engine:
    if reason := why_missing(name):
        pytest.skip(reason)
    return engines()[name]


def errors_at(engine: Engine, scene: Scenario, timestep: float, steps: int) -> np.ndarray:
    method, samples = engine.method(METHODS[engine.name]), np.arange(0, steps + 1, steps // 16)
    run = engine.run(scene, method, timestep, samples)
    assert (run.outcome, run.reason) == ("ok", ""), (engine.name, scene.name)
    assert run.trajectory is not None
    assert run.active == scene.called_for
    exact = solve(scene, samples * timestep).trajectory
    errors = errors_between(scene, run.trajectory, exact)
    fast = np.abs(exact.spins).max()
    spins = np.abs(run.trajectory.spins - exact.spins).max() / fast
    return np.array([errors.omega, errors.attitude, spins])


@pytest.mark.parametrize("name", METHODS)
def test_rotors_of_the_library_converge_with_the_declared_order(name: str) -> None:
    engine = installed(name)
    order = engine.method(METHODS[name]).order
    for scene in map(library_scene, ROTORS):
        rate = fastest_rate(scene, scene.start.omega_body)
        coarse, fine = (errors_at(engine, scene, TURN / rate / k, k * STEPS) for k in (1, 2))
        # Of a driven rotor the spin stays, but for rounding.
        known = coarse > STEPS * np.finfo(float).eps
        assert known[:2].all(), scene.name
        ratio = coarse[known] / fine[known]
        assert (np.log2(ratio) > order - ORDER_SLACK).all(), (scene.name, coarse, fine)


def undriven_pin(world: Any) -> None:
    world.model.armature = np.zeros(world.model.nv)


def damped_pin(world: Any) -> None:
    world.model.damping = np.full(world.model.nv, 1e-3)


def undriven_dart(world: Any) -> None:
    world.rotors[2][0].setActuatorType(world.actuators.FORCE)


def damped_dart(world: Any) -> None:
    world.rotors[0][0].setDampingCoefficient(0, 1e-3)


def off_dart(world: Any) -> None:
    inertia = world.rotors[0][1].getInertia()
    inertia.setLocalCOM(np.array([0.01, 0.0, 0.0]))
    world.rotors[0][1].setInertia(inertia)


def undriven_drake(world: Any) -> None:
    (index,) = world.plant.GetJointActuatorIndices()
    world.plant.get_joint_actuator(index).SetRotorInertia(world.context, 0.0)


def damped_drake(world: Any) -> None:
    world.rotors[0].SetDampingVector(world.context, np.array([1e-3]))


FAULTS: dict[tuple[str, Callable[[Any], None]], str] = {
    ("pin", undriven_pin): "armature",
    ("pin", damped_pin): "joint friction",
    ("dartpy", undriven_dart): "rotor 3 with another actuator than that of a driven hinge",
    ("dartpy", damped_dart): "damping or a spring on the hinge of rotor 1",
    ("dartpy", off_dart): "must read back",
    ("drake", undriven_drake): "rotor 3 with 0 kg m² on a driven hinge",
    ("drake", damped_drake): "damping on the hinge of rotor 1",
}


@each_case(("engine", "plant", "words"), [(*fault, words) for fault, words in FAULTS.items()])
def test_a_hinge_with_a_planted_fault_fails_the_run(
    engine: str, plant: Callable[[Any], None], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, scene = installed(engine), SCENES["free-rotors"]
    opened = one.open

    def faulty(*arguments: Any) -> Any:
        session: Any = opened(*arguments)
        if engine == "dartpy":
            session.world.actuators = session.module.dart.dynamics.ActuatorType
        plant(session.world)
        return session

    with monkeypatch.context() as patch:
        patch.setattr(one, "open", faulty, raising=False)
        run = one.run(scene, one.method(METHODS[engine]), 1e-3, np.arange(0, 21, 10))
    assert run.outcome == "failed"
    assert words in run.reason, run.reason
