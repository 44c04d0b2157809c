"""The command 'inspect' on real engines: output and exit code."""

import json
import re
from types import SimpleNamespace

import pytest
from case_loops import each_case
from spincheck.reports.cli import inspecting as command
from spincheck.reports.cli.app import app
from spincheck.reports.cli.terminal import Complaint
from spincheck.reports.harness.executors import CallFailed, InProcess, LocalWorkers
from spincheck.reports.harness.executors.executor import Answer
from spincheck.reports.users_models import inspection as harness
from spincheck.reports.users_models.mend import Mended
from spincheck.scenarios.errors import is_control
from typer.testing import CliRunner
from users_models import arm, arm_with_a_tool, body, diagonal, written

pytest.importorskip("pybullet")
ROUND = diagonal(0.002, 0.002, 0.003)
KEYS = {
    "engine",
    "engine_version",
    "configuration",
    "mass",
    "com",
    "inertia",
    "agrees",
    "cause",
    "fused",
    "difference",
    "attitude_apart_deg",
}


@pytest.fixture(autouse=True)
def in_process(monkeypatch):
    """Read files in this process; one test checks that it is done in another."""
    monkeypatch.setattr(command, "LocalWorkers", lambda *_: InProcess())


def inspect(*arguments):
    return CliRunner().invoke(app, ["inspect", *map(str, arguments)])


def records(*arguments):
    return json.loads(inspect(*arguments, "--json").stdout)


def held_of(record, name, configuration):
    (one,) = (li for li in record["links"] if li["link"] == name)
    (held,) = (h for h in one["held"] if h["configuration"] == configuration)
    return held


def test_a_faithful_engine_ends_with_exit_code_0(tmp_path):
    text = body('<inertial mass="1" pos="0 0 0" diaginertia="1 2 2.5"/>')
    ended = inspect(written(tmp_path, text, "a.xml"))
    assert ended.exit_code == 0
    assert ended.stdout.endswith("No differences found.\n\n")


def test_json_keeps_its_contract(tmp_path):
    path = written(tmp_path, arm())
    record = records(path)
    assert set(record) == {"file", "links", "summary"}
    assert record["file"] == str(path)
    base, moved = record["links"]
    assert (base["stated"], moved["stated"]["mass"]) == (None, 2)
    for held in moved["held"]:
        assert set(held) == KEYS
    held = held_of(record, "arm", "default")
    assert set(held["difference"]) == {"mass", "com", "inertia", "axes_deg"}
    assert set(held["attitude_apart_deg"]) == {"1", "3"}
    assert held["agrees"] is False
    assert held_of(record, "arm", "inertia-from-file")["agrees"] is True
    assert record["summary"]["held_wrongly"] == {
        "mujoco as-is": 0,
        "mujoco unfused": 0,
        "pybullet default": 2,
        "pybullet inertia-from-file": 1,
    }


def test_welded_links_are_said_to_be_one_body(tmp_path):
    path, one = written(tmp_path, arm_with_a_tool(ROUND)), written(tmp_path, arm(), "one.urdf")
    said = "Welded together, each one body and one scene of 'import':\n  arm, tool: 4 kg, principal"
    assert said in inspect(path).stdout
    # Several files are a list.
    welded, free = records(path, one)
    assert (welded["file"], free["file"]) == (str(path), str(one))
    (whole,) = welded["summary"]["composed"]
    assert (whole["link"], whole["welded"], whole["mass"]) == ("arm", ["tool"], 4.0)
    assert free["summary"]["composed"] == []


def test_what_differs_is_reported_in_words_with_what_to_do(tmp_path):
    """First, what a robot gains by links that state nothing."""
    path = written(tmp_path, arm())
    ended = inspect(path)
    assert ended.exit_code == 1
    assert "pybullet default, arm: made up from the collision shapes: tensor 1/" in ended.stdout
    of_base = "pybullet inertia-from-file, base: held as 1 kg, 1 kg m²: the file states nothing"
    assert of_base in ended.stdout
    assert "load it with flags=pybullet.URDF_USE_INERTIA_FROM_FILE" in ended.stdout
    printed = ended.stdout.splitlines()
    assert printed[1] == (
        "Its links weigh 2 kg together; 3 kg in pybullet default and pybullet inertia-from-file."
    )
    first = printed[printed.index("Bodies that engines hold differently, the worst first:") + 1]
    assert first.startswith("  pybullet default, base: held as 1 kg, ")
    assert records(path)["summary"]["mass"] == {
        "stated": 2.0,
        "added": {"pybullet default": 1.0, "pybullet inertia-from-file": 1.0},
    }


def test_nothing_in_a_file_commands_a_terminal(tmp_path):
    """What XML lets a name hold: a C1 control, and what turns text about."""
    text = arm().replace("arm", "a\x9b31m\u202eb")
    printed = inspect(written(tmp_path, text)).stdout
    assert "a\\x9b31m\\u202eb" in printed
    assert not [c for c in printed if is_control(c) and c not in "\n\t"]


