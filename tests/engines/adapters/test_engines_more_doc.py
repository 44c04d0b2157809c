"""The figures of docs/measured/engines-more.md are those of the engines that are there."""

import re
from pathlib import Path

import numpy as np
import pytest
from kinds_of_engines import OPTIONAL, why_missing
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.engines.child.process import end_idle
from spincheck.reference import solve
from spincheck.scenarios import errors_between

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[3] / "docs/measured/engines-more.md"
ROWS = re.findall(
    r"^\| `([\w-]+)` \| (\w+) \| ([\d.e+-]+) / .* \|$", PAGE.read_text(encoding="utf-8"), re.M
)
#: Of the page's timesteps the one that takes the fewest steps.
TIMESTEP = 1e-2
#: The page has two digits; roundings in single precision differ from processor to processor.
PRINTED, SINGLE = 0.05, 0.2


@pytest.fixture(scope="module", autouse=True)
def _nobody_left():
    yield
    end_idle()


@pytest.mark.parametrize(("name", "method", "printed"), ROWS)
def test_the_error_on_the_fast_top_is_the_pages(name: str, method: str, printed: str) -> None:
    if reason := why_missing(name):
        pytest.skip(reason)
    engine, scenario = engines()[name], library_scene("fast-top")
    steps = np.arange(round(scenario.window.duration / TIMESTEP) + 1)
    run = engine.run(scenario, engine.method(method), TIMESTEP, steps)
    assert run.trajectory is not None
    exact = solve(scenario, run.trajectory.t).trajectory
    error = errors_between(scenario, run.trajectory, exact).omega
    slack = SINGLE if engine.single_precision else PRINTED
    assert error == pytest.approx(float(printed), rel=slack)


def test_the_page_has_a_row_for_every_optional_engine() -> None:
    assert {name for name, _, _ in ROWS} == set(OPTIONAL)
