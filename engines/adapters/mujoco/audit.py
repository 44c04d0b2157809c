"""What acts on the body of a MuJoCo model, read back from the compiled model.

Forces in MuJoCo come from the model, from those set in its data, and from callbacks of the process;
all three are checked.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from spincheck.engine import FloatArray, Rotor, Scenario

from ...models.mjcf import armature
from ...models.mjcf_contact import PASSES, sphere_and_plane
from .coordinates import BODY
from .world import disabling, flags

#: Parts of a model that no scene calls for, each with fields that are all zero if the model has no
#: such part: fields of the model, or of its options (`FOREIGN_OPTIONS`). Not every version of
#: MuJoCo has all of them.
FOREIGN = {
    "equality constraints": ("neq",),
    "tendons": ("ntendon",),
    "flexible bodies": ("nflex",),
    "sensors": ("nsensor",),
    "plugins": ("nplugin",),
    "actuator dynamics": ("na",),
    "actuator delays": ("nhistory",),
    "actuator limits": ("actuator_forcelimited", "jnt_actfrclimited"),
    "joint springs": ("jnt_stiffness", "jnt_stiffnesspoly"),
    "joint limits": ("jnt_limited",),
    "joint friction": ("dof_frictionloss",),
    "nonlinear damping": ("dof_dampingpoly",),
    "gravity compensation": ("body_gravcomp",),
}
FOREIGN_OPTIONS = {"wind": ("wind",), "air": ("density", "viscosity")}

#: Relative tolerance of a hinge's numbers, which were rounded in the text of the MJCF:
#: `HINGE_SLACK`, or `ROUNDINGS` ulp of the model's precision if that is larger.
HINGE_SLACK, ROUNDINGS = 1e-12, 4

#: Words by which the audit reports MuJoCo's flags; flags that are not listed keep MuJoCo's names.
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

    An effect whose strength is not the scene's is both named and described.

    Parameters
    ----------
    model, data : MuJoCo's model and data, or those of a port with the same field names
    """
    strengths, others = read_strengths(model)
    drag = strengths["drag"]
    named = {
        **{name: strength.any() for name, strength in strengths.items()},
        "uneven drag": (drag != drag[0, 0] * np.eye(3)).any(),
        "applied forces": data.qfrc_applied.any() or data.xfrc_applied.any(),
        **{
            name: any(np.any(getattr(holder, field, 0)) for field in fields)
            for holder, foreign in ((model, FOREIGN), (model.opt, FOREIGN_OPTIONS))
            for name, fields in foreign.items()
        },
        **{f"callback {n}": getattr(mujoco, f"get_mjcb_{n}")() is not None for n in CALLBACKS},
    }
    return frozenset(
        {
            *(name for name, acts in named.items() if acts),
            *others,
            *_wrong_strengths(strengths, scenario),
            *_joints(model, scenario),
            *_further_parts(model, scenario.rotors.each),
            *_idle_passes(model),
        }
    )


def _further_parts(model: Any, rotors: Sequence[Rotor]) -> set[str]:
    """Return what the model has besides the body, as a set of names and descriptions.

    For a scene with rotors, the set is {"rotors"}, or says how the further bodies differ from the
    rotors. For any other scene it has descriptions of further bodies, joints and armatures; it is
    empty if there are none. Bodies welded to the first one are part of the body.
    """
    if rotors:
        return {*_wrong_hinges(model, rotors)} or {"rotors"}
    further = {
        "a second body": model.body_weldid[BODY + 1 :] != model.body_weldid[BODY],
        "a second joint": model.jnt_bodyid != BODY,
        "added rotor inertia": model.dof_armature,
    }
    return {name for name, numbers in further.items() if np.any(numbers)}


def _wrong_hinges(model: Any, rotors: Sequence[Rotor]) -> Iterator[str]:
    """Yield, in words, how the bodies after the first differ from the scene's rotors."""
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


def _wrong_strengths(strengths: dict[str, FloatArray], scenario: Scenario) -> Iterator[str]:
    """Yield a description of each effect that acts with another strength than in the scene.

    An effect that is only in the model, or only in the scene, is left out.

    Parameters
    ----------
    strengths : strengths of the effects in the model, from `read_strengths`
    """
    wanted_of = {"gravity": scenario.gravity_world, **scenario.pushed}
    for name, strength in strengths.items():
        got = np.diag(strength) if strength.ndim > 1 else strength
        wanted = np.broadcast_to(wanted_of[name], got.shape)
        # Effects that are not called for, or are missing, are found when names are compared.
        if wanted.any() and got.any() and (got != wanted.astype(got.dtype)).any():
            yield f"{name} of {got.tolist()}, not {wanted.tolist()}"


