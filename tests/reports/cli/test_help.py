"""The command line's help, and its messages about unknown names."""

import re

import pytest
from case_loops import each_case
from spincheck.engines.model_readers import model_readers
from spincheck.reports.cli.app import app
from spincheck.reports.cli.choosing import choose
from spincheck.reports.cli.grouped import GROUPS
from spincheck.reports.cli.scenes.scene import new_scene
from spincheck.reports.cli.terminal import Complaint
from spincheck.scenarios import load
from typer.main import get_group
from typer.testing import CliRunner

COMMANDS = get_group(app).list_commands(None)


def printed(*arguments: str) -> str:
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0
    return done.output


def test_every_command_is_in_one_group():
    grouped = [name for names in GROUPS.values() for name in names]
    assert len(grouped) == len(set(grouped))
    assert set(COMMANDS) <= set(grouped)
    assert set(COMMANDS) <= set(printed("--help").split())


@each_case("name", COMMANDS)
def test_every_command_has_an_example_and_says_which_options_may_be_repeated(name):
    usage, _, example = printed(name, "--help").partition("Example: ")
    assert usage.splitlines()[0].count("...") <= 1
    words = example.split()
    assert words[:2] == ["spincheck", name]
    options = [
        p for p in get_group(app).get_command(None, name).params if p.param_type_name == "option"
    ]
    assert [p.opts for p in options if p.multiple and "repeated" not in p.help] == []
    assert not re.search(r"<\w", usage), "a type of Python's"


def test_inspect_offers_no_engines_that_it_refuses():
    offered = re.findall(r"'(\S+?)'", " ".join(printed("inspect", "--help").split()))
    engines = [one for one in offered if not one.startswith("-")]
    assert engines == ["mujoco@3.3.7"]
    assert engines[0].partition("@")[0] in model_readers()


def test_shells_complete_commands(monkeypatch):
    monkeypatch.setenv("_SPINCHECK_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", "spincheck rec")
    monkeypatch.setenv("COMP_CWORD", "1")
    done = CliRunner().invoke(app, prog_name="spincheck")
    assert done.output.split() == ["recommend"]


def test_the_version_is_printed_and_commands_and_methods_are_known_in_any_case():
    assert printed("--version").startswith("spincheck 0.")
    assert printed("LIST", "fast-top") == printed("list", "fast-top")
    assert {choose(["mujoco"], [name], []).methods for name in ("rk4", "RK4", "Rk4")} == {("RK4",)}


@pytest.mark.parametrize(
    ("engine", "method", "meant"), [("mujco", [], "mujoco"), ("mujoco", ["RK5"], "RK4")]
)
def test_the_nearest_name_is_offered(engine, method, meant):
    with pytest.raises(Complaint, match=f"did you mean '{meant}'"):
        choose([engine], method, [])
    with pytest.raises(Complaint) as near_to_nothing:
        choose(["zzzzzz"], [], [])
    assert "did you mean" not in str(near_to_nothing.value)


def test_a_new_scene_is_a_scene_and_is_never_written_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load(new_scene("my-top")).called_for == {"gravity", "pivot"}
    with pytest.raises(Complaint, match="exists already"):
        new_scene("my-top.toml")
    with pytest.raises(Complaint, match="'NAME' must be"):
        new_scene("../top")
    with pytest.raises(Complaint, match="200 bytes at most"):
        new_scene("a" * 300)
    assert [path.name for path in tmp_path.iterdir()] == ["my-top.toml"]
