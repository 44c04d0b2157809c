"""The exact derivatives of an exact motion by its start and by the parameters of its scene.

The derivation, the conventions and measured errors are in docs/explanation/sensitivities.md.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from mpmath import mp, mpf

from ..scenarios import FloatArray, Scenario, Trajectory, read_only
from ..scenarios.exact import DIGITS, product
from ..scenarios.fastest_rate import fastest_rate
from ..scenarios.principal import principal_axes
from ..scenarios.rotation import cross, matrix
from .dual_numbers import Dual
from .effect_terms import TERMS
from .kernel import as_kernels_take
from .parameter_changes import ENTRIES, Change, changed_problem, changes
from .problem import Problem
from .rotational_problem import rotational_problem
from .solve import EPS, ROUNDING
from .tangent_march import WIDTH, march_with_tangent
from .taylor import (
    CHECK_ORDERS,
    FINE_ORDERS,
    TRUTH_ORDERS,
    IntegrationError,
    Orders,
    constants_of,
    derived_constants,
    inverses_to,
    tables,
    terms_of,
)
from .taylor_coefficients import OMEGA, STATE, Q, Terms
from .taylor_march import DONE, PAUSED, Tables

#: Most steps of a march. A step takes some 15 µs. A march is made for each of up to thirty numbers,
#: by two series.
MAX_STEPS = 100_000
STEPS_AT_ONCE = 2_000
#: If the relative uncertainty is above this, the next, more expensive series is tried.
GOOD = 1e-12
#: Orders of the series, from cheap to expensive. Beside a saddle, second derivatives are as large
#: as the squares of first ones, and errors grow with them.
SERIES = (CHECK_ORDERS, TRUTH_ORDERS, FINE_ORDERS, Orders(40, 24))
#: Relative rounding error of the start and the constants, which all series share: they are rounded
#: to double-double.
PAIR = EPS**2
#: Number of adjacent columns of an array of derivatives that have the same unit.
KIND = 3
#: Derivatives of six numbers, (n, 6, k), by name.
Arrays = dict[str, FloatArray]


@final
@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of a motion's state; arrays are read-only.

    The rows are a turn of the attitude, δR = R [δθ]×, rad, then ω, rad/s, both in body axes.
    The columns are the numbers that the derivatives are with respect to. In each derivative all
    other numbers stay constant: ω at the start in body axes, and the inertia about the com where
    mass or com change. The body's numbers are those of `[body]`, without rotors.

    Attributes
    ----------
    t : (n,) s
    state_transition : (n, 6, 6), by attitude, rad, and ω, rad/s, at t = 0, both in body axes
    parameters : by the name of a parameter that the scene has; each is also an attribute

        - `inertia` (n, 6, 6), by the entries Ixx, Iyy, Izz, Ixy, Ixz, Iyz of the tensor about the
          com, kg m², body axes, which stays symmetric
        - `moments` (n, 6, 3), by the principal moments about the com, kg m², at constant axes
        - `mass` (n, 6), kg; `com` (n, 6, 3), from the body's origin, m, body axes
        - the parameters of effects: `gravity` (n, 6, 3), m/s², world axes; constant torques
          (n, 6, 3), N m, in the axes that they are constant in; coefficients (n, 6); the spins of
          rotors at t = 0 (n, 6, rotors), rad/s, zero for rotors that cannot turn
    translation : None on a pivot; for other bodies, arrays with the same names and columns, whose
        rows are the com, m, and its velocity, m/s, world axes. `state_transition`, (n, 6, 12), has
        further columns for com and velocity at t = 0, zero along axes along which the body is held
    rate : fastest rate of the motion, rad/s: the unit of ω in `conditioning` and `uncertainty`
    conditioning : (n,), the largest singular value of the state transition: the largest factor by
        which a small change of the start grows
    uncertainty : for each array, by its name, a bound on its errors relative to its largest value,
        both over all samples
    """

    t: FloatArray
    state_transition: FloatArray
    parameters: Mapping[str, FloatArray]
    translation: Mapping[str, FloatArray] | None
    rate: float
    conditioning: FloatArray
    uncertainty: Mapping[str, float]

    def __getattr__(self, name: str) -> FloatArray:
        parameters: Mapping[str, FloatArray] = vars(self).get("parameters", {})
        if name not in parameters:
            raise AttributeError(
                f"'{name}' must be a parameter of the scene, which has {', '.join(parameters)}."
            )
        return parameters[name]


