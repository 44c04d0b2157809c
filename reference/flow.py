"""The exact flow of many states at once, each over its own time span, in double precision.

It is integrated by the Taylor series of `taylor_coefficients`, as the exact motion is, but without
double-doubles: rounding errors are a few ulp in a radian, and engines' states have such errors too.
"""

import math
from functools import lru_cache

import numpy as np

from ..scenarios import FloatArray, Scenario, Trajectory
from ..scenarios.mechanics import RECENT
from .kernel import allocating, kernel
from .motion import Flight, along_axes, assembled
from .problem import Problem
from .rotational_problem import rotational_problem
from .taylor import IntegrationError, constants_of, inverses_to, terms_of
from .taylor_coefficients import COLUMNS, MOMENTUM, OMEGA, STATE, Q, Terms, extend
from .taylor_march import start_from_state, step_size

#: Orders of the series, from cheap to expensive. The longest step of order N is e⁻³⁶ᐟᴺ of the
#: radius of convergence: the last term is then e⁻³⁶ of the state, an ulp. A step takes the first
#: order whose longest step reaches the end of the time span, or else the last.
ORDERS = (8, 12, 18)
DIGITS = 2.0 * ORDERS[-1]
#: Largest number of steps of one state; a step takes some 3 µs.
MAX_STEPS = 100_000


def flow(scenario: Scenario, states: Trajectory, spans: FloatArray) -> Trajectory:
    """Return the states to which the exact motion takes given states, each after its own time span.

    If the body has a pivot, com and velocity are not read: attitude and ω determine them. It is not
    detected that a body leaves its table: the table also pulls.

    Parameters
    ----------
    states : at least n states, of which the first n are used; their times do not matter
    spans : time spans, s, (n,); a negative span leads to an earlier state

    Returns
    -------
    n states, with the times of the states they started from

    Raises
    ------
    IntegrationError
        If a motion leaves the range of doubles, or takes more than `MAX_STEPS` steps.
    """
    problem, constants, terms = _posed(scenario)
    inverses = inverses_to(ORDERS[-1])[0]
    table = np.empty((len(spans), STATE))
    attitude, spin = table[:, Q : Q + 4], table[:, OMEGA : OMEGA + 3]
    q_world_axes, omega_axes = along_axes(problem, states)
    attitude[:], spin[:] = q_world_axes[: len(spans)], omega_axes[: len(spans)]
    kept = scenario.kept(states.omega_body, states.spins)[: len(spans)]
    momenta = kept @ np.array(problem.kept_axes, dtype=float).reshape(-1, 3)
    done = flow_each(constants.copy(), inverses, terms, table, momenta, spans, MAX_STEPS)
    if done < len(spans):
        raise IntegrationError(
            f"The motion from state {done} cannot be followed for {spans[done]:g} s: it is too "
            f"fast for doubles, or for {MAX_STEPS} steps. Ask for a shorter span."
        )
    flight = Flight(spans, states.com_world[: len(spans)], states.velocity_world[: len(spans)])
    return assembled(scenario, problem, states.t[: len(spans)], (attitude, spin), flight, kept)


@lru_cache(maxsize=RECENT)
def _posed(scenario: Scenario) -> tuple[Problem, FloatArray, Terms]:
    """Return a scene's problem, and the constants and terms of its equations of motion.

    They are cached, because computing them takes as long as many calls of `flow`.
    """
    problem = rotational_problem(scenario)
    terms = terms_of(problem)
    return problem, constants_of(problem)[0], terms._replace(momentum=bool(problem.kept))


@kernel
def _advance(series: FloatArray, order: int, h: float) -> None:
    """Replace order 0 of a series by the sum of orders 0 to `order` at time h, s, by Horner."""
    for i in range(STATE):
        total = 0.0
        for n in range(order, -1, -1):
            total = total * h + series[n, i]
        series[0, i] = total


@allocating
def flow_each(
    constants: FloatArray,
    inverses: FloatArray,
    terms: Terms,
    states: FloatArray,
    momenta: FloatArray,
    spans: FloatArray,
    steps: int,
) -> int:
    """Replace each state by the state that the exact motion takes it to, after its own time span.

    Parameters
    ----------
    constants, inverses : the first of the two arrays, high parts, that `taylor.constants_of` and
        `taylor.inverses_to` return; the row of `constants` for h is overwritten
    terms : which terms the equations of motion have
    states : ω, rad/s, and q, w x y z, of each state, principal axes, (n, STATE); overwritten
    momenta : for each state the constant angular momentum h of the rotors, kg m²/s, principal axes,
        (n, 3)
    spans : time spans, s, (n,), which may be negative
    steps : largest number of steps for a state

    Returns
    -------
    The number of states, counted from the first, that were replaced: fewer than n if the next one
    takes more than `steps` steps or leaves the range of doubles
    """
    series = np.empty((ORDERS[-1] + 1, COLUMNS))
    for k in range(spans.size):
        for i in range(STATE):
            series[0, i] = states[k, i]
        if terms.momentum:
            constants[MOMENTUM] = momenta[k]
        left, direction = abs(spans[k]), math.copysign(1.0, spans[k])
        taken = 0
        while left > 0.0:
            start_from_state(series, constants, terms)
            order, h = 0, 0.0
            for next_order in ORDERS:
                if h < left:
                    extend(series, constants, inverses, terms, order, next_order)
                    order = next_order
                    h = step_size(series, order) * math.exp(2.0 - DIGITS / order)
            if not h > 0.0 or taken == steps:
                return k
            _advance(series, order, direction * min(h, left))
            left -= h
            taken += 1
        for i in range(STATE):
            states[k, i] = series[0, i]
    return spans.size