def read_strengths(model: Any) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the strengths of effects by name, and descriptions of what else the actuators do.

    The strengths are "gravity", m/s², world axes, (3,); "torque_body" and "torque_world", N m, in
    body and in world axes, (3,); and "drag", N m s: the matrix D of the torque −D ω in body axes,
    (3, 3). A strength is zero if the effect does not act, or if its pass is switched off.
    """
    drag, others = np.diag(_joint_damping(model)), []
    torque_body, torque_world = np.zeros((2, 3), model.opt.gravity.dtype)
    # Actuators of both types are constant torques: the gear is along axes of the body, or of the
    # world.
    constant_along = {
        int(mujoco.mjtTrn.mjTRN_JOINT): torque_body,
        int(mujoco.mjtTrn.mjTRN_JOINTINPARENT): torque_world,
    }
    is_free = model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    for i in range(model.nu if _is_on(model, "actuation") else 0):
        first, last = model.actuator_gear[i][:3], model.actuator_gear[i][3:]
        torque, force = (last, first) if is_free else (first, last)
        constant, per_length, per_velocity = model.actuator_biasprm[i][:3]
        turned_by = constant_along.get(int(model.actuator_trntype[i]))
        if turned_by is None or model.actuator_gainprm[i].any() or per_length or force.any():
            others.append("an actuator that is neither a constant torque nor drag")
            continue
        turned_by += constant * torque
        if turned_by is torque_body:
            drag = drag - per_velocity * np.outer(torque, torque)
        elif per_velocity:
            others.append("drag along world axes")
    gravity = model.opt.gravity * _is_on(model, "gravity")
    strengths = {"gravity": gravity, "drag": drag}
    return strengths | {"torque_body": torque_body, "torque_world": torque_world}, others


def _joint_damping(model: Any) -> FloatArray:
    """Return the damping coefficients of the body's ω, N m s, (3,); zero if dampers are off."""
    damping: FloatArray = model.dof_damping[_turning(model)] * _is_on(model, "damper")
    return damping


def _turning(model: Any) -> slice:
    """Return the indices of the body's ω in qvel: the last three of the body's velocities."""
    end = _own(model.dof_bodyid)
    return slice(end - 3, end)


def _own(bodies: NDArray[np.integer]) -> int:
    """Return how many joints, or velocities, of a model belong to its first body.

    In MuJoCo's arrays these come before those of other bodies.

    Parameters
    ----------
    bodies : for each joint, or velocity, the index of the body that it moves
    """
    return int(np.count_nonzero(bodies == bodies[0]))


def _joints(model: Any, scenario: Scenario) -> Iterator[str]:
    """Yield "pivot" or "table" if the body's joints, or a contact, implement that effect.

    Descriptions of joints, shapes and damping that the scene does not call for are yielded, too.
    """
    if model.ngeom:
        yield "table" if _rests(model, scenario) else "collision geometry"
        return
    last, constraint = _own(model.jnt_bodyid) - 1, scenario.constraint
    kinds = model.jnt_type[: last + 1].tolist()
    is_free = kinds == [mujoco.mjtJoint.mjJNT_FREE]
    moving = np.eye(3)[~np.array(constraint.is_held)]
    point_body = scenario.body.com - constraint.lever
    place_world = np.array(constraint.place_exact, dtype=float)
    is_held = (
        kinds == [mujoco.mjtJoint.mjJNT_SLIDE] * len(moving) + [mujoco.mjtJoint.mjJNT_BALL]
        and np.array_equal(model.jnt_axis[:last], moving)
        and _same(model.jnt_pos[last], point_body)
        and _same(model.body_pos[BODY], place_world - point_body)
        and np.array_equal(model.body_quat[BODY], (1, 0, 0, 0))
    )
    if is_held:
        yield "pivot" if constraint.is_pivot else "table"
    elif not is_free:
        yield "a joint that is no ball where the scene holds the body"
    if (is_held or is_free) and model.dof_damping[: _turning(model).start].any():
        yield "drag on the translation"


def _same(got: FloatArray, wanted: FloatArray) -> bool:
    """Whether two arrays are equal in the precision of `got`, which was read from the model."""
    return np.array_equal(got, wanted.astype(got.dtype))


def _rests(model: Any, scenario: Scenario) -> bool:
    """Whether the body is free and has a sphere on a plane, as the scene's table demands.

    The contact must be frictionless. The sphere's radius and place, and the plane's height, must be
    those of the scene.
    """
    table = scenario.effects.table
    if table is None:
        return False
    radius, height = sphere_and_plane(scenario)
    return (
        model.jnt_type[: _own(model.jnt_bodyid)].tolist() == [mujoco.mjtJoint.mjJNT_FREE]
        and model.geom_type.tolist() == [mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_SPHERE]
        and model.geom_condim.tolist() == [1, 1]
        and np.array_equal(model.geom_pos, [(0.0, 0.0, height), table.tip])
        and model.geom_size[1, 0] == radius
    )


def _idle_passes(model: Any) -> frozenset[str]:
    """Return descriptions of the parts of a step that are on although nothing needs them."""
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
    """Whether a pass (part of a step) is on; true if MuJoCo has no flag of the given name."""
    return not model.opt.disableflags & disabling().get(name, 0)
