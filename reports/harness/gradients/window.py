"""Gradients of a loss over many steps, by the chain rule along an engine's own run.

The losses are half the square of the turn to a target, which the exact attitude at the end is one
radian away from, and the kinetic energy of rotation. Both are differentiated by attitude and ω at
the start, in units: docs/how-to/gradients.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....engines import EngineError, Session, State
from ....engines.checks.equations import Equations
from ....reference import sensitivity, solve_cheaply
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import rotation_vectors
from .jacobians import CHART, Units

#: Steps after which gradients are compared.
STEPS = 2 ** np.arange(10)
#: From the exact attitude to the target, rad, body axes.
TO_TARGET = np.ones(3) / np.sqrt(3.0)
#: Beyond it squares leave the range of doubles.
HUGE = 1e150
#: Relative error of a gradient that is no better than none.
USELESS = 1.0


class TapeCut(EngineError):
    """A derivative is none of steps from somewhere on."""


@dataclass(frozen=True)
class Gradient:
    """The gradient of the turn to the target after some steps, beside the exact one.

    Attributes
    ----------
    t : s
    error : of the gradient, relative
    cosine : of the angle between the two
    energy_error : of the gradient of the kinetic energy, relative
    conditioning : of the exact motion: what a change of the start is multiplied by, at most
    """

    t: float
    error: float
    cosine: float
    energy_error: float
    conditioning: float


def gradients_along(
    session: Session,
    scenario: Scenario,
    timestep: float,
    units: Units,
    jacobian: Callable[[Session], FloatArray],
    at_once: int,
) -> tuple[Gradient, ...]:
    """Those along a run from the start of a scene, as far as its exact motion is known.

    Parameters
    ----------
    jacobian : of the next steps of a session, (6, 6)
    at_once : how many those are

    Raises
    ------
    TapeCut
        If a derivative is none of steps.
    EngineError
        If the run ends in numbers that are not finite, or the engine refuses a step.
    """
    counts = STEPS[STEPS % at_once == 0]
    (solution,) = solve_cheaply(scenario, [np.asarray(counts * timestep, dtype=float)])
    exact = solution.trajectory
    truth = sensitivity(scenario, exact)
    equations, found, taken = Equations(scenario), [], 0
    whole: FloatArray = np.eye(CHART)
    for n, steps in enumerate(counts[: len(exact.t)]):
        while taken < steps:
            stepped = jacobian(session)
            if words := _no_steps(stepped):
                raise TapeCut(f"the tape is cut after {taken} steps: from there on it is {words}")
            with np.errstate(over="ignore", invalid="ignore"):
                whole = np.asarray(stepped @ whole, dtype=float)
            session.advance(at_once)
            taken += at_once
        state = session.read_state()
        if not (np.abs(whole).max() < HUGE and np.isfinite(state.omega_body).all()):
            raise EngineError(f"the gradient overflows after {taken} steps", "not-finite")
        there = State(exact.q_world_body_wxyz[n], exact.omega_body[n], *(np.zeros(3),) * 2)
        attitude = Rotation.from_quat(there.q_world_body_wxyz, scalar_first=True)
        target = (attitude * Rotation.from_rotvec(TO_TARGET)).as_quat(scalar_first=True)
        phi = truth.state_transition[n, :, :CHART]
        pairs: list[list[FloatArray]] = [
            [units.each * (by_start.T @ slope) for slope in _slopes(equations, at, target)]
            for by_start, at in [(whole, state), (phi, there)]
        ]
        (turn, energy), (wanted_turn, wanted_energy) = pairs
        cosine = turn @ wanted_turn / _norm(turn) / _norm(wanted_turn)
        found.append(
            Gradient(
                float(exact.t[n]),
                _norm(turn - wanted_turn) / _norm(wanted_turn),
                float(cosine),
                _norm(energy - wanted_energy) / _norm(wanted_energy),
                float(truth.conditioning[n]),
            )
        )
    return tuple(found)


def useless_from(gradients: tuple[Gradient, ...]) -> float | None:
    """The time, s, from which on all gradients are as wrong as none; None if there is none."""
    wrong = [one.t for one in gradients]
    for one in reversed(gradients):
        if one.error < USELESS:
            break
        wrong.append(one.t)
    return wrong[-1] if len(wrong) > len(gradients) else None


def _no_steps(jacobian: FloatArray) -> str:
    """What a Jacobian is instead of one of steps, in words; empty if it may be one."""
    if not np.isfinite(jacobian).all():
        return "not finite"
    if not jacobian.any():
        return "zero"
    return "the identity" if np.array_equal(jacobian, np.eye(CHART)) else ""


def _slopes(equations: Equations, state: State, target: FloatArray) -> list[FloatArray]:
    """Derivatives of both losses by attitude and ω at a state, (6,) each."""
    turn = rotation_vectors(target[None], state.q_world_body_wxyz[None])[0]
    momentum = equations.inertia @ state.omega_body
    return [np.append(turn, np.zeros(3)), np.append(np.zeros(3), momentum)]


def _norm(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector)) or float(np.finfo(float).tiny)
