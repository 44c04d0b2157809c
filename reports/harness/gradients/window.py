"""Gradients of a loss over many steps, by the chain rule along an engine's own run.

There are two losses at the end of a run: half the square of the angle between the attitude and a
target, which is one radian away from the exact attitude, and the kinetic energy of rotation. Both
are differentiated by attitude and ω at the start, in the units of `Units`:
docs/how-to/gradients.md.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from ....engines import EngineError, Session, State
from ....engines.checks.equations import Equations
from ....reference import Sensitivity, sensitivity, solve_cheaply
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import rotation_vectors
from ..measuring.noise import SURE, ULPS
from ..measuring.steps import Sessions
from .jacobians import CHART, ORDER, Units, own_jacobian

#: Rotation vector from the exact attitude to the target, rad, body axes.
TO_TARGET = np.ones(3) / np.sqrt(3.0)
#: Size of a Jacobian's entries beyond which their squares leave the range of doubles.
HUGE = 1e150
#: Relative error of a gradient that is no better than a gradient of zero.
USELESS = 1.0
#: Number of exact motions that are cached together with their derivatives.
KEPT = 4


@dataclass(frozen=True)
class Gradient:
    """The gradients of two losses after some steps, compared with the exact gradients.

    Attributes
    ----------
    t : time, s
    error : relative error of the gradient of the first loss, half the square of the turn from the
        attitude to a target attitude
    cosine : cosine of the angle between that gradient and the exact one
    energy_error : relative error of the gradient of the kinetic energy
    conditioning : largest factor by which the exact motion up to this time multiplies a change of
        its start
    """

    t: float
    error: float
    cosine: float
    energy_error: float
    conditioning: float


def counts_to(last: int) -> list[int]:
    """Return numbers of steps after which gradients are compared, ascending.

    They are the powers of two below `last`, and `last`.
    """
    return [*(2**k for k in range(last.bit_length()) if 2**k < last), last]


@lru_cache(maxsize=KEPT)
def exact_along(
    scenario: Scenario, timestep: float, counts: tuple[int, ...]
) -> tuple[Trajectory, Sensitivity]:
    """Return the exact motion after given numbers of steps, and its derivatives by the start.

    The motion ends where it is no longer known. The result is cached, as all derivatives of an
    engine are compared with it.

    Parameters
    ----------
    timestep : s
    counts : the n numbers of steps, ascending, (n,)

    Raises
    ------
    IntegrationError
        If the motion or a derivative cannot be integrated that far.
    """
    (solution,) = solve_cheaply(scenario, [timestep * np.array(counts, dtype=float)])
    motion = solution.trajectory
    return motion, sensitivity(scenario, motion, of_start_alone=True)


def own_over(
    sessions: Sessions,
    start: State,
    timestep: float,
    units: Units,
    counts: Sequence[int],
    conditioning: FloatArray,
) -> list[FloatArray]:
    """Return Jacobians of an engine's runs of given numbers of steps, in `units`, (6, 6) each.

    They are central differences of runs from changed starts. For each run the change ε is chosen
    that makes the error least: the error by rounding grows as 1/ε, the truncation error of fourth
    order as (ε conditioning)⁴.

    Parameters
    ----------
    start : the state in which all runs begin
    timestep : s
    counts : the n numbers of steps, (n,)
    conditioning : for each, the largest factor by which the motion multiplies a change of its
        start, (n,)
    """
    shares = conditioning ** (-ORDER / (ORDER + 1))
    return [
        units.of(own_jacobian(sessions, start, timestep, units, [count], float(share))[0])
        for count, share in zip(counts, shares, strict=True)
    ]


def run_along(
    session: Session, counts: Sequence[int], jacobian: Callable[[Session], FloatArray] | None
) -> tuple[list[State], list[FloatArray]]:
    """Run a session, and compute the Jacobian of each step.

    Parameters
    ----------
    counts : numbers of steps, ascending; the run ends after the last one
    jacobian : returns the Jacobian of a session's next step, in `Units`, (6, 6); None if no
        Jacobians are wanted

    Returns
    -------
    The states after the given numbers of steps, and the Jacobians of all steps, empty if none are
    wanted
    """
    states, each = [], []
    for step in range(counts[-1]):
        each += [jacobian(session)] if jacobian else []
        session.advance(1)
        if step + 1 in counts:
            states.append(session.read_state())
    return states, each


def chained(each: Iterable[FloatArray]) -> list[FloatArray]:
    """Return the Jacobians over the first 0, 1, 2, … steps, (6, 6) each.

    Parameters
    ----------
    each : the Jacobian of every step, (6, 6) each, in the same `Units` as the result
    """
    found: list[FloatArray] = [np.eye(CHART)]
    with np.errstate(over="ignore", invalid="ignore"):
        for one in each:
            found.append(one @ found[-1])
    return found


def gradients_along(
    scenario: Scenario,
    units: Units,
    exact: Trajectory,
    truth: Sensitivity,
    jacobians: Sequence[FloatArray],
    states: Sequence[State],
) -> tuple[Gradient, ...]:
    """Return the gradients of two losses at n times, compared with the exact gradients.

    The losses are half the square of the turn to a target attitude, which is the exact one turned
    by `TO_TARGET`, and the kinetic energy of rotation.

    Parameters
    ----------
    units : units of attitude and ω in Jacobians
    exact, truth : the exact motion at these times, and its derivatives
    jacobians : an engine's Jacobians from the start to each time, in `units`, (6, 6) each
    states : the engine's states at these times

    Raises
    ------
    EngineError
        If a Jacobian or ω is not finite, or so large that it is about to overflow.
    """
    equations = Equations(scenario)
    along = []
    for n, (by_start, state) in enumerate(zip(jacobians, states, strict=True)):
        if not (np.abs(by_start).max() < HUGE and np.isfinite(state.omega_body).all()):
            raise EngineError(f"the gradient overflows before {exact.t[n]:.3g} s", "not-finite")
        there = State(exact.q_world_body_wxyz[n], exact.omega_body[n], *(np.zeros(3),) * 2)
        attitude = Rotation.from_quat(there.q_world_body_wxyz, scalar_first=True)
        target = (attitude * Rotation.from_rotvec(TO_TARGET)).as_quat(scalar_first=True)
        phi = units.of(truth.state_transition[n, :, :CHART])
        (turn, energy), (wanted_turn, wanted_energy) = (
            [jacobian.T @ (units.each * slope) for slope in _slopes(equations, at, target)]
            for jacobian, at in [(by_start, state), (phi, there)]
        )
        along.append(
            Gradient(
                float(exact.t[n]),
                _norm(turn - wanted_turn) / _norm(wanted_turn),
                float(turn @ wanted_turn / _norm(turn) / _norm(wanted_turn)),
                _norm(energy - wanted_energy) / _norm(wanted_energy),
                float(truth.conditioning[n]),
            )
        )
    return tuple(along)


def cut_in_words(each: Sequence[FloatArray], taped: FloatArray, ulp: float) -> str:
    """Return how a Jacobian of N steps differs from the product of the N steps' own Jacobians.

    The text is empty if they agree up to rounding: each Jacobian is rounded, and so is the state at
    which it is computed, and later Jacobians multiply these errors.

    Parameters
    ----------
    each : the Jacobian of every step, in `Units`, (6, 6) each
    taped : the Jacobian of all steps at once, in the same units, (6, 6)
    ulp : relative spacing of the engine's numbers
    """
    steps = len(each)
    if not np.isfinite(taped).all():
        return f"over {steps} steps it is not finite"
    if not taped.any():
        return f"over {steps} steps it is zero: the tape is detached"
    first = chained(each)
    last = [one.T for one in chained(one.T for one in each[::-1])]
    before, after = (np.linalg.norm(made, axis=(1, 2)) for made in (first, last[::-1]))
    known_to = SURE * ULPS * ulp * float((after * before * (1 + before)).sum())
    for words, made in (("first", first), ("last", last)):
        off = np.linalg.norm(np.array(made) - taped, axis=(1, 2))
        # The whole product is tested first, as the product of fewer steps may be equal to it.
        if off[-1] <= known_to:
            return ""
        kept = int(off[:-1].argmin())
        if off[kept] <= known_to:
            return f"over {steps} steps the tape is cut: it is of the {words} {kept}"
    return f"over {steps} steps it is not the product of its steps' derivatives"


def useless_from(gradients: tuple[Gradient, ...]) -> float | None:
    """Return the time, s, from which on all gradients are no better than a gradient of zero.

    It is None if the last gradient is better. Only the gradients of the first loss count, half the
    square of the turn to the target.
    """
    wrong = [one.t for one in gradients]
    for one in reversed(gradients):
        if one.error < USELESS:
            break
        wrong.append(one.t)
    return wrong[-1] if len(wrong) > len(gradients) else None


def _slopes(equations: Equations, state: State, target: FloatArray) -> list[FloatArray]:
    """Return the derivatives of two losses by attitude and ω at the end of a run, (6,) each.

    The losses are half the square of the turn to the target, and the kinetic energy of rotation.

    Parameters
    ----------
    state : the state at the end
    target : quaternion of the target attitude, (4,)
    """
    turn = rotation_vectors(target[None], state.q_world_body_wxyz[None])[0]
    momentum = equations.scenario.inertia @ state.omega_body
    return [np.append(turn, np.zeros(3)), np.append(np.zeros(3), momentum)]


def _norm(vector: FloatArray) -> float:
    """Return the norm of a vector; in place of zero, the least normal double, to divide by it."""
    return float(np.linalg.norm(vector)) or float(np.finfo(float).tiny)
