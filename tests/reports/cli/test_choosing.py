"""Which engines run, and which only if they are named; what is typed wrongly is one message."""

import sys
import time
from pathlib import Path

import pytest
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines import Missing, engines
from spincheck.engines.adapters.node.discovered import FAMILY
from spincheck.reports.cli import choosing
from spincheck.reports.cli.choosing import choose
from spincheck.reports.cli.terminal import BAD_INPUT, NOT_RUN, Complaint

PLANTED = Path(__file__).parents[2] / "engines" / "child" / "planted_child.py"
#: What runs without being named, if it is installed.
ALWAYS = {"mujoco", "pybullet"}


def names(*asked: str) -> set[str]:
    return {engine.name for engine in choose(asked, [], []).engines}


def refused(*asked: str, **options: object) -> Complaint:
    with pytest.raises(Complaint) as complaint:
        choose(asked, [], [], **options)  # type: ignore[arg-type]
    return complaint.value


def test_an_optional_engine_runs_only_if_it_is_named() -> None:
    assert names() <= ALWAYS
    here = {name for name, engine in engines().items() if not engine.of_file}
    assert names("all") == here
    for engine in engines().values():
        assert engine.is_optional == (engine.name not in ALWAYS and not engine.of_file)
        assert engine.name in names(engine.name.upper())
    # Those of users' files, where a scene names one.
    chosen = choose(["all"], [], [], scenarios=[library_scene("fast-top")]).engines
    assert not any(engine.of_file for engine in chosen)


def test_a_family_is_asked_for_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    family = {name for name, engine in engines().items() if engine.family == FAMILY}
    if family:
        assert names("node", "jolt") == family
    without = {name: engine for name, engine in engines().items() if name not in family}
    monkeypatch.setattr(choosing, "engines", lambda: without)
    absent = (Missing("jolt", "node", "node is not installed", FAMILY),)
    monkeypatch.setattr(choosing, "missing", lambda: absent)
    assert refused("node").exit_code == NOT_RUN
    assert "node is not installed" in str(refused("node"))


OF_MY_OWN = """
from spincheck.engines.adapters.mujoco import MuJoCo

class Mine(MuJoCo):
    name = "mine"

not_one = 3

class Panicking:
    def __init__(self):
        raise type("Panic", (BaseException,), {})("in Rust")

class Interrupted:
    def __init__(self):
        raise KeyboardInterrupt
"""


def test_an_engine_of_ones_own_is_a_class_of_a_module_in_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "module_of_mine.py").write_text(OF_MY_OWN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path.copy())
    try:
        assert names("module_of_mine:Mine") == {"mine"}
        for name, words in {
            "module_of_mine:not_one": "must be a subclass of spincheck.engine.Engine",
            "module_of_mine:Panicking": "'--engine' module_of_mine:Panicking: Panic: in Rust",
            "module_of_mine:Yours": "has no attribute 'Yours'",
            "no_module_of_mine:Mine": "ModuleNotFoundError: No module named 'no_module_of_mine'",
            "module_of_mine.py": "or of your own MODULE:CLASS, got 'module_of_mine.py'",
        }.items():
            assert words in str(refused(name))
            assert refused(name).exit_code == BAD_INPUT
        with pytest.raises(KeyboardInterrupt):
            choose(["module_of_mine:Interrupted"], [], [])
    finally:
        engines().pop("mine", None)


@each_case("name", ["mujoco@", "mujoco@abc", "mujoco@1..2", f"mujoco@{'9' * 5000}", "@1"])
def test_a_malformed_version_is_bad_input(name: str) -> None:
    assert refused(name).exit_code == BAD_INPUT


def test_a_wrong_python_is_reported_as_that() -> None:
    complaint = refused("mujoco@3.1.6", python="no-such-python")
    assert complaint.exit_code == BAD_INPUT
    assert "'--python'" in str(complaint)


def child(fault: str) -> str:
    return f"child:{sys.executable} -S {PLANTED} '{fault}'"


@pytest.mark.processes
def test_a_child_that_answers_hello_with_an_error_or_another_id_is_quoted() -> None:
    complaint = refused(child("refuses hello"))
    assert complaint.exit_code == NOT_RUN
    assert str(complaint).endswith("the licence has run out")
    assert "must have the call's 'id', 1" in str(refused(child("true for one")))


@pytest.mark.processes
@each_case(
    ("fault", "words"),
    [("speaks protocol 2", "'protocol' must be 1, got 2"), ("has no methods", "at 'methods'")],
)
def test_what_a_child_states_wrongly_is_bad_input_as_of_an_adapter_in_python(
    fault: str, words: str
) -> None:
    complaint = refused(child(fault))
    assert words in str(complaint)
    assert complaint.exit_code == BAD_INPUT


@pytest.mark.processes
def test_the_time_limit_is_that_of_the_first_call_too() -> None:
    began = time.monotonic()
    complaint = refused(child("never says hello"), time_limit=0.5)
    assert "did not answer 'hello' within 0.5 s" in str(complaint)
    assert time.monotonic() - began < 30
