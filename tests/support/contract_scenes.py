"""Every scene of the library, solved once for all tests of a process."""

from functools import cache

import numpy as np
from case_loops import each_case
from library_scenes import library
from spincheck.reference import Solution, solve
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import integrate
from spincheck.scenarios import Scenario

SCENES = {scenario.name: scenario for scenario in library()}
every_scene = each_case("name", [*SCENES])


@cache
def solved(name: str) -> tuple[Scenario, Solution]:
    """A scene and its exact motion at the window's times."""
    scenario = SCENES[name]
    return scenario, solve(scenario, scenario.times)


def states(problem: Problem, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q_world_axes and omega_axes as `solve` finds them."""
    form = closed_form(problem)
    return integrate(problem, times) if form is None else form.states(times)
