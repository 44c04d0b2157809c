"""Solves a scene by the simplest method that covers its effects, and bounds the error."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple, final

import numpy as np

from ..scenarios import (
    Errors,
    FloatArray,
    Scenario,
    Trajectory,
    error_series,
    errors_between,
)
from ..scenarios.fastest_rate import fastest_rate
from .closed_forms import ClosedForm, closed_form
from .conditioning import conditioning
from .motion import motion
from .problem import Problem
from .rotational_problem import rotational_problem
from .solution import MAX_UNCERTAINTY, Solution
from .state_rounding import rounding_of
from .taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    IntegrationError,
    LiftOffError,
    Orders,
    integrate,
)

EPS = float(np.finfo(float).eps)
#: Error, relative or in rad, by rounding of the states to double, and of L and E, which are
#: computed from them.
ROUNDING = 8 * EPS
#: Error, rad, for each radian turned: a closed form's phase is a time t multiplied by a rate in
#: double-double, whose relative error is at most EPS²/4.
PHASE_ROUNDING = EPS**2
#: Turn, rad, up to which a closed form is compared with the ODE, which takes a tenth of a second.
CHECKED_TURN = 5e3
#: Number of samples compared over all of that turn, and again over its first `SURE_TURN`.
CHECKED_SAMPLES = 64
#: Number of scenes whose problem and closed form are kept, because reports ask for them repeatedly.
SCENES = 256
#: Turn, rad, up to which even errors that grow by a factor e a radian are small in double-double.
SURE_TURN = 30.0


def solve(scenario: Scenario, times: FloatArray) -> Solution:
    """Return the exact motion of a scene.

    The motion ends before the last of the times if it is chaotic and no longer known, or if the
    body leaves its table; see `Solution.horizon`.

    Parameters
    ----------
    times : (n,) s, increasing, from 0 on

    Raises
    ------
    ValueError
        If there are no times, or they do not increase or are negative.
    IntegrationError
        If the motion cannot be integrated over that span, or is not known at the first time.
    NotImplementedError
        If the exact motion under an effect of the scene is unknown.
    """
    return ExactMotion(scenario).solve(times)


def solve_cheaply(scenario: Scenario, rows: Sequence[FloatArray]) -> list[Solution]:
    """Return the exact motion of a scene at each of several rows of times, at low cost.

    It is for studies of very many scenes, in which no verdict depends on a single scene. The
    motion is integrated by Taylor series, with a conditioning of NaN and an uncertainty without
    the rounding of states. `solve` is called only if the series is not known to the last time, as
    beside a saddle, where errors grow: finding a closed form costs as much as hundreds of radians
    of the series. The errors raised are those of `solve`.

    Parameters
    ----------
    rows : rows of times, (n,) s, each increasing and from 0 on

    Returns
    -------
    A solution for each row
    """
    times = np.unique(np.concatenate([_increasing(row) for row in rows]))
    solution = _by_series(scenario, rotational_problem(scenario), times)
    if solution.horizon is not None and not solution.lifts_off:
        solution = solve(scenario, times)
    return [_part(solution, row) for row in rows]


@final
class ExactMotion:
    """The exact motion of one scene; numbers that do not depend on times are computed once."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._problem, self._closed = _posed(scenario)

    def solve(self, times: FloatArray) -> Solution:
        """Return the motion and its uncertainty at given times, (n,) s, increasing, from 0 on.

        It raises the errors of the function `solve`.
        """
        times = _increasing(times)
        if self._closed is not None:
            return _solve_closed(self._scenario, self._problem, self._closed, times)
        return _solve_ode(self._scenario, self._problem, times)

    def solve_each(self, rows: Sequence[FloatArray]) -> list[Solution]:
        """Return the motion at each of several rows of times, (n,) s, computed for all together.

        Uncertainty and conditioning are those over all times, and so upper bounds for each row. The
        errors raised are those of the function `solve`, for all times together.
        """
        together = self.solve(np.unique(np.concatenate(list(rows))))
        return [_part(together, times) for times in rows]

    def outline(self, times: FloatArray) -> Trajectory:
        """Return the motion that `solve` finds, up to its horizon, without its uncertainty.

        Parameters
        ----------
        times : (n,) s, increasing, from 0 on

        Raises
        ------
        ValueError, IntegrationError
            As by the function `solve`.
        """
        times = _increasing(times)
        if self._closed is not None:
            return motion(self._scenario, self._problem, times, self._closed.states(times))
        return _integrated_to_horizon(self._scenario, self._problem, times).trajectory


@lru_cache(maxsize=SCENES)
def _posed(scenario: Scenario) -> tuple[Problem, ClosedForm | None]:
    """Return a scene's problem and its closed form, which is None if there is none."""
    problem = rotational_problem(scenario)
    return problem, closed_form(problem)


