"""PyBullet's defaults that alter a motion: each, planted, is detected, and absent otherwise.

The traps and their sources are listed in docs/measured/engines-pybullet.md.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from pybullet_planted import (
    BY_CONSTRAINT,
    ENGINE,
    MAXIMAL,
    METHODS,
    MULTIBODY,
    STEPS,
    TIMESTEP,
    change,
    leave_out,
    opened,
    rotor,
    run,
    skip,
)
from scipy.spatial.transform import Rotation
from spincheck.engines import EngineError, Method
from spincheck.engines.adapters.pybullet import load as pybullet_load
from spincheck.engines.adapters.pybullet import session as pybullet_session
from spincheck.engines.adapters.pybullet import world as pybullet_world
from spincheck.scenarios import Scenario
from spincheck.scenarios.rotation import matrix
from spincheck.suite.contract_scenes import SCENES, scene

EPS = np.finfo(float).eps
#: A few products of rotations a step, over `STEPS`.
ROUND_OFF = 16 * EPS * STEPS[-1]


# Damping and the velocity clamp

FAST = 150.0


@each_case("method", METHODS)
def test_the_default_clamp_holds_every_velocity_to_a_hundred(method: Method) -> None:
    """Without it, and without damping, a rotor keeps its spin."""
    for spin in (10.0, FAST):
        motion = run(rotor(spin), method).trajectory
        assert motion is not None
        assert np.abs(motion.omega_body[:, 2] / spin - 1).max() <= ROUND_OFF
    if method != MAXIMAL:
        with pytest.MonkeyPatch.context() as patch:
            leave_out(patch, "changeDynamics", "maxJointVelocity")
            motion = run(rotor(FAST), method).trajectory
        assert motion is not None
        assert motion.omega_body[1:, 2] == pytest.approx(100.0)


# The rotation clamp


def turned(method: Method, rotation: float) -> tuple[float, float]:
    """How far one step turns a rotor that should turn by `rotation`, and its spin after that."""
    with opened(rotor(FAST), method, rotation / FAST) as session:
        session.advance(1)
        state = session.read_state()
        attitude = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        return float(attitude.magnitude()), float(state.omega_body[2])


@each_case("method", METHODS)
def test_the_attitude_keeps_up_below_the_clamp_and_lags_above(method: Method) -> None:
    """Where it would lag, the scene is not run."""
    below, above = 0.99 * method.max_rotation_per_step, 1.5 * method.max_rotation_per_step
    assert turned(method, below) == pytest.approx((below, FAST), rel=ROUND_OFF)
    lagging, spin = turned(method, above)
    assert lagging < 0.99 * above
    assert spin == pytest.approx(FAST, rel=ROUND_OFF)
    timestep = 1.01 * method.max_rotation_per_step / FAST
    result = ENGINE.run(rotor(FAST), method, timestep, STEPS)
    assert result.outcome == "unsupported"
    assert "where the engine clamps it" in result.reason


# Calls of many steps


def lost_steps() -> tuple[int, float]:
    """A number of steps that is one less after k · dt is divided by k, and that by dt again."""
    dt = 1e-4
    return next((k, dt) for k in range(1, 1000) if int((dt * k) / ((dt * k) / k)) < k)


def test_calls_are_split_into_powers_of_two_which_lose_no_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    steps, dt = lost_steps()

    def turned() -> float:
        with opened(rotor(1.0), MULTIBODY, dt) as session:
            session.advance(steps)
            q = session.read_state().q_world_body_wxyz
            return float(Rotation.from_quat(q, scalar_first=True).magnitude())

    assert turned() == pytest.approx(steps * dt, rel=steps * EPS)
    monkeypatch.setattr(pybullet_world, "calls", lambda k, _: [k])
    assert turned() == pytest.approx((steps - 1) * dt, rel=steps * EPS)


def test_a_call_that_is_given_up_is_noticed() -> None:
    with opened(SCENES["free"], MULTIBODY) as session:
        p.setTimeOut(1e-6, session.client)
        with pytest.raises(EngineError, match="did not complete a step"):
            session.advance(1024)
        # However fast the next calls are: a world that gave up a call is not used again.
        p.setTimeOut(10.0, session.client)
    assert not p.isConnected(session.client)


# Sleep


def slow_spin(method: Method) -> float:
    """What is left of a spin of 0.01 rad/s after three seconds; Bullet falls asleep after two."""
    with opened(rotor(0.01, effects=""), method, 0.01) as session:
        session.advance(300)
        return float(session.read_state().omega_body[2])


@pytest.mark.parametrize("method", [MULTIBODY, MAXIMAL], ids=lambda method: method.name)
def test_a_slow_body_never_sleeps(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    assert slow_spin(method) == pytest.approx(0.01, rel=300 * EPS)
    change(monkeypatch, "loadURDF", flags=p.URDF_USE_INERTIA_FROM_FILE | p.URDF_ENABLE_SLEEPING)
    assert slow_spin(method) == 0.0


# Small bodies


def small(moment: float) -> Scenario:
    body = f"\nmass = 1.0\ninertia = [{moment}, {2 * moment}, {2.5 * moment}]\n"
    return scene("small", body=body)


@pytest.mark.parametrize(
    ("method", "moment"), [(MULTIBODY, 1e-17), (MAXIMAL, 1e-6)], ids=["multibody", "maximal"]
)
def test_a_body_too_small_for_its_gyroscopic_term_is_refused(
    method: Method, moment: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(small(100 * moment), method).outcome == "ok"
    refused = run(small(moment), method)
    assert refused.outcome == "unsupported"
    assert "scale the scene up" in refused.reason
    monkeypatch.setattr(pybullet_load, "TAKEN_FOR_ZERO", 0.0)
    result = run(small(moment), method)
    assert result.outcome == "failed"
    assert "a resistance of" in result.reason


def test_a_body_too_heavy_for_a_constraint_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bullet drops a row of mobility not above an ulp, which along the arm is the inverse mass."""

    def heavy(mass: float) -> Scenario:
        moments = [mass, 1.5 * mass, 2 * mass]
        body = f"\nmass = {mass}\ninertia = {moments}\ncom = [0.0, 0.0, 1.0]\n"
        return scene("heavy", body=body, effects="[effects.pivot]")

    def gave_way(mass: float) -> float:
        with opened(heavy(mass), BY_CONSTRAINT) as session:
            session.advance(200)
            state = session.read_state()
        arm_world = matrix(state.q_world_body_wxyz)[:, 2]
        return float(np.linalg.norm(state.com_world - arm_world))

    assert gave_way(4.4e15) < 1e-4
    assert "scale the scene down" in run(heavy(1e16), BY_CONSTRAINT).reason
    monkeypatch.setattr(pybullet_load, "TAKEN_FOR_ZERO", 0.0)
    assert gave_way(1e16) > 0.1


