"""What 'run --worlds' prints, returns and refuses; what it measures is in test_batches.py."""

from dataclasses import replace

import pytest
from case_loops import each_case
from command_line import ended
from kinds_of_engines import installed
from spincheck.engines import engines
from spincheck.reports.cli.run.batches import exit_code, print_batches
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT, DISAGREES, NOT_RUN
from spincheck.reports.harness.varied.batches import NUMBER, STOPPED, STOPS, Apart, BatchRow

COST = {"seconds_per_step": 64e-6, "beside": 2e-6, "beside_by": "mujoco Euler"}
SAME = BatchRow("top", "e", "m", 2e-3, 64, "CPU", until=5.0, has_neighbours=True, **COST)
APART = replace(SAME, alone=Apart(1, 3.0, 0.02), because=(NUMBER,))
LOST = replace(SAME, worlds=4096, outcome="failed", reason="out of memory")
UNABLE = replace(LOST, outcome="unsupported", reason="e m cannot simulate pivot")


@each_case(
    ("name", "message"),
    [
        ("newton", "'--device': there is no device 'cuda:99' here"),
        ("mujoco-warp", "'--device': there is no device 'cuda:99' here"),
        ("mjx", "'--device': mjx leaves no choice of a device"),
        ("brax", "'--device': brax leaves no choice of a device"),
    ],
)
def test_a_device_that_cannot_be_had_is_one_line_before_anything_runs(
    name: str, message: str
) -> None:
    installed(name)
    scene = ["fast-top", "--engine", name, "--worlds", "2", "--device", "cuda:99"]
    code, out, err = ended("run", *scene)
    assert (code, out) == (BAD_INPUT, "")
    assert message in err
    assert len(err.splitlines()) == 1


def test_an_engine_of_one_world_names_those_of_many() -> None:
    many = [name for name, engine in engines().items() if engine.has_batches]
    _, _, err = ended("run", "fast-top", "--engine", "mujoco", "--worlds", "2")
    assert all(name in err for name in many)


@each_case(
    ("rows", "code"),
    [
        ([SAME], AGREES),
        ([SAME, APART], DISAGREES),
        ([SAME, LOST], DISAGREES),
        ([SAME, UNABLE], AGREES),
        ([UNABLE], NOT_RUN),
    ],
)
def test_the_exit_code_says_whether_a_motion_depends_on_its_batch(
    rows: list[BatchRow], code: int
) -> None:
    assert exit_code(rows) == code


def test_differences_causes_costs_and_failures_are_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    print_batches([replace(SAME, worlds=1), APART, LOST])
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines())) <= 100
    assert "3 ulp, 0.02°" in printed
    text = " ".join(printed.split())
    assert "depends on the number of worlds" in text
    assert "from 64 worlds on, a world's step costs less than one of mujoco Euler, 2 µs" in text
    assert "4096 worlds: out of memory" in text


def test_worlds_that_a_neighbour_stops_are_not_finite(capsys: pytest.CaptureFixture[str]) -> None:
    stopped = replace(APART, neighbours=STOPPED, because=(f"one at rest{STOPS}",))
    print_batches([stopped])
    text = " ".join(capsys.readouterr().out.split())
    assert "not finite" in text
    assert "depends on one at rest, which stops all worlds" in text
    assert "inf" not in text.replace("not finite", "")


def test_a_dear_batch_is_not_said_to_pay(capsys: pytest.CaptureFixture[str]) -> None:
    print_batches([replace(SAME, beside=0.5e-6)])
    text = " ".join(capsys.readouterr().out.split())
    assert "same bits" in text
    assert "moves the same, to the last bit" in text
    assert "with up to 64 worlds, a world's step costs more than" in text


def test_batches_that_pay_are_named_where_larger_ones_do_not(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A world's step takes 1.5 µs of 2, 2 µs of 16, and 1 µs of 64 worlds."""
    costs = {2: 3e-6, 16: 32e-6, 64: 64e-6}
    rows = [replace(SAME, worlds=n, seconds_per_step=t) for n, t in costs.items()]
    print_batches([replace(row, beside=1.8e-6) for row in rows])
    text = " ".join(capsys.readouterr().out.split())
    assert "with 2 or 64 worlds, a world's step costs less than" in text
    costs = {2: 3e-6, 16: 24e-6, 64: 128e-6}
    rows = [replace(SAME, worlds=n, seconds_per_step=t, beside=1.8e-6) for n, t in costs.items()]
    print_batches(rows)
    text = " ".join(capsys.readouterr().out.split())
    assert "with 2 or 16 worlds, a world's step costs less than" in text
    print_batches([replace(row, beside=None) for row in rows])
    assert "a world's step costs" not in capsys.readouterr().out
