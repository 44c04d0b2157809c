"""Speed and error of the reference and of scipy's DOP853.

Errors are against the Taylor series of orders 34/18 in double-double, itself right to 1e-22 (see
docs/explanation/ode.md): the largest difference in q, up to sign, and in ω over its size.
Ratios are of CPU seconds, all methods in turn: their median over the rounds, with the distance of
the quartiles. Takes three minutes.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from bench_timing import in_turn, ratio
from mpmath import mp
from numba import njit
from rich.console import Console
from rich.table import Column, Table
from scipy.integrate import solve_ivp
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.taylor import FINE_ORDERS, TRUTH_ORDERS, Orders, integrate_double_double
from spincheck.scenarios import FloatArray, Scenario, find, load, loads
from spincheck.scenarios.exact import DIGITS

#: ω and q at times (n,): (n, 7) double or long double.
Solver = Callable[[FloatArray], np.ndarray]

ROUNDS = 7
#: What DOP853 does in some tenths of a second, and a closed form in as many hundredths.
TIMED_PERIODS = 50
SAMPLES_PER_PERIOD = 1_000
#: Errors are measured after so many; DOP853's only after the former.
PERIODS, LATER_PERIODS = 100, 10_000
#: The least tolerance that scipy accepts, and the second method's (`cross_check`).
TOLERANCES = (2.3e-14, 1e-13)
TIGHTEST = f"DOP853 {TOLERANCES[0]:g}"
CLOSED_FORM = "closed form"
#: Goals: samples a second of a closed form, and DOP853's time over that of the series.
SAMPLES_GOAL, RATIO_GOAL = 1e6, 25

#: Regular, so that errors are the methods' and not the motion's.
LOPSIDED = """spincheck = 1
title = "A lopsided top that does not tumble"
source = "made for the bench"
[body]
mass = 10.0
inertia = [1.0, 1.3, 0.7]
inertia_about = "origin"
com = [0.02, 0.01, 0.09]
[start]
quaternion_wxyz = [0.96, 0.0, 0.28, 0.0]
omega_body = [0.5, 1.0, 3.0]
[effects.pivot]
[effects.gravity]
acceleration = [0.0, 0.0, -1.0]
[window]
duration = 2.0
samples = 2
"""
#: Scenes by class, all regular.
CASES = {
    "free symmetric": "discus-wobble",
    "free asymmetric": "mujoco-box",
    "near its separatrix": "tennis-racket",
    "heavy symmetric": "nutation-loops",
    "heavy asymmetric": None,
}


@dataclass(frozen=True)
class Measured:
    """One method on one scene.

    Attributes
    ----------
    ms_a_period : CPU, the least over the rounds, with one sample at the end
    times_the_series : its time over that of the series 28/10, median and distance of quartiles
    samples_a_second : CPU, the most over the rounds, at `SAMPLES_PER_PERIOD`
    slower_than_ours : its time for those samples over that of the closed form (of the series where
        there is none), median and distance of quartiles
    error, later_error : after `PERIODS` and `LATER_PERIODS`; None where it was not measured
    """

    scene: str
    method: str
    ms_a_period: float
    times_the_series: tuple[float, float]
    samples_a_second: float
    slower_than_ours: tuple[float, float]
    error: float
    later_error: float | None


class Constants(NamedTuple):
    """Of the equations: (Ij − Ik)/Ii and l/I by axis, and g in world axes.

    Whether the top is heavy spares a free one what comes to nothing.
    """

    heavy: bool
    euler: Sequence[Any]
    next_: Sequence[Any]
    after: Sequence[Any]
    gravity: Sequence[Any]


def constants(problem: Problem) -> Constants:
    """Rounded once, from sixty digits."""
    cyclic = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    moments, lever = problem.moments, problem.lever_axes
    with mp.workdps(DIGITS):
        return Constants(
            any(lever) and any(problem.gravity_world),
            [float((moments[j] - moments[k]) / moments[i]) for i, j, k in cyclic],
            [float(lever[j] / moments[i]) for i, j, k in cyclic],
            [float(-lever[k] / moments[i]) for i, j, k in cyclic],
            [*map(float, problem.gravity_world)],
        )


def rates(y: Sequence[Any], c: Constants) -> list[Any]:
    """ω' and q': Euler's equations along the principal axes, and q' = ½ q ω."""
    w1, w2, w3, q0, q1, q2, q3 = y
    spin1, spin2, spin3 = c.euler[0] * w2 * w3, c.euler[1] * w3 * w1, c.euler[2] * w1 * w2
    if c.heavy:
        g = c.gravity
        # Gravity as the body sees it: the columns of the rotation matrix times g.
        gamma1 = (q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3) * g[0]
        gamma1 = gamma1 + 2 * (q1 * q2 + q0 * q3) * g[1] + 2 * (q1 * q3 - q0 * q2) * g[2]
        gamma2 = (q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3) * g[1]
        gamma2 = gamma2 + 2 * (q1 * q2 - q0 * q3) * g[0] + 2 * (q2 * q3 + q0 * q1) * g[2]
        gamma3 = (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3) * g[2]
        gamma3 = gamma3 + 2 * (q1 * q3 + q0 * q2) * g[0] + 2 * (q2 * q3 - q0 * q1) * g[1]
        spin1 = spin1 + c.next_[0] * gamma3 + c.after[0] * gamma2
        spin2 = spin2 + c.next_[1] * gamma1 + c.after[1] * gamma3
        spin3 = spin3 + c.next_[2] * gamma2 + c.after[2] * gamma1
    return [
        spin1,
        spin2,
        spin3,
        (q1 * w1 + q2 * w2 + q3 * w3) * -0.5,
        (q0 * w1 + q2 * w3 - q3 * w2) * 0.5,
        (q0 * w2 + q3 * w1 - q1 * w3) * 0.5,
        (q0 * w3 + q1 * w2 - q2 * w1) * 0.5,
    ]


def dop853(problem: Problem, tolerance: float, compiled: bool) -> Solver:
    """Scipy's, its right side in Python floats or compiled by numba."""
    c = constants(problem)
    y0 = np.array([*problem.omega_axes, *problem.q_world_axes], dtype=float)

    def in_python(_: float, y: FloatArray) -> list[float]:
        return rates(y.tolist(), c)

    right_side: Callable[..., Any] = in_python
    if compiled:
        frozen = Constants(c.heavy, *(tuple(row) for row in c[1:]))
        shared = njit(rates)

        @njit  # type: ignore[untyped-decorator]
        def by_numba(_: float, y: FloatArray) -> FloatArray:
            return np.array(shared((y[0], y[1], y[2], y[3], y[4], y[5], y[6]), frozen))

        right_side = by_numba

    def solve(times: FloatArray) -> np.ndarray:
        solved = solve_ivp(
            right_side, (0, times[-1]), y0, "DOP853", times, rtol=tolerance, atol=tolerance
        )
        return np.asarray(solved.y.T)

    return solve


