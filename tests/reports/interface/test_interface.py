"""The Python interface: what is exported, its values, and its complaints."""

import tomllib

import numpy as np
import psutil
import pytest
import spincheck
from library_scenes import library_scene
from spincheck import single_run
from spincheck.reports.harness.executors import compiling
from spincheck.scenarios import Scenario, ScenarioError
from spincheck.testing import assert_matches_exact


@pytest.fixture(scope="module")
def exact():
    return spincheck.exact("fast-top").at(np.linspace(0, 2, 401))


def test_scenes_are_loaded_by_name_path_or_tables_and_refused_as_files_would_be():
    scene = spincheck.load("fast-top")
    assert isinstance(scene, Scenario)
    assert spincheck.load(scene) is scene
    assert spincheck.load(scene.path).digest == scene.digest
    tables = tomllib.loads(scene.text)
    tables["body"]["inertia"] = np.array(tables["body"]["inertia"])
    assert spincheck.load(tables).digest == scene.digest
    del tables["spincheck"]
    assert spincheck.load(tables, "mine").name == "mine"
    tables["body"]["mass"] = -1.0
    with pytest.raises(ScenarioError, match="mass"):
        spincheck.load(tables)
    with pytest.raises(ScenarioError, match="neither a file, a folder, nor a scene"):
        spincheck.load("no-such-top")
    with pytest.raises(ScenarioError, match=r"hard: takes one scene, this is \d\d"):
        spincheck.load("hard")


def test_a_file_that_goes_before_the_library_is_named(tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    text = spincheck.load("fast-top").text
    assert not caplog.messages
    (tmp_path / "fast-top.toml").write_text(text.replace("source", "# mine\nsource", 1))
    assert "# mine" in spincheck.load("fast-top").text
    (message,) = caplog.messages
    assert message.startswith("fast-top.toml: taken from the current folder; the library has")


def test_exact_states_have_what_their_names_say(exact):
    assert exact.energy == pytest.approx(exact.energy[0], rel=1e-14)
    assert exact.angular_momentum_world[:, 2] == pytest.approx(
        exact.angular_momentum_world[0, 2], rel=1e-14
    )
    norms = [np.linalg.norm(a, axis=1) for a in (exact.omega_body, exact.omega_world)]
    assert norms[0] == pytest.approx(norms[1], rel=1e-14)
    assert 0 < exact.uncertainty["attitude"] < 1e-13
    arrays = [value for value in vars(exact).values() if isinstance(value, np.ndarray)]
    assert len(arrays) == 9
    assert not any(array.flags.writeable for array in arrays)
    scene = library_scene("chaos-beyond-the-horizon")
    with pytest.raises(ValueError, match=r"'times' must not reach .*: it is chaotic"):
        spincheck.exact(scene).at([0.0, scene.window.duration * 10])
    for times in ([], [[0.0, 1.0]]):
        with pytest.raises(ValueError, match=r"'times' must have the shape \(n,\), n > 0, got"):
            spincheck.exact(scene).at(times)


def test_derivatives_are_at_the_times_asked_for_and_none_are_beyond_what_is_known():
    motion = spincheck.exact("fast-top")
    assert motion.sensitivity([0.0, 1.0]).state_transition.shape == (2, 6, 6)
    assert motion.sensitivity(1.0).gravity.shape == (1, 6, 3)
    for times in ([], [[0.0, 1.0]]):
        with pytest.raises(ValueError, match=r"'times' must have the shape \(n,\), n > 0, got"):
            motion.sensitivity(times)
    scene = library_scene("chaos-beyond-the-horizon")
    with pytest.raises(ValueError, match=r"'times' must not reach .*: it is chaotic"):
        spincheck.exact(scene).sensitivity([0.0, scene.window.duration * 10])


def test_a_motion_is_judged_in_every_form_that_it_may_have(exact):
    xyzw = np.roll(exact.q_world_body_wxyz, -1, axis=1)
    forms = [
        {"q_wxyz": exact.q_world_body_wxyz, "omega_body": exact.omega_body},
        {"q_xyzw": xyzw, "omega_world": exact.omega_world},
        {"q_wxyz": exact.q_world_body_wxyz},
    ]
    for form in forms:
        judged = spincheck.judge("fast-top", t=exact.t, **form)
        assert judged.errors["attitude"] < 1e-14
        assert judged.explained_by == ()
    assert judged.errors["omega"] is None


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"q_wxyz": None}, "'q_wxyz' or 'q_xyzw' must be given"),
        ({"q_wxyz": np.ones((401, 3))}, r"'q_wxyz' must have the shape \(n, 4\), got \(401, 3\)"),
        ({"q_xyzw": np.ones((401, 4))}, "'q_xyzw' must not be given besides the same"),
        ({"t": np.zeros(401)}, "times must increase"),
        ({"omega_body": np.full((401, 3), np.nan)}, "'omega' must be finite"),
        ({"omega_body": np.ones((3, 3))}, "'omega' must have a row for each time, got 3"),
        ({"order": 1.5}, "'order' must be a whole number from 1 to 12, got 1.5"),
        ({"order": 13}, "'order' must be a whole number from 1 to 12, got 13"),
    ],
)
def test_arrays_that_are_no_motion_are_refused(exact, changed, words):
    arrays = {"t": exact.t, "q_wxyz": exact.q_world_body_wxyz} | changed
    with pytest.raises(ValueError, match=words):
        spincheck.judge("fast-top", **arrays)