#: Names of the arrays that a state transition consists of.
OF_START = ("attitude", "omega", "com_start", "velocity_start")


def sensitivity(
    scenario: Scenario, motion: Trajectory, *, of_start_alone: bool = False
) -> Sensitivity:
    """Return the derivatives of a scene's motion at the times of its samples.

    Parameters
    ----------
    motion : the exact motion, as far as it is known
    of_start_alone : whether derivatives by parameters, which take most of the time, are left out

    Raises
    ------
    IntegrationError
        If a derivative leaves the range of doubles, or takes more than `MAX_STEPS` steps.
    """
    problem = rotational_problem(scenario)
    by_parameter = changes(scenario, problem)
    if of_start_alone:
        by_parameter = {name: by_parameter[name] for name in OF_START if name in by_parameter}
    by_name = {
        name: [each] if isinstance(each, Change) else each for name, each in by_parameter.items()
    }
    single = {name for name, each in by_parameter.items() if isinstance(each, Change)}
    rate = fastest_rate(scenario, motion.omega_body) or 1.0

    varied_by = _varied(scenario, problem)
    varied = {name: [varied_by(one) for one in each] for name, each in by_name.items()}

    def found(orders: Orders) -> tuple[Arrays, Arrays]:
        turned = {
            name: np.stack([_motion_derivative(one, motion.t, orders) for one in each], -1)
            for name, each in varied.items()
        }
        pivoted = scenario.constraint.is_pivot
        translated = {} if pivoted else _translated(scenario, motion, by_name, turned)
        return _named(scenario, turned, single), _named(scenario, translated, single)

    finer, uncertainty = found(SERIES[0]), {"": np.inf}
    for orders in SERIES[1:]:
        if max(uncertainty.values()) > GOOD:
            coarser, finer = finer, found(orders)
            uncertainty = _apart(coarser, finer, rate)
    turned, translated = finer
    transition = turned["state_transition"]
    conditioning = _conditioning(transition, rate)
    started = PAIR * float(conditioning.max())
    return Sensitivity(
        t=motion.t,
        state_transition=transition,
        parameters={name: turned[name] for name in turned if name != "state_transition"},
        translation=translated or None,
        rate=rate,
        conditioning=conditioning,
        uncertainty={name: value + started for name, value in uncertainty.items()},
    )


@dataclass(frozen=True, eq=False)
class _Varied:
    """A problem and its derivative by one number, in double-double, for series of any order.

    Attributes
    ----------
    constants : constants of the equations, and their derivatives
    terms : which terms the equations have
    start : ω, rad/s, and the quaternion of the attitude, principal axes, in one row
    tangent : the derivatives of `start`, in one row
    tensor : δI, kg m² per unit of the number, principal axes, (3, 3)
    R_axes_body : matrix from body axes to principal axes, (3, 3)
    """

    constants: Dual
    terms: Terms
    start: Tables
    tangent: Tables
    tensor: Tables
    R_axes_body: FloatArray


def _varied(scenario: Scenario, problem: Problem) -> Callable[[Change], _Varied]:
    """Return a function that returns, for a given change, the problem and its derivative by it."""
    # The effects of the scene, not only those that turn the body: a lever that is zero may have a
    # derivative that is not.
    terms = terms_of(problem, scenario.called_for & TERMS.keys())
    constants, start = constants_of(problem), tables([(*problem.omega_axes, *problem.q_world_axes)])
    R_axes_body = matrix(np.array(problem.q_axes_body, dtype=float))

    def along(change: Change) -> _Varied:
        with mp.workdps(DIGITS):
            turn = product(problem.q_world_axes, (mpf(0), *change.turn_axes))
            tangent = (*change.omega_axes, *(x / 2 for x in turn))
        derived = derived_constants(problem, changed_problem(problem, change))
        return _Varied(
            Dual(constants, derived),
            terms,
            start,
            tables([tangent]),
            tables(change.inertia_axes),
            R_axes_body,
        )

    return along


