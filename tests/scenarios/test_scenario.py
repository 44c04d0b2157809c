"""A scene as the program sees it: starts converted without loss, effects by name, read-only."""

import pickle

import numpy as np
import pytest
import top_scenes
from case_loops import each_case
from library_scenes import library
from scene_texts import TEXT, scene
from scipy.spatial.transform import Rotation
from spincheck.scenarios import EFFECTS, ScenarioError, loads
from spincheck.scenarios.scenario import started_at, with_tables

EPS = np.finfo(float).eps
ATTITUDE = "euler_zyz_deg = [10.0, 30.0, 20.0]"
OMEGA = "omega_body = [0.5, 1.0, -2.0]"
GRAVITY = "[effects.gravity]\nacceleration = [1.0, 2.0, -9.81]\n"
PIVOT = "[effects.pivot]\n"
DRAG = "[effects.drag]\nrotational = 0.25\n"
TORQUE_BODY = "[effects.torque]\nbody = [0.1, 0.2, 0.3]\n"
TORQUE_WORLD = "[effects.torque]\nworld = [0.1, 0.2, 0.3]\n"


def attitude_of(scenario):
    return Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)


@pytest.mark.parametrize(
    "written",
    [
        "quaternion_wxyz = [0.7071067811865476, 0.0, 0.7071067811865476, 0.0]",
        "rotation_vector_deg = [0.0, 90.0, 0.0]",
        "euler_zyz_deg = [0.0, 90.0, 0.0]",
    ],
    ids=lambda written: written.split()[0],
)
def test_a_quarter_turn_about_y_may_be_written_in_three_ways(written):
    scenario = scene((ATTITUDE, written))
    assert attitude_of(scenario).apply([0, 0, 1]) == pytest.approx([1, 0, 0], abs=2 * EPS)


def test_the_attitude_is_of_unit_norm_however_it_was_typed():
    scenario = scene((ATTITUDE, "quaternion_wxyz = [0.5001, 0.5, 0.5, 0.5]"))
    assert np.linalg.norm(scenario.start.q_world_body_wxyz) == pytest.approx(1, abs=EPS)


def test_omega_world_is_turned_into_body_axes():
    scenario = scene((OMEGA, "omega_world = [0.5, 1.0, -2.0]"))
    world = attitude_of(scenario).apply(np.array(scenario.start.omega_body))
    assert world == pytest.approx([0.5, 1.0, -2.0], abs=8 * EPS)
    assert np.abs(scenario.start.omega_body - [0.5, 1.0, -2.0]).max() > 0.1


def test_euler_rates_are_turned_into_body_axes():
    """α̇ = 2 rad/s at β = 90 deg, γ = 0 is rotation about −x of the body."""
    rates = ("euler_zyz_rates = [2.0, 0.0, 5.0]",)
    scenario = scene((ATTITUDE, "euler_zyz_deg = [0.0, 90.0, 0.0]"), (OMEGA, *rates))
    assert scenario.start.omega_body == pytest.approx([-2.0, 0.0, 5.0], abs=EPS)


@pytest.mark.parametrize(
    ("more", "names"),
    [
        ("", set()),
        (GRAVITY, {"gravity"}),
        (PIVOT, {"pivot"}),
        (DRAG, {"drag"}),
        (TORQUE_BODY, {"torque_body"}),
        (TORQUE_WORLD, {"torque_world"}),
        (GRAVITY + PIVOT + DRAG + TORQUE_BODY, {"gravity", "pivot", "drag", "torque_body"}),
    ],
    ids=["none", "gravity", "pivot", "drag", "torque in body", "torque in world", "four"],
)
def test_a_scene_calls_for_the_effects_it_names(more, names):
    assert scene(more=more).called_for == names
    assert names <= set(EFFECTS)


def test_effects_have_the_values_given():
    scenario = scene(more=GRAVITY + DRAG + TORQUE_BODY)
    assert list(scenario.gravity_world) == [1.0, 2.0, -9.81]
    assert scenario.pushed["drag"] == 0.25
    assert list(scenario.pushed["torque_body"]) == [0.1, 0.2, 0.3]
    assert not scenario.pushed["torque_world"].any()


