"""What acts on the body of a MuJoCo model, read back from the model as it was compiled.

Forces in MuJoCo come from the model, from what was applied to its data, and from callbacks of the
process; all three are checked.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np
from spincheck.engine import FloatArray, Rotor, Scenario

from ...models.mjcf import armature
from ...models.mjcf_contact import PASSES, sphere_and_plane
from .world import disabling, flags

#: Fields of a model that no scene calls for, with their names; those with non-zero values are
#: reported.
FOREIGN: dict[str, Callable[[Any], Any]] = {
    # Bodies welded to the first body are parts of it, and so are not a second body.
    "a second body": lambda m: m.body_weldid[2:] != m.body_weldid[1],
    "a second joint": lambda m: m.jnt_bodyid != 1,
    "equality constraints": lambda m: m.neq,
    "tendons": lambda m: m.ntendon,
    "flexible bodies": lambda m: m.nflex,
    "sensors": lambda m: m.nsensor,
    "plugins": lambda m: m.nplugin,
    "actuator dynamics": lambda m: m.na,
    "actuator delays": lambda m: m.nhistory,
    "actuator limits": lambda m: [*m.actuator_forcelimited, *m.jnt_actfrclimited],
    "joint springs": lambda m: [*m.jnt_stiffness, *m.jnt_stiffnesspoly.flat],
    "joint limits": lambda m: m.jnt_limited,
    "joint friction": lambda m: m.dof_frictionloss,
    "nonlinear damping": lambda m: m.dof_dampingpoly,
    "added rotor inertia": lambda m: m.dof_armature,
    "gravity compensation": lambda m: m.body_gravcomp,
    "wind": lambda m: m.opt.wind,
    "air": lambda m: [m.opt.density, m.opt.viscosity],
}

#: Names, among these, of what rotors on hinges are in a MuJoCo model.
OF_ROTORS = {"a second body", "a second joint", "added rotor inertia"}
#: Relative tolerance of numbers that went through text, in double precision; and in single
#: precision the number of roundings allowed.
HINGE_SLACK, ROUNDINGS = 1e-12, 4

#: MuJoCo's flags in words; flags of later versions are reported by MuJoCo's own names.
FLAG_WORDS = {
    "constraint": "constraint solver",
    "equality": "equality constraint pass",
    "frictionloss": "joint friction pass",
    "limit": "joint limit pass",
    "contact": "collision detection",
    "spring": "joint spring pass",
    "damper": "joint damper pass",
    "clampctrl": "control clamping",
    "warmstart": "solver warm start",
    "actuation": "actuator pass",
    "refsafe": "constraint stiffness guard",
    "sensor": "sensor pass",
    "midphase": "collision mid-phase",
    "eulerdamp": "implicit joint damping",
    "autoreset": "automatic reset",
    "island": "constraint islands",
    "energy": "energy computation",
    "fwdinv": "inverse dynamics check",
    "sleep": "sleeping",
}
#: Flags that choose how contacts are found; they have no effect when collision detection is off.
CONTACT_CHOICES = frozenset({"filterparent", "nativeccd", "multiccd"})

CALLBACKS = ("act_bias", "act_dyn", "act_gain", "contactfilter", "control", "passive", "sensor")


def acting(model: Any, data: Any, scenario: Scenario) -> frozenset[str]:
    """Return names of the effects that act, and descriptions of anything else that is switched on.

    An effect whose strength differs from the scene's is described too.
    """
    strengths, other = read_strengths(model)
    held_by, of_joints = _joints(model, scenario)
    drag = strengths["drag"]
    named = {
        held_by: held_by,
        **{name: got.any() for name, got in strengths.items()},
        "uneven drag": (drag != drag[0, 0] * np.eye(3)).any(),
        "applied forces": data.qfrc_applied.any() or data.xfrc_applied.any(),
    }
    names_acting = {name for name, acts in named.items() if acts}
    foreign = {name for name, part in FOREIGN.items() if _has(model, part)}
    if scenario.rotors:
        wrong = list(_wrong_hinges(model, scenario.rotors.each))
        names_acting |= set(wrong) or {"rotors"}
        foreign -= set() if wrong else OF_ROTORS
    names_acting |= foreign
    names_acting |= {
        f"callback {n}" for n in CALLBACKS if getattr(mujoco, f"get_mjcb_{n}")() is not None
    }
    names_acting |= {*_wrong_strengths(strengths, scenario), *other, *of_joints}
    return frozenset(names_acting) | _idle_passes(model)


def _wrong_hinges(model: Any, rotors: Sequence[Rotor]) -> Iterator[str]:
    """Yield in words how the bodies after the first differ from rotors on their hinges."""
    if model.nbody - 2 != len(rotors) or (model.body_parentid[2:] != 1).any():
        yield f"{model.nbody - 2} parts of the body, not {len(rotors)} rotors"
        return
    slack = max(HINGE_SLACK, ROUNDINGS * float(np.finfo(model.dof_armature.dtype).eps))
    for number, rotor in enumerate(rotors, start=1):
        joint, count = model.body_jntadr[number + 1], model.body_jntnum[number + 1]
        if rotor.hinge == "locked" or count != 1:
            if count != (rotor.hinge != "locked"):
                yield f"rotor {number} on {count} joints, though it is {rotor.hinge}"
            continue
        dof = model.jnt_dofadr[joint]
        numbers = model.dof_armature[dof], model.dof_damping[dof]
        if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
            yield f"rotor {number} on a joint that is no hinge"
        if not np.allclose(numbers, (armature(rotor), 0.0), rtol=slack, atol=0.0):
            inertia, damping = map(float, numbers)
            on = f"on a {rotor.hinge} hinge"
            yield f"rotor {number} with {inertia:g} kg m² and {damping:g} N m s {on}"
        off = model.jnt_pos[joint] - model.body_ipos[number + 1]
        if np.linalg.norm(np.cross(off, model.jnt_axis[joint])) > slack * np.linalg.norm(off):
            yield f"rotor {number} on a hinge beside its centre of mass"


def _has(model: Any, part: Callable[[Any], Any]) -> bool:
    """Whether `part` finds something in a model; False if this MuJoCo has no such field."""
    try:
        return bool(np.any(part(model)))
    except AttributeError:
        return False


def _wrong_strengths(strengths: dict[str, FloatArray], scenario: Scenario) -> Iterator[str]:
    """Yield in words the effects whose strength differs from the scene's."""
    wanted_of = {"gravity": scenario.gravity_world, **scenario.pushed}
    for name, strength in strengths.items():
        got = np.diag(strength) if strength.ndim > 1 else strength
        wanted = np.broadcast_to(wanted_of[name], got.shape)
        # Effects not called for, or missing, are reported elsewhere.
        if wanted.any() and got.any() and (got != wanted.astype(got.dtype)).any():
            yield f"{name} of {got.tolist()}, not {wanted.tolist()}"


