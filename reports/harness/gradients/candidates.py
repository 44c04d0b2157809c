"""Jacobians that common mistakes would give in place of the exact one, by name of the mistake.

The effect of leaving a term out is computed to first order in the timestep; the error of this
approximation vanishes with the timestep. The state x is attitude and ω in the chart, so that the
derivative of dx/dt by x is a 6 × 6 matrix. δθ, rad, and δω, rad/s, are changes of the two, in body
axes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import permutations

import numpy as np
from scipy.optimize import minimize_scalar

from ....engines import State
from ....engines.checks.equations import Equations
from ....scenarios import FloatArray, Scenario, push
from ....scenarios.effects import gravity
from ....scenarios.rotation import cross, matrix
from ..measuring.steps import flowed
from .jacobians import CHANGES, CHART, WEIGHTS, Units, changed, stepped_by_rate

#: Names of the terms of I dω/dt.
TERMS = ("gravity", "applied torques", "gyroscopic torque")
#: ε, in rad and in rad/s, is the change of attitude and of ω by which an engine may take finite
#: differences. `POWERS` are the decimal logarithms of ε that are tried, and `SPACING` is their
#: distance.
SPACING = 0.125
POWERS = np.arange(-5.0, SPACING, SPACING).tolist()
#: Relative error of the derivatives of terms by differences, and so the tolerance of the fitted ε.
KNOWN = 1e-6


@dataclass(frozen=True, eq=False)
class Exact:
    """The exact Jacobians from K states over J spans of time, and those that mistakes would give.

    The Jacobians that mistakes would give are cached, as all derivatives of an engine are compared
    with them.

    Attributes
    ----------
    states : the K states
    spans : s, (J,); each is the duration of `steps` steps
    jacobians : the exact Jacobians, rad and rad/s, (J, K, 6, 6)
    units : units in which Jacobians are compared
    steps : number of steps that each Jacobian covers
    """

    scenario: Scenario
    states: State
    spans: FloatArray
    jacobians: FloatArray
    units: Units
    steps: int = 1

    @cached_property
    def in_world_axes(self) -> list[tuple[str, FloatArray]]:
        """Mistakes of world axes in words, with Jacobians by span and state, (J, K, 6, 6)."""
        return list(_in_world_axes(self))

    @cached_property
    def lacking(self) -> list[tuple[str, FloatArray]]:
        """Mistakes of a missing term in words, with Jacobians by span and state, (J, K, 6, 6)."""
        return list(_lacking(self))

    @cached_property
    def rates(self) -> list["_Rates"]:
        """The function dω/dt near each of the K states."""
        equations = Equations(self.scenario)
        return [_Rates(equations, self.states.rows(k), self.units) for k in range(self.count)]

    @cached_property
    def secants(self) -> dict[bool, list[FloatArray]]:
        """The errors that finite differences make in the derivative of dx/dt by x, (K, 6, 6) each.

        They are those in K states; x is attitude and ω in the chart, and its changes are the powers
        of 10 in `POWERS`. The key is True for central differences, and False for forward ones.
        """
        return {
            two_sided: [self.secant(power, two_sided) for power in POWERS]
            for two_sided in (False, True)
        }

    @property
    def count(self) -> int:
        """The number of states."""
        return len(self.states.omega_body)

    def secant(self, power: float, two_sided: bool) -> FloatArray:
        """Return the error that finite differences make in the derivative of dx/dt by x, (K, 6, 6).

        It is that in each of the K states; x is attitude and ω in the chart.

        Parameters
        ----------
        power : decimal logarithm of the change of attitude and ω by which differences are taken
        two_sided : True for central differences, False for forward differences
        """
        return np.array([one.secant(10.0**power, two_sided) for one in self.rates])

    def off_by(self, change: Callable[["_Rates"], FloatArray]) -> FloatArray:
        """Return the Jacobians that a mistake in the derivative of dx/dt by x gives, (J, K, 6, 6).

        x is attitude and ω in the chart. The Jacobians are from K states over J spans of time, to
        first order in the spans.

        Parameters
        ----------
        change : returns the error of that derivative near a state, (6, 6)
        """
        h = self.spans[:, None, None, None]
        return np.asarray(self.jacobians + h * np.array([change(one) for one in self.rates]))


def candidates(exact: Exact, limits: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield known mistakes of derivatives in words, with the Jacobians they give, (J, K, 6, 6).

    Parameters
    ----------
    exact : the exact Jacobians, from K states over J spans of time
    limits : difference of the engine's Jacobian from the exact one, divided by the span of time, in
        the limit of vanishing timesteps, (K, 6, 6), 1/s; each entry in the units of its row and
        column, rad and rad/s
    """
    P = exact.jacobians
    yield "it is zero: nothing is differentiated", 0 * P
    yield "it is the identity: the step is detached", 0 * P + np.eye(CHART)
    for taken in range(1, exact.steps):
        share = taken / exact.steps
        words = f"the tape is cut: it is of {taken} of {exact.steps} steps"
        yield words, share * P + (1 - share) * np.eye(CHART)
    yield "it is transposed", np.swapaxes(P, 2, 3)
    yield "it is the inverse, of a step back", np.asarray(np.linalg.inv(P), dtype=float)
    half: FloatArray = np.diag(np.repeat([0.5, 1.0], 3))
    twice: FloatArray = np.diag(np.repeat([2.0, 1.0], 3))
    words = "the attitude is in numbers of the quaternion, half of the angle, in its"
    yield f"{words} rows and columns", half @ P @ twice
    yield f"{words} rows", half @ P
    yield f"{words} columns", P @ twice
    yield from _detached(P)
    yield from exact.in_world_axes
    for order in list(permutations(range(3)))[1:]:
        kept = [*order, *(3 + axis for axis in order)]
        axes = "".join("xyz"[axis] for axis in order)
        yield f"axes are exchanged, {axes} for xyz", P[:, :, kept][..., kept]
    swapped = [3, 4, 5, 0, 1, 2]
    yield "ω comes first, and the attitude last", P[:, :, swapped][..., swapped]
    yield from exact.lacking
    for way, two_sided in {"forward": False, "central": True}.items():
        epsilon = _fitted(exact, limits, two_sided)
        made = exact.off_by(partial(_Rates.secant, epsilon=epsilon, two_sided=two_sided))
        yield f"ε of {way} differences is too large, about {epsilon:.2g}", made


