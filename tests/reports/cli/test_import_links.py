"""The command 'import': scenes of links, what was left out, and the file they are from."""

from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.users_models import read_model, users_link
from spincheck.reports.cli.app import app
from spincheck.reports.cli.choosing import _applying
from spincheck.reports.cli.inspecting import import_scenes
from spincheck.reports.cli.terminal import Complaint
from spincheck.scenarios import ScenarioError, load
from typer.testing import CliRunner
from users_models import arm, diagonal, inertial, joint, link, robot, written

pytest_plugins = ["pytester"]
BAD = inertial("1", diagonal(0.3, 0.1, 0.9))
ODD = robot(
    link("base"),
    link("fore arm", inertial()),
    link("fore/arm", inertial()),
    link("bad", BAD),
    *(joint("base", name) for name in ("fore arm", "fore/arm", "bad")),
)


def imported(tmp_path, text=ODD, links=()):
    path = written(tmp_path, text, "robots/robot.urdf")
    return path, import_scenes(path, tmp_path / "scenes", links)


def test_a_link_becomes_a_scene_with_the_files_numbers_about_its_middle_axis(tmp_path):
    path, (line, unmade) = imported(tmp_path, arm())
    scene = load(line)
    stated = read_model(path).link("arm").stated
    assert (scene.body.mass, scene.body.com.tolist()) == (stated.mass, stated.com.tolist())
    assert (scene.body.inertia_com == stated.inertia_com).all()
    assert scene.title == "arm of robot.urdf: tumbles"
    assert scene.document.body.model == "../robots/robot.urdf"
    assert unmade == "left out: base: the file states no inertia of it"
    spin = scene.start.omega_body / np.linalg.norm(scene.start.omega_body)
    moment = spin @ scene.body.inertia_com @ spin
    assert moment == pytest.approx(scene.body.principal_moments[1], rel=0.01)


def test_names_are_made_such_as_files_may_have_and_what_no_body_has_is_left_out(tmp_path):
    _, lines = imported(tmp_path)
    names = [line.rpartition("/")[2] for line in lines if line.endswith(".toml")]
    assert names == ["fore-arm.toml", "fore-arm-2.toml"]
    assert "left out: bad: 0.1 + 0.3 < 0.9: no body has it" in lines


def test_welded_links_are_one_scene_with_the_sum_of_their_numbers(tmp_path):
    """Two halves 2 m apart, in axes of their own, as one body: by hand."""
    half = inertial("1", diagonal(0.1, 0.1, 0.1), origin="")
    text = robot(
        link("base"), link("arm", half), link("tool", half), joint("base", "arm"),
        joint("arm", "tool", "fixed", '<origin xyz="2 0 0" rpy="0.3 0.4 0.5"/>'),
    )  # fmt: skip
    path, (line, _) = imported(tmp_path, text)
    assert line.endswith("arm.toml: arm with tool, welded to it: one body")
    scene = load(line.partition(":")[0])
    assert (scene.body.mass, scene.body.com.tolist()) == (2.0, [1.0, 0.0, 0.0])
    rounding = 8 * np.finfo(float).eps
    wanted = np.diag([0.2, 2.2, 2.2])
    assert np.abs(scene.body.inertia_com - wanted).max() <= rounding * wanted.max()
    assert scene.document.body.welded == ("tool",)
    # A part may be named too.
    out = tmp_path / "one"
    assert import_scenes(path, out, ["tool"]) == [line.replace(str(tmp_path / "scenes"), str(out))]


def test_one_link_can_be_asked_for(tmp_path):
    assert [line[-13:] for line in imported(tmp_path, links=("fore arm",))[1]] == ["fore-arm.toml"]


NONE = robot(
    link("base"),
    link("bad", BAD),
    link("hand"),
    joint("base", "bad"),
    joint("bad", "hand"),
)
WELDED = robot(link("arm", inertial()), link("bad", BAD), joint("arm", "bad", "fixed"))


@pytest.mark.parametrize(
    ("text", "links", "message"),
    [
        (ODD, ("none",), "there is no link 'none'"),
        (ODD, ("bad",), "no link makes a scene; left out: bad: "),
        (
            NONE,
            (),
            r"left out: base, hand: the file states no .*; left out: bad: .* no body",
        ),
        (WELDED, (), r"0\.1 \+ 0\.3 < 0\.9: no body has it \(of bad, welded to"),
    ],
)
def test_a_link_without_a_scene_is_a_complaint(tmp_path, text, links, message):
    with pytest.raises(Complaint, match=message):
        imported(tmp_path, text, links)


