"""The scenes of the library, each solved once a process, and by independent methods."""

import importlib
from dataclasses import fields
from functools import cache

import numpy as np
from case_loops import each_case
from closed_form_checks import repeated_free
from extended_motion import ExtendedMotion
from library_scenes import library
from mpmath import mp, mpf
from spincheck.reference import Solution, solve
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.motion import motion
from spincheck.reference.problem import Problem
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.taylor import FINE_ORDERS, Orders, integrate
from spincheck.scenarios import FloatArray, Scenario, Trajectory
from spincheck.scenarios.fastest_rate import fastest_rate

solving = importlib.import_module("spincheck.reference.solve")

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


#: All terms in double-double: dearer than any series that scenes are solved by.
DEAREST_ORDERS = Orders(40, 40)
#: rad; the dearest series takes this far in a second.
DEAREST_TURN = 1e3

#: A free body that the ODE does not follow to the end; a period of it is solved in sixty digits.
MANY_PERIODS = "million-turns"
#: Solved in sixty digits by plain Taylor series: besides that, on separatrices; about a pivot that
#: leaves a sphere no axis; and without a closed form.
SIXTY_DIGITS = (
    MANY_PERIODS,
    "pendulum-on-the-separatrix",
    "separatrix-exactly",
    "sphere-about-its-pivot",
    "lopsided-body",
)
#: rad; this far in sixty digits takes a second or two.
SIXTY_DIGITS_TURN = 30.0
#: Samples compared with many digits.
FEW = 3


def by_series(scenario: Scenario, solution: Solution) -> Trajectory:
    """By the ODE, as far as it reaches: of closed forms the fine one, of itself the dearest."""
    problem, exact = rotational_problem(scenario), solution.trajectory
    rate = fastest_rate(scenario, exact.omega_body)
    closed = closed_form(problem) is not None
    reach = solving.CHECKED_TURN if closed else DEAREST_TURN
    times = exact.t[exact.t * rate <= reach]
    return motion(
        scenario,
        problem,
        times,
        integrate(problem, times, FINE_ORDERS if closed else DEAREST_ORDERS),
    )


def in_sixty_digits(scenario: Scenario, solution: Solution) -> Trajectory:
    """By Taylor series of order 100 in integers of 260 bits, for so many turns or periods."""
    problem, times = rotational_problem(scenario), solution.trajectory.t
    if scenario.name == MANY_PERIODS:
        return _rounded(scenario, problem, few(times), repeated_free(problem).state)
    rate = mpf(fastest_rate(scenario, solution.trajectory.omega_body))
    times = few(times[times * float(rate) <= SIXTY_DIGITS_TURN])
    # A motion's poles in complex time are about a turn's time away.
    solved = ExtendedMotion(problem, 1 / rate, rate, mpf(float(times[-1])) + 1 / rate)
    return _rounded(scenario, problem, times, solved.state)


def few(times: FloatArray) -> FloatArray:
    """The last sample, and some before it."""
    return times[np.linspace(0, len(times) - 1, FEW + 1).astype(int)[1:]]


def _rounded(scenario: Scenario, problem: Problem, times: FloatArray, state) -> Trajectory:
    with mp.workdps(30):
        states = [state(mpf(float(t))) for t in times]
        parts = tuple(np.array([s[k] for s in states], dtype=float) for k in range(2))
    return motion(scenario, problem, times, parts)


def at(motion_: Trajectory, times: FloatArray) -> Trajectory:
    """Those of its samples."""
    chosen = np.searchsorted(motion_.t, times)
    return Trajectory(**{f.name: getattr(motion_, f.name)[chosen] for f in fields(motion_)})
