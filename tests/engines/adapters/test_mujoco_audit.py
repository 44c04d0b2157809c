"""The audit names the effects that act, at their strengths, and whatever else is switched on."""

import xml.etree.ElementTree as ET
from collections.abc import Callable

import mujoco
from case_loops import each_case
from spincheck.engines.adapters.mujoco.audit import acting
from spincheck.engines.models.mjcf import mjcf
from spincheck.suite.contract_scenes import SCENES

TIMESTEP = 1e-3
Edit = Callable[[ET.Element], None]


def model_of(name: str, edit: Edit | None = None) -> mujoco.MjModel:
    root = ET.fromstring(mjcf(SCENES[name], TIMESTEP, "RK4"))
    if edit is not None:
        edit(root)
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


def active(name: str, edit: Edit | None = None) -> frozenset[str]:
    model = model_of(name, edit)
    return acting(model, mujoco.MjData(model), SCENES[name])


def having(path: str, **attributes: str) -> Edit:
    """Set attributes of the element at `path`."""

    def edit(root: ET.Element) -> None:
        element = root.find(path)
        assert element is not None
        element.attrib.update(attributes)

    return edit


def adding(path: str, xml: str) -> Edit:
    """Add children to the element at `path`."""

    def edit(root: ET.Element) -> None:
        element = root if path == "." else root.find(path)
        assert element is not None
        element.insert(0, ET.fromstring(xml))

    return edit


def both(first: Edit, second: Edit) -> Edit:
    def edit(root: ET.Element) -> None:
        first(root)
        second(root)

    return edit


def actuated(attributes: str) -> Edit:
    """Add one actuator, and switch actuators on."""
    return both(
        adding(".", f"<actuator><general {attributes}/></actuator>"),
        having(FLAG, actuation="enable"),
    )


BODY, JOINT, FLAG = "worldbody/body", "worldbody/body/joint", "option/flag"
PLANTED: dict[str, Edit] = {
    "automatic reset": having(FLAG, autoreset="enable"),
    "collision detection": having(FLAG, contact="enable"),
    "constraint solver": having(FLAG, constraint="enable"),
    "joint spring pass": having(FLAG, spring="enable"),
    "joint damper pass": having(FLAG, damper="enable"),
    "actuator pass": having(FLAG, actuation="enable"),
    "sensor pass": having(FLAG, sensor="enable"),
    "solver warm start": having(FLAG, warmstart="enable"),
    "constraint islands": having(FLAG, island="enable"),
    "energy computation": having(FLAG, energy="enable"),
    "sleeping": having(FLAG, sleep="enable"),
    "flag 'diagexact'": having(FLAG, diagexact="enable"),
    "gravity": both(having("option", gravity="0 0 -9.81"), having(FLAG, gravity="enable")),
    "drag": both(having(JOINT, damping="1e-6"), having(FLAG, damper="enable", eulerdamp="enable")),
    "torque_body": actuated('joint="joint" gainprm="0" biastype="affine" biasprm="1"'),
    "uneven drag": actuated('joint="joint" gainprm="0" biastype="affine" biasprm="0 0 -1"'),
    "drag along world axes": actuated(
        'jointinparent="joint" gainprm="0" biastype="affine" biasprm="0 0 -1"'
    ),
    "an actuator that is neither a constant torque nor drag": actuated('joint="joint"'),
    "air": having("option", density="1.2"),
    "wind": having("option", wind="1 0 0"),
    "joint springs": having(JOINT, stiffness="1"),
    "joint friction": having(JOINT, frictionloss="1e-3"),
    "joint limits": having(JOINT, range="0 1"),
    "added rotor inertia": having(JOINT, armature="1e-3"),
    "nonlinear damping": having(JOINT, damping="0 1e-3"),
    "gravity compensation": having(BODY, gravcomp="1"),
    "collision geometry": adding(BODY, '<geom size="0.1" mass="0"/>'),
    "a second body": adding("worldbody", '<body name="other"/>'),
    "sensors": adding(".", '<sensor><clock name="clock"/></sensor>'),
    "a joint that is no ball where the scene holds the body": having(JOINT, pos="0 0 0.01"),
}


@each_case(("planted", "edit"), list(PLANTED.items()))
def test_anything_planted_is_named(planted: str, edit: Edit) -> None:
    assert planted not in active("pivot")
    assert planted in active("pivot", edit)


def test_damping_of_a_free_joint_is_named_for_it_brakes_the_translation() -> None:
    def edit(root: ET.Element) -> None:
        body = root.find(BODY)
        assert body is not None
        freejoint = body.find("freejoint")
        assert freejoint is not None
        freejoint.tag = "joint"
        freejoint.attrib.clear()
        freejoint.attrib.update(name="joint", type="free", damping="0.3")
        having(FLAG, damper="enable", eulerdamp="enable")(root)

    assert active("free", edit) == {"drag", "drag on the translation"}


def test_forces_applied_to_the_data_are_named() -> None:
    model = model_of("pivot")
    data = mujoco.MjData(model)
    data.qfrc_applied[0] = 1e-6
    assert acting(model, data, SCENES["pivot"]) == {"pivot", "applied forces"}


def test_a_callback_somebody_installed_in_the_process_is_named() -> None:
    mujoco.set_mjcb_passive(lambda model, data: None)
    try:
        assert active("pivot") == {"pivot", "callback passive"}
    finally:
        mujoco.set_mjcb_passive(None)


def test_an_effect_that_is_disabled_reads_back_as_absent() -> None:
    planted = having(FLAG, gravity="disable", damper="disable")
    expected = {"pivot", "torque_world", "implicit joint damping"}
    assert active("everything", planted) == expected


#: What is told, the scene, and the element of its model that is planted in.
STRENGTHS: dict[str, tuple[str, Edit]] = {
    "gravity of [1.0, -2.0, -9.1], not": ("heavy-tilted", having("option", gravity="1 -2 -9.1")),
    "drag of [0.31, 0.31, 0.31], not": ("pivot-drag", having(JOINT, damping="0.31")),
    **{
        f"{torque} of [0.4, -0.3, 0.3], not": (
            *(f"pivot-{torque.replace('_', '-')}", having("actuator/general", gear="0.4 -0.3 0.3")),
        )
        for torque in ("torque_body", "torque_world")
    },
}


@each_case(("words", "name", "planted"), [(words, *case) for words, case in STRENGTHS.items()])
def test_an_effect_at_another_strength_than_the_scenes_is_reported(
    words: str, name: str, planted: Edit
) -> None:
    (effect,) = active(name, planted) - SCENES[name].called_for
    assert effect.startswith(words)
