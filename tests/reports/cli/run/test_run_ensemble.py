"""The commands of ensembles: what they print, what they refuse, and with which exit code."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import spincheck
from default_signals import WITH_DEFAULT_SIGNALS
from made_up_ensembles import ensemble_result
from spincheck.engines import engines
from spincheck.reports.cli import choosing
from spincheck.reports.cli.app import app
from spincheck.reports.cli.run import ensembles
from spincheck.reports.cli.run.ensembles import choose_for_ensemble as choose
from spincheck.reports.cli.run.ensembles import (
    exit_code_of,
    run_ensembles,
)
from spincheck.reports.cli.run.summary import run_lines
from spincheck.reports.cli.terminal import AGREES, DISAGREES, NOT_RUN, Complaint
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.results.ensemble_records import Ensemble
from spincheck.reports.results.records import variation
from spincheck.reports.results.store import open_store
from spincheck.scenarios import loads
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

COMMAND = Path(sys.executable).with_name("spincheck")
SCENE = "fast-top"
ONE_METHOD = ("--engine", "mujoco", "--method", "RK4")
ENSEMBLE = ("run", SCENE, "--ensemble")


@pytest.fixture
def in_process(monkeypatch):
    """What is run is run here."""
    monkeypatch.setattr(choosing, "LocalWorkers", lambda *_: InProcess())


@pytest.fixture(scope="module")
def scattered(tmp_path_factory):
    """A result file, and what the command printed that made an ensemble in it."""
    path = tmp_path_factory.mktemp("scattered") / "results.sqlite"
    done = spincheck(*ENSEMBLE, 3, "--seed", 7, *ONE_METHOD, "--out", path, "--json")
    assert done.returncode == AGREES, done.stderr
    return path, done


def test_an_ensemble_prints_its_members(scattered):
    path, done = scattered
    printed = json.loads(done.stdout)
    assert [p["variation"] for p in printed["points"]] == [
        {"member": k, "seed": 7} for k in range(3)
    ]
    first = printed["points"][0]
    assert (first["engine"], first["method"], first["outcome"]) == ("mujoco", "RK4", "ok")
    assert 0 < first["omega_error"] < 1
    with open_store(path) as store:
        (ensemble,) = store.read().ensembles
    assert ensemble.ensemble == Ensemble(SCENE, 3, 7, None)


def test_asked_again_it_answers_from_the_file_in_words_with_the_worst_member_and_as_csv(scattered):
    path, before = scattered
    asked = (*ENSEMBLE, 3, "--seed", 7, *ONE_METHOD, "--out", path)
    again = spincheck(*asked, "--json")
    assert again.stdout == before.stdout
    assert again.stderr == f"{path}: 3 of 3 points are stored already\n"
    points = json.loads(before.stdout)["points"]
    done = spincheck(*asked)
    assert "fast-top: 3 members of seed 7" in done.stdout
    (line,) = (line for line in done.stdout.splitlines() if "mujoco RK4" in line)
    worst = max(points, key=lambda point: point["attitude_error"])
    assert f"member {worst['variation']['member']}" in line
    first, *others = spincheck("rows", path, "--csv").stdout.splitlines()
    assert first.startswith("scenario,engine,method,engine_version,timestep,outcome,")
    assert ",variation.member,variation.seed" in first
    assert all(line.startswith("fast-top,mujoco,RK4,") for line in others)
    assert len(others) == 3
    assert json.loads(spincheck("rows", path, "--json").stdout) == points


@pytest.mark.usefixtures("in_process")
def test_methods_made_for_other_scenes_are_not_run(path):
    """As in a study: `contact` is for bodies on a table, `mujoco-file` for users' files."""
    (swept,) = run_ensembles([SCENE], 1, 0, choose(["mujoco"], [], [0.5]), 1, path)
    methods = {one.name for one in engines()["mujoco"].methods_for(swept.scenario)}
    with open_store(path) as store:
        assert {point.pair[1] for point in store.varied(SCENE)} == methods
    assert {point.pair[1] for point in swept.points} == methods


def test_points_are_printed_below_their_method_which_is_named_once():
    swept = ensemble_result()
    methods = {point.pair for point in swept.points}
    assert len(methods) > 1
    points = sorted(swept.points, key=lambda point: point.pair)
    assert len([*run_lines(points)]) == 2 * len(methods) + len(points)


