"""The command line: what it prints, its exit codes, one message for each complaint."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ET
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import small_result_file
from command_line import ended
from library_scenes import library_scene
from scene_texts import sphere_text
from spincheck import exact, load
from spincheck.reports.cli import stopping
from spincheck.reports.cli.scenes.scene import EXPORTED_TURN
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.scenarios.fastest_rate import fastest_rate

pytestmark = pytest.mark.slow

SPHERE = sphere_text((0.0, 1.0, 2.0), samples=5, tilt_deg=30.0)


@pytest.fixture
def spincheck(tmp_path):
    """Run the command in an empty folder."""
    return partial(ended, cwd=tmp_path)


@pytest.fixture
def sphere(tmp_path):
    path = tmp_path / "sphere-here.toml"
    path.write_text(SPHERE)
    return path


@pytest.mark.processes
@pytest.mark.parametrize("module", ["spincheck", "spincheck.reports.cli.app"])
def test_the_interface_and_help_need_no_heavy_imports(module):
    program = (
        f"import sys; import {module};"
        "print([m for m in ('numpy', 'numba', 'mujoco', 'pybullet', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_check_accepts_a_good_file_and_names_what_is_wrong_with_another(spincheck, sphere):
    code, out, _ = spincheck("check", sphere)
    assert code == 0
    assert "A spinning sphere: 1 kg, z axis 30° from the world's, 2.236 rad/s (21.35 rpm)\n" in out
    sphere.write_text(SPHERE.replace("mass = 1.0", "mass = -1.0"))
    line = SPHERE.splitlines().index("mass = 1.0") + 1
    code, _, err = spincheck("check", sphere)
    assert code == 2
    assert f"{sphere}:{line}: [body] mass: must be greater than 0, got -1.0" in err


def test_list_names_scenes_show_gives_the_body_and_engines_the_methods(spincheck, sphere):
    code, out, _ = spincheck("list", "--json")
    assert code == 0
    assert "tennis-racket" in {scene["scene"] for scene in json.loads(out)}
    _, out, _ = spincheck("show", sphere, "--json")
    assert json.loads(out)["principal_moments"] == [1.0, 1.0, 1.0]
    _, out, _ = spincheck("engines", "--json")
    orders = {(e["engine"], e["method"]): e["order"] for e in json.loads(out)["engines"]}
    assert orders[("mujoco", "RK4")] == 4
    assert orders[("mujoco", "Euler")] == 1


def test_reference_prints_states_at_the_times_asked_for(spincheck, sphere):
    code, out, _ = spincheck("reference", sphere, "--at", 1, "--at", 0.5, "--json")
    exact = json.loads(out)
    assert code == 0
    assert [state["t"] for state in exact["states"]] == [0.5, 1.0]
    assert exact["states"][1]["omega_body"] == [0.0, 1.0, 2.0]
    assert exact["states"][1]["energy"] == pytest.approx(2.5, rel=1e-15)


def test_derivatives_are_printed_with_all_digits_and_exported(spincheck, sphere, tmp_path):
    code, out, _ = spincheck("reference", sphere, "--at", 0.5, "--sensitivities", "--json")
    assert code == 0
    printed = json.loads(out)["sensitivities"]
    found = exact(sphere).sensitivity(0.5)
    assert printed["t"] == [0.5]
    assert printed["state_transition"] == found.state_transition.tolist()
    assert printed["inertia"] == found.inertia.tolist()
    assert printed["translation"]["com"] == found.translation["com"].tolist()
    assert printed["uncertainty"] == found.uncertainty
    assert "gravity" not in printed
    code, out, _ = spincheck("reference", sphere, "--at", 0.5, "--sensitivities")
    assert code == 0
    assert all(label in out for label in ("attitude x", "Ixy", "com z", "velocity y", "moment 3"))
    assert spincheck("export", sphere, "out", "--truth", "--sensitivities")[0] == 0
    written = json.loads((tmp_path / "out/sensitivities.json").read_text("utf-8"))
    assert len(written["t"]) == len(written["state_transition"]) == load(sphere).window.samples


def test_export_writes_files_whose_timestep_resolves_the_fastest_rate(spincheck, tmp_path):
    """The wheel turns its satellite far more slowly than itself, and faster than the start's ω."""
    satellite = library_scene("satellite-and-its-wheel")
    rate = fastest_rate(satellite, satellite.start.omega_body)
    assert rate > np.linalg.norm(satellite.start.omega_body)
    assert spincheck("export", satellite.name, "out")[0] == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"scene.xml", "scene.urdf"}
    (option,) = ET.parse(tmp_path / "out/scene.xml").iter("option")
    assert float(option.attrib["timestep"]) == pytest.approx(EXPORTED_TURN / rate)


