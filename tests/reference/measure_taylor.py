"""Prints the figures of docs/explanation/ode.md: error and cost, beside scipy's DOP853.

Run it from the repository: ``python tests/reference/measure_taylor.py``. Both integrators are
timed in turn, in CPU time, least of three; it takes about twenty seconds.
"""

from collections.abc import Callable
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp
from spincheck.reference.problem import Problem
from spincheck.reference.taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    integrate,
    integrate_double_double,
)
from spincheck.scenarios import FloatArray
from taylor_problems import apart, problem

PERIODS = (1, 10, 100, 1_000, 10_000)
#: Over so many periods the two are compared: what DOP853 does in about half a second.
COMPARED_PERIODS = 100
#: The least that scipy accepts.
TOLERANCE = 2.3e-14
REPEATS = 3

START = (0.96, 0.0, 0.28, 0.0)
DOWN = (0.0, 0.0, -1.0)
#: Each top with a time that is about a period of its nutation.
TOPS = {
    "free, asymmetric": (problem((1, 2, 3), (0.5, 1.0, 0.7), START), 6.0),
    "heavy, symmetric": (
        problem((1, 1, 0.6), (0.1, 0.4, 4.0), START, (0, 0, 1), DOWN),
        3.0,
    ),
    "heavy, asymmetric": (
        problem((1.0, 1.3, 0.7), (0.5, 1.0, 3.0), START, (0.2, 0.1, 0.9), DOWN),
        2.0,
    ),
}


def right_side(p: Problem) -> Callable[[float, FloatArray], list[float]]:
    """ω' and q' in plain floats, which for seven numbers are faster than arrays."""
    i1, i2, i3 = (float(x) for x in p.moments)
    l1, l2, l3 = (float(x) for x in p.lever_axes)
    g = float(p.gravity_world[2])

    def rates(_: float, y: FloatArray) -> list[float]:
        w1, w2, w3, q0, q1, q2, q3 = y.tolist()
        g1 = 2 * g * (q1 * q3 - q0 * q2)
        g2 = 2 * g * (q2 * q3 + q0 * q1)
        g3 = g * (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3)
        return [
            ((i2 - i3) * w2 * w3 + l2 * g3 - l3 * g2) / i1,
            ((i3 - i1) * w3 * w1 + l3 * g1 - l1 * g3) / i2,
            ((i1 - i2) * w1 * w2 + l1 * g2 - l2 * g1) / i3,
            -0.5 * (q1 * w1 + q2 * w2 + q3 * w3),
            0.5 * (q0 * w1 + q2 * w3 - q3 * w2),
            0.5 * (q0 * w2 + q3 * w1 - q1 * w3),
            0.5 * (q0 * w3 + q1 * w2 - q2 * w1),
        ]

    return rates


def dop853(p: Problem, t: float) -> FloatArray:
    """The state at t, ω before q."""
    start = [float(x) for x in (*p.omega_axes, *p.q_world_axes)]
    solved = solve_ivp(
        right_side(p), (0, t), start, "DOP853", t_eval=[t], rtol=TOLERANCE, atol=TOLERANCE
    )
    return np.asarray(solved.y[:, -1])


def seconds(run: Callable[[], object]) -> float:
    """CPU time of one run."""
    start = process_time()
    run()
    return process_time() - start


def print_errors() -> None:
    """How far the exact motion and its cheaper check are from a dearer series."""
    print("error after so many periods:", *PERIODS)
    for name, (p, period) in TOPS.items():
        times = period * np.array(PERIODS, dtype=float)
        for orders in (TRUTH_ORDERS, CHECK_ORDERS):
            errors = [
                apart(
                    integrate_double_double(p, times[k : k + 1], orders),
                    integrate_double_double(p, times[k : k + 1], FINE_ORDERS),
                )
                for k in range(len(times))
            ]
            print(f"{name}, {orders}:", *(f"{error:.0e}" for error in errors))


def print_costs() -> None:
    """Milliseconds a period, both in turn, and the errors they buy."""
    print(f"\nover {COMPARED_PERIODS} periods: ms a period, error")
    for name, (p, period) in TOPS.items():
        t = COMPARED_PERIODS * period
        times = np.array([t])
        pairs = [
            (seconds(lambda: integrate(p, times)), seconds(lambda: dop853(p, t)))  # noqa: B023
            for _ in range(REPEATS)
        ]
        mine, theirs = (min(column) * 1e3 / COMPARED_PERIODS for column in zip(*pairs, strict=True))
        exact = integrate_double_double(p, times, FINE_ORDERS)
        error = apart(integrate_double_double(p, times), exact)
        omega_error = np.abs(dop853(p, t)[:3] - exact.omega_axes[0]).max()
        speed = np.abs(exact.omega_axes).max()
        print(
            f"{name}: Taylor {mine:.3f} {error:.0e}, DOP853 {theirs:.2f} "
            f"{omega_error / speed:.0e}, {theirs / mine:.0f} times"
        )


def main() -> None:
    """Print all."""
    resting = problem((1, 2, 3), (0, 0, 0))
    print(f"first call: {seconds(lambda: integrate(resting, np.array([0.0]))):.1f} s")
    print_errors()
    print_costs()


if __name__ == "__main__":
    main()
