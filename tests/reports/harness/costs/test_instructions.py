"""Instructions of a step: equal from run to run, of stepping alone."""

from pathlib import Path

import pytest
from command_line import spincheck
from library_scenes import library_scene
from spincheck import results
from spincheck.engines import engines
from spincheck.reports.harness.costs import instructions, timing
from spincheck.reports.harness.costs.instructions import instructions_per_step, why_not_counted

TIMESTEP = 1e-4
needs_valgrind = pytest.mark.skipif(bool(why_not_counted()), reason=why_not_counted())


def count(name: str, method: str) -> float | None:
    """Of the fast top; a count takes ten seconds."""
    engine = engines()[name]
    return instructions_per_step(library_scene("fast-top"), engine, engine.method(method), TIMESTEP)


@needs_valgrind
@pytest.mark.slow
@pytest.mark.processes
@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("mujoco", "RK4"),
        pytest.param("pybullet", "multibody", marks=pytest.mark.needs_pybullet),
    ],
)
def test_two_counts_are_equal_to_the_last_instruction(name, method):
    first = count(name, method)
    assert first > 1000
    assert count(name, method) == first
    # Four evaluations take more than three times as many as one.
    assert method != "RK4" or first > 3 * count(name, "Euler")


@pytest.mark.parametrize(("total", "per_step"), [("summary: 0\n", None), ("totals: 512\n", 2.0)])
def test_an_engine_that_steps_in_another_function_has_no_count(monkeypatch, total, per_step):
    """Callgrind's total is 0 then, as of a function that there is not."""

    def counted(command: list[str]) -> None:
        (option,) = (part for part in command if part.startswith("--callgrind-out-file="))
        Path(option.partition("=")[2]).write_text(total, encoding="utf-8")

    monkeypatch.setattr(instructions, "_run", counted)
    assert count("mujoco", "RK4") == per_step
    # Nor has one whose steps are not native.
    monkeypatch.setattr(type(engines()["mujoco"]), "steps_in", "")
    monkeypatch.setattr(instructions, "_run", lambda command: pytest.fail("started"))
    assert count("mujoco", "RK4") is None


@pytest.mark.parametrize(
    ("tool", "options", "words"),
    [
        (None, (), "valgrind is not installed"),
        ("/bin/true", ("--quick",), "no steps are timed"),
        ("/bin/true", ("--ensemble", "3"), "no steps are timed"),
    ],
)
def test_where_nothing_can_be_counted_it_is_said_and_nothing_is_run(
    tmp_path, monkeypatch, tool, options, words
):
    monkeypatch.setattr(instructions, "which", lambda name: tool)
    done = spincheck("run", "fast-top", "--instructions", *options, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("spincheck: '--instructions': ")
    assert words in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_counts_are_stored_and_shown_beside_times(tmp_path, monkeypatch):
    asked = ("run", "fast-top", "--engine", "mujoco", "--method", "RK4", "--timestep", "2e-3")
    assert spincheck(*asked, cwd=tmp_path).returncode == 0
    monkeypatch.setattr(instructions, "which", lambda name: "/bin/true")
    monkeypatch.setattr(timing, "instructions_per_step", lambda *_: 23326.125)
    ran = spincheck(*asked[:-2], "--quick", cwd=tmp_path)
    assert "Instructions" not in ran.stdout
    ran = spincheck(*asked[:-2], "--instructions", cwd=tmp_path)
    assert "Instructions a step: mujoco RK4 23,326.1 on fast-top." in ran.stdout
    (stored,) = {row.instructions_per_step for row in results(tmp_path / "spincheck.sqlite").rows}
    assert stored == 23326.125
    spincheck("report", cwd=tmp_path)
    page = (tmp_path / "spincheck-report" / "scenes" / "fast-top.md").read_text("utf-8")
    assert "instructions a step" in page
    assert "23,326.1" in page