def read_strengths(model: Any) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the strength of each effect by name, and in words what else actuators do.

    A strength is a vector, (3,), except of drag the matrix D of the torque −D ω in body axes, (3,
    3).
    It is zero for an effect whose pass is switched off.
    """
    numbers = model.opt.gravity.dtype
    strengths: dict[str, FloatArray] = {
        "gravity": model.opt.gravity * _is_on(model, "gravity"),
        "drag": np.diag(_joint_damping(model)),
        "torque_body": np.zeros(3, numbers),
        "torque_world": np.zeros(3, numbers),
    }
    return strengths, _add_actuators(model, strengths) if _is_on(model, "actuation") else []


def _joint_damping(model: Any) -> FloatArray:
    damping: FloatArray = model.dof_damping[_turning(model)] * _is_on(model, "damper")
    return damping


def _own_joints(model: Any) -> int:
    """Return the number of joints of the body itself, which come before those of its rotors."""
    return int(np.count_nonzero(model.jnt_bodyid == 1))


def _turning(model: Any) -> slice:
    """Return the indices of the velocities that are the body's ω."""
    last = _own_joints(model) - 1
    if last < 0:
        return slice(0, 3)
    first = model.jnt_dofadr[last] + 3 * (model.jnt_type[last] == mujoco.mjtJoint.mjJNT_FREE)
    return slice(first, first + 3)


