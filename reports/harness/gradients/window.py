"""Gradients of a loss over many steps, by the chain rule along an engine's own run.

The losses are half the square of the turn to a target, which the exact attitude at the end is one
radian away from, and the kinetic energy of rotation. Both are differentiated by attitude and ω at
the start, in units: docs/how-to/gradients.md.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ....engines import EngineError, Session, State
from ....engines.checks.equations import Equations
from ....reference import sensitivity, solve_cheaply
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import rotation_vectors
from ..measuring.noise import ULPS
from .jacobians import CHART, Units
from .verdict import SURE

#: Steps after which gradients are compared.
STEPS = 2 ** np.arange(10)
#: From the exact attitude to the target, rad, body axes.
TO_TARGET = np.ones(3) / np.sqrt(3.0)
#: Beyond it squares leave the range of doubles.
HUGE = 1e150
#: Relative error of a gradient that is no better than none.
USELESS = 1.0


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
    jacobian: Callable[[Session], FloatArray] | None,
    taped: Mapping[int, FloatArray],
) -> tuple[tuple[Gradient, ...], str]:
    """Those along a run from the start of a scene, and how a tape is cut, in words.

    They go as far as the exact motion is known.

    Parameters
    ----------
    jacobian : of the next step of a session, (6, 6)
    taped : Jacobians of so many steps at once, (6, 6) each; if empty, the product of single steps

    Raises
    ------
    EngineError
        If the run ends in numbers that are not finite, or the engine refuses a step.
    """
    counts: NDArray[np.int_] = np.array(list(taped)) if taped else STEPS
    (solution,) = solve_cheaply(scenario, [np.asarray(counts * timestep, dtype=float)])
    exact = solution.trajectory
    truth = sensitivity(scenario, exact)
    equations, found, cut = Equations(scenario), [], ""
    each: list[FloatArray] = []
    whole: FloatArray = np.eye(CHART)
    taken = 0
    for n, steps in enumerate(map(int, counts[: len(exact.t)])):
        while taken < steps:
            if jacobian is not None:
                each.append(units.of(np.asarray(jacobian(session), dtype=float)))
                with np.errstate(over="ignore", invalid="ignore"):
                    whole = each[-1] @ whole
            session.advance(1)
            taken += 1
        state = session.read_state()
        if not (np.abs(whole).max() < HUGE and np.isfinite(state.omega_body).all()):
            raise EngineError(f"the gradient overflows after {steps} steps", "not-finite")
        by_start = taped.get(steps, whole * units.each[:, None] / units.each)
        if each and taped and not cut:
            cut = cut_in_words(np.array(each), units.of(by_start), units.ulp)
        there = State(exact.q_world_body_wxyz[n], exact.omega_body[n], *(np.zeros(3),) * 2)
        attitude = Rotation.from_quat(there.q_world_body_wxyz, scalar_first=True)
        target = (attitude * Rotation.from_rotvec(TO_TARGET)).as_quat(scalar_first=True)
        phi = truth.state_transition[n, :, :CHART]
        pairs: list[list[FloatArray]] = [
            [units.each * (by_start.T @ slope) for slope in _slopes(equations, at, target)]
            for by_start, at in [(by_start, state), (phi, there)]
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
    return tuple(found), cut


def cut_in_words(each: FloatArray, taped: FloatArray, ulp: float) -> str:
    """What a Jacobian of N steps at once, in units, is instead of the product of theirs.

    Empty where it is that but for rounding, of each Jacobian and of the state that it is at, which
    later ones multiply.

    Parameters
    ----------
    each : of every step, in units, (N, 6, 6)
    """
    steps = len(each)
    if not np.isfinite(taped).all():
        return f"over {steps} steps it is not finite"
    if not taped.any():
        return f"over {steps} steps it is zero: the tape is detached"
    first, last = [np.eye(CHART)], [np.eye(CHART)]
    for k in range(steps):
        first.append(each[k] @ first[-1])
        last.append(last[-1] @ each[steps - 1 - k])
    before, after = (np.linalg.norm(made, axis=(1, 2)) for made in (first, last[::-1]))
    known_to = SURE * ULPS * ulp * float((after * before * (1 + before)).sum())
    for words, made in (("first", first), ("last", last)):
        off = np.linalg.norm(np.array(made) - taped, axis=(1, 2))
        # The whole product is the same from both ends, and comes before any part of it.
        if off[-1] <= known_to:
            return ""
        kept = int(off[:-1].argmin())
        if off[kept] <= known_to:
            return f"over {steps} steps the tape is cut: it is of the {words} {kept}"
    return f"over {steps} steps it is not the product of its steps' derivatives"


def useless_from(gradients: tuple[Gradient, ...]) -> float | None:
    """The time, s, from which on all gradients are as wrong as none; None if there is none."""
    wrong = [one.t for one in gradients]
    for one in reversed(gradients):
        if one.error < USELESS:
            break
        wrong.append(one.t)
    return wrong[-1] if len(wrong) > len(gradients) else None


def _slopes(equations: Equations, state: State, target: FloatArray) -> list[FloatArray]:
    """Derivatives of both losses by attitude and ω at a state, (6,) each."""
    turn = rotation_vectors(target[None], state.q_world_body_wxyz[None])[0]
    momentum = equations.inertia @ state.omega_body
    return [np.append(turn, np.zeros(3)), np.append(np.zeros(3), momentum)]


def _norm(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector)) or float(np.finfo(float).tiny)