def test_an_impossible_tensor_is_reported_of_file_and_engines(tmp_path):
    path = written(tmp_path, arm(diagonal(0.3, 0.1, 0.9)))
    ended = inspect(path)
    assert ended.exit_code == 1
    assert "arm (line 3): 0.1 + 0.3 < 0.9: no body has it" in ended.stdout
    assert (
        "pybullet inertia-from-file, arm: tensor set to zero: no body has it, 0.1 + 0.3 < 0.9"
        in ended.stdout
    )
    assert "mujoco as-is: MuJoCo refuses the file: inertia must satisfy A + B >= C" in ended.stdout


def test_fused_links_are_compared_with_the_sum_of_their_parts(tmp_path):
    text = arm_with_a_tool(ROUND)
    record = records(written(tmp_path, text), "--engine", "mujoco")
    whole = held_of(record, "arm", "as-is")
    assert (whole["agrees"], whole["fused"], whole["mass"]) == (True, ["tool"], 4)
    assert held_of(record, "tool", "as-is")["cause"] == "fused with 'arm'"
    assert held_of(record, "base", "as-is")["cause"] == "fused with the world: it cannot move"


@each_case(
    ("part", "unread"),
    [
        (
            '<frame pos="1 0 0"><attach model="t" body="arm" prefix="t-"/></frame>',
            "bodies made in arm, as by <attach>, are not read",
        ),
        (
            '<body name="tool" pos="1 0 0"><geom size="0.1"/></body>',
            "the inertia of tool is that of its shapes, not read",
        ),
    ],
)
def test_what_is_fused_with_unread_parts_is_not_compared(tmp_path, part, unread):
    one = '<inertial mass="1" pos="0 0 0" diaginertia="1 1.1 1.2"/>'
    written(tmp_path, body(one), "tool.xml")
    head = '<compiler fusestatic="true"/><asset><model name="t" file="tool.xml"/></asset>'
    path = written(tmp_path, body(f"<freejoint/>{one}{part}", head), "robot.xml")
    record = records(path, "--engine", "mujoco")
    fused, alone = (held_of(record, "arm", name) for name in ("as-is", "unfused"))
    assert (fused["agrees"], fused["cause"], alone["agrees"]) == (None, unread, True)
    ended = inspect(path, "--engine", "mujoco")
    assert re.search(r"arm +1 +unread +ok", ended.stdout)
    assert ended.exit_code == 0
    with pytest.raises(Complaint, match=f"left out: arm: {unread}"):
        command.import_scenes(path, tmp_path / "scenes", ())


def test_a_sum_that_an_engine_gets_wrong_is_reported(tmp_path, monkeypatch):
    """Planted: the engine adds the parts' tensors without their distance."""
    text = arm_with_a_tool(ROUND)
    read = harness.read_held

    def lossy(engine, model, configuration):
        bodies = read(engine, model, configuration)
        if configuration == "as-is":
            bodies["arm"].inertia_com[:] /= 2
        return bodies

    monkeypatch.setattr(harness, "read_held", lossy)
    record = records(written(tmp_path, text), "--engine", "mujoco")
    assert held_of(record, "arm", "as-is")["cause"] == (
        "the sum of its fused parts is wrong: tensor 1/2 of the file's"
    )


def test_an_engine_that_crashes_costs_its_configuration_alone(tmp_path, monkeypatch):
    class Crashing(InProcess):
        def call_at(self, site, function, /, *arguments):
            if arguments[2] == "default":
                return Answer(CallFailed("the worker process was killed by SIGSEGV", "crash"))
            return super().call_at(site, function, *arguments)

    monkeypatch.setattr(command, "LocalWorkers", lambda *_: Crashing())
    path = written(tmp_path, arm())
    assert inspect(path).exit_code == 1
    record = records(path)
    assert held_of(record, "arm", "default")["cause"] == "the worker process was killed by SIGSEGV"
    assert held_of(record, "arm", "inertia-from-file")["agrees"] is True
    assert record["summary"]["refused"] == {
        "pybullet default": "the worker process was killed by SIGSEGV"
    }


@pytest.mark.processes
def test_engines_read_in_a_process_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setattr(command, "LocalWorkers", LocalWorkers)
    record = records(written(tmp_path, arm()))
    assert held_of(record, "arm", "inertia-from-file")["agrees"] is True
    assert record["summary"]["refused"] == {}


def complaint(*arguments):
    ended = inspect(*arguments)
    assert isinstance(ended.exception, Complaint)
    return ended.exception.exit_code, str(ended.exception), ended.stdout


ONE_OF = "'--engine' must be one of mujoco, pybullet, which read model files, or a version of one, "
REFUSED = {
    "a file that nobody can read": (arm(mass="0,5"), (), "'value' of <mass> must be decimal"),
    "no engine": (
        arm(),
        ("--engine", "pybulet"),
        f"{ONE_OF}got 'pybulet'; did you mean 'pybullet'?",
    ),
    "another format": (body("<geom/>"), ("--engine", "pybullet"), "pybullet cannot read MJCF"),
    "no version": (
        arm(),
        ("--engine", "mujoco@new"),
        "'--engine' a version must be like 3.1.6, got 'new'",
    ),
    **{
        f"no package: {value}": (
            arm(),
            ("--package-path", value),
            "'--package-path' takes NAME=DIR with a folder that is there",
        )
        for value in ("made-up", "made-up=/no/such/folder", "=/tmp")
    },
}


