"""The workflows for GitHub Actions call existing commands with existing options."""

import os
import re
import shlex
import subprocess
import textwrap
from pathlib import Path

import numpy as np
import pytest
import typer
from command_line import ended
from planted_physics import Ungyroscopic
from spincheck.reports.cli.app import app
from spincheck.scenarios import load
from spincheck.suite import SCENES
from stepped import METHODS, Stepped, SteppedEngine

ROOT = Path(__file__).parents[1]
HOW_TO = ROOT / "docs/how-to"
QUICK = ROOT / ".github/workflows/quick.yml"
WORKFLOW, JUDGING = HOW_TO / "github-actions.yml", HOW_TO / "github-actions-judge.yml"


def calls(workflow: Path) -> list[str]:
    lines = re.findall(r"\bspincheck [a-z]+ [^\n]*", workflow.read_text(encoding="utf-8"))
    return [line for line in lines if not line.endswith((".", ","))]


CALLS, (JUDGE,) = calls(WORKFLOW), [call for call in calls(JUDGING) if "judge" in call]


@pytest.mark.parametrize("call", [*CALLS, JUDGE, *calls(QUICK)])
def test_a_call_is_of_a_command_with_its_options(call: str) -> None:
    name, *words = shlex.split(call.partition(">")[0])[1:]
    commands = vars(typer.main.get_command(app))["commands"]
    options = {option for parameter in commands[name].params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= options


def test_the_quick_tests_are_those_of_make_and_nox_on_the_same_pythons() -> None:
    quick, nox, make = (
        path.read_text(encoding="utf-8") for path in (QUICK, ROOT / "noxfile.py", ROOT / "Makefile")
    )
    (made,) = re.findall(r"pytest (-n auto --dist loadfile -m 'not processes[^']*') tests", make)
    (run,) = re.findall(r"pytest (.*) tests", quick)
    assert shlex.split(run) == shlex.split(made)
    pythons = (re.findall(r'"(3\.\d+)"', text) for text in (quick, nox))
    assert next(pythons) == next(pythons)


def test_it_runs_compares_and_makes_a_report() -> None:
    commands = [call.split()[1] for call in CALLS]
    assert commands == ["check", "run", "compare", "report"]
    assert "--junitxml" in WORKFLOW.read_text(encoding="utf-8")


@pytest.mark.processes
@pytest.mark.parametrize(("code", "is_shown"), [(0, True), (1, True), (2, False)])
def test_the_summary_is_shown_where_a_verdict_disagrees(
    code: int, is_shown: bool, tmp_path: Path
) -> None:
    """GitHub runs a step by `bash -e`, which ends at the first command that fails."""
    text = WORKFLOW.read_text(encoding="utf-8")
    block = text.partition("- name: Summary")[2].partition("run: |\n")[2].partition("      #")[0]
    command = tmp_path / "spincheck"
    report = "mkdir spincheck-report; echo '# Report' > spincheck-report/report.md"
    command.write_text(f"#!/bin/sh\n{report}; exit {code}\n", encoding="utf-8")
    command.chmod(0o755)
    paths = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    env = os.environ | {"GITHUB_STEP_SUMMARY": "summary.md", "PATH": paths}
    subprocess.run(["bash", "-e", "-c", textwrap.dedent(block)], cwd=tmp_path, env=env, check=False)
    assert (tmp_path / "summary.md").exists() == is_shown


def test_what_is_compared_and_shown_is_what_the_run_wrote() -> None:
    written = re.search(r"spincheck run .*--out (\S+)", WORKFLOW.read_text(encoding="utf-8"))
    assert written is not None
    assert all(written[1] in call for call in CALLS if call.split()[1] in ("compare", "report"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Stepped, Ungyroscopic])
def test_a_simulator_that_is_judged_passes_and_one_with_a_fault_does_not(
    kind: type[Stepped], tmp_path: Path
) -> None:
    (tmp_path / "scenes").mkdir()
    file = SCENES / "free-asymmetric.toml"
    (tmp_path / "scenes/my-body.toml").write_text(file.read_text(encoding="utf-8"))
    scene = load(file)
    for name, timestep in zip(
        re.findall(r"motion-\d\.csv", JUDGE), re.findall(r"--timestep (\S+)", JUDGE), strict=True
    ):
        steps = np.arange(0, round(1.0 / float(timestep)) + 1, round(0.02 / float(timestep)))
        motion = SteppedEngine(kind).run(scene, METHODS[2], float(timestep), steps).trajectory
        assert motion is not None
        table = np.column_stack([motion.t, motion.q_world_body_wxyz, motion.omega_body])
        heads = "t,qw,qx,qy,qz,wx,wy,wz"
        np.savetxt(tmp_path / name, table, delimiter=",", header=heads, comments="")
    code, out, _ = ended(*shlex.split(JUDGE)[1:], cwd=tmp_path)
    assert (code, "no gyroscopic torque" in out) == (int(kind is Ungyroscopic),) * 2
    assert (tmp_path / "spincheck-judged").is_dir()