def scenario(name: str | None) -> Scenario:
    return loads(LOPSIDED, name="lopsided") if name is None else load(find([name])[0])


def series(problem: Problem, orders: Orders) -> Solver:
    """The project's integrator, with all its digits that a long double holds."""

    def solve(times: FloatArray) -> np.ndarray:
        states = integrate_double_double(problem, times, orders)
        high = np.hstack([states.omega_axes, states.q_world_axes]).astype(np.longdouble)
        return high + np.hstack([states.omega_low, states.q_low])

    return solve


def by_closed_form(problem: Problem) -> Solver | None:
    form = closed_form(problem)
    if form is None:
        return None
    return lambda times: np.hstack(form.states(times)[::-1])


def methods(problem: Problem) -> dict[str, Solver]:
    """By name, ours first."""
    ours = by_closed_form(problem)
    solvers: dict[str, Solver] = {} if ours is None else {CLOSED_FORM: ours}
    solvers["series 28/10"] = series(problem, TRUTH_ORDERS)
    for tolerance in TOLERANCES:
        solvers[f"DOP853 {tolerance:g}"] = dop853(problem, tolerance, compiled=False)
    solvers[f"DOP853 {TOLERANCES[0]:g}, numba"] = dop853(problem, TOLERANCES[0], compiled=True)
    return solvers