# What the audit feels: torques, gravity and shapes that the scene does not call for

Plant = Callable[[pytest.MonkeyPatch], None]


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["pivot-torque-body", "pivot-torque-world", "pivot-drag"])
def test_the_audit_feels_a_torque_that_is_not_applied(name: str, method: Method) -> None:
    scenario = SCENES[name]
    with opened(scenario, method) as session:
        assert session.active() == scenario.called_for
    (missing,) = scenario.called_for - {"pivot"}
    without = replace(scenario, document=SCENES["pivot"].document)
    with opened(without, method) as session:
        assert missing not in pybullet_session.what_acts(session.advance, session.model, scenario)


@pytest.mark.parametrize("method", [MULTIBODY, MAXIMAL], ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["free-torque-body", "free-drag"])
def test_a_torque_that_turns_must_be_renewed_every_step(name: str, method: Method) -> None:
    def after(at_once: bool) -> np.ndarray:
        with opened(SCENES[name], method) as session:
            session.world.at_once = at_once
            session.advance(64)
            return session.read_state().omega_body

    assert np.abs(after(at_once=True) - after(at_once=False)).max() > TIMESTEP**2


def in_the_model(old: str, new: str) -> Plant:
    """Another text of the model."""
    real = pybullet_load.urdf

    def plant(patch: pytest.MonkeyPatch) -> None:
        def written(scenario: Scenario, **keywords: object) -> str:
            assert old in real(scenario, **keywords)
            return real(scenario, **keywords).replace(old, new)

        patch.setattr(pybullet_load, "urdf", written)

    return plant


