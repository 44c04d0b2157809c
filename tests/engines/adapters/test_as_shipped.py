"""An engine as shipped is run like any other, and its differences from the scene are reported."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from pybullet_planted import rotor
from spincheck.engines import Engine, Method, Run
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.pybullet.engine import PyBullet
from spincheck.engines.adapters.pybullet.session import DEFAULT_CLAMP
from spincheck.suite.contract_scenes import SCENES, SPUN_UP, scene

MUJOCO, PYBULLET = MuJoCo(), PyBullet()
FROM_FILE = PYBULLET.method("default-inertia-from-file")
TIMESTEP = 1e-3
STEPS = np.arange(0, 51, 10)
#: PyBullet's default: of a linear and of an angular velocity, a second.
DAMPING = 0.04


def default(engine: Engine, name: str, timestep: float = TIMESTEP) -> Run:
    return engine.run(SCENES[name], engine.method("default"), timestep, STEPS)


@each_case(
    ("engine", "method"),
    [
        (engine, method)
        for engine in (MUJOCO, PYBULLET)
        for method in engine.methods
        if method.as_shipped and not method.requires
    ],
)
def test_what_differs_is_reported_and_fails_no_run_but_of_methods_that_claim_the_scene(
    engine: Engine, method: Method
) -> None:
    for name in ("free", "heavy-tilted"):
        run = engine.run(SCENES[name], method, TIMESTEP, STEPS)
        assert run.outcome == "ok"
        assert "active though the scene does not call for it: " in run.reason
        assert run.trajectory is not None
        assert len(run.trajectory.t) == len(STEPS)
    # The adapter's way of opening is asked for by the real method, whatever it is given.
    real, strict = engine.open, replace(method, as_shipped=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(engine), "open", lambda _, scene, __, dt: real(scene, method, dt))
        assert engine.run(SCENES["free"], strict, TIMESTEP, STEPS).outcome == "failed"


# MuJoCo


def test_mujocos_stock_timestep_is_that_of_an_empty_model() -> None:
    assert mujoco.MjModel.from_xml_string("<mujoco/>").opt.timestep == MUJOCO.stock_timestep


@each_case("name", [*SCENES])
def test_mujocos_defaults_are_its_euler_to_the_last_bit(name: str) -> None:
    def omega(method: str) -> np.ndarray:
        motion = MUJOCO.run(SCENES[name], MUJOCO.method(method), TIMESTEP, STEPS).trajectory
        assert motion is not None
        return motion.omega_body

    assert np.array_equal(omega("default"), omega("Euler"))
    assert not np.array_equal(omega("default"), omega("RK4"))


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


@each_case("name", ["free", "heavy-top"])
def test_of_a_box_along_the_bodys_axes_the_inertia_is_the_scenes(name: str) -> None:
    assert "'inertia_com'" not in default(PYBULLET, name).reason


def test_of_one_that_is_turned_it_is_that_of_its_bounding_box() -> None:
    """The margin of a millimetre around it makes up a thousandth."""
    reason = default(PYBULLET, "pivot").reason
    assert reason.startswith("'inertia_com' reads back as [[")
    off = re.search(r": off by ([\d.]+)%", reason)
    assert off is not None
    assert float(off[1]) == pytest.approx(0.1, abs=0.05)
    run = PYBULLET.run(SCENES["pivot"], FROM_FILE, TIMESTEP, STEPS)
    assert "'inertia_com'" not in run.reason
    assert "joint motor" in run.reason


def test_a_multibody_is_damped_its_velocity_clamped_and_its_joint_driven() -> None:
    reasons = {name: default(PYBULLET, name).reason for name in ("free", "pivot")}
    for name, reason in reasons.items():
        assert "damping" in reason
        assert "velocity clamp" in reason
        assert ("joint motor" in reason) == (name == "pivot")


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