def _motion_derivative(varied: _Varied, times: FloatArray, orders: Orders) -> FloatArray:
    """Return the derivative of a motion with respect to a change, body axes, (n, 6).

    The columns are a rotation vector, rad, and ω, rad/s, per unit of the change.

    Parameters
    ----------
    varied : the problem and its derivative with respect to the change
    times : s, (n,)
    orders : orders of the Taylor series
    """
    states, tangents = _marched(varied, times, orders)
    (w, x, y, z), (dw, dx, dy, dz) = states[:, Q : Q + 4].T, tangents[:, Q : Q + 4].T
    # The vector part of q̄ δq is δθ/2.
    turn_axes = 2 * np.stack(
        [
            w * dx - x * dw - (y * dz - z * dy),
            w * dy - y * dw - (z * dx - x * dz),
            w * dz - z * dw - (x * dy - y * dx),
        ],
        axis=-1,
    )
    R = varied.R_axes_body
    return np.hstack([turn_axes @ R, tangents[:, OMEGA : OMEGA + 3] @ R])


def _marched(varied: _Varied, times: FloatArray, orders: Orders) -> tuple[FloatArray, FloatArray]:
    """Return states and their derivatives by a change, principal axes, (n, STATE) each.

    Parameters
    ----------
    varied : the problem and its derivative with respect to the change
    times : s, (n,)
    orders : orders of the Taylor series

    Raises
    ------
    IntegrationError
        If a derivative leaves the range of doubles, or takes more than `MAX_STEPS` steps.
    """
    series = Dual(*(_first_order(row, orders) for row in (varied.start, varied.tangent)))
    high, low = inverses_to(orders.total)
    counts = np.arange(orders.total + 1.0)
    inverses = np.vstack([high, counts]), np.vstack([low, 0 * counts])
    numbers = (
        varied.constants,
        Dual(inverses, (np.zeros_like(inverses[0]), np.zeros_like(inverses[0]))),
        varied.terms,
        varied.tensor,
        orders.double_double,
        series,
    )
    clock, times = np.zeros(2), as_kernels_take(times)
    states, tangents = np.zeros((2, len(times), STATE))
    sample, steps, outcome = 0, 0, PAUSED
    while outcome == PAUSED and steps < MAX_STEPS:
        outcome, sample = march_with_tangent(
            *numbers, clock, times, states, tangents, sample, STEPS_AT_ONCE
        )
        steps += STEPS_AT_ONCE
    if outcome != DONE:
        why = (
            f"take more than {MAX_STEPS} steps"
            if outcome == PAUSED
            else "leave the range of doubles"
        )
        raise IntegrationError(
            f"The derivatives of the motion {why} beyond {clock[0]:.6g} s, got times up to "
            f"{times[-1]:.6g} s. Ask for earlier times."
        )
    return states, tangents


def _first_order(row: Tables, orders: Orders) -> Tables:
    """Return the table of a Taylor series that has only its order 0, as high and low parts.

    All other coefficients are zeros, for orders up to `orders.total`. `row` has the first numbers
    of order 0: the state, or its derivative.
    """
    series = np.zeros((2, orders.total + 1, WIDTH))
    series[:, :1, : row[0].shape[1]] = row
    return series[0], series[1]


def _translated(
    scenario: Scenario, motion: Trajectory, by_name: dict[str, list[Change]], turned: Arrays
) -> Arrays:
    """Return derivatives of com and velocity, world axes, (n, 6, k), of a body without a pivot.

    Along world axes that are not held the body is in free flight; on a table the height of the com
    is that of the rotated lever. n is the number of samples, and k the number of components that
    one name has.

    Parameters
    ----------
    by_name : changes of the problem, by the name of what derivatives are with respect to
    turned : derivatives of attitude and ω, by the same names, (n, 6, k)
    """
    flying = ~np.array(scenario.constraint.is_held)
    t = motion.t[:, None, None]
    flown = np.diag(flying.astype(float)) + 0 * t
    nothing = np.zeros_like(flown)
    derived = {name: np.zeros_like(values) for name, values in turned.items()}
    if "gravity" in derived:
        derived["gravity"] = np.concatenate([flown * t**2 / 2, flown * t], 1)
    if not flying.all():
        for name, values in turned.items():
            levers = np.array([one.lever_body for one in by_name[name]], dtype=float)
            derived[name][:, 2::3] = _heaved(scenario, motion, values, levers)
    derived["com_start"] = np.concatenate([flown, nothing], 1)
    derived["velocity_start"] = np.concatenate([flown * t, flown], 1)
    return derived


