"""Wrong published values and effects without influence are reported alike by all commands."""

import re
from pathlib import Path

import pytest
from command_line import spincheck
from library_scenes import library_scene
from spincheck.reports.pages.scene.scene_tables import published_table
from spincheck.scenarios import load

SCENE = """
spincheck = 1
title = "A sphere"
source = "made up"
[body]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
com = [0.0, 0.0, {arm}]
[start]
euler_zyz_deg = [0.0, {tilt}, 0.0]
omega_body = [0.0, 0.0, 3.0]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 1.0
samples = 11
"""
PUBLISHED = """
[[published]]
t = 1.0
omega_body = {{ z = {value} }}
tolerance = 1e-6
source = "a book"
"""
#: Of a table whose plane the body's origin slides on.
TIP = "tip = [0.0, 0.0, 0.0]\nradius = 0.0"
#: By the command, what is asked of it besides the scene.
COMMANDS = {
    "check": (),
    "reference": ("--at", "1"),
    "run": ("--engine", "mujoco", "--method", "RK4", "--quick", "--jobs", "1"),
}


def file_of(folder: Path, value: float | None = None, arm: float = 0.1, tilt: float = 30) -> Path:
    path = folder / "sphere.toml"
    more = PUBLISHED.format(value=value) if value is not None else ""
    path.write_text(SCENE.format(arm=arm, tilt=tilt) + more, encoding="utf-8")
    return path


@pytest.mark.parametrize(("value", "code"), [(3.0, 0), (3.1, 1)])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_published_value_that_does_not_hold_is_reported_alike(tmp_path, command, value, code):
    """One component of three is enough to publish; a report of a run reports it too."""
    asked = [(command, file_of(tmp_path, value), *COMMANDS[command])]
    for words in asked + [("report",)] * (command == "run"):
        done = spincheck(*words, cwd=tmp_path)
        assert done.returncode == code
        wrong = "omega_body at t = 1 s: 3.1 in 'a book', exact 3; they differ by 1.00e-01"
        assert (wrong in done.stderr) == bool(code)
        assert ("ok: " in done.stdout) == (command == "check" and not code)


def test_a_component_that_is_none_is_complained_of_by_its_key(tmp_path):
    path = file_of(tmp_path, 3.0)
    path.write_text(path.read_text().replace("z = 3.0", "w = 3.0"), encoding="utf-8")
    done = spincheck("check", str(path))
    assert done.returncode == 2
    assert "number 1 omega_body" in done.stderr


def test_a_check_says_what_a_scene_cannot_tell(tmp_path):
    words = "cannot tell whether there is gravity"
    assert words in spincheck("check", str(file_of(tmp_path, arm=0.0))).stdout
    assert words in spincheck("check", str(file_of(tmp_path, tilt=0))).stdout
    assert words not in spincheck("check", str(file_of(tmp_path))).stdout


def test_a_check_reports_values_that_do_not_hold_besides_files_that_are_wrong(tmp_path):
    """The exit code is that of a file that is wrong; no finding hides another."""
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(SCENE.format(arm="nan", tilt=0), encoding="utf-8")
    done = spincheck("check", str(file_of(tmp_path, 3.1)), str(wrong))
    assert done.returncode == 2
    assert "wrong.toml:8: [body] com" in done.stderr
    assert "exact 3; they differ by 1.00e-01" in done.stderr


def test_a_check_of_a_scene_without_an_exact_motion_fails_as_a_run_of_it_does(tmp_path):
    text = library_scene("chaos-beyond-the-horizon").path.read_text(encoding="utf-8")
    path = tmp_path / "too-long.toml"
    window = "[window]\nduration = 400.0\nsamples = 3\n"
    path.write_text(re.sub(r"\[window\]\n(?:\w.*\n)+", window, text), encoding="utf-8")
    done = spincheck("check", str(path))
    assert done.returncode == 3
    assert "too-long: no exact motion: no sample but the first is known" in done.stderr


def test_a_value_after_the_end_of_the_exact_motion_is_not_compared_with_another_time(tmp_path):
    """The body leaves its table at 0.03 s; the value printed for 0.5 s is that of the start."""
    path = file_of(tmp_path, 3.0, arm=0.05, tilt=60)
    text = path.read_text().replace("[effects.pivot]", "[effects.table]\nheight = 0.0\n" + TIP)
    text = text.replace("[1.0, 1.0, 1.0]", "[1.6e-3, 1.6e-3, 8e-4]").replace("t = 1.0", "t = 0.5")
    path.write_text(text.replace("[0.0, 0.0, 3.0]", "[0.0, 16.5, 3.0]"), encoding="utf-8")
    done = spincheck("check", str(path))
    assert done.returncode == 3
    assert "3 in 'a book' cannot be compared: the exact motion is not known" in done.stderr
    (row,) = published_table(load(path)).rows
    assert (row[4].text, row[6].text) == ("—", "the exact motion ends before")


def test_a_page_has_a_dash_for_a_component_that_nobody_printed(tmp_path):
    (row,) = published_table(load(file_of(tmp_path, 3.0))).rows
    assert row[2].text == "—, —, 3"