def heavy(patch: pytest.MonkeyPatch) -> None:
    real = p.setGravity
    patch.setattr(p, "setGravity", lambda x, y, z, **keywords: real(x, y, z - 9.81, **keywords))


def along_the_body(patch: pytest.MonkeyPatch) -> None:
    """A joint's ω along the body's axes, not along its principal ones."""
    real, omega = p.resetJointStateMultiDof, SCENES["pivot"].start.omega_body

    def reset(body: int, link: int, q: object, _: object, **named: object) -> None:
        real(body, link, q, omega, **named)

    patch.setattr(p, "resetJointStateMultiDof", reset)


def damped(patch: pytest.MonkeyPatch) -> None:
    leave_out(patch, "changeDynamics", "linearDamping", "angularDamping")


def damped_along_its_way(patch: pytest.MonkeyPatch) -> None:
    leave_out(patch, "changeDynamics", "linearDamping")


def driven_by_the_default_motor(patch: pytest.MonkeyPatch) -> None:
    skip(patch, "setJointMotorControlMultiDof")


def pushed_along_other_axes(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(p, "LINK_FRAME", p.WORLD_FRAME)


def of_another_inertia_than_the_files(patch: pytest.MonkeyPatch) -> None:
    change(patch, "loadURDF", flags=0)


LINK = '<link name="top">'
SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
with_a_shape = in_the_model(LINK, LINK + SHAPE)
warned_of = in_the_model("<axis", "<no-axis")
not_loaded = in_the_model("</robot>", "")
#: What is planted, in which scene and methods, and in what words the run fails.
FAULTS: list[tuple[Plant, Scenario, list[Method], str]] = [
    (damped, rotor(10.0), [MULTIBODY, BY_CONSTRAINT], "a resistance of"),
    (damped_along_its_way, SCENES["free-thrown"], [MULTIBODY], "a force of"),
    (driven_by_the_default_motor, rotor(10.0), [MULTIBODY], "a resistance of"),
    (pushed_along_other_axes, SCENES["free-torque-body"], [MULTIBODY], "a torque of"),
    (heavy, SCENES["pivot"], METHODS, "a gravity of [0.0, 0.0, -9.81] m/s²"),
    (with_a_shape, SCENES["pivot"], METHODS, "a collision shape"),
    (
        *(of_another_inertia_than_the_files, SCENES["free-tilted"], [MULTIBODY, MAXIMAL]),
        "'inertia_com' must read back as",
    ),
    (warned_of, SCENES["pivot"], [MULTIBODY], "PyBullet warns; PyBullet printed: b3Warning"),
    (not_loaded, SCENES["free"], [MULTIBODY], "PyBullet cannot load the body"),
    (along_the_body, SCENES["pivot"], [MULTIBODY], "'omega_body' must read back as"),
]


@each_case(("plant", "scenario", "methods", "words"), FAULTS)
def test_a_planted_fault_fails_the_run(
    plant: Plant, scenario: Scenario, methods: list[Method], words: str
) -> None:
    for method in methods:
        with pytest.MonkeyPatch.context() as patch:
            plant(patch)
            result = run(scenario, method)
        assert result.outcome == "failed", method.name
        assert words in result.reason, result.reason
