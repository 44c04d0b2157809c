"""Engines that load the link a scene names out of the user's own file: what they hold and do."""

import re
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library
from spincheck.engines import engines
from spincheck.engines.checks.read_back import BodyReading, start_state, stated_body
from spincheck.engines.users_models import AGREES, MESHES, RigidBody, read_model
from spincheck.engines.users_models import read as of_scene
from spincheck.engines.users_models.model_file import Pose
from spincheck.engines.users_models.urdf import body_alone
from spincheck.reference import solve
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.reports.users_models.scenes import link_scenes
from spincheck.scenarios import Scenario, load
from users_models import TENSOR, arm, body, diagonal, inertial, joint, link, robot, written

pytest.importorskip("pybullet")
FILE_ENGINES = ("mujoco-file", "pybullet-file")
TIMESTEP = 1e-3
STEPS = np.array([0, 100, 200])
BOX = '<collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>'
#: Another body beside it, one on it, a joint, an actuator and a sensor: none is part of the link.
HUNG = """<mujoco><compiler angle="radian" eulerseq="XYZ"/>
<worldbody><body name="base"><geom size="0.1"/>
<body name="arm" pos="1 2 3" euler="0.1 0.2 0.3"><joint name="hinge"/><geom size="0.3"/>
<inertial mass="2" pos="0.1 0 0" euler="0.4 0.2 0.5" diaginertia="0.03 0.04 0.05"/>
<body name="tip"><joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1.2 1.5"/></body>
</body></body></worldbody>
<actuator><motor joint="hinge"/></actuator><sensor><jointpos joint="hinge"/></sensor></mujoco>
"""


def scene_of(folder: Path, text: str, name: str = "robot.urdf", link: str = "arm") -> Scenario:
    """The scene that `import` makes of a link."""
    model = read_model(written(folder, text, name))
    (scene,) = (one for one in link_scenes(model, folder / "scenes") if one.link == link)
    return load(written(folder, scene.text, f"scenes/{scene.name}.toml"))


def run(name: str, scenario: Scenario, method: str = ""):
    engine = engines()[name]
    chosen = engine.method(method) if method else engine.methods[0]
    return engine.run(scenario, chosen, TIMESTEP, STEPS)


@pytest.mark.parametrize("name", FILE_ENGINES)
def test_a_reader_that_holds_another_tensor_fails_with_the_cause(tmp_path, name, monkeypatch):
    """Planted: the file's rotation is lost before the engine reads it."""
    scenario = scene_of(tmp_path, arm())
    module = __import__(type(engines()[name]).__module__, fromlist=["body_alone"])
    cut = module.body_alone

    def unturned(*arguments):
        data, meshes = cut(*arguments)
        return data.replace(b'rpy="0 0 0.5"', b""), meshes

    monkeypatch.setattr(module, "body_alone", unturned)
    done = run(name, scenario)
    assert (done.outcome, done.cause) == ("failed", "read-back")
    assert done.reason == (
        "holds another body than the file states: moments kept, axes turned by 28.6°: "
        "the rotation of its inertial frame is lost"
    )


def test_without_its_flag_an_engine_makes_the_tensor_up_and_that_is_reported(tmp_path):
    done = run("pybullet-file", scene_of(tmp_path, arm(inside=BOX)), "default")
    assert done.cause == "read-back"
    assert done.reason.startswith(
        "holds another body than the file states: made up from the collision shapes: tensor "
    )


def test_a_file_that_changed_after_the_scene_was_read_is_reported(tmp_path):
    scenario = scene_of(tmp_path, arm())
    written(tmp_path, arm(mass="3"))
    done = run("mujoco-file", scenario)
    assert done.outcome == "failed"
    assert done.reason == "'../robot.urdf' has changed since the scene was made of it"


def test_a_link_that_the_file_has_not_is_reported(tmp_path):
    scenario = scene_of(tmp_path, arm())
    text = scenario.text.replace('link = "arm"', 'link = "leg"')
    done = run("mujoco-file", load(written(tmp_path, text, "scenes/leg.toml")))
    assert done.reason == "'../robot.urdf' has no link 'leg'"


def test_of_a_model_whose_total_mass_is_stated_no_link_alone_is_run(tmp_path):
    """What MuJoCo scales all links by follows from all of them."""
    text = HUNG.replace("<worldbody>", '<compiler settotalmass="20"/><worldbody>')
    done = run("mujoco-file", scene_of(tmp_path, text, "robot.xml"))
    assert (done.outcome, done.cause) == ("failed", "body")
    assert done.reason.startswith("the file's compiler option 'settotalmass' scales the mass and ")


def test_none_is_asked_about_scenes_without_a_file_or_of_a_format_that_it_cannot_read(tmp_path):
    asked = {name: engines()[name].applies_to for name in FILE_ENGINES}
    assert not any(applies(scene) for applies in asked.values() for scene in library())
    scenario = scene_of(tmp_path, HUNG, "robot.xml")
    assert [name for name, applies in asked.items() if applies(scenario)] == ["mujoco-file"]