def error(states: np.ndarray, exact: np.ndarray) -> float:
    """Largest over the samples, of states (n, 7)."""
    q, true_q = states[:, 3:], exact[:, 3:]
    either = [np.abs(q - sign * true_q).max(axis=1) for sign in (1, -1)]
    omega = np.abs(states[:, :3] - exact[:, :3]).max() / np.abs(exact[:, :3]).max()
    return float(max(np.minimum(*either).max(), omega))


def errors(
    solvers: dict[str, Solver], problem: Problem, period: float, periods: int
) -> Iterator[float]:
    """Of each, at times spread over a span."""
    times = period * periods * np.array([0.0, 0.37, 0.71, 1.0])
    exact = series(problem, FINE_ORDERS)(times)
    for solver in solvers.values():
        yield error(solver(times), exact)


def measure(kind: str, name: str | None) -> list[Measured]:
    """All methods on one scene."""
    scene = scenario(name)
    problem = rotational_problem(scene)
    form = closed_form(problem)
    period = scene.window.duration if form is None or form.period is None else form.period
    solvers = methods(problem)
    ours = next(iter(solvers))
    span = TIMED_PERIODS * period
    end, grid = np.array([0.0, span]), np.linspace(0, span, TIMED_PERIODS * SAMPLES_PER_PERIOD)
    to_end = in_turn(ROUNDS, [lambda s=s: s(end) for s in solvers.values()])  # type: ignore[misc]
    sampled = in_turn(ROUNDS, [lambda s=s: s(grid) for s in solvers.values()])  # type: ignore[misc]
    names = list(solvers)
    soon = dict(zip(names, errors(solvers, problem, period, PERIODS), strict=True))
    lasting = {name: s for name, s in solvers.items() if not name.startswith("DOP853")}
    late = dict(zip(lasting, errors(lasting, problem, period, LATER_PERIODS), strict=True))
    return [
        Measured(
            kind,
            method,
            1e3 * float(to_end[:, k].min()) / TIMED_PERIODS,
            ratio(to_end[:, k] / to_end[:, names.index("series 28/10")]),
            len(grid) / float(sampled[:, k].min()),
            ratio(sampled[:, k] / sampled[:, names.index(ours)]),
            soon[method],
            late.get(method),
        )
        for k, method in enumerate(names)
    ]


def shown(sample: tuple[float, float]) -> str:
    middle, spread = sample
    return f"{middle:.3g} ± {spread:.1g}"


def scene_table(rows: list[Measured]) -> Table:
    grid = Table(
        Column("method", no_wrap=True),
        "ms a period",
        "over the series",
        f"samples a second (goal {SAMPLES_GOAL:g})",
        "over ours",
        f"error, {PERIODS} periods",
        f"{LATER_PERIODS} periods",
        title=f"{rows[0].scene}, CPU over {TIMED_PERIODS} periods; goal for {TIGHTEST} over the "
        f"series {RATIO_GOAL}",
    )
    for row in rows:
        missed = row.method == TIGHTEST and row.times_the_series[0] < RATIO_GOAL
        slow = row.method == CLOSED_FORM and row.samples_a_second < SAMPLES_GOAL
        later = "" if row.later_error is None else f"{row.later_error:.0e}"
        grid.add_row(
            row.method,
            f"{row.ms_a_period:.3g}",
            shown(row.times_the_series) + (" !" if missed else ""),
            f"{row.samples_a_second:.2g}" + (" !" if slow else ""),
            shown(row.slower_than_ours),
            f"{row.error:.0e}",
            later,
        )
    return grid


def main() -> None:
    """Measure, and print tables."""
    console = Console(width=120, markup=False)
    for case in CASES.items():
        console.print(scene_table(measure(*case)))


if __name__ == "__main__":
    main()
