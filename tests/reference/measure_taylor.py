"""Prints the errors of docs/explanation/ode.md; costs beside scipy's DOP853: `make bench`.

PYTHONPATH=tests/support python tests/reference/measure_taylor.py
"""

from time import process_time

import numpy as np
from spincheck.reference.taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    integrate,
    integrate_double_double,
)
from taylor_problems import apart, problem

PERIODS = (1, 10, 100, 1_000, 10_000)

START = (0.96, 0.0, 0.28, 0.0)
DOWN = (0.0, 0.0, -1.0)
#: Each top with a time that is about a period of its nutation.
TOPS = {
    "free, asymmetric": (problem((1, 2, 3), (0.5, 1.0, 0.7), START), 6.0),
    "heavy, symmetric": (problem((1, 1, 0.6), (0.1, 0.4, 4.0), START, (0, 0, 1), DOWN), 3.0),
    "heavy, asymmetric": (
        problem((1.0, 1.3, 0.7), (0.5, 1.0, 3.0), START, (0.2, 0.1, 0.9), DOWN),
        2.0,
    ),
}


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


if __name__ == "__main__":
    begun = process_time()
    integrate(problem((1, 2, 3), (0, 0, 0)), np.array([0.0]))
    print(f"first call: {process_time() - begun:.1f} s")
    print_errors()