def test_what_is_not_stated_is_zero_and_what_is_is_kept_to_the_last_bit():
    scenario = scene()
    assert list(scenario.start.omega_body) == [0.5, 1.0, -2.0]
    assert list(scenario.times) == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert scenario.pushed["drag"] == 0
    start = scenario.start
    for at_rest in (start.position_world, start.velocity_world, scenario.gravity_world):
        assert not at_rest.any()
    assert not scenario.pushed["torque_body"].any()


START = ("q_world_body_wxyz", "omega_body", "position_world", "velocity_world")


@pytest.mark.parametrize(
    "values",
    [
        scene().times,
        scene().gravity_world,
        *map(scene().pushed.get, ("torque_body", "torque_world")),
        *(getattr(scene().start, name) for name in START),
    ],
)
def test_arrays_are_read_only(values):
    with pytest.raises(ValueError, match="read-only"):
        values[0] = 5.0


def test_every_scene_comes_whole_out_of_another_process():
    for scenario in library():
        again = pickle.loads(pickle.dumps(scenario))
        assert (again.name, again.document) == (scenario.name, scenario.document)
        assert again.start.q_exact == scenario.start.q_exact
        assert again.start.omega_body_exact == scenario.start.omega_body_exact
        assert again.body.inertia_origin_exact == scenario.body.inertia_origin_exact
        assert not again.start.omega_body.flags.writeable


def test_a_process_that_is_sent_a_scene_again_does_not_build_it_again():
    sent = pickle.dumps(scene())
    assert pickle.loads(sent) is pickle.loads(sent)
    assert pickle.loads(pickle.dumps(scene(more=DRAG))) is not pickle.loads(sent)


#: A change of the text, and whether the motion and the verdicts depend on it.
CHANGES = [
    ("samples = 5\n", "samples = 5  # a comment\n", False, False),
    ('title = "t"', 'title = "u"\ntags = ["v"]\ndescription = "w"', False, False),
    ("mass = 2.0", "mass = 2", False, False),
    ("com = [0.1", 'inertia_about = "com"\ncom = [0.1', False, False),
    (
        "samples = 5\n",
        "samples = 5\n[[published]]\nt = 0\nenergy = 1\ntolerance = 1\nsource = 's'\n",
        *(False, False),
    ),
    ("mass = 2.0", "mass = 2.0000000000000004", True, True),
    ("[0.5, 1.0, -2.0]", "[0.5, 1.0, 2.0]", True, True),
    ("[0.1, 0.2, 0.3]", "[0.1, 0.2, -0.3]", True, True),
    ("samples = 5", "samples = 6", True, True),
    ("samples = 5\n", "samples = 5\n" + DRAG, True, True),
    (
        "samples = 5\n",
        "samples = 5\n[[expect]]\nengine = 'e'\nmethod = 'm'\ntimestep = 0.1\nomega = 1\n",
        *(False, True),
    ),
    (
        "samples = 5\n",
        "samples = 5\n[[known]]\nengine = 'e'\nmethod = 'm'\nverdict = 'disagrees'\nreason = 'r'\n",
        *(False, True),
    ),
]


@pytest.mark.parametrize(("old", "new", "moves", "judged"), CHANGES)
def test_digests_are_of_what_motion_and_verdicts_depend_on(old, new, moves, judged):
    before, after = loads(TEXT, "a"), loads(TEXT.replace(old, new), "b")
    assert after.text != before.text
    assert (after.digest != before.digest) == moves
    assert (after.judged_digest != before.judged_digest) == judged


STATE = {
    "q_world_body_wxyz": (0.5, -0.5, 0.5, 0.5),
    "omega_body": (1.0, 2.0, 3.0),
    "com_world": (4.0, 5.0, 6.0),
    "velocity_world": (7.0, 8.0, 9.0),
}


def test_every_scene_can_be_started_elsewhere_and_reads_back_from_its_text():
    # On a table a body cannot be anywhere.
    for scenario in (scenario for scenario in library() if scenario.effects.table is None):
        moved = started_at(scenario, **STATE)
        assert tuple(moved.start.q_world_body_wxyz) == STATE["q_world_body_wxyz"]
        assert tuple(moved.start.omega_body) == STATE["omega_body"]
        flight = [*moved.start.position_world, *moved.start.velocity_world]
        assert flight == ([0] * 6 if scenario.constraint.is_pivot else [4, 5, 6, 7, 8, 9])
        assert (moved.name, moved.effects) == (scenario.name, scenario.effects)
        assert (moved.carrier, moved.rotors) == (scenario.carrier, scenario.rotors)
        assert moved.window == scenario.window
        assert moved.digest != scenario.digest
        again = loads(moved.text, scenario.name)
        assert (again.document, again.digest) == (moved.document, moved.digest)


