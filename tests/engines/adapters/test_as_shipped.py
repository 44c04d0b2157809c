"""An engine as shipped is run like any other, and its differences from the scene are reported."""

from dataclasses import replace

import mujoco
import numpy as np
import pybullet as p
import pytest
from pybullet_planted import rotor
from spincheck.engines import Engine, Method, Run, engines
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.pybullet.engine import PyBullet
from spincheck.engines.adapters.pybullet.session import DEFAULT_CLAMP
from spincheck.suite.contract_scenes import SCENES, SPUN_UP, scene

MUJOCO, PYBULLET = MuJoCo(), PyBullet()
FROM_FILE = PYBULLET.method("default-inertia-from-file")
TIMESTEP = 1e-3
STEPS = np.arange(0, 51, 10)
SHIPPED = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine in (MUJOCO, PYBULLET)
    for method in engine.methods
    if method.as_shipped and not method.requires
]
#: PyBullet's default: of a linear and of an angular velocity, a second.
DAMPING = 0.04


def default(engine: Engine, name: str, timestep: float = TIMESTEP) -> Run:
    return engine.run(SCENES[name], engine.method("default"), timestep, STEPS)


def reason_of(name: str) -> str:
    return default(PYBULLET, name).reason


def test_engines_that_have_defaults_of_their_own_are_run_with_them() -> None:
    shipped = {e.name for e in engines().values() if any(m.as_shipped for m in e.methods)}
    assert {"mujoco", "pybullet"} <= shipped


@pytest.mark.parametrize(("engine", "method"), SHIPPED)
@pytest.mark.parametrize("name", ["free", "heavy-tilted"])
def test_what_differs_is_reported_and_fails_no_run(
    engine: Engine, method: Method, name: str
) -> None:
    run = engine.run(SCENES[name], method, TIMESTEP, STEPS)
    assert run.outcome == "ok"
    assert "active though the scene does not call for it: " in run.reason
    assert run.trajectory is not None
    assert len(run.trajectory.t) == len(STEPS)