def _increasing(times: FloatArray) -> FloatArray:
    """Return times, s, as an array; raise `ValueError` unless they increase from 0 on."""
    times = np.asarray(times, dtype=float)
    if not (len(times) and times[0] >= 0 and (np.diff(times) > 0).all()):
        raise ValueError("'times' must increase from 0 on.")
    return times


def _part(together: Solution, times: FloatArray) -> Solution:
    """Return the part of a solution at `times`, up to the solution's horizon.

    All of `times` must be among those that the solution `together` was computed at. If the part
    ends before the last of these times, its horizon is the time of lift-off, or else the first of
    these times from the solution's horizon on.
    """
    count = (
        len(times) if together.horizon is None else int(np.searchsorted(times, together.horizon))
    )
    at = np.searchsorted(together.trajectory.t, times[:count])
    horizon = None
    if count < len(times):
        horizon = together.horizon if together.lifts_off else float(times[count])
    return replace(
        together,
        trajectory=together.trajectory.at(at),
        horizon=horizon,
        lifts_off=together.lifts_off and horizon is not None,
    )


def solve_ode(scenario: Scenario, times: FloatArray) -> Trajectory:
    """Return a scene's motion by the ODE integrator, even if the scene has a closed form.

    Parameters
    ----------
    times : (n,) s, increasing, from 0 on

    Raises
    ------
    ValueError
        If the times do not increase or are negative.
    IntegrationError
        If the motion cannot be integrated to the last time, or the body leaves its table before.
    """
    problem = rotational_problem(scenario)
    return motion(scenario, problem, times, integrate(problem, times))


def _solve_closed(
    scenario: Scenario, problem: Problem, closed: ClosedForm, times: FloatArray
) -> Solution:
    """Return the solution by a closed form; the ODE is compared with it to find its uncertainty."""
    trajectory = motion(scenario, problem, times, closed.states(times))
    rate = fastest_rate(scenario, trajectory.omega_body)
    checked = _checked_times(times, rate)
    by_form = motion(scenario, problem, checked, closed.states(checked))
    difference = _larger(
        _apart_from_ode(scenario, problem, by_form), rounding_of(scenario, trajectory)
    )
    turned = rate * float(times[-1])
    return Solution(
        trajectory=trajectory,
        method=closed.label,
        uncertainty=_at_least(difference, ROUNDING + closed.residual + PHASE_ROUNDING * turned),
        conditioning=_conditioning_of_closed(scenario, problem, trajectory, by_form),
    )


def _apart_from_ode(scenario: Scenario, problem: Problem, by_form: Trajectory) -> Errors:
    """Return the largest distances in each signal of a closed form from the ODE's solution.

    Only samples at which the ODE's solution is accurate count. `by_form` is the motion by the
    closed form. Beside a saddle the ODE's solution is inaccurate: its rounding error grows, and
    that of the closed form does not. If the two differ by more than rounding, the closed form is
    compared with a Taylor series of more terms instead (`FINE_ORDERS`), up to the sample where the
    usual series (`TRUTH_ORDERS`) departs from this one.
    """

    def by_ode(orders: Orders) -> Trajectory:
        return motion(scenario, problem, by_form.t, integrate(problem, by_form.t, orders))

    usual = by_ode(TRUTH_ORDERS)
    difference = errors_between(scenario, by_form, usual)
    if max(value for _, value in difference) <= ROUNDING:
        return difference
    finest = by_ode(FINE_ORDERS)
    n = _count_of_agreeing_samples(scenario, finest, usual)
    return errors_between(scenario, by_form.until(n), finest.until(n))


def _count_of_agreeing_samples(
    scenario: Scenario, trajectory: Trajectory, coarser: Trajectory
) -> int:
    """Return the number of samples before the first at which two motions differ.

    They differ if ω, relative, or attitude, rad, is apart by more than `MAX_UNCERTAINTY`.
    """
    series = error_series(scenario, trajectory, coarser)
    beyond = np.flatnonzero(np.maximum(series["omega"], series["attitude"]) > MAX_UNCERTAINTY)
    return int(beyond[0]) if len(beyond) else len(trajectory.t)


