"""Rotors in engines: they converge to the exact motion, and planted faults are found.

Coarse faults in all that are installed, faint ones in MuJoCo. That engines in double precision
hold, step and restart rotors of every kind is verified by the contract (`free-rotors`,
`pivot-rotors`).
"""

from pathlib import Path
from shutil import copytree, ignore_patterns
from typing import Any

import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from library_scenes import library_scene
from spincheck.engines import Engine, engines
from spincheck.engines.adapters.node.discovered import HERE, modules_folder
from spincheck.engines.child import child_engine
from spincheck.engines.child.process import end_idle
from spincheck.reference import solve
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.scenarios import Scenario, errors_between
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

#: A free rotor and a locked one off the com, four on a falling body, a driven one on a pivot.
ROTORS = ("brake-on-one-wheel", "quadrotor-body", "gyroscope-in-its-frame")
METHODS = {
    "mujoco": "RK4",
    "mjx": "Euler",
    "pin": "RK4",
    "drake": "runge_kutta3",
    "dartpy": "semi-implicit",
    "rapier3d": "impulse",
    "rapier3d-js": "impulse",
    "jolt": "gyroscopic",
    "physx": "pgs",
    "exudyn": "TrapezoidalIndex2",
}
BY_IMPULSES = ("rapier3d", "rapier3d-js", "jolt", "physx", "havok", "cannon-es")
#: Engines of which a rotor is a body of its own: its step has to resolve how far that turns.
OWN_BODIES = ("exudyn", *BY_IMPULSES)
#: The fastest rate times the step, of the coarser of two runs; and how many steps it takes.
TURN, STEPS = 0.1, 64
#: How far an order may fall short of the declared one, as in the contract.
ORDER_SLACK = 0.25


