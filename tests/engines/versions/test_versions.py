"""Versions of engines: installed once, imported first by their workers, and compared."""

import pkgutil
import subprocess
import venv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from case_loops import each_case
from spincheck.engines import Engine, Method, Session, engines
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.models.mjcf import mjcf
from spincheck.engines.versions import VersionedEngine, VersionError, folders, versioned
from spincheck.reports.cli.results.compare import changes_between_versions
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess, LocalWorkers
from spincheck.reports.harness.executors.executor import CallFailed
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from spincheck.reports.pages.analysis.changes import Change
from spincheck.reports.results.store import open_store
from spincheck.scenarios import Scenario
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

TIMESTEP = 1e-3


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(folders, "user_cache", lambda: tmp_path)
    return tmp_path


def pretend(name: str) -> Path:
    """A version that is there, with nothing in it but a module that says where it is."""
    folder = folders.folder_of(name)
    folder.mkdir(parents=True)
    (folder / "where_am_i.py").write_text("PLACE = 'in the folder'\n", encoding="utf-8")
    return folder


# Folders


def test_what_is_there_is_not_downloaded(monkeypatch: pytest.MonkeyPatch) -> None:
    folder = pretend("mujoco@3.1.6")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: pytest.fail("pip was started"))
    assert versioned("mujoco@3.1.6").site == str(folder)


def test_robots_that_come_along_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def pip(_: str, command: list[str]) -> str:
        target = Path(command[command.index("--target") + 1])
        for name in ("pybullet", "pybullet_data"):
            (target / name).mkdir(parents=True)
        return ""

    monkeypatch.setattr(folders, "_call", pip)
    said: list[str] = []
    site = Path(versioned("pybullet@3.2.5", say=said.append).site)
    assert [line.split("-")[0] for line in said] == ["Installing pybullet@3.2.5"]
    assert [folder.name for folder in site.iterdir()] == ["pybullet"]


def test_without_a_network_one_message_says_so(
    monkeypatch: pytest.MonkeyPatch, cache: Path
) -> None:
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    with pytest.raises(VersionError, match=r"mujoco@3\.1\.6 is not installed, and pip cannot"):
        versioned("mujoco@3.1.6")
    assert list(cache.glob("engines/*")) == []


@each_case(
    ("name", "python", "words"),
    [
        ("mujoco@../../etc", "", "a version must be like 3.1.6"),
        ("mujoco@", "", "a version must be like 3.1.6"),
        ("nonesuch@1.0", "", "'nonesuch' cannot be had in other versions, only mujoco, "),
        ("havok@3.1.6", "", "cannot be had in other versions"),
        ("mujoco@3.1.6", "no-such-python", "'no-such-python' cannot be started"),
        ("mujoco@3.1.6", "echo", "'--python' must be Python 3.11 or later, 'echo' says"),
        ("mujoco@3.1.6", "false", "'--python' false: it fails: it said nothing"),
    ],
)
def test_what_is_no_version_or_no_interpreter_is_reported(
    name: str, python: str, words: str, cache: Path
) -> None:
    with pytest.raises(VersionError, match=words):
        versioned(name, python)
    assert list(cache.glob("engines/*")) == []


def test_a_worker_of_a_virtual_environment_is_of_its_interpreter(cache: Path) -> None:
    """Made without anything to import: pip is not needed to see which Python runs."""
    venv.create(cache / "another", with_pip=False, symlinks=True)
    with LocalWorkers(1) as workers:
        prefix = workers.call_at(str(cache / "another"), pkgutil.resolve_name, "sys:prefix").value
    assert prefix == str(cache / "another")


# What an engine is in another version


def test_orders_that_differ_are_data() -> None:
    def order(version: str) -> int:
        release = MuJoCo().at_version(version)
        return next(m.attitude_order for m in release.methods if m.name == "RK4")

    assert [order(version) for version in ("2.3.7", "3.17.0", "4.0.0")] == [2, 2, 4]


@pytest.mark.needs_pybullet
def test_a_version_needs_what_it_was_built_with() -> None:
    pybullet = engines()["pybullet"]
    requirements = [pybullet.at_version(v).requirements for v in ("3.2.6", "3.2.7")]  # type: ignore[union-attr]
    assert requirements == [("pybullet==3.2.6", "numpy==1.26.4"), ("pybullet==3.2.7",)]


