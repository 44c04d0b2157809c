"""The figures of docs/measured/engines-more.md are those of the engines that are there."""

import re
from pathlib import Path

import numpy as np
import pytest
from kinds_of_engines import OPTIONAL, installed, why_missing
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.child.process import end_idle
from spincheck.reference import solve
from spincheck.scenarios import Trajectory, errors_between
from spincheck.scenarios.rotation import rotation_vectors

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[3] / "docs/measured/engines-more.md"
ROWS = re.findall(
    r"^\| `([\w-]+)` \| (\w+) \| ([\d.e+-]+) / .* \|$", PAGE.read_text(encoding="utf-8"), re.M
)
#: JAX compiles it for half a minute; in double precision it is compiled too, to the same figure.
LONG_COMPILED = ("mjx-float32", "RK4")
#: Of the page's timesteps the one that takes the fewest steps.
TIMESTEP = 1e-2
#: The page has two digits; roundings in single precision differ from processor to processor.
PRINTED, SINGLE = 0.05, 0.2
#: Of a small angle, relative, of a step that turns by it.
ROUNDED = 1e-12


@pytest.fixture(scope="module", autouse=True)
def _nobody_left():
    yield
    end_idle()


@pytest.fixture(scope="module")
def exact() -> Trajectory:
    """The fast top's motion at every step of the page's longest timestep."""
    scenario = library_scene("fast-top")
    steps = round(scenario.window.duration / TIMESTEP)
    return solve(scenario, np.arange(steps + 1) * TIMESTEP).trajectory


@pytest.mark.parametrize(
    ("name", "method", "printed"), [row for row in ROWS if row[:2] != LONG_COMPILED]
)
def test_the_error_on_the_fast_top_is_the_pages(
    exact: Trajectory, name: str, method: str, printed: str
) -> None:
    engine, scenario = installed(name), library_scene("fast-top")
    run = engine.run(scenario, engine.method(method), TIMESTEP, np.arange(len(exact.t)))
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