def errors_at(engine: Engine, scene: Scenario, timestep: float, steps: int) -> np.ndarray:
    method, samples = engine.method(METHODS[engine.name]), np.arange(0, steps + 1, steps // 16)
    run = engine.run(scene, method, timestep, samples)
    assert (run.outcome, run.reason) == ("ok", ""), (engine.name, scene.name)
    assert run.trajectory is not None
    assert run.active == scene.called_for
    exact = solve(scene, samples * timestep).trajectory
    errors = errors_between(scene, run.trajectory, exact)
    return np.array([errors.omega, errors.attitude, errors["spins"]])


@pytest.mark.parametrize("name", METHODS)
def test_rotors_of_the_library_converge_with_the_declared_order(name: str) -> None:
    engine = installed(name)
    order = engine.method(METHODS[name]).order
    for scene in map(library_scene, ROTORS):
        rate = fastest_rate(scene, scene.start.omega_body)
        if name in OWN_BODIES:
            rate = max(rate, float(np.abs(scene.rotors.start_spins).max()))
        coarse, fine = (errors_at(engine, scene, TURN / rate / k, k * STEPS) for k in (1, 2))
        # Of a driven rotor the spin stays, but for rounding; in single precision, of all.
        known = coarse > STEPS * np.finfo(float).eps
        known[2] &= not engine.single_precision
        assert known[:2].all(), scene.name
        assert fine[2] <= fine[0], scene.name
        # Each of the finer run's steps is rounded; all in one direction at worst.
        largest = coarse * 0.5 ** (order - ORDER_SLACK) + 2 * STEPS * engine.ulp
        assert (fine < largest)[known].all(), (scene.name, coarse, fine)


#: Of engines of which faults alone are planted here.
FAULTY = METHODS | {"mujoco-warp": "RK4", "newton": "mujoco-rk4"}
DRIVEN = "rotor 3 driven to another spin than -5 rad/s"
NO_ARMATURE = "rotor 3 with 0 kg m² on a driven hinge"
#: By engine: what is typed at its session, on `free-rotors`, and how that is told.
FAULTS = {
    "mujoco": {
        "session.model.dof_armature[6] = 0.01": "rotor 1 with 0.01 kg m² and 0 N m s on a free",
        "session.model.dof_armature[7] = 0": "rotor 3 with 0 kg m² and 0 N m s on a driven hinge",
        "session.model.dof_damping[6] = 0.01": "rotor 1 with 0 kg m² and 0.01 N m s on a free",
        "session.model.jnt_axis[1] = 0, 0, 1": "'axial moment of rotor 1' must read back",
        "session.model.jnt_pos[1] += 0.1, 0, 0": "rotor 1 on a hinge beside its centre of mass",
        "session.model.body_inertia[2] = 1, 2, 2": "'inertia_com' must read back",
        "session.data.qvel[6] += 0.1": "'spin of rotor 1' must read back as [9.0], got [9.1]",
    },
    "mujoco-warp": {
        "session._world.on_device.body_mass.fill_(2.0)": "'mass' must read back",
        "session._world.on_device.opt.gravity.zero_()": "called for but not active: gravity",
        "session._world.on_device.dof_armature.zero_()": "rotor 3 with 0 kg m²",
        "model = session._world.on_device; model.dof_damping.fill_(1e-3);"
        "model.opt.disableflags = 0": "drag",
    },
    "newton": {
        "world.model.joint_damping.fill_(1e-3)": "joint damping",
        "world.model.joint_armature.zero_()": NO_ARMATURE,
        "world.solver.mjw_model.body_mass.fill_(2.0)": "'mass' must read back",
        "world.model.gravity.zero_()": "called for but not active: gravity",
    },
    "pin": {
        "world.model.armature = np.zeros(world.model.nv)": "armature",
        "world.model.damping = np.full(world.model.nv, 1e-3)": "joint friction",
    },
    "dartpy": {
        "world.rotors[2][0].setActuatorType(session.module.dart.dynamics.ActuatorType.FORCE)": (
            "rotor 3 with another actuator than that of a driven hinge"
        ),
        "world.rotors[0][0].setDampingCoefficient(0, 1e-3)": (
            "damping or a spring on the hinge of rotor 1"
        ),
        "moved = world.rotors[0][1].getInertia(); moved.setLocalCOM(np.array([0.01, 0, 0]));"
        "world.rotors[0][1].setInertia(moved)": "must read back",
    },
    "drake": {
        "(index,) = world.plant.GetJointActuatorIndices();"
        "world.plant.get_joint_actuator(index).SetRotorInertia(world.context, 0.0)": NO_ARMATURE,
        "world.rotors[0].SetDampingVector(world.context, np.array([1e-3]))": (
            "damping on the hinge of rotor 1"
        ),
    },
    "rapier3d": {
        "import rapier3d; world.rotors[0][1].data.lock_axes(rapier3d.JointAxesMask.ANG_X)": (
            "'axial moment of rotor 1' must read back"
        ),
        "world.rotors[0][0].angular_damping = 0.1": "damping",
        "world.rotors[1][1].data.local_anchor1 = (0.1, 0.1, 0.0)": "'com' must read back",
    },
    "exudyn": {
        "world.system.SetObjectParameter(world.rotors[2].drive, 'activeConnector', False)": DRIVEN,
        "world.system.SetObjectParameter(world.rotors[2].drive, 'offset', -5.001)": DRIVEN,
        "world.system.SetObjectParameter("
        "world.rotors[1].joint, 'constrainedAxes', [1, 1, 1, 1, 1, 0])": (
            "rotor 2 on another joint than that of a locked hinge"
        ),
        "world.system.SetLoadParameter(1, 'loadVector', [0.0, 0.0, 0.0])": (
            "a load of [0.0, 0.0, 0.0]"
        ),
        "_, end = world.system.GetObject(world.rotors[0].joint)['markerNumbers'];"
        "at = np.array(world.system.GetMarker(end)['localHT']); at[0, 3] = 0.01;"
        "world.system.SetMarkerParameter(end, 'localHT', at)": "must read back",
    },
}


@each_case(
    ("engine", "typed", "words"),
    [(engine, *fault) for engine, faults in FAULTS.items() for fault in faults.items()],
)
def test_a_hinge_with_a_planted_fault_fails_the_run(engine: str, typed: str, words: str) -> None:
    one, scene = installed(engine), SCENES["free-rotors"]
    with pytest.MonkeyPatch.context() as patch:
        plant(patch, one, typed)
        run = one.run(scene, one.method(FAULTY[engine]), 1e-3, np.arange(0, 21, 10))
    assert run.outcome == "failed"
    assert words in run.reason, run.reason


def plant(patch: pytest.MonkeyPatch, engine: Engine, typed: str) -> None:
    """Have something typed at each session that an engine opens."""
    opened = engine.open

    def faulty(*arguments: Any) -> Any:
        session: Any = opened(*arguments)
        world = getattr(session, "world", None)
        exec(typed, {"np": np, "session": session, "world": world})
        return session

    patch.setattr(engine, "open", faulty, raising=False)


UNDRIVEN = "rotor 3 without a drive on a driven hinge"
LOCKED = "rotor 1 on a free hinge that locks 4 axes"
PLACE, AXIS = "'com' must read back", "'axial moment of rotor 1' must read back"
#: In the text of an engine under node: what is written there, what is planted, and how it is told.
PLANTED = [
    ("jolt", "SetMotorState(TWIST, J.EMotorState_Velocity)", "GetMotorState(TWIST)", UNDRIVEN),
    ("physx", "FAST, FAST, true", "0, FAST, true", UNDRIVEN),
    ("havok", "if (spin !== null) {", "if (false) {", UNDRIVEN),
    ("cannon-es", "if (fixed || spin !== null) {", "if (fixed) {", UNDRIVEN),
    ("jolt", "locked[k] ?", "locked[k] && (k !== 4 || locked[3]) ?", LOCKED),
    ("physx", "locked[k] ?", "locked[k] && (k !== 4 || locked[3]) ?", LOCKED),
    ("havok", "locked[k] &&", "locked[k] && (k !== 4 || locked[3]) &&", LOCKED),
    ("jolt", "mLinearDamping: 0", "mLinearDamping: mass === scene.mass ? 0 : 0.1", "damping"),
    ("physx", "setAngularDamping(0)", "setAngularDamping(mass === told.mass ? 0 : 0.1)", "damping"),
    ("jolt", "mPosition1: make(J.RVec3, ...at)", "mPosition1: make(J.RVec3, ...X)", PLACE),
    ("physx", "pose(at, turn)", "pose(X, turn)", PLACE),
    ("rapier3d-js", "[vector(at), ", "[vector(X), ", PLACE),
    ("cannon-es", "pivotA: vec(at)", "pivotA: vec(x)", PLACE),
    ("jolt", "mAxisX1: make(J.Vec3, ...x)", "mAxisX1: make(J.Vec3, ...Y)", AXIS),
    ("physx", "pose(at, turn)", "pose(at, UPRIGHT)", AXIS),
    ("rapier3d-js", "vector(x), vector(X)", "vector(X), vector(X)", AXIS),
    ("cannon-es", "axisA: vec(x)", "axisA: vec([1, 0, 0])", AXIS),
    (
        *("jolt", "make(J.Vec3, ...omega)", "make(J.Vec3, ...scene.omega)"),
        "'spin of rotor 1' must read",
    ),
    ("havok", "moments.map((I) => I / mass)", "moments.map(() => 1)", "'inertia_com' must read"),
]


@pytest.mark.processes
@each_case(("engine", "written", "planted", "words"), PLANTED)
def test_a_fault_planted_in_the_hinges_of_an_engine_under_node_fails_the_run(
    engine: str, written: str, planted: str, words: str, tmp_path: Path
) -> None:
    installed(engine)
    folder = tmp_path / str(len([*tmp_path.iterdir()]))
    copytree(HERE, folder, ignore=ignore_patterns("*.py", "__pycache__"))
    file = folder / f"{engine}.mjs"
    text = file.read_text(encoding="utf-8")
    assert text.count(written) == 1, (engine, written)
    file.write_text(text.replace(written, planted), encoding="utf-8")
    one = child_engine(("node", str(file), str(modules_folder())))
    run = one.run(SCENES["free-rotors"], one.methods[0], 1e-3, np.arange(0, 21, 10))
    end_idle()
    assert run.outcome == "failed"
    assert words in run.reason, run.reason


# MuJoCo: a published figure, and faint faults

BOX = "wheel-in-a-box"
#: Steps of 2 ms to 5 s, every tenth of a second.
SAMPLES, STEP = np.arange(0, 2501, 50), 2e-3


def test_semi_implicit_euler_is_43_degrees_off_where_rk4_is_on_a_flywheel_at_300_rad_a_second() -> (
    None
):
    """Known of MuJoCo from before: 0.745 rad after 5 s at 2 ms, RK4 below 4e-8."""
    scene, engine = library_scene(BOX), engines()["mujoco"]
    exact = solve(scene, SAMPLES * STEP).trajectory
    off = {}
    for name in ("Euler", "RK4"):
        run = engine.run(scene, engine.method(name), STEP, SAMPLES)
        assert run.trajectory is not None
        off[name] = errors_between(scene, run.trajectory, exact).attitude
    assert round(off["Euler"], 3) == 0.745
    assert off["RK4"] < 4e-8


#: What is typed at MuJoCo's session, with every pass of its model switched on, and how it is told.
FAINT = {
    "": "",
    # A millionth of N m s, a hundredth of the rotor's moment, a ten thousandth of its momentum.
    "session.model.dof_damping[6] = 1e-6": "I dω/dt",
    "session.model.dof_armature[6] = 1e-5": "I dω/dt",
    "session.model.body_inertia[2][2] *= 1 + 1e-4": (
        "behaves as if the rotors had 1.0001 times their angular momentum"
    ),
}


@each_case(("typed", "words"), [*FAINT.items()])
def test_single_steps_show_a_faint_fault_of_a_hinge(typed: str, words: str) -> None:
    engine = engines()["mujoco"]
    with pytest.MonkeyPatch.context() as patch:
        plant(patch, engine, f"session.model.opt.disableflags = 0\n{typed}")
        found = physics_in_words(engine, library_scene(BOX), engine.method("RK4"))
    assert words in found
    assert bool(found) == bool(typed)