@pytest.mark.parametrize(("text", "options", "words"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_inspected_ends_with_exit_code_2(tmp_path, text, options, words):
    name = "a.xml" if text.startswith("<mujoco>") else "robot.urdf"
    code, message, _ = complaint(written(tmp_path, text, name), *options)
    assert code == 2
    assert words in message


def test_a_model_is_mended_beside_itself_and_inspected_again(tmp_path):
    path = written(tmp_path, arm_with_a_tool(diagonal(0.1, 0.1, 0.3)))
    printed = inspect(path, "--mend", tmp_path / "good.urdf", "--nearest", "--compose").stdout
    after = printed[printed.index("good.urdf: ") :]
    rows = {line.split()[0] + line.split()[1]: line.split()[2:] for line in after.splitlines()[4:8]}
    assert rows == {
        "mujocoas-is": ["refused", "0"],
        "mujocounfused": ["refused", "0"],
        "pybulletdefault": ["3", "1"],
        "pybulletinertia-from-file": ["3", "0"],
    }
    assert "  arm: nearest possible tensor, 0.17 of its norm off: moments 0.1333, 0.1333" in after
    # What no file can mend is said.
    assert "  pybullet default, arm: load it with flags=pybullet.URDF_USE_INERTIA" in after
    before, mended = records(path, "--mend", tmp_path / "again.urdf")
    assert (before["file"], mended["file"]) == (str(path), str(tmp_path / "again.urdf"))
    assert [one["names"] for one in mended["changes"]] == [["base"]]
    assert mended["left"][0]["text"].startswith("0.1 + 0.1 < 0.3: no body has it; '--nearest'")
    # Before anything is inspected.
    refused = inspect(path, "--mend", tmp_path / "again.urdf")
    assert refused.stdout == ""
    assert "again.urdf: it exists already; remove it, or" in str(refused.exception)


def test_a_mended_model_that_engines_hold_ends_with_exit_code_0(tmp_path):
    text = body('<inertial mass="1" pos="0 0 0" euler="9 0 0" diaginertia="1 2 2.5"/>')
    path = written(tmp_path, text, "a.xml")
    assert inspect(path, "--mend", tmp_path / "b.xml").exit_code == 0


MENDED_WRONGLY = {
    "elsewhere": (("robot.urdf", "--mend", "x/b.urdf"), "'--mend' writes into the folder of FILE"),
    "two files": (("robot.urdf", "robot.urdf", "--mend", "b.urdf"), "writes one file, got 2"),
    "onto itself": (
        ("robot.urdf", "--mend", "robot.urdf"),
        "it exists already; remove it",
    ),
    "nothing": (("robot.urdf", "--nearest"), "'--nearest', '--made-up' and '--compose' say how"),
}


@each_case(("arguments", "words"), MENDED_WRONGLY)
def test_what_cannot_be_written_ends_with_exit_code_2(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, arm())
    code, message, _ = complaint(*arguments)
    assert code == 2
    assert words in message
    assert path.read_text(encoding="utf-8") == arm()
    assert [one.name for one in tmp_path.iterdir()] == ["robot.urdf"]


def test_no_broken_file_is_left(tmp_path, monkeypatch):
    """Planted: a mended file whose last tag is cut off."""
    broken = Mended(arm().encode()[:-9], [], [])
    monkeypatch.setattr(command, "mended", lambda *_: broken)
    path = written(tmp_path, arm())
    code, message, _ = complaint(path, "--mend", tmp_path / "b.urdf")
    assert (code, message) == (2, f"{tmp_path / 'b.urdf'}:5: not well-formed XML: no element found")
    assert [one.name for one in tmp_path.iterdir()] == ["robot.urdf"]


def test_beside_a_file_that_nobody_can_read_others_are_inspected(tmp_path):
    path = written(tmp_path, arm())
    code, message, printed = complaint(tmp_path / "none.urdf", path, "--json")
    unread = f"{tmp_path / 'none.urdf'}: cannot be read: No such file or directory"
    assert (code, message) == (2, unread)
    assert [one["file"] for one in json.loads(printed)] == [str(path)]


def test_a_version_is_asked_in_its_own_folder(tmp_path, monkeypatch):
    """Without an installation: folder and version are made up."""
    engine = SimpleNamespace(version="3.3.7", site="/where/3.3.7/is")
    monkeypatch.setattr(harness, "versioned", lambda name, say: engine)
    calls = []

    class AtSite(InProcess):
        def call_at(self, site, function, /, *arguments):
            calls.append((site, arguments[0]))
            return super().call(function, *arguments)

    monkeypatch.setattr(command, "LocalWorkers", lambda *_: AtSite())
    record = records(written(tmp_path, arm()), "--engine", "mujoco@3.3.7")
    assert calls == [("/where/3.3.7/is", "mujoco")] * 2
    held = held_of(record, "arm", "as-is")
    assert (held["engine"], held["engine_version"]) == ("mujoco@3.3.7", "3.3.7")