@pytest.mark.parametrize(("engine", "method"), SHIPPED)
def test_the_same_is_no_run_of_a_method_that_claims_to_simulate_the_scene(
    engine: Engine, method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The adapter's way of opening is asked for by the real method, whatever it is given."""
    real = engine.open
    monkeypatch.setattr(type(engine), "open", lambda _, scene, __, dt: real(scene, method, dt))
    strict = replace(method, as_shipped=False)
    assert engine.run(SCENES["free"], strict, TIMESTEP, STEPS).outcome == "failed"


# MuJoCo


def test_mujocos_stock_timestep_is_that_of_an_empty_model() -> None:
    assert mujoco.MjModel.from_xml_string("<mujoco/>").opt.timestep == MUJOCO.stock_timestep


@pytest.mark.parametrize("name", SCENES)
def test_mujocos_defaults_are_its_euler_to_the_last_bit(name: str) -> None:
    shipped = default(MUJOCO, name).trajectory
    euler = MUJOCO.run(SCENES[name], MUJOCO.method("Euler"), TIMESTEP, STEPS).trajectory
    rk4 = MUJOCO.run(SCENES[name], MUJOCO.method("RK4"), TIMESTEP, STEPS).trajectory
    assert shipped is not None
    assert euler is not None
    assert rk4 is not None
    assert np.array_equal(shipped.omega_body, euler.omega_body)
    assert not np.array_equal(shipped.omega_body, rk4.omega_body)


def test_mujocos_options_are_untouched_but_for_timestep_and_gravity() -> None:
    with MUJOCO.open(SCENES["heavy-tilted"], MUJOCO.method("default"), TIMESTEP) as session:
        held, fresh = session.model.opt, mujoco.MjModel.from_xml_string("<mujoco/>").opt
        options = {name for name in dir(held) if not name.startswith("_")}
        differing = {
            name for name in options if np.any(getattr(held, name) != getattr(fresh, name))
        }
    assert differing == {"timestep", "gravity"}


@pytest.mark.parametrize(("method", "is_reset"), [("default", True), ("Euler", False)])
def test_mujocos_automatic_reset_ends_a_run_that_blew_up(method: str, is_reset: bool) -> None:
    """Without it only the warning is reported."""
    coarse, blown_up = 1e-2, np.arange(0, 501, 10)
    run = MUJOCO.run(SCENES["heavy-top"], MUJOCO.method(method), coarse, blown_up)
    assert run.outcome == "diverged"
    assert ("it was reset" in run.reason) == is_reset
    assert run.stopped_at is not None
    assert run.trajectory is not None
    assert run.trajectory.t[-1] < run.stopped_at < blown_up[-1] * coarse


# PyBullet


def test_pybullets_stock_timestep_is_that_of_an_empty_world() -> None:
    world = p.connect(p.DIRECT)
    assert p.getPhysicsEngineParameters(world)["fixedTimeStep"] == PYBULLET.stock_timestep
    p.disconnect(world)


@pytest.mark.parametrize("name", ["free", "heavy-top"])
def test_of_a_box_along_the_bodys_axes_the_inertia_is_the_scenes(name: str) -> None:
    assert "'inertia_com'" not in default(PYBULLET, name).reason


def test_of_one_that_is_turned_it_is_that_of_its_bounding_box() -> None:
    """The margin of a millimetre around it makes up a thousandth."""
    reason = default(PYBULLET, "pivot").reason
    assert reason.startswith("'inertia_com' reads back as [[")
    assert ": off by 0.1%" in reason
    run = PYBULLET.run(SCENES["pivot"], FROM_FILE, TIMESTEP, STEPS)
    assert "'inertia_com'" not in run.reason
    assert "joint motor" in run.reason


@pytest.mark.parametrize("words", ["damping", "velocity clamp"])
@pytest.mark.parametrize("name", ["free", "pivot"])
def test_a_multibody_is_damped_and_its_velocity_clamped(name: str, words: str) -> None:
    assert words in reason_of(name)


def test_a_joint_has_a_motor_and_a_free_body_none() -> None:
    assert "joint motor" in reason_of("pivot")
    assert "joint motor" not in reason_of("free")


def test_the_spin_decays_by_the_default_damping_and_not_without() -> None:
    """A rotor: in PyBullet's 3.2.7 there is a quadratic part, faint at slow spins."""
    spin, steps = 0.01, np.array([0, 1000])
    free = rotor(spin, effects="")

    def spin_kept(method: str) -> float:
        motion = PYBULLET.run(free, PYBULLET.method(method), TIMESTEP, steps).trajectory
        assert motion is not None
        return float(motion.omega_body[-1, 2] / spin)

    # Linear and quadratic part together: d ln ω / dt = −DAMPING (1 + |ω|).
    assert spin_kept("default") == pytest.approx(np.exp(-DAMPING), rel=DAMPING * (spin + TIMESTEP))
    assert spin_kept("multibody") == pytest.approx(1.0, rel=steps[-1] * np.finfo(float).eps)


def test_a_clamped_velocity_ends_the_run() -> None:
    fast = rotor(1.5 * DEFAULT_CLAMP, effects="")
    run = PYBULLET.run(fast, PYBULLET.method("default"), TIMESTEP, STEPS)
    assert run.outcome == "diverged"
    assert "PyBullet clamps velocities at 100" in run.reason
    slow = rotor(0.5 * DEFAULT_CLAMP, effects="")
    assert PYBULLET.run(slow, PYBULLET.method("default"), TIMESTEP, STEPS).outcome == "ok"


def test_a_clamp_is_found_along_axes_that_are_no_coordinate_axes() -> None:
    spun = SPUN_UP.replace("40.0", "400.0")
    tilted = scene("tilted", body="\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n", start=spun)
    with PYBULLET.open(tilted, PYBULLET.method("default"), TIMESTEP) as session:
        session.advance(1)
        omega_world = np.array(p.getBaseVelocity(session.world.body, session.client)[1])
        assert np.abs(omega_world).max() == DEFAULT_CLAMP
    run = PYBULLET.run(tilted, PYBULLET.method("default"), TIMESTEP, STEPS)
    assert "PyBullet clamps velocities at 100" in run.reason