def _detached(P: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield mistakes in words, each with the exact Jacobians in which some entries are zero.

    These are the rows of attitude, its columns, the rows of ω, or its columns.

    Parameters
    ----------
    P : the exact Jacobians, from K states over J spans of time, (J, K, 6, 6)
    """
    for what, first in {"attitude": 0, "ω": 3}.items():
        three = slice(first, first + 3)
        for part in ("rows", "columns"):
            remainder = P.copy()
            remainder[(..., three, slice(None)) if part == "rows" else (..., three)] = 0.0
            yield f"the {what} is detached: its {part} are zero", remainder


def _in_world_axes(exact: Exact) -> Iterator[tuple[str, FloatArray]]:
    """Yield mistakes in words, each with the exact Jacobians in world axes, (J, K, 6, 6).

    They are from K states over J spans of time. Those rows and columns are turned that belong to
    attitude, to ω, or to both. For changes δθ of the attitude and δω of ω, in body axes, ω along
    world axes changes by R (δω − ω × δθ), with R from body to world. An engine that only turns the
    derivative to world axes has R δω instead.
    """
    states, P = exact.states, exact.jacobians
    ends = _ends(exact)
    ways = {
        "attitude and ω": (True, True, True),
        "the attitude": (True, False, False),
        "ω": (False, True, True),
        "attitude and ω, both only turned,": (True, True, False),
        "ω, only turned,": (False, True, False),
    }
    for what, (turn, spin, carried) in ways.items():
        made = np.empty_like(P)
        for j, k in np.ndindex(P.shape[:2]):
            after = _to_world(*ends[j][k], turn, spin, carried)
            before = _to_world(
                states.q_world_body_wxyz[k], states.omega_body[k], turn, spin, carried
            )
            made[j, k] = after @ P[j, k] @ np.linalg.inv(before)
        yield f"{what} {'is' if what.startswith(('the', 'ω')) else 'are'} in world axes", made


def _ends(exact: Exact) -> list[list[tuple[FloatArray, FloatArray]]]:
    """Return the states to which the exact motion leads from K states in each of J spans of time.

    There is a list for each span, with K pairs of attitude, (4,), and ω, rad/s, body axes, (3,).
    """
    count = exact.count
    rows = np.tile(np.arange(count), len(exact.spans))
    flown = flowed(exact.scenario, exact.states.rows(rows), np.repeat(exact.spans, count))
    pairs = list(zip(flown.q_world_body_wxyz, flown.omega_body, strict=True))
    return [pairs[j : j + count] for j in range(0, len(pairs), count)]


def _to_world(
    q: FloatArray, omega: FloatArray, turn: bool, spin: bool, carried: bool
) -> FloatArray:
    """Return the matrix from the chart, in body axes, to a chart with some world axes, (6, 6).

    Parameters
    ----------
    q : attitude, (4,)
    omega : ω, rad/s, body axes, (3,)
    turn, spin : whether the change of the attitude, δθ, is in world axes; whether that of ω is
    carried : whether the change of ω includes −ω × δθ, by which the body's axes turn
    """
    R, made = matrix(q), np.eye(CHART)
    if turn:
        made[:3, :3] = R
    if spin:
        made[3:, 3:] = R
    if carried:
        made[3:, :3] = -R @ np.cross(omega, np.eye(3)).T
    return made


def _lacking(exact: Exact) -> Iterator[tuple[str, FloatArray]]:
    """Yield mistakes in words, each with the Jacobians that it gives, (J, K, 6, 6).

    They are from the K states of `exact` over its J spans of time. In each, the derivative of dx/dt
    by x lacks a part, with x the attitude and ω in the chart.
    """
    words = {name: f"the {name} is not differentiated" for name in TERMS}
    for name in ("ω", "I ω"):
        words[name] = f"of the gyroscopic torque ω × I ω the factor {name} is not differentiated"
    for name, said in words.items():
        yield said, exact.off_by(partial(_Rates.without, name=name))
    turn = "the attitude's derivative lacks"
    for first, part in {0: "the turn of the body's axes, ω × δθ", 3: "δω"}.items():
        yield f"{turn} {part}", exact.off_by(partial(_Rates.without_turn, first=first))


def _fitted(exact: Exact, limits: FloatArray, two_sided: bool) -> float:
    """Return the ε, rad and rad/s, whose finite differences explain an engine's Jacobians best.

    ε is the change of attitude and of ω by which the differences are taken.

    Parameters
    ----------
    limits : difference of the engine's Jacobian from the exact one, divided by the span of time, in
        the limit of vanishing timesteps, from K states, (K, 6, 6)
    two_sided : True for central differences, False for forward differences
    """

    def remainder(power: float) -> float:
        return float(np.linalg.norm(limits - exact.secant(power, two_sided)))

    tried = [float(np.linalg.norm(limits - off)) for off in exact.secants[two_sided]]
    near = POWERS[int(np.argmin(tried))]
    bounds = near - SPACING, near + SPACING
    found = minimize_scalar(remainder, bounds=bounds, method="bounded", options={"xatol": KNOWN})
    return float(10.0**found.x)


class _Rates:
    """The function dω/dt near one state, term by term, and its derivatives, by differences.

    Parameters
    ----------
    equations : the scene's equations
    state : one state
    units : units of the changes of attitude and ω by which the differences are taken
    """

    def __init__(self, equations: Equations, state: State, units: Units) -> None:
        self.equations, self.state, self.units = equations, state, units
        self.exact = self._derivative("")

    def without(self, name: str) -> FloatArray:
        """Return the error of the derivative of dx/dt by x if a term is not differentiated, (6, 6).

        x is attitude and ω in the chart.

        Parameters
        ----------
        name : name of the term, one of `TERMS`; or "ω" or "I ω", a factor of the gyroscopic torque
        """
        return self._whole(self._derivative(name) - self.exact)

    def without_turn(self, first: int) -> FloatArray:
        """Return the error of the derivative of dx/dt by x if rows of attitude lack a part, (6, 6).

        x is attitude and ω in the chart. Small changes of the two obey δθ' = δω − ω × δθ.

        Parameters
        ----------
        first : the first column of that part: 0 for ω × δθ, 3 for δω
        """
        kept = stepped_by_rate(np.zeros((3, CHART)), self.state.omega_body, 1.0) - np.eye(CHART)
        lacking = np.zeros((CHART, CHART))
        lacking[:, first : first + 3] = -kept[:, first : first + 3]
        return lacking

    def secant(self, epsilon: float, two_sided: bool) -> FloatArray:
        """Return the error that finite differences make in the derivative of dx/dt by x, (6, 6).

        x is attitude and ω in the chart.

        Parameters
        ----------
        epsilon : change of attitude and ω, rad and rad/s
        two_sided : True for central differences, False for forward differences
        """
        ahead, behind = (self._rates(step * np.eye(CHART)) for step in (epsilon, -epsilon))
        if two_sided:
            slope = (ahead - behind) / (2 * epsilon)
        else:
            slope = (ahead - self._rates(np.zeros((1, CHART)))) / epsilon
        return self._whole(slope.T - self.exact)

    def _whole(self, rate: FloatArray) -> FloatArray:
        """Return a 6 × 6 matrix with zeros in the rows of attitude, and given rows of ω.

        Parameters
        ----------
        rate : derivative of dω/dt, (3, 6)
        """
        return np.vstack([np.zeros((3, CHART)), rate])

    def _derivative(self, frozen: str) -> FloatArray:
        """Return the derivative of dω/dt by attitude and ω, (3, 6).

        Parameters
        ----------
        frozen : name of the term, or of the factor of a term, that is kept constant; none if empty
        """
        sizes = self.units.change * self.units.each
        rates = [self._rates(step * np.diag(sizes), frozen) for step in CHANGES]
        return np.tensordot(WEIGHTS, np.array(rates), axes=1).T / sizes

    def _with_table(
        self,
        R: FloatArray,
        omega: FloatArray,
        torque: FloatArray,
        weighed: tuple[FloatArray, FloatArray],
    ) -> FloatArray:
        """Return the whole torque on a body on a table, N m, body axes, (3,).

        Parameters
        ----------
        R : attitude, body to world, (3, 3)
        omega : ω, rad/s, body axes, (3,)
        torque : the torques other than that of the table, body axes, N m, (3,)
        weighed : attitude and ω for the part of the table's force that the weight causes; those of
            the unchanged state if the term of gravity is kept constant
        """
        scenario, none = self.equations.scenario, np.zeros(3)
        answer = scenario.answer
        assert answer is not None
        by_weight = [
            answer(scenario, weighed[0][2], weighed[1], none, g)[0]
            for g in (scenario.gravity_world, none)
        ]
        otherwise = answer(scenario, R[2], omega, torque, none)[0]
        return np.asarray(otherwise + by_weight[0] - by_weight[1])

    def _rates(self, offsets: FloatArray, frozen: str = "") -> FloatArray:
        """Return dω/dt at n states near this one, rad/s², (n, 3).

        Parameters
        ----------
        offsets : changes of attitude and ω, rad and rad/s, (n, 6)
        frozen : name of a term, or of a factor of one, that is kept constant; none if empty
        """
        equations, scenario = self.equations, self.equations.scenario
        there = changed(scenario, self.state, offsets)
        kept = equations.kept_body(self.state)
        R0, omega0 = matrix(self.state.q_world_body_wxyz), self.state.omega_body
        rows = []
        for q, omega in zip(there.q_world_body_wxyz, there.omega_body, strict=True):
            R = matrix(q)
            at = {name: (R0, omega0) if name == frozen else (R, omega) for name in TERMS}
            torque = gravity.torque_body(scenario, at["gravity"][0])
            Rp, op = at["applied torques"]
            torque = torque + push(scenario.pushed, Rp, Rp @ op) @ Rp
            spin = omega0 if frozen in ("ω", "gyroscopic torque") else omega
            omega_of_L = omega0 if frozen in ("I ω", "gyroscopic torque") else omega
            torque = torque - cross(spin, equations.scenario.inertia @ omega_of_L + kept)
            if scenario.answer is not None:
                torque = self._with_table(R, omega, torque, at["gravity"])
            rows.append(equations.inverse @ torque)
        return np.array(rows)