def _joints(model: Any, scenario: Scenario) -> tuple[str, set[str]]:
    """Return the effect that the body's joints implement, and in words what else they are or do.

    The effect is "pivot", "table" or, if the body is free or held otherwise, empty.
    """
    if model.njnt == 0:
        return "", {"a weld to the world"}
    if model.ngeom:
        rests = scenario.effects.table is not None and _rests(model, scenario)
        return ("table", set()) if rests else ("", {"collision geometry"})
    last, turning = _own_joints(model) - 1, _turning(model)
    slides, ball = model.jnt_type[:last], model.jnt_type[last]
    other = {"drag on the translation"} if model.dof_damping[: turning.start].any() else set()
    if len(slides) == 0 and ball == mujoco.mjtJoint.mjJNT_FREE:
        return "", other
    constraint = scenario.constraint
    wanted = [
        axis for axis, is_held in zip(np.eye(3), constraint.is_held, strict=True) if not is_held
    ]
    point_body = scenario.body.com - constraint.lever
    place_world = np.array(constraint.place_exact, dtype=float)
    is_held = (
        ball == mujoco.mjtJoint.mjJNT_BALL
        and (slides == mujoco.mjtJoint.mjJNT_SLIDE).all()
        and np.array_equal(model.jnt_axis[:last], np.reshape(wanted, (-1, 3)))
        and _same(model.jnt_pos[last], point_body)
        and _same(model.body_pos[1], place_world - point_body)
        and np.array_equal(model.body_quat[1], (1, 0, 0, 0))
    )
    if not is_held:
        return "", {"a joint that is no ball where the scene holds the body"}
    return "pivot" if constraint.is_pivot else "table", other


def _same(got: FloatArray, wanted: FloatArray) -> bool:
    """Whether numbers are equal, in the precision of the numbers that were read."""
    return np.array_equal(got, wanted.astype(got.dtype))


def _rests(model: Any, scenario: Scenario) -> bool:
    """Whether a free body's sphere lies on a plane as the scene's tip does, without friction."""
    kinds = [mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_SPHERE]
    radius, height = sphere_and_plane(scenario)
    table = scenario.effects.table
    assert table is not None
    return (
        _own_joints(model) == 1
        and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
        and model.geom_type.tolist() == kinds
        and model.geom_condim.tolist() == [1, 1]
        and np.array_equal(model.geom_pos, [(0.0, 0.0, height), table.tip])
        and model.geom_size[1, 0] == radius
    )


def _add_actuators(model: Any, strengths: dict[str, FloatArray]) -> list[str]:
    """Add constant torques and servos to the strengths; return other actuators in words."""
    other = []
    for i in range(model.nu):
        gear = model.actuator_gear[i]
        is_free = model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
        torque, force = (gear[3:], gear[:3]) if is_free else (gear[:3], gear[3:])
        constant, per_length, per_velocity = model.actuator_biasprm[i][:3]
        # Both effects are constant torques; they differ in the axes in which the gear is written.
        turned_by = {
            int(mujoco.mjtTrn.mjTRN_JOINT): strengths["torque_body"],
            int(mujoco.mjtTrn.mjTRN_JOINTINPARENT): strengths["torque_world"],
        }.get(int(model.actuator_trntype[i]))
        is_servo = turned_by is strengths["torque_body"]
        if turned_by is None or model.actuator_gainprm[i].any() or per_length or force.any():
            other.append("an actuator that is neither a constant torque nor drag")
            continue
        turned_by += constant * torque
        if is_servo:
            strengths["drag"] -= per_velocity * np.outer(torque, torque)
        elif per_velocity:
            other.append("drag along world axes")
    return other


def _idle_passes(model: Any) -> frozenset[str]:
    """Return in words the passes that are on although nothing in the scene needs them."""
    needed = {"gravity"} | CONTACT_CHOICES
    needed |= {"damper", "eulerdamp"} if _joint_damping(model).any() else set()
    needed |= {"actuation"} if model.nu else set()
    needed |= PASSES if model.ngeom else set()
    passes = disabling()
    needed_bits = {passes[name] for name in needed & passes.keys()}
    on = {name for name, bit in passes.items() if _is_on(model, name) and bit not in needed_bits}
    bits = flags(mujoco.mjtEnableBit, "mjENBL_")
    on |= {name for name, bit in bits.items() if model.opt.enableflags & bit}
    return frozenset(FLAG_WORDS.get(name, f"flag '{name}'") for name in on - needed)


def _is_on(model: Any, name: str) -> bool:
    return not model.opt.disableflags & disabling().get(name, 0)
