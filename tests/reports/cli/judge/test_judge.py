"""`spincheck judge`: what it prints of a recorded motion, as JSON, and its exit codes."""

import json
from functools import partial

import numpy as np
import pytest
import spincheck as interface
from command_line import ended


@pytest.fixture
def recorded(tmp_path):
    """Write motions into an empty folder; returns the command that judges there."""
    states = interface.exact("fast-top").at(np.linspace(0, 1, 201))

    def write(name, omega, header=""):
        table = np.column_stack([states.t, states.q_world_body_wxyz, omega])
        heads = "t,qw,qx,qy,qz,wx,wy,wz"
        np.savetxt(tmp_path / name, table, delimiter=",", header=f"{header}{heads}", comments="")

    write("exact.csv", states.omega_body)
    write("world.csv", states.omega_world)
    write("stated.csv", states.omega_world, "# omega = world\n")

    return partial(ended, "judge", "fast-top", cwd=tmp_path)


def test_an_exact_motion_is_found_exact(recorded):
    code, out, _ = recorded("exact.csv", "--json")
    (file,) = json.loads(out)["files"]
    assert code == 0
    assert file["file"] == "exact.csv"
    assert file["attitude_error"] < 1e-13
    assert (file["exceeds_1deg_at"], file["explained_by"]) == (None, [])
    assert file["defect"]["omega"]["max"] < 1e-13


def test_frames_are_read_from_the_file_or_a_flag_and_a_mistake_is_named_and_fails(recorded):
    for arguments in (("stated.csv",), ("world.csv", "--omega", "world")):
        code, out, _ = recorded(*arguments)
        assert (code, "Explained by" in out) == (0, False)
    code, out, _ = recorded("world.csv")
    assert (code, "Explained by: ω is in world axes (state 'omega = world')." in out) == (1, True)


def test_a_recording_in_the_scenes_place_is_said_to_be_there(tmp_path):
    code, _, err = ended("judge", "exact.csv", "scene.toml", cwd=tmp_path)
    assert code == 2
    assert "exact.csv: a recording; the scene comes first, then its recordings" in err


@pytest.mark.parametrize(("bound", "code"), [("omega=1e-3", 0), ("attitude=1e-20deg", 1)])
def test_bounds_fail_where_they_are_exceeded(recorded, bound, code):
    exit_code, out, _ = recorded("exact.csv", "--fail-above", bound)
    assert (exit_code, "exact.csv: " in out and " is off by " in out) == (code, bool(code))


def test_a_page_shows_the_files_as_the_runs_of_one_method(recorded, tmp_path):
    code, _, err = recorded("world.csv", "--out", "page")
    assert (code, err.split()) == (1, ["page/scenes/fast-top.html"])
    page = (tmp_path / "page/scenes/fast-top.html").read_text(encoding="utf-8")
    assert "The recorded motion at 5 ms is off by " in page
    assert "What the files show" in page
    assert "recommended" not in page
    assert "ω is in world axes" in page
    assert "a verdict takes 3 files at halved timesteps or more" in page


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.csv",), "none.csv: cannot be read: No such file or directory"),
        (("exact.csv", "--omega", "wrld"), "'--omega' must be body or world, got 'wrld'"),
        (("exact.csv", "--fail-above", "tilt=1"), "must begin with one of omega, attitude"),
        (
            ("exact.csv", "--fail-above", "spins=1"),
            "exact.csv: 'spins' cannot be checked: it was not",
        ),
        (("exact.csv", "--fail-above", "omega"), "must be SIGNAL=SIZE, such as omega=1e-3"),
        (("exact.csv", "--fail-above", "attitude=five"), "attitude=1e-3, got 'attitude=five'"),
        (("exact.csv", "--timestep", "1", "--timestep", "2"), "once for each file, got 2 for 1"),
        (("exact.csv", "--timestep", "nan"), "'timestep' must be a positive number of seconds"),
        (("exact.csv", "--timestep", "0"), "'timestep' must be a positive number of seconds"),
        (("exact.csv", "--timestep", "-1"), "'timestep' must be a positive number of seconds"),
        (("exact.csv", "stated.csv"), "timesteps must be halved from file to file"),
    ],
)
def test_what_cannot_be_judged_is_one_message(recorded, arguments, words):
    code, _, err = recorded(*arguments)
    assert (code, words in err, err.count("\n")) == (2, True, 1)