def test_in_this_process_which_has_another_version_it_is_not_run_but_says_what_it_leaves_out() -> (
    None
):
    """Which is asked before its steps are timed."""
    engine = VersionedEngine("mujoco", "3.1.6", MuJoCo.methods, Path("nowhere"))
    run = engine.run(SCENES["free"], engine.method("RK4"), TIMESTEP, np.array([0, 1]))
    assert run.outcome == "failed"
    assert "runs in a process of its own" in run.reason
    for method in MuJoCo.methods:
        assert engine.left_out(SCENES["free"], method) == MuJoCo().left_out(SCENES["free"], method)


def test_whatever_an_engine_has_is_its_adapters() -> None:
    """A method that is added to `Engine` too: nothing is inherited but what is final."""
    members = {name for name in vars(Engine) if not name.startswith("_")}
    final = {name for name in members if hasattr(vars(Engine)[name], "__final__")}
    assert members - final - vars(VersionedEngine).keys() == set()
    assert {"run", "method", "unsupported"} <= final


@pytest.mark.needs_pybullet
def test_its_defaults_are_its_adapters() -> None:
    newest, scene = engines()["pybullet"], SCENES["pivot"]
    engine = VersionedEngine("pybullet", newest.version, newest.methods, Path("nowhere"))
    method = engine.method("default")
    assert engine.defaults(scene, method) == newest.defaults(scene, method) != ()
    with (
        engine.open_with(scene, method, TIMESTEP, defaults=["damping"]) as at_version,
        newest.open_with(scene, method, TIMESTEP, defaults=["damping"]) as own,
    ):
        for session in (at_version, own):
            session.advance(10)
        assert np.array_equal(at_version.read_state().omega_body, own.read_state().omega_body)


def test_its_worker_finds_its_folder_first_and_an_executor_without_a_place_for_it_says_so() -> None:
    folder = pretend("mujoco@3.1.6")
    with LocalWorkers(1) as workers:
        inside = workers.call_at(str(folder), pkgutil.resolve_name, "where_am_i:PLACE").value
        outside = workers.call(pkgutil.resolve_name, "where_am_i:PLACE").value
    assert inside == "in the folder"
    assert isinstance(outside, CallFailed)
    answer = InProcess().call_at("a folder", len, ()).value
    assert isinstance(answer, CallFailed)
    assert "in local workers only" in answer.reason


# What changed


def released(release: str, steps_like: str = "RK4") -> Engine:
    """The same engine at a version, with one method, that steps like it or like another."""

    class Released(MuJoCo):
        name, version = f"mujoco@{release}", release
        methods = tuple(method for method in MuJoCo.methods if method.name == "RK4")

        def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
            return super().open(scenario, replace(method, name=steps_like), timestep)

    return Released()


def test_a_newer_one_that_errs_more_is_worse_and_one_that_does_not_is_alike(tmp_path: Path) -> None:
    """It is declared to be of fourth order, and is of first."""

    def changes_to(newer: Engine) -> list[Change]:
        older = released("3.9.0")
        choice = Choice((older, newer), max_steps=QUICK_STEPS, timed=False)
        with open_store(tmp_path / f"{newer.version}.sqlite", create=True) as store:
            run_study(plan([SCENES["free"]], choice, store), choice, store, InProcess(), print)
            return changes_between_versions(store.read(), older.name, newer.name)

    assert changes_to(released("4.0.0")) == []
    changes = changes_to(released("4.0.1", "Euler"))
    assert {change.engine for change in changes} == {"mujoco@3.9.0 → 4.0.1"}
    (verdict,) = [change for change in changes if change.kind == "verdict"]
    assert (verdict.old, verdict.new, verdict.regression) == ("converges", "disagrees", True)
    errors = [change for change in changes if change.kind == "error" and change.name == "omega"]
    assert all(change.regression for change in errors)
    assert max(change.new / change.old for change in errors) > 100


def test_mjcf_for_the_newest_is_as_complete_as_before() -> None:
    """Flags are set on the compiled model for the sake of older versions; the file has them."""
    assert "<flag" in mjcf(SCENES["free"], TIMESTEP, "RK4")