def test_on_a_table_a_scene_is_started_where_the_tip_touches_it():
    for scenario in (scenario for scenario in library() if scenario.effects.table is not None):
        start = scenario.start
        q, omega = start.q_world_body_wxyz, start.omega_body
        moved = started_at(scenario, q, omega, (4.0, 5.0, 60.0), (0.7, 0.8, 90.0))
        assert (*moved.start.position_world[:2], *moved.start.velocity_world[:2]) == (
            4,
            5,
            0.7,
            0.8,
        )
        assert moved.start.position_world[2] == pytest.approx(start.position_world[2], rel=1e-15)
        assert loads(moved.text, scenario.name).digest == moved.digest


TABLE = "[effects.table]\nheight = 1.0\ntip = [0.0, 0.0, 0.0]\nradius = 0.0"
ON_A_TABLE = f"{top_scenes.GRAVITY}\n{TABLE}"


def on_a_table(tilt: float, omega: float = 0.0, stated: str = "", effects: str = ON_A_TABLE):
    """A top whose com is half a metre from its tip, 1.25 m up at a tilt of 60°."""
    turned = f"euler_zyz_deg = [0.0, {tilt}, 0.0]\nomega_body = [0.0, {omega}, 0.0]\n"
    return top_scenes.scene(start=turned + stated, effects=effects)


@each_case(
    ("refused", "complaint"),
    [
        ({"tilt": 120.0}, "[effects.table] tip: must touch the table below the centre of mass"),
        ({"tilt": 60.0, "stated": "position = [0.0, 0.0, 1.26]"}, "hangs above the table, by 0.01"),
        ({"tilt": 60.0, "stated": "position = [0.0, 0.0, 1.24]"}, "pierces the table, by 0.01 m"),
        # ω × lever moves the com down at half a metre times sin 60° times ω.
        ({"tilt": 60.0, "omega": 1.0, "stated": "velocity = [0.0, 0.0, 0.0]"}, "by 0.433 m/s"),
        ({"tilt": 60.0, "stated": "velocity = [0.0, 0.0, -0.1]"}, "drives the tip into the table"),
        ({"tilt": 60.0, "omega": 9.0}, "would have to pull at the body with"),
        (
            {"tilt": 60.0, "effects": f"{ON_A_TABLE}\n{top_scenes.PIVOT}"},
            "does not go with a pivot",
        ),
    ],
)
def test_what_does_not_lie_on_its_table_is_refused(refused, complaint):
    with pytest.raises(ScenarioError) as raised:
        on_a_table(**refused)
    assert complaint in str(raised.value)
    # Within a millionth it may be typed in decimals, and is as the tip has it.
    typed = on_a_table(60.0, stated="position = [0.0, 0.0, 1.2500001]").start.position_world
    assert typed.tolist() == on_a_table(60.0).start.position_world.tolist()
    assert typed[2] == pytest.approx(1.25, rel=1e-15)


def test_a_scene_cannot_be_started_from_what_is_no_state():
    with pytest.raises(ValueError, match="must have norm 1"):
        started_at(scene(), **STATE | {"q_world_body_wxyz": (1.0, 1.0, 0.0, 0.0)})
    with pytest.raises(ValueError, match="finite"):
        started_at(scene(), **STATE | {"omega_body": (np.nan, 0.0, 0.0)})


def test_a_scene_with_other_tables_is_another_scene():
    scenario = scene(more=GRAVITY + DRAG)
    undragged = with_tables(scenario, effects=scenario.effects.model_copy(update={"drag": None}))
    assert undragged.called_for == {"gravity"}
    assert undragged.digest == scene(more=GRAVITY).digest != scenario.digest
    assert undragged.body is scenario.body
    assert undragged.start.q_exact == scenario.start.q_exact
