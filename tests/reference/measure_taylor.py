"""Prints the figures of docs/explanation/ode.md: error and cost, beside scipy's DOP853.

    PYTHONPATH=tests/support:tests/bench python tests/reference/measure_taylor.py

Both integrators are timed in turn, in CPU time, least of three; it takes about twenty seconds.
"""

from collections.abc import Callable
from time import process_time

import numpy as np
from bench_rivals import dop853
from spincheck.reference.taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    integrate,
    integrate_double_double,
)
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
        times = np.array([COMPARED_PERIODS * period])
        theirs_at = dop853(p, TOLERANCE, compiled=False)
        pairs = [
            (seconds(lambda: integrate(p, times)), seconds(lambda: theirs_at(times)))  # noqa: B023
            for _ in range(REPEATS)
        ]
        mine, theirs = (min(column) * 1e3 / COMPARED_PERIODS for column in zip(*pairs, strict=True))
        exact = integrate_double_double(p, times, FINE_ORDERS)
        error = apart(integrate_double_double(p, times), exact)
        omega_error = np.abs(theirs_at(times)[-1, :3] - exact.omega_axes[0]).max()
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