def _heaved(
    scenario: Scenario, motion: Trajectory, turned: FloatArray, levers: FloatArray
) -> FloatArray:
    """Return derivatives of the com's height, ẑ·R lever, and its rate, ẑ·R (ω × lever), at n times.

    R is the attitude, and the lever the vector from the tip on a table to the com.

    Parameters
    ----------
    turned : derivatives of attitude and ω by k numbers, (n, 6, k)
    levers : derivatives of the lever by these numbers, body axes, (k, 3)

    Returns
    -------
    (n, 2, k)
    """
    up_body, lever = motion.R_world_body.as_matrix()[:, 2], scenario.constraint.lever
    heaved = np.empty((len(motion.t), 2, len(levers)))
    for k, longer in enumerate(levers):
        turn, spin = turned[:, :3, k], turned[:, 3:, k]
        swing = cross(turn, cross(motion.omega_body, lever)) + cross(spin, lever)
        heaved[:, 0, k] = ((cross(turn, lever) + longer) * up_body).sum(1)
        heaved[:, 1, k] = ((swing + cross(motion.omega_body, longer)) * up_body).sum(1)
    return heaved


def _named(scenario: Scenario, derived: Arrays, single: set[str]) -> Arrays:
    """Return derivatives by the names that `Sensitivity` has, with `moments` added.

    There are none if `derived` is empty.

    Parameters
    ----------
    derived : derivatives, by the names that `changes` returns
    single : names of scalars, whose arrays lose their last axis
    """
    if not derived:
        return {}
    starts = [derived[name] for name in OF_START if name in derived]
    arrays = {"state_transition": np.concatenate(starts, 2)}
    arrays |= {name: values for name, values in derived.items() if name not in OF_START}
    if "inertia" in arrays:
        axes = np.array(principal_axes(scenario.carrier.inertia_com_exact)[1], dtype=float)
        arrays["moments"] = arrays["inertia"] @ np.array([axes[i] * axes[j] for i, j in ENTRIES])
    arrays |= {name: arrays[name][..., 0] for name in single}
    return {name: read_only(values) for name, values in arrays.items()}


def _apart(
    coarser: tuple[Arrays, Arrays], finer: tuple[Arrays, Arrays], rate: float
) -> dict[str, float]:
    """Return for each array the difference of two solutions relative to the array's largest value.

    `ROUNDING` is added to each difference.

    Parameters
    ----------
    coarser, finer : derivatives of rotation and of translation, from series of fewer and more terms
    rate : the unit of ω, rad/s
    """
    return {
        name: ROUNDING
        + max(
            _relative(one[name] - other[name], other[name], rate)
            for one, other in zip(coarser, finer, strict=True)
            if one
        )
        for name in finer[0]
    }


def _relative(difference: FloatArray, values: FloatArray, rate: float) -> float:
    """Return the largest difference relative to the largest value.

    Columns of different units are treated separately, and the largest of their ratios is returned.
    A ratio is 0 if all values in its columns are zero.

    Parameters
    ----------
    difference : differences of derivatives by k numbers from those of another solution, (n, 6, k);
        or by a single number, (n, 6)
    values : the derivatives, of the same shape
    rate : the unit of ω, rad/s
    """
    unit = np.repeat([1.0, rate], 3)[:, None]
    worst = 0.0
    for first in range(0, values[0, 0].size, KIND):
        sizes = []
        for array in (difference, values):
            kind = array.reshape(len(array), 6, -1)[..., first : first + KIND] / unit
            largest = np.abs(kind).max()
            # Scaled first: the squares of derivatives by the moments of a grain leave the range of
            # doubles.
            sizes.append(largest and largest * np.linalg.norm(kind / largest, axis=(1, 2)).max())
        worst = max(worst, sizes[0] / sizes[1] if sizes[1] else 0.0)
    return float(worst)


def _conditioning(state_transition: FloatArray, rate: float) -> FloatArray:
    """Return the largest singular value of each of n state transitions, (n,).

    `state_transition` is (n, 6, 6); ω in it is taken in units of `rate`, rad/s.
    """
    unit = np.repeat([1.0, rate], 3)
    return read_only(np.linalg.norm(state_transition / unit[:, None] * unit, 2, axis=(1, 2)))