def test_complaints_have_paths_on_one_line(tmp_path):
    odd = written(tmp_path, arm(), "robot\nall is well.urdf")
    plain, out = written(tmp_path, arm()), tmp_path / "scenes\nall is well"
    import_scenes(plain, out, ())
    for file, links in ((odd, ("leg",)), (odd, ()), (plain, ())):
        with pytest.raises(Complaint, match=r"(robot|scenes)\\nall is well") as raised:
            import_scenes(file, out, links)
        assert "\n" not in str(raised.value)


def test_a_scene_that_is_there_is_not_written_over(tmp_path):
    _, (line, _) = imported(tmp_path, arm())
    Path(line).write_text("mine", encoding="utf-8")
    more = robot(link("base"), link("leg", inertial()), link("arm", inertial()))
    joints = joint("base", "leg") + joint("base", "arm")
    there = r"arm\.toml: a scene of that name exists already; remove it, or"
    with pytest.raises(Complaint, match=there):
        imported(tmp_path, more.replace("</robot>", f"{joints}</robot>"))
    assert Path(line).read_text(encoding="utf-8") == "mine"
    # Nor is anything else written then.
    assert [path.name for path in Path(line).parent.iterdir()] == ["arm.toml"]


def test_a_scene_finds_its_model_from_where_symbolic_links_lead(tmp_path):
    """A link to the folder of the scenes, and one in the path of the model."""
    (tmp_path / "a/b/scenes").mkdir(parents=True)
    (tmp_path / "to-scenes").symlink_to(tmp_path / "a/b/scenes")
    written(tmp_path, arm(), "a/b/robot.urdf")
    for model in ("a/b/robot.urdf", "to-scenes/../robot.urdf"):
        for out in ("to-scenes/x", "other/x"):
            line, _ = import_scenes(tmp_path / model, tmp_path / out, ())
            assert users_link(load(line)).model.data == arm().encode()
            Path(line).unlink()


def test_an_origin_is_given_whole(tmp_path):
    _, (line, _) = imported(tmp_path, arm())
    kept = Path(line).read_text(encoding="utf-8").splitlines()
    text = "\n".join(li for li in kept if not li.startswith("sha256"))
    scene = written(tmp_path, text, "scenes/half.toml")
    with pytest.raises(ScenarioError, match=r"\[body\]: 'link', 'model' needs 'sha256' too"):
        load(scene)


def test_a_model_that_changed_or_is_gone_is_an_error_that_says_so(tmp_path):
    path, (line, _) = imported(tmp_path, arm())
    path.write_text(arm(mass="3"), encoding="utf-8")
    changed = r"arm\.toml:\d+: \[body\] sha256: .* has changed since"
    with pytest.raises(ScenarioError, match=changed):
        load(line)
    ended = CliRunner().invoke(app, ["run", line, "--out", str(tmp_path / "results.sqlite")])
    assert isinstance(ended.exception, Complaint)
    assert ended.exception.exit_code == 2
    message = str(ended.exception)
    assert "'../robots/robot.urdf' has changed since this scene was made" in message
    # A scene may name any file: what its bytes are is not told.
    assert sha256(path.read_bytes()).hexdigest() not in message
    path.unlink()
    with pytest.raises(ScenarioError, match=r"\[body\] model: .*robot\.urdf: cannot be read"):
        load(line)


def test_a_run_asks_engines_of_users_files_only_where_a_scene_names_one(tmp_path):
    _, (line, _) = imported(tmp_path, arm())
    of_file = {name for name, engine in engines().items() if engine.of_file}
    assert of_file <= {engine.name for engine in _applying([load(line)])}
    assert not of_file & {engine.name for engine in _applying([library_scene("fast-top")])}
    out = str(tmp_path / "results.sqlite")
    ended = CliRunner().invoke(app, ["run", "fast-top", "--engine", "mujoco-file", "--out", out])
    assert str(ended.exception).startswith(
        "'--engine' mujoco-file loads links of users' files, and no scene here names one"
    )


@pytest.mark.needs_pybullet
def test_pytest_has_an_item_a_link_and_engine(pytester):
    path = written(pytester.path, arm())
    import_scenes(path, pytester.path / "scenes", ())
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider", "--collect-only", "-q")
    result.stdout.fnmatch_lines(["*::mujoco-file-RK4", "*::pybullet-file-inertia-from-file"])
    result.stdout.no_fnmatch_line("*::pybullet-file-default")
