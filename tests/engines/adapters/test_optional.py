"""Optional engines hold the scene, and nothing else acts; each skipped if not installed.

Their page in the docs has their figures.
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from adapter_checks import CHECKS, Check
from case_loops import each_case
from kinds_of_engines import OPTIONAL, installed, why_missing
from library_scenes import library_scene
from spincheck.engines import Engine, engines, missing
from spincheck.engines.adapters.genesis.caches import FOLDERS, kernels_kept
from spincheck.engines.adapters.mjx import session as mjx_session
from spincheck.engines.adapters.node import discovered
from spincheck.engines.child.process import end_idle
from spincheck.reference import solve
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.scenarios import Trajectory, errors_between
from spincheck.scenarios.rotation import rotation_vectors
from spincheck.suite.contract_scenes import SCENES, scene
from spincheck.suite.test_adapter import RESTARTED

pytestmark = pytest.mark.slow

TIMESTEP = 2.0**-10
#: A body that feels no gyroscopic torque where it starts: ω is along L.
START_ON_AXIS = """
quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, 5.0]
"""
ON_AXIS = scene("on-axis", start=START_ON_AXIS)
#: A method of each engine that is asked whether it keeps the contract.
IN_DOUBLE = {
    ("dartpy", "semi-implicit"),
    ("drake", "runge_kutta3"),
    ("exudyn", "RK44"),
    ("exudyn", "TrapezoidalIndex2"),
    ("mjx", "Euler"),
    ("pin", "semi-implicit"),
}
FIRST = {(name, "") for name in OPTIONAL} - {(name, "") for name, _ in IN_DOUBLE}
#: Of engines in single precision, and for games, first steps and orders are looked at below, at
#: timesteps at which they show.
(HOLDS,) = (one for one in CHECKS if one.__name__.startswith("test_holds"))
IN_DOUBLE_ALONE = ("test_begins_as_the_equations_of_motion_say", "test_order_of_accuracy")
CONTRACT = [
    (check, *asked)
    for asked in sorted(IN_DOUBLE | FIRST)
    for check in ([HOLDS] if asked[0] == "mjx-float32" else CHECKS)
    if asked in IN_DOUBLE or check.__name__ not in IN_DOUBLE_ALONE
]
#: A plant that steps itself is built anew for another timestep.
(RESTARTS,) = (one for one in CHECKS if one.__name__.startswith("test_restarts"))
CONTRACT.append((RESTARTS, "drake", "discrete"))
#: What one of them does not keep, and why: shown by two of the contract's scenes with rotors.
NOT_KEPT = {
    ("exudyn", "TrapezoidalIndex2", "test_order_of_accuracy"): (
        "it declares the order of a step from a state with rotors, and runs are of second order"
    ),
    ("exudyn", "TrapezoidalIndex2", "test_begins_as_the_equations_of_motion_say"): (
        "with rotors its shortest steps end where its iteration does, 4e-5 of the torque off"
    ),
}
NOT_KEPT_ON = {"free-rotors", "pivot-rotors"}
#: JAX takes seconds to compile for each kind of scene. MJX's models are MuJoCo's, and what it adds
#: to them (forces, torques, drag, rotors, restarts) is all in the scenes of which the contract asks
#: for restarts, but for the one on which its implicit methods differ from Euler's; in single
#: precision it is the same model, and all its methods share it.
COMPILED = {"mjx": {*RESTARTED, "free-drag"}, "mjx-float32": {"heavy-top", "free-drag"}}
NOT_MJX = [name for name in OPTIONAL if name != "mjx"]
WITHOUT_GYROSCOPIC_TORQUE = ("cannon-es", "havok", "pybox3d")


@pytest.fixture(params=OPTIONAL)
def engine(request: pytest.FixtureRequest):
    return installed(request.param)


@pytest.fixture(scope="module", autouse=True)
def _nobody_left():
    yield
    end_idle()


@pytest.fixture
def scenes_put_back() -> Iterator[None]:
    """Scenes that a test leaves out are put back in their order: `delitem` would append them."""
    every = dict(SCENES)
    yield
    SCENES.clear()
    SCENES.update(every)


def test_every_optional_engine_is_there_or_missing_with_how_to_get_it() -> None:
    present, absent = set(engines()), {one.name: one.reason for one in missing()}
    assert set(OPTIONAL) <= present | set(absent)
    remedies = ("pip install 'spincheck[", "python -m spincheck.engines", "node is not installed")
    for name in set(OPTIONAL) & set(absent):
        assert any(remedy in absent[name] for remedy in remedies)


def test_no_engine_whose_package_is_installed_fails_to_load() -> None:
    """Its tests would skip, as if it were not there."""
    assert [one for one in missing() if not one.package] == []


# In double precision MJX is by a switch; as shipped it is the other engine.
@pytest.mark.parametrize("engine", NOT_MJX, indirect=True)
def test_its_defaults_have_a_row_that_says_what_differs(engine: Engine) -> None:
    shipped = [method for method in engine.methods if method.as_shipped]
    runs = [engine.run(SCENES["heavy-top"], one, TIMESTEP, np.arange(3)) for one in shipped]
    assert runs
    assert {run.outcome for run in runs} == {"ok"}
    assert all({"gravity", "pivot"} <= run.active for run in runs)


@pytest.mark.parametrize("engine", NOT_MJX, indirect=True)
@pytest.mark.parametrize("name", ["free-drag", "heavy-top", "on-axis"])
def test_its_first_steps_are_the_scenes_but_for_a_torque_that_it_leaves_out(
    engine: Engine, name: str
) -> None:
    residual = physics_in_words(engine, (SCENES | {"on-axis": ON_AXIS})[name], engine.methods[0])
    if engine.name in WITHOUT_GYROSCOPIC_TORQUE:
        assert residual.startswith("behaves as if there were no gyroscopic torque")
    else:
        assert residual == ""


@each_case(
    ("name", "scene_name"),
    [
        # It loses turns of less than 1.5e-8 rad a step from the world's axes; this rod's are.
        ("exudyn", "pendulum-just-over"),
        # Rapier's first step from a state lacks a seventh of the torque that turns a rotor.
        ("rapier3d", "wheel-in-a-box"),
        ("rapier3d", "middle-axis-let-go"),
        # Its joint is a spring of 1 MHz, which steps of 10 µs feel, unless it is made stiffer.
        ("rapier3d", "gyroscope-at-24000-rpm"),
        # It does not put back less than 1e-6 rad a step: no smooth function of that.
        ("jolt", "motor-through-the-threshold"),
    ],
)
def test_what_its_first_steps_lose_is_no_other_equation_of_motion(
    name: str, scene_name: str
) -> None:
    engine = installed(name)
    assert physics_in_words(engine, library_scene(scene_name), engine.methods[0]) == ""


@pytest.mark.parametrize(
    ("check", "name", "method"), CONTRACT, ids=lambda one: getattr(one, "__name__", one)
)
@pytest.mark.usefixtures("scenes_put_back")
def test_it_keeps_the_contract(check: Check, name: str, method: str) -> None:
    engine = installed(name)
    reason = NOT_KEPT.get((name, method, check.__name__))
    for other in set(SCENES) - (NOT_KEPT_ON if reason else COMPILED.get(name, {*SCENES})):
        del SCENES[other]
    asked = engine.method(method) if method else engine.methods[0]
    if reason:
        with pytest.raises(pytest.fail.Exception):
            check(engine, asked)
        pytest.xfail(reason)
    for one in engine.methods if check is HOLDS and name not in COMPILED else (asked,):
        check(engine, one)


@pytest.mark.parametrize("method", ["RK44", "TrapezoidalIndex2"])
def test_exudyn_takes_as_many_steps_as_asked_for_where_they_are_of_hours(method: str) -> None:
    """Its clock then has an ulp that is more than what it allows for at the end of a call."""
    engine = installed("exudyn")
    with engine.open(library_scene("spin-of-1e-6"), engine.method(method), 125_000 / 6) as session:
        for steps in (1, 34, 129, 512):
            session.advance(steps)


def test_mjx_compiles_once_for_scenes_that_differ_in_numbers_alone() -> None:
    """Once for each precision, whichever was used before."""
    installed("mjx")
    compiled = []
    for scene_name, timestep in (("fast-top", 1e-3), ("nutation-loops", 5e-4)):
        scenario = library_scene(scene_name)
        for name in ("mjx", "mjx-float32"):
            engine = engines()[name]
            run = engine.run(scenario, engine.method("Euler"), timestep, np.arange(3))
            assert run.outcome == "ok"
        compiled.append(mjx_session._module().loop.cache_info().misses)
    assert compiled[1] == compiled[0]


@pytest.mark.processes
def test_nothing_optional_is_imported_before_a_scene_is_opened() -> None:
    """In a process of its own: another test of this one may have opened one."""
    code = (
        "import sys; from spincheck.engines import engines; "
        "print({one.package for one in engines().values()} & {*sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_without_node_or_their_packages_they_are_missing_and_say_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    which = sys.modules[discovered.__module__].shutil
    monkeypatch.setattr(which, "which", lambda _: None)
    without_node = list(discovered())
    assert {"cannon-es", "rapier3d-js"} <= {one.name for one in without_node}
    assert {one.reason for one in without_node} == {"node is not installed"}
    monkeypatch.setattr(which, "which", lambda _: "node")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (reason,) = {one.reason for one in discovered()}
    assert "python -m spincheck.engines.adapters.node" in reason


def test_caches_are_in_spinchecks_folder_unless_the_user_named_another(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    users, ours = FOLDERS
    monkeypatch.setenv(ours, "to be deleted, and restored after the test")
    monkeypatch.delenv(ours)
    monkeypatch.setenv(users, "/elsewhere")
    with kernels_kept():
        print("nothing of this is seen")
    assert os.environ[users] == "/elsewhere"
    assert os.environ[ours] == str(tmp_path / "spincheck" / FOLDERS[ours])


# The figures of docs/measured/engines-more.md

PAGE = Path(__file__).parents[3] / "docs/measured/engines-more.md"
ROWS = re.findall(
    r"^\| `([\w-]+)` \| (\w+) \| ([\d.e+-]+) / .* \|$", PAGE.read_text(encoding="utf-8"), re.M
)
#: JAX compiles it for half a minute; in double precision it is compiled too, to the same figure.
LONG_COMPILED = ("mjx-float32", "RK4")
#: Of the page's timesteps the one that takes the fewest steps.
PAGES_TIMESTEP = 1e-2
#: The page has two digits; roundings in single precision differ from processor to processor.
PRINTED, SINGLE = 0.05, 0.2
#: Of a small angle, relative, of a step that turns by it.
ROUNDED = 1e-12


@pytest.fixture(scope="module")
def exact() -> Trajectory:
    """The fast top's motion at every step of the page's longest timestep."""
    scenario = library_scene("fast-top")
    steps = round(scenario.window.duration / PAGES_TIMESTEP)
    return solve(scenario, np.arange(steps + 1) * PAGES_TIMESTEP).trajectory


@pytest.mark.parametrize(
    ("name", "method", "printed"), [row for row in ROWS if row[:2] != LONG_COMPILED]
)
def test_the_error_on_the_fast_top_is_the_pages(
    exact: Trajectory, name: str, method: str, printed: str
) -> None:
    engine, scenario = installed(name), library_scene("fast-top")
    run = engine.run(scenario, engine.method(method), PAGES_TIMESTEP, np.arange(len(exact.t)))
    assert run.trajectory is not None
    error = errors_between(scenario, run.trajectory, exact).omega
    slack = SINGLE if engine.single_precision else PRINTED
    assert error == pytest.approx(float(printed), rel=slack)


def test_dart_turns_a_body_by_a_truncated_series_below_a_thousandth_of_a_radian() -> None:
    engine, scenario = installed("dartpy"), library_scene("book-long-axis")
    speed = float(np.linalg.norm(scenario.start.omega_body))

    def off(turn: float) -> float:
        """By which part of itself a step's rotation is off."""
        timestep = turn / speed
        with engine.open(scenario, engine.method("semi-implicit"), timestep) as session:
            before = session.read_state().q_world_body_wxyz
            session.advance(1)
            after = session.read_state()
        turned = rotation_vectors(before[None], after.q_world_body_wxyz[None])[0]
        return float(np.linalg.norm(turned - timestep * after.omega_body)) / turn

    assert off(2e-3) < ROUNDED
    for turn in (0.98e-3, 1e-4):
        assert off(turn) == pytest.approx(turn**2 / 3, rel=PRINTED)


def test_the_row_that_is_not_run_is_that_of_double_precision() -> None:
    printed = {(name, method): error for name, method, error in ROWS}
    assert printed[LONG_COMPILED] == printed["mjx", LONG_COMPILED[1]]


def test_the_page_has_a_row_for_every_optional_engine() -> None:
    assert {name for name, _, _ in ROWS} == set(OPTIONAL)


def test_the_engines_with_rotors_and_tables_are_the_pages() -> None:
    section = PAGE.read_text(encoding="utf-8").split("## Rotors and tables")[1].split("\nMuJoCo")[0]
    listed = set(re.findall(r"^\| `([\w-]+)` \|", section, re.MULTILINE))
    able = {
        name
        for name, engine in engines().items()
        if name in OPTIONAL and any({"rotors", "table"} & one.effects for one in engine.methods)
    }
    assert able <= listed
    assert all(why_missing(name) for name in listed - able)
