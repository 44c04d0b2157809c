"""Speed and error of the reference and of DOP853 (scipy) and heyoka's Taylor series.

Errors are against the Taylor series of orders 34/18 in double-double, itself right to 1e-22 (see
docs/explanation/ode.md): the largest difference in q, up to sign, and in ω over its size.
Ratios are of CPU seconds, all methods in turn: their median over the rounds, with the distance of
the quartiles. Takes three minutes.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from bench_rivals import HEYOKA, Solver, dop853, heyoka
from bench_timing import in_turn, ratio
from rich.console import Console
from rich.table import Column, Table
from spincheck.reference.closed_forms import closed_form
from spincheck.reference.problem import Problem
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.reference.taylor import FINE_ORDERS, TRUTH_ORDERS, Orders, integrate_double_double
from spincheck.scenarios import FloatArray, Scenario, find, load, loads

OUT = Path("build/bench/reference.json")
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
    if HEYOKA:
        solvers["heyoka, long double"] = heyoka(problem, np.longdouble)
        solvers["heyoka, double"] = heyoka(problem, float)
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
    """Measure, print tables, and write the same as JSON."""
    console = Console(width=120, markup=False)
    if not HEYOKA:
        console.print("heyoka is not installed and left out: pip install 'spincheck[bench]'")
    by_scene = []
    for case in CASES.items():
        by_scene.append(measure(*case))
        console.print(scene_table(by_scene[-1]))
    OUT.parent.mkdir(parents=True, exist_ok=True)
    figures = [asdict(row) for rows in by_scene for row in rows]
    OUT.write_text(json.dumps(figures, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
