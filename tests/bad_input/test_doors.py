"""A bad scene in every command that reads scenes: one complaint, exit code 2, no traceback."""

import os

import pytest
from mutated_scenes import LEAST, Raw, changed, written
from spincheck.reports.cli.app import app
from spincheck.reports.cli.terminal import BAD_INPUT, Complaint
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

GOOD = written(LEAST)
BAD = {
    "a negative mass": written(changed(LEAST, ("body", "mass"), -1.0)),
    "a spin of 1e300": written(changed(LEAST, ("start", "omega_body"), [0.0, 0.0, 1e300])),
    "cut short": GOOD[: len(GOOD) // 2],
    "a key twice": GOOD + "samples = 5\n",
    "an unknown engine": GOOD
    + '[[expect]]\nengine = "x"\nmethod = "RK4"\ntimestep = 0.1\nomega = 1.0\n',
    "an unknown method": GOOD
    + '[[expect]]\nengine = "mujoco"\nmethod = "x"\ntimestep = 0.1\nomega = 1.0\n',
    "an escape": written(changed(LEAST, ("title",), Raw(r'"\u001b[31m"'))),
}
DOORS = {
    "check": ["check", "bad.toml"],
    "show": ["show", "bad.toml"],
    "reference": ["reference", "bad.toml"],
    "run": ["run", "bad.toml"],
    "run a folder": ["run", "."],
    "export": ["export", "bad.toml", "models"],
    "recommend": ["recommend", "bad.toml", "--omega", "1e-3"],
    "list": ["list", "."],
    "check a folder": ["check", "."],
}
#: All read scenes alike: each meets a scene that is none, and what is promised of an engine that
#: there is not; one of them meets every kind of bad scene.
MET = [(door, kind) for door in DOORS for kind in ("a negative mass", "an unknown engine")]
MET += [("check", kind) for kind in BAD if ("check", kind) not in MET]
#: These look at a scene alone, not at what it promises of engines.
PHYSICS_ALONE = ("show", "reference", "export", "list")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "good.toml").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("door", "kind"), MET)
def test_a_bad_scene_is_one_complaint_with_its_place(folder, door, kind):
    (folder / "bad.toml").write_text(BAD[kind])
    result = CliRunner().invoke(app, DOORS[door])
    if "[[expect]]" in BAD[kind] and door in PHYSICS_ALONE:
        assert result.exit_code == 0
        return
    assert isinstance(result.exception, Complaint)
    assert result.exception.exit_code == BAD_INPUT
    (line,) = str(result.exception).splitlines()
    assert line.startswith("bad.toml:")
    assert line.isprintable()
    assert {entry.name for entry in folder.iterdir()} == {"good.toml", "bad.toml"}


@pytest.mark.parametrize("door", ["list", "check a folder"])
def test_the_other_scenes_of_a_folder_are_still_named(folder, door):
    (folder / "bad.toml").write_text(BAD["a negative mass"])
    result = CliRunner().invoke(app, DOORS[door])
    assert "good" in result.stdout
    assert "bad" not in result.stdout


def test_every_bad_file_of_a_folder_is_named_before_a_run_is_begun(folder):
    for name in ("bad-1", "bad-2"):
        (folder / f"{name}.toml").write_text(BAD["a negative mass"])
    result = CliRunner().invoke(app, ["run", "."])
    lines = str(result.exception).splitlines()
    assert [line.split(":")[0] for line in lines] == ["bad-1.toml", "bad-2.toml"]
    assert not (folder / "spincheck.sqlite").exists()


NOT_FILES = {
    "a pipe": (os.mkfifo, "cannot be read: it is not a regular file"),
    "a folder": (lambda path: path.mkdir(), ""),
    "a loop of links": (lambda path: path.symlink_to(path), "neither a file, a folder, nor"),
    "nothing": (lambda path: None, "neither a file, a folder, nor a scene"),
    "a device that never ends": (
        lambda path: path.symlink_to("/dev/zero"),
        "cannot be read: it is not a regular file",
    ),
    "no text": (lambda path: path.write_bytes(b"\xff\xfe\x00"), "not a text file in UTF-8"),
}


@pytest.mark.parametrize(("make", "words"), NOT_FILES.values(), ids=NOT_FILES)
def test_what_is_no_file_is_reported_and_not_waited_for(folder, make, words):
    make(folder / "bad.toml")
    for door in ("show", "run"):
        result = CliRunner().invoke(app, DOORS[door])
        assert isinstance(result.exception, Complaint)
        assert result.exception.exit_code == BAD_INPUT
        assert str(result.exception).startswith("bad.toml: ")
        assert words in str(result.exception)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32", "utf-8-sig"])
def test_an_encoding_is_read_or_refused(folder, encoding):
    (folder / "bad.toml").write_text(GOOD, encoding=encoding)
    result = CliRunner().invoke(app, DOORS["check"])
    assert (result.exit_code == 0) == (encoding == "utf-8-sig")
    assert encoding == "utf-8-sig" or "UTF-8" in str(result.exception)


def test_lines_may_end_as_on_windows(folder):
    (folder / "bad.toml").write_bytes(GOOD.replace("\n", "\r\n").encode())
    assert CliRunner().invoke(app, DOORS["check"]).exit_code == 0