def test_no_file_is_written_over_but_those_that_spincheck_has_written(spincheck, tmp_path):
    run = ("--engine", "mujoco", "--method", "RK4", "--timestep", 0.01)
    last_files = {
        "scene.urdf": ("export", "hammer", "out"),
        "sensitivities.json": ("export", "hammer", "out", "--truth", "--sensitivities"),
        "run.py": ("reproduce", "hammer", *run, "--out", "out/run.py"),
    }
    (tmp_path / "out").mkdir()
    for name, words in last_files.items():
        for _ in range(2):
            assert spincheck(*words)[0] == 0
        for path in (tmp_path / "out").iterdir():
            path.unlink()
        path = tmp_path / "out" / name
        path.write_text("mine", encoding="utf-8")
        code, out, err = spincheck(*words)
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert f"{name}: exists already, and spincheck has not written it; remove it" in err
        # Nothing is written before the complaint, either.
        assert [one.read_text(encoding="utf-8") for one in path.parent.iterdir()] == ["mine"]


def test_what_a_method_cannot_simulate_it_cannot_at_any_timestep(spincheck):
    pytest.importorskip("pybullet")
    words = ("--engine", "pybullet", "--method", "maximal", "--timestep", 0.01, "--json")
    _, out, _ = spincheck("run", "wheel-in-a-box", *words)
    (verdict,) = json.loads(out)["verdicts"]
    assert verdict["reason"] == "pybullet maximal cannot simulate rotors"


def test_run_judges_stores_and_prints_and_an_unmet_expectation_exits_with_1(
    spincheck, sphere, tmp_path
):
    run = ("run", sphere, "--engine", "mujoco", "--method", "RK4")
    code, out, err = spincheck(*run)
    assert (code, "converges" in out) == (0, True)
    assert "results are in" in err.lower()
    assert (tmp_path / "spincheck.sqlite").exists()
    promise = '[[expect]]\nengine = "mujoco"\nmethod = "RK4"\ntimestep = 0.01\nattitude = 1e-300\n'
    sphere.write_text(SPHERE + promise)
    code, out, _ = spincheck(*run)
    assert code == 1
    assert "attitude error" in out


@pytest.mark.processes
def test_an_engine_whose_package_is_missing_is_named_and_exits_with_3(tmp_path):
    program = (
        "import sys; sys.modules['pybullet'] = None;"
        "sys.argv = ['spincheck', 'run', 'sphere', '--engine', 'pybullet'];"
        "from spincheck.reports.cli.app import main; main()"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 3
    assert "engine 'pybullet' cannot be used: the package 'pybullet' is not" in done.stderr


def test_the_last_words_are_of_what_was_asked_for(monkeypatch, capfd):
    """A command without a result file may run another that has one."""
    monkeypatch.setattr(stopping, "_last_words", threading.Lock())
    monkeypatch.setattr(stopping, "_said", threading.Event())

    def stopped() -> None:
        with stopping.saying("nothing is kept"):
            with stopping.saying("over and done with"):
                pass
            with stopping.saying("what was finished is in a file"):
                raise stopping.Stopped(signal.SIGTERM)

    with pytest.raises(stopping.Stopped):
        stopped()
    for _ in range(2):
        stopping.say_last_words(signal.SIGTERM)
    stopping._besides.clear()
    assert capfd.readouterr().err == "spincheck: stopped by SIGTERM; nothing is kept\n"


def test_no_thread_ends_the_program_while_another_prints_the_last_words(monkeypatch):
    monkeypatch.setattr(stopping, "_last_words", threading.Lock())
    monkeypatch.setattr(stopping, "_said", threading.Event())
    begun, printed = threading.Event(), []

    def slowly(descriptor, text):
        begun.set()
        time.sleep(stopping.ENDING / 4)
        printed.append(text)

    terminal = SimpleNamespace(isatty=lambda _: False, write=slowly)
    monkeypatch.setattr(stopping, "os", terminal)
    first = threading.Thread(target=stopping.say_last_words, args=(signal.SIGTERM,))
    first.start()
    begun.wait()
    stopping.say_last_words(signal.SIGTERM)
    assert printed == [b"spincheck: stopped by SIGTERM\n"]
    first.join()


def test_a_report_of_one_scene_holds_what_there_is_of_it_alone(spincheck, tmp_path):
    stored = small_result_file.write(tmp_path / "all.sqlite")
    code, out, err = spincheck("report", str(stored), "--scene", small_result_file.SWEPT)
    assert (code, err) == (0, "")
    pages = tmp_path / out.removeprefix("The report is ").removesuffix("index.html\n")
    assert [path.name for path in pages.rglob("*.html")] == ["index.html"]
    code, *_ = spincheck("report", str(stored), "--scene", f"{small_result_file.SCENE}.toml")
    assert code == 1
    assert [path.name for path in pages.rglob("*.html")] == [
        "index.html",
        f"{small_result_file.SCENE}.html",
    ]
    code, _, err = spincheck("report", str(stored), "--scene", "made-up-tops")
    assert code == BAD_INPUT
    assert "holds no results of 'made-up-tops', which 'spincheck run' makes; did you mean" in err


ONE_THREAD = """
import os, sys
from spincheck.reports.cli.start import main
sys.argv = ["spincheck", "--version"]
try:
    main()
except SystemExit:
    before = len(os.listdir("/proc/self/task"))
    import scipy.linalg
print(len(os.listdir("/proc/self/task")) - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="threads are counted in /proc")
@pytest.mark.processes
def test_linear_algebra_starts_no_threads() -> None:
    environment = {name: value for name, value in os.environ.items() if "THREADS" not in name}
    command = [sys.executable, "-c", ONE_THREAD]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "0"