#: An arm with two tools of other axes, one of them on the other; a wheel turns on the arm.
WELDED = robot(
    link("base"),
    *(link(name, inertial() + BOX) for name in ("arm", "tool", "tip", "wheel")),
    joint("base", "arm"),
    joint("arm", "tool", "fixed"),
    joint("tool", "tip", "fixed", '<origin xyz="0.2 0.1 -0.1" rpy="0.4 -0.7 1.1"/>'),
    joint("arm", "wheel"),
)
#: Three tools in a ring about the arm's origin, so that the com is zero but for rounding.
RING = robot(
    link("base"),
    link("arm", inertial(tensor=diagonal(0.03, 0.04, 0.05), origin="")),
    joint("base", "arm"),
    *(
        link(f"tool{k}", inertial(origin='<origin xyz="0.1 0 0"/>'))
        + joint("arm", f"tool{k}", "fixed", f'<origin rpy="0 0 {2 * np.pi * k / 3!r}"/>')
        for k in range(3)
    ),
)
#: The same arm and tool in MJCF, with a hinged body on the tool.
NESTED = """<mujoco><option timestep="0.01"/><worldbody><body name="arm"><freejoint/>
<body name="tool" pos="0.1 0.2 -0.1" euler="20 30 40">
<inertial mass="2" pos="0.1 0 0" euler="40 20 50" diaginertia="0.03 0.04 0.05"/>
<body name="wheel"><joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1.2 1.5"/></body>
</body></body></worldbody></mujoco>
"""


#: A body of a file that the model includes.
INCLUDING = '<mujoco><include file="parts/arm.xml"/></mujoco>'
INCLUDED = body('<inertial mass="2" pos="0 0 0" diaginertia="1 2 2.5"/>')


@each_case(
    ("name", "text", "file"),
    [
        *(
            (name, text, "robot.urdf")
            for name in FILE_ENGINES
            for text in (arm(inside=BOX), WELDED, RING)
        ),
        *(("mujoco-file", text, "robot.xml") for text in (HUNG, NESTED, INCLUDING)),
    ],
)
def test_a_body_moves_as_its_numbers_and_those_of_what_is_welded_to_it_say(
    tmp_path, name, text, file
):
    """Without what hangs on it by a joint."""
    written(tmp_path, INCLUDED, "parts/arm.xml")
    scenario = scene_of(tmp_path, text, file)
    done, engine = run(name, scenario), engines()[name]
    assert (done.outcome, done.reason, done.active) == ("ok", "", frozenset())
    assert physics_in_words(engine, scenario, engine.methods[0]) == ""
    exact = solve(scenario, STEPS * TIMESTEP).trajectory
    # Of order 1: a step is off by the square of the turn it makes.
    turn = float(np.linalg.norm(scenario.start.omega_body)) * TIMESTEP
    assert np.abs(done.trajectory.com_world - exact.com_world).max() <= STEPS[-1] * turn**2
    off = np.abs(done.trajectory.omega_body - exact.omega_body).max()
    assert off <= (AGREES if text is HUNG else STEPS[-1] * turn**2)
    # Planted: the engine is given the host without what is welded to it.
    short = re.sub("(?m)^welded = .*$", "welded = []", scenario.text)
    assert (short != scenario.text) == (text in (WELDED, RING, NESTED))
    if short != scenario.text:
        done = run(name, load(written(tmp_path, short, "scenes/short.toml")))
        assert done.outcome == "failed"


@each_case(("off", "count"), [(1.2, 0), (2.0, 1)])
def test_a_run_takes_the_bodies_that_inspect_takes(tmp_path, off, count):
    """An entry off by more than the threshold of the largest moment, but less of the norm's √3."""
    scenario = scene_of(tmp_path, arm(diagonal(0.03, 0.03, 0.03)))
    body, engine = stated_body(scenario), engines()["mujoco-file"]
    held = BodyReading(body.mass, body.com, body.inertia_com + np.diag([0, 0, off * AGREES * 0.03]))
    found = engine.differences(scenario, "RK4", held, start_state(scenario))
    assert len(found) == count


def test_a_link_is_cut_out_byte_for_byte(tmp_path):
    odd = "<!-- ünïcödé --><inertial>\n <mass value='2.50e0'/>" + (
        f"<inertia {TENSOR}/><origin\txyz='0 0 1'/></inertial><odd:tag a='>'/>"
    )
    text = robot(link("base"), link("arm", odd + BOX), joint("base", "arm"))
    model = read_model(written(tmp_path, text))
    cut, meshes = body_alone(model, RigidBody(((model.link("arm"), Pose()),)))
    assert cut.decode() == f'<robot name="cut"><link name="arm">{odd}</link></robot>'
    assert meshes == {}


def test_of_its_shapes_those_are_kept_that_a_tensor_is_made_up_from(tmp_path):
    mesh = '<collision><geometry><mesh filename="a.obj"/></geometry></collision>'
    written(tmp_path, "mtllib /etc/passwd\nv 0 0 0", "a.obj")
    model = read_model(written(tmp_path, arm(inside=BOX + mesh)))
    cut, meshes = body_alone(model, RigidBody(((model.link("arm"), Pose()),)), MESHES)
    assert BOX.encode() in cut
    assert b'filename="mesh-0.obj"' in cut
    # PyBullet opens the materials that an OBJ file asks for, wherever they are.
    assert meshes == {"mesh-0.obj": b"# /etc/passwd\nv 0 0 0"}


def test_a_file_is_parsed_once_for_all_runs(tmp_path, monkeypatch):
    scenario = scene_of(tmp_path, robot(link("arm", inertial("2", diagonal(1, 2, 2.5)))))
    read = []
    monkeypatch.setattr(of_scene, "read_model", lambda path: read.append(path) or read_model(path))
    for _ in range(3):
        run("mujoco-file", scenario)
    assert len(read) == 1
