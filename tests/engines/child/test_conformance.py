"""`spincheck conform` reports whether an engine keeps the protocol, and where it does not."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines.child.conformance import TURN, timestep_for
from spincheck.reports.cli.app import app
from typer.testing import CliRunner, Result

pytestmark = pytest.mark.processes

HERE = Path(__file__).parent
TOY = HERE.parent / "interface_1/toy.mjs"


def conform(*command: str) -> Result:
    return CliRunner().invoke(app, ["conform", "--limit", "5", "--", *command])


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_an_engine_of_fifty_lines_in_another_language_conforms() -> None:
    result = conform("node", str(TOY))
    assert result.exit_code == 0, result.output
    assert "FAILS" not in result.output
    assert len(TOY.read_text(encoding="utf-8").splitlines()) <= 55


def test_one_that_keeps_the_protocol_and_turns_every_body_like_a_sphere_is_wrong() -> None:
    result = conform(sys.executable, "-S", str(HERE / "planted_child.py"))
    assert result.exit_code == 1
    assert "WRONG  exact on book-in-skew-axes: " in result.output
    assert "It keeps the protocol; in 1 of " in result.output
    assert "Next: spincheck run fast-top tennis-racket --engine 'child:" in result.output


@pytest.mark.parametrize("name", ["brake-on-one-wheel", "gimbal-pushed-at-rest", "fast-top"])
def test_neither_body_nor_rotor_turns_far_in_a_step(name: str) -> None:
    """A clamp or a pivot that gives way at such steps would be called a broken protocol."""
    scene = library_scene(name)
    speeds = [np.linalg.norm(scene.start.omega_body), *abs(scene.start_spins)]
    assert max(speeds) * timestep_for(scene) == pytest.approx(TURN)


def test_its_command_may_be_given_as_to_run() -> None:
    result = conform(f"child:{sys.executable} -S {HERE / 'planted_child.py'}")
    assert "It keeps the protocol; in 1 of " in result.output


@pytest.mark.parametrize(
    ("fault", "words"),
    {
        "dies": "ended with exit code 3",
        "prints garbage": "is not JSON",
        "heavier": "'mass' must read back as",
        "confesses": "active though the scene does not call for it: wind",
        "faster than time": "it says that 64 steps took",
        "restarts late": "restarted from its start it moves in another way",
    }.items(),
    ids=str,
)
def test_one_that_breaks_the_protocol_is_reported_where(fault: str, words: str) -> None:
    result = conform(sys.executable, "-S", str(HERE / "planted_child.py"), fault)
    assert result.exit_code == 1
    assert "FAILS  exact on book-in-skew-axes: " in result.output
    assert words in result.output