@pytest.mark.parametrize("motions", [[], ["motion"]])
def test_a_verdict_is_on_motions_that_were_judged(motions):
    with pytest.raises(ValueError, match=r"'motions' must be what 'spincheck\.judge' returned"):
        spincheck.judge_timesteps("fast-top", motions)


@pytest.mark.parametrize("bound", [-1.0, 0.0, np.nan, "1deg"])
def test_a_bound_is_a_positive_number(exact, bound):
    arrays = {"t": exact.t, "q_wxyz": exact.q_world_body_wxyz}
    with pytest.raises(ValueError, match="'attitude' must be a positive number, got"):
        assert_matches_exact("fast-top", **arrays, attitude=bound)


def test_the_assertion_passes_on_the_exact_motion_and_fails_with_an_explanation(exact):
    states = {"t": exact.t, "q_wxyz": exact.q_world_body_wxyz, "omega_body": exact.omega_body}
    assert_matches_exact("fast-top", **states, attitude=1e-12, omega=1e-12, energy=1e-12)
    states |= {"omega_body": exact.omega_world}
    with pytest.raises(AssertionError) as failed:
        assert_matches_exact("fast-top", **states, attitude=1e-3, omega=1e-3)
    assert "ω is off by 0.6" in str(failed.value)
    assert "(relative), more than 0.001 from t = 0 s on" in str(failed.value)
    assert "attitude" not in str(failed.value)
    assert "Explained by: ω is in world axes (state 'omega = world')." in str(failed.value)


def test_the_assertion_takes_the_spins_of_rotors():
    exact = spincheck.exact("wheel-in-a-box").at(np.linspace(0, 0.2, 41))
    states = {"t": exact.t, "q_wxyz": exact.q_world_body_wxyz, "omega_body": exact.omega_body}
    assert_matches_exact("wheel-in-a-box", **states, spins=exact.spins, spins_error=1e-12)
    with pytest.raises(AssertionError, match="spins"):
        assert_matches_exact("wheel-in-a-box", **states, spins=-exact.spins, spins_error=1e-3)


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({}, "a bound must be given"),
        ({"atitude": 1e-3}, "'atitude' must be one of omega, attitude"),
        ({"omega": 1e-3}, "'omega' cannot be checked: it was not given"),
    ],
)
def test_bounds_that_check_nothing_are_refused(exact, bounds, words):
    with pytest.raises(ValueError, match=words):
        assert_matches_exact("fast-top", t=exact.t, q_wxyz=exact.q_world_body_wxyz, **bounds)


ASKED = {"engine": "mujoco", "method": "RK4", "timestep": 2e-3}


@pytest.mark.processes
def test_runs_are_made_in_a_process_of_their_own_the_same_unless_one_was_interrupted(monkeypatch):
    workers = set()

    def made(*args):
        run_study(*args)
        workers.add(args[3]._slots[0]._worker._process.pid)

    run_study = single_run.run_study
    monkeypatch.setattr(single_run, "run_study", made)
    first = spincheck.run("fast-top", **ASKED)
    assert (first.outcome, first.steps) == ("ok", 2500)
    assert 0 < first.errors["attitude"] < 1e-4
    states = {"q_wxyz": first.motion.q_world_body_wxyz, "omega_body": first.motion.omega_body}
    judged = spincheck.judge("fast-top", t=first.motion.t, **states)
    assert judged.errors["attitude"] == first.errors["attitude"]
    assert spincheck.run("fast-top", **ASKED).errors == first.errors
    assert len(workers) == 1

    def interrupted(*args):
        made(*args)
        raise KeyboardInterrupt

    monkeypatch.setattr(single_run, "run_study", interrupted)
    with pytest.raises(KeyboardInterrupt):
        spincheck.run("fast-top", **ASKED)
    assert not any(map(psutil.pid_exists, workers))
    monkeypatch.setattr(single_run, "run_study", made)
    assert spincheck.run("fast-top", **ASKED).errors == first.errors
    assert len(workers) == 2


@pytest.mark.processes
@pytest.mark.parametrize("timestep", [np.float32(0.01), np.int64(1)])
def test_a_timestep_may_be_a_number_of_numpy(timestep):
    row = spincheck.run("fast-top", **ASKED | {"timestep": timestep})
    assert row.outcome in ("ok", "diverged")
    assert row.timestep == timestep


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"engine": "mujocoo"}, "'engine' must be one of .*mujoco"),
        ({"method": "rk5"}, "'method' must be one of .*RK4"),
        ({"engine": "mujoco-file"}, "'engine' mujoco-file loads .* and fast-top names none"),
        ({"timestep": 0.0}, "'timestep' must be above 0"),
        ({"timestep": "0.002"}, "'timestep' must be above 0 .*got '0.002'"),
    ],
)
def test_runs_that_cannot_be_made_are_refused(changed, words):
    with pytest.raises(ValueError, match=words):
        spincheck.run("fast-top", **ASKED | changed)


def test_what_is_compiled_first_is_announced(monkeypatch, caplog):
    monkeypatch.setattr(compiling, "is_compiled", lambda: False)
    monkeypatch.setattr(compiling, "compile_side_by_side", lambda _: None)
    spincheck.exact("sphere")
    (record,) = caplog.records
    assert record.name == "spincheck"
    assert "the solver of exact motions is compiled, roughly" in record.message