def _conditioning_of_closed(
    scenario: Scenario, problem: Problem, trajectory: Trajectory, within_reach: Trajectory
) -> Errors:
    """Return the conditioning of a motion in closed form.

    It is computed by the ODE at the times of `within_reach`, which the ODE integrator reaches
    quickly. If `trajectory` goes further, it is also computed by closed forms, which must be found
    for each changed problem at a higher cost, and the larger result is returned.
    """

    def by_ode(neighbour: Problem) -> Trajectory:
        times = within_reach.t
        return motion(scenario, neighbour, times, integrate(neighbour, times, CHECK_ORDERS))

    def by_form(neighbour: Problem) -> Trajectory:
        form = closed_form(neighbour)
        assert form is not None, "a nudge keeps the symmetry that the closed form rests on"
        return motion(scenario, neighbour, trajectory.t, form.states(trajectory.t))

    near = conditioning(scenario, problem, within_reach, by_ode)
    if trajectory.t[-1] <= within_reach.t[-1]:
        return near
    far = conditioning(scenario, problem, trajectory, by_form)
    return _larger(near, far)


def _solve_ode(scenario: Scenario, problem: Problem, times: FloatArray) -> Solution:
    """Return the solution by the ODE, with its conditioning."""
    solution = _by_series(scenario, problem, times)
    within = solution.trajectory

    def solved(neighbour: Problem) -> Trajectory:
        return motion(scenario, neighbour, within.t, integrate(neighbour, within.t, CHECK_ORDERS))

    return replace(
        solution,
        uncertainty=_larger(solution.uncertainty, rounding_of(scenario, within)),
        conditioning=conditioning(scenario, problem, within, solved),
    )


def _by_series(scenario: Scenario, problem: Problem, times: FloatArray) -> Solution:
    """Return the solution by the ODE, without its conditioning, which would take twice as long.

    Conditioning is NaN, and uncertainty does not include the errors that `rounding_of` returns.
    """
    known = _integrated_to_horizon(scenario, problem, times)
    apart = errors_between(scenario, known.trajectory, known.coarser)
    return Solution(
        trajectory=known.trajectory,
        method="Taylor series of the equations of motion, low orders in double-double",
        uncertainty=_at_least(apart, ROUNDING),
        conditioning=Errors(**{name: np.nan for name, _ in apart}),
        horizon=known.horizon,
        lifts_off=known.lifts_off,
    )


class _Known(NamedTuple):
    """A motion computed by two series, up to the first sample at which they disagree.

    Attributes
    ----------
    trajectory : the motion by the more expensive series
    coarser : the motion by the less expensive one
    horizon, lifts_off : as in `Solution`
    """

    trajectory: Trajectory
    coarser: Trajectory
    horizon: float | None
    lifts_off: bool = False


def _integrated_to_horizon(scenario: Scenario, problem: Problem, times: FloatArray) -> _Known:
    """Return the motion by two series, up to where they disagree or the body leaves its table.

    Raises
    ------
    IntegrationError
        If the motion is not known at the first of the times, or cannot be integrated.
    """

    def integrated(orders: Orders) -> Trajectory:
        return motion(scenario, problem, times, integrate(problem, times, orders))

    try:
        coarser, trajectory = integrated(CHECK_ORDERS), integrated(TRUTH_ORDERS)
    except LiftOffError as lift_off:
        within = times[times < lift_off.time]
        if not len(within):
            raise
        known = _integrated_to_horizon(scenario, problem, within)
        if known.horizon is not None:
            return known
        return known._replace(horizon=lift_off.time, lifts_off=True)
    n = _count_of_agreeing_samples(scenario, trajectory, coarser)
    if n < len(times):  # chaos: the most expensive series is known to later times
        coarser, trajectory = trajectory, integrated(FINE_ORDERS)
        n = _count_of_agreeing_samples(scenario, trajectory, coarser)
    if n == 0:
        raise IntegrationError(
            f"The motion is chaotic and not known any more at {times[0]} s. Ask for earlier times."
        )
    horizon = float(times[n]) if n < len(times) else None
    return _Known(trajectory.until(n), coarser.until(n), horizon)


def _checked_times(times: FloatArray, rate: float) -> FloatArray:
    """Return the times, s, at which a closed form is compared with the ODE.

    They are spread over the time span that the ODE integrator reaches quickly, and again over the
    first turns, in which it is certainly accurate. They need not be the sample times: a wrong
    closed form is wrong at these times as well.

    Parameters
    ----------
    times : the sample times, of which only the last matters, s
    rate : fastest rate of the motion, rad/s
    """
    end = min(CHECKED_TURN / rate, times[-1]) if rate else times[-1]
    sure = min(SURE_TURN / rate, end) if rate else end
    return np.union1d(*(np.linspace(0.0, span, CHECKED_SAMPLES) for span in (sure, end)))


def _larger(errors: Errors, others: Errors) -> Errors:
    """Return for each signal the larger of its two errors."""
    return Errors(**{name: max(size, others[name]) for name, size in errors})


def _at_least(errors: Errors, least: float) -> Errors:
    """Return errors, each raised to `least` if it is smaller."""
    return Errors(**{name: max(value, least) for name, value in errors})
