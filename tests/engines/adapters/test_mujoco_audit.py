"""The audit names the effects that act, at their strengths, and whatever else is switched on."""

import mujoco
from case_loops import each_case
from spincheck.engines.adapters.mujoco.audit import acting
from spincheck.engines.models.mjcf import mjcf
from spincheck.suite.contract_scenes import SCENES

TIMESTEP = 1e-3
#: What is written in a model, and what is planted in its place.
Edits = dict[str, str]


def model_of(name: str, edits: Edits | None = None) -> mujoco.MjModel:
    text = mjcf(SCENES[name], TIMESTEP, "RK4")
    for written, planted in (edits or {}).items():
        assert written in text, written
        text = text.replace(written, planted, 1)
    return mujoco.MjModel.from_xml_string(text)


def active(name: str, edits: Edits | None = None) -> frozenset[str]:
    model = model_of(name, edits)
    return acting(model, mujoco.MjData(model), SCENES[name])


def on(*flags: str) -> Edits:
    """Switch on what the scene does not call for."""
    return {f'{flag}="disable"': f'{flag}="enable"' for flag in flags}


def joint(attributes: str) -> Edits:
    return {"<joint ": f"<joint {attributes} "}


def actuated(attributes: str) -> Edits:
    """Add one actuator, and switch actuators on."""
    actuator = f"<actuator><general {attributes}/></actuator>"
    return {"</worldbody>": f"</worldbody>{actuator}"} | on("actuation")


PLANTED: dict[str, Edits] = {
    "automatic reset": on("autoreset"),
    "collision detection": on("contact"),
    "constraint solver": on("constraint"),
    "joint spring pass": on("spring"),
    "joint damper pass": on("damper"),
    "actuator pass": on("actuation"),
    "sensor pass": on("sensor"),
    "solver warm start": on("warmstart"),
    "constraint islands": on("island"),
    "energy computation": {"<flag ": '<flag energy="enable" '},
    "sleeping": {"<flag ": '<flag sleep="enable" '},
    "flag 'diagexact'": {"<flag ": '<flag diagexact="enable" '},
    "gravity": {'gravity="0.0 0.0 0.0"': 'gravity="0 0 -9.81"'} | on("gravity"),
    "drag": joint('damping="1e-6"') | on("damper", "eulerdamp"),
    "torque_body": actuated('joint="joint" gainprm="0" biastype="affine" biasprm="1"'),
    "uneven drag": actuated('joint="joint" gainprm="0" biastype="affine" biasprm="0 0 -1"'),
    "drag along world axes": actuated(
        'jointinparent="joint" gainprm="0" biastype="affine" biasprm="0 0 -1"'
    ),
    "an actuator that is neither a constant torque nor drag": actuated('joint="joint"'),
    "air": {"<option ": '<option density="1.2" '},
    "wind": {"<option ": '<option wind="1 0 0" '},
    "joint springs": joint('stiffness="1"'),
    "joint friction": joint('frictionloss="1e-3"'),
    "joint limits": joint('range="0 1"'),
    "added rotor inertia": joint('armature="1e-3"'),
    "nonlinear damping": joint('damping="0 1e-3"'),
    "gravity compensation": {"<body ": '<body gravcomp="1" '},
    "collision geometry": {"<joint ": '<geom size="0.1" mass="0"/><joint '},
    "a second body": {"<worldbody>": '<worldbody><body name="other"/>'},
    "sensors": {"</worldbody>": '</worldbody><sensor><clock name="clock"/></sensor>'},
    "a joint that is no ball where the scene holds the body": joint('pos="0 0 0.01"'),
}


@each_case(("planted", "edits"), list(PLANTED.items()))
def test_anything_planted_is_named(planted: str, edits: Edits) -> None:
    assert planted not in active("pivot")
    assert planted in active("pivot", edits)


def test_damping_of_a_free_joint_is_named_for_it_brakes_the_translation() -> None:
    damped = '<joint name="joint" type="free" damping="0.3"'
    edits = {'<freejoint name="joint" align="false"': damped} | on("damper", "eulerdamp")
    assert active("free", edits) == {"drag", "drag on the translation"}


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
    disabled = {"<flag ": '<flag gravity="disable" damper="disable" '}
    expected = {"pivot", "torque_world", "implicit joint damping"}
    assert active("everything", disabled) == expected


#: What is told, and the scene in whose model an effect is planted at another strength.
STRENGTHS: dict[str, tuple[str, Edits]] = {
    "gravity of [1.0, -2.0, -9.1], not": ("heavy-tilted", {"-9.0": "-9.1"}),
    "drag of [0.31, 0.31, 0.31], not": ("pivot-drag", {'damping="0.3"': 'damping="0.31"'}),
    "torque_body of [0.4, -0.3, 0.3], not": ("pivot-torque-body", {"0.4 -0.3 0.2": "0.4 -0.3 0.3"}),
    "torque_world of [0.4, -0.3, 0.3], not": (
        *("pivot-torque-world", {"0.4 -0.3 0.2": "0.4 -0.3 0.3"}),
    ),
}


@each_case(("words", "name", "planted"), [(words, *case) for words, case in STRENGTHS.items()])
def test_an_effect_at_another_strength_than_the_scenes_is_reported(
    words: str, name: str, planted: Edits
) -> None:
    (effect,) = active(name, planted) - SCENES[name].called_for
    assert effect.startswith(words)
