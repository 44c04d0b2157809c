"""`spincheck gradients` and `spincheck.gradients`: what they print and return, and bad input."""

import json

import pytest
import spincheck
from case_loops import each_case
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reports.cli.engines.gradients import exit_code, gradients, print_gradients
from spincheck.reports.cli.engines.gradients import gradients_as_json as as_json
from spincheck.reports.cli.terminal import AGREES, DISAGREES, NOT_RUN, Complaint, to_json
from spincheck.reports.harness.gradients.compared import OURS, GradientRow
from spincheck.reports.harness.gradients.study import gradients_of
from spincheck.reports.harness.gradients.verdict import Judged

pytestmark = pytest.mark.slow

#: s; as long as it takes.
WINDOW = 0.05


def test_a_line_for_each_derivative_with_its_reason(capsys: pytest.CaptureFixture[str]) -> None:
    rows = gradients(["fast-top"], ["mujoco"], ["Euler", "rk4"], None, WINDOW, None)
    print_gradients(rows)
    printed = capsys.readouterr().out
    for words in ("mjd_transitionFD, centred", "RK4 integrator is not supported", "cosine"):
        assert words in printed
    assert exit_code(rows) == AGREES
    records = json.loads(to_json(as_json(rows)))
    assert [one["judged"]["verdict"] for one in records].count("unsupported") == 2
    assert records[0]["window"][-1]["conditioning"] > 1


@each_case(
    ("verdict", "is_own", "code"),
    [
        ("converges", True, AGREES),
        ("converges", None, AGREES),
        ("converges", False, DISAGREES),
        ("disagrees", True, DISAGREES),
        ("failed", None, DISAGREES),
        ("unsupported", None, NOT_RUN),
    ],
)
def test_the_exit_code_is_of_what_is_wrong(verdict: str, is_own: bool | None, code: int) -> None:
    row = GradientRow("s", "e", "m", "d", Judged(verdict, is_own=is_own))  # type: ignore[arg-type]
    assert exit_code([row]) == code


@each_case(
    ("timestep", "window", "message"),
    [
        (0.0, None, "'--timestep' must be above 0, got 0"),
        (None, -1.0, "'--window' must be above 0, got -1"),
        (None, float("inf"), "'--window' must be above 0, got inf"),
        (1.0, 0.5, "'--window' must be no shorter than '--timestep', got 0.5 s"),
    ],
)
def test_a_timestep_or_a_window_that_is_none_is_refused(
    timestep: float | None, window: float | None, message: str
) -> None:
    with pytest.raises(Complaint, match=message):
        gradients(["fast-top"], ["mujoco"], [], timestep, window, None)


def test_a_window_says_from_when_on_gradients_mean_nothing_and_the_conditioning_there(
    capsys: pytest.CaptureFixture[str],
) -> None:
    chaos, mujoco = library_scene("chaos-beyond-the-horizon"), engines()["mujoco"]
    rows = gradients_of(chaos, mujoco, "Euler", window=20.0, derivative=OURS)
    print_gradients(rows)
    printed = capsys.readouterr().out
    assert all(row.useless_from is not None and row.useless_from < 20.0 for row in rows)
    there = next(one for one in rows[0].window if one.t == rows[0].useless_from)
    assert f"{there.t:.2g} ({there.conditioning:.0e})" in printed


@each_case(
    ("named", "message"),
    [
        ({"engine": "moon"}, "'engine' must be one of"),
        ({"method": "Moon"}, "'method' must be one of"),
        ({"timestep": float("nan")}, "'timestep' must be above 0, got nan"),
        ({"window": 0.0}, "'window' must be above 0, got 0.0"),
        (
            {"window": 1e-3, "timestep": 1e-2},
            "'window' must be no shorter than 'timestep', got 0.001 s",
        ),
    ],
)
def test_bad_input_in_python_is_a_value_error(named: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        spincheck.gradients("fast-top", **({"engine": "mujoco", "method": "Euler"} | named))


def test_python_returns_the_same_rows() -> None:
    of_mujoco = {"engine": "mujoco", "method": "Euler", "window": WINDOW}
    (forward, centred, ours) = spincheck.gradients("fast-top", **of_mujoco)
    assert {row.judged.verdict for row in (forward, centred, ours)} == {"converges"}
    assert forward.window
    assert centred.judged.is_own