def test_a_point_is_printed_with_its_timestep_beside_seed_and_member():
    point = ensemble_result().points[0]
    varied = variation({"member": 199, "seed": 1234, "timestep": 1 / 1920})
    _, _, line = run_lines([replace(point, variation=varied)])
    assert line.split()[:3] == ["199", "1234", "0.000520833"]


def test_without_a_number_an_ensemble_has_two_hundred_members(monkeypatch):
    calls = []
    monkeypatch.setattr(
        ensembles, "run_ensembles", lambda scenes, members, *_: calls.append((scenes, members))
    )
    monkeypatch.setattr(ensembles, "print_ensembles", lambda *_: None)
    monkeypatch.setattr(ensembles, "exit_code_of", lambda _: AGREES)
    for arguments in ([SCENE, "--ensemble"], ["--ensemble", SCENE], ["--ensemble", "3", SCENE]):
        assert run("run", *arguments)[0] == AGREES
    assert calls == [([SCENE], 200), ([SCENE], 200), ([SCENE], 3)]


def test_a_member_is_printed_as_a_scenario_file():
    member = loads(spincheck("show", SCENE, "--toml", "--seed", 7, "--member", 2).stdout, "member")
    assert member.title.endswith("with member 2 of seed 7")


def test_a_member_is_shown_without_a_file() -> None:
    shown = CliRunner().invoke(app, ["show", SCENE, "--member", "2"]).output
    assert "None" not in shown
    assert "with member 2 of seed 0" in shown


def run(*arguments: object) -> tuple[int, str]:
    """The command's exit code and message, in this process."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if isinstance(result.exception, Complaint):
        return result.exception.exit_code, str(result.exception)
    return result.exit_code, result.output


@pytest.mark.processes
def test_ctrl_c_ends_it_with_130_and_the_same_command_goes_on(path):
    arguments = [*ENSEMBLE, "8", *ONE_METHOD, "--jobs", "1", "--out", str(path)]
    process = subprocess.Popen(
        [*WITH_DEFAULT_SIGNALS, COMMAND, *arguments],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stderr
    first = process.stderr.readline()
    assert first.startswith("[1/8]")
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate()
    assert (process.returncode, out) == (130, "")
    assert "the same command continues from there" in err.splitlines()[-1]
    assert "of 8 points are stored already" in spincheck(*arguments).stderr


@pytest.mark.parametrize(
    ("outcomes", "code"),
    [
        (["ok", "diverged", "unsupported"], AGREES),
        (["ok", "failed"], DISAGREES),
        (["failed", "failed"], NOT_RUN),
    ],
    ids=["none failed", "one failed", "all failed"],
)
def test_an_ensemble_fails_only_by_runs_that_failed(outcomes, code):
    points = [SimpleNamespace(outcome=outcome) for outcome in outcomes]
    assert exit_code_of([SimpleNamespace(points=points)]) == code


@pytest.mark.usefixtures("in_process")
def test_of_several_methods_in_a_file_those_asked_for_are_reported(scattered):
    choice = choose(["mujoco"], ["Euler"], [])
    (swept,) = run_ensembles([SCENE], 3, 7, choice, 1, scattered[0])
    assert {point.key.method for point in swept.points} == {"Euler"}


@pytest.mark.usefixtures("in_process")
def test_a_member_runs_as_in_its_ensemble(path, tmp_path):
    """What the command prints is the very scene whose point is in the file."""
    choice = choose(["mujoco"], ["RK4"], [])
    (ensemble,) = run_ensembles([SCENE], 2, 7, choice, 1, path)
    point, alone = ensemble.points[1], tmp_path / "alone.toml"
    alone.write_text(spincheck("show", SCENE, "--toml", "--seed", 7, "--member", 1).stdout)
    options = ("--timestep", repr(point.timestep), "--out", tmp_path / "alone.sqlite", "--json")
    done = spincheck("run", alone, *ONE_METHOD, *options)
    (row,) = json.loads(done.stdout)["rows"]
    assert (row["steps"], row["outcome"]) == (point.steps, "ok")
    # The same run; its exact motion is a closed form here, and a series there.
    sure = row["reference_uncertainty"] + point.reference_uncertainty
    assert row["omega_error"] == pytest.approx(point.errors.omega, rel=0, abs=sure)
    assert row["turns"] == pytest.approx(point.turns, rel=1e-9)
