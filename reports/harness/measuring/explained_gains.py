"""Finds the changes of a scene's equations of motion that explain the gains of an engine's steps.

The gains that follow from changed equations are compared with the measured gains of several states
at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....engines import State
from ....engines.checks.equations import Equations
from ....reference.following import rates
from ....reference.other_equations import inverse
from ....scenarios import FloatArray
from ....scenarios.rotation import matrices, turned
from ...results.evidence import Explanation
from ..explaining.changes import changes
from ..explaining.effect_changes import drags_of_other_powers
from ..explaining.fit import RANK, Data
from ..explaining.hypothesis import Change, Hypothesis, scaled
from ..explaining.search import Search
from .noise import NO_SIZE


@dataclass(frozen=True, eq=False)
class Gains(Data):
    """The limits, at vanishing timesteps, of the gains of steps from K states.

    Attributes
    ----------
    states : K states, each repeated R times with small changes, (R K)
    excess : the limits for attitude, I ω, velocity and position, means of repeats, (K, 4, 3), in
        the units of `step_gains`
    noise : the largest error of these limits that noise may cause, (K, 4)
    """

    equations: Equations
    states: State
    excess: FloatArray
    noise: FloatArray

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the limits of gains less those that H hypotheses predict, (H, K, 4, 3).

        They are those from K states, in units of `scale`. A hypothesis predicts as limit the
        difference between the rates of attitude, I ω, velocity and position by its equations and by
        the scene's.
        """
        made = np.stack([self.made(hypotheses[k]) for k in range(len(hypotheses))])
        off = (self.excess - made + self.exact) / self.scale[..., None]
        return np.asarray(off)

    @cached_property
    def scale(self) -> FloatArray:
        """The error allowed to the limits of attitude, I ω, velocity and position, (K, 4).

        It is `noise`, plus the fraction `RANK` of the largest limit of the same quantity in any
        state.
        """
        largest = np.linalg.norm(self.excess, axis=2).max(axis=0)
        return np.asarray(np.maximum(self.noise + RANK * largest, NO_SIZE))

    @cached_property
    def exact(self) -> FloatArray:
        """The rates of attitude, I ω, velocity and position in K states, (K, 4, 3).

        They are those by the scene's equations.
        """
        return self.made(self.base)

    def made(self, hypothesis: Hypothesis) -> FloatArray:
        """Return the rates of attitude, I ω, velocity and position by a hypothesis, (K, 4, 3).

        They are those in K states, means of repeats, in the units of `excess`. On a pivot, velocity
        and position are returned themselves, not their rates.

        Parameters
        ----------
        hypothesis : one hypothesis
        """
        scenario = self.equations.scenario
        R_world_body = matrices(self.states.q_world_body_wxyz)
        omega = self.states.omega_body @ inverse(hypothesis.read).T
        turning, omega_rate = np.split(self._rates(hypothesis, omega), 2, axis=1)
        torque = omega_rate @ hypothesis.read.T @ scenario.inertia.T
        if scenario.constraint.is_pivot:
            com = np.tile(hypothesis.pull / scenario.body.mass, (len(omega), 1))
            position, step = turned(R_world_body, com), 1.0
            velocity = turned(R_world_body, np.cross(omega, com))
        else:
            position, step = self.states.velocity_world, float(hypothesis.step)
            position = position / (hypothesis.velocity or np.nan)
            velocity = np.tile(hypothesis.gravity_world, (len(omega), 1))
            if hypothesis.mobility:
                lever = hypothesis.lever
                swing = np.cross(omega_rate, lever)
                swing += np.cross(omega, np.cross(omega, lever))
                velocity[:, 2] = turned(R_world_body, swing)[:, 2]
            velocity -= hypothesis.braking * self.states.velocity_world
        velocity = hypothesis.velocity * velocity
        parts = (
            hypothesis.step * turning,
            hypothesis.step * torque,
            step * velocity,
            step * position,
        )
        each = np.stack(parts, axis=1).reshape(-1, *self.excess.shape)
        return np.asarray(np.mean(each, axis=0))

    def _rates(self, hypothesis: Hypothesis, omega: FloatArray) -> FloatArray:
        """Return the angular velocity, rad/s, at which each state turns, and its ω', rad/s².

        Both are along body axes; the shape is (R K, 6), for K states, each repeated R times.

        Parameters
        ----------
        omega : ω of the states, without the mistakes of reading it, rad/s, body axes, (R K, 3)
        """
        usual = self.base.kept
        # The rotors' momentum depends on the state, so that its value at the start cannot be used.
        factor = float(hypothesis.kept @ usual / (usual @ usual)) if usual.any() else 0.0
        kept = factor * self.equations.kept_body(self.states)
        return rates(hypothesis, np.hstack([self.states.q_world_body_wxyz, omega]), kept)


def explanations(gains: Gains) -> tuple[Explanation, ...]:
    """Return the change, or the pair of changes, that explains the limits of an engine's gains.

    The changes are those of the equations, of the step's length, or of how ω and velocity are read.
    The result is empty if no change and no pair does.
    """
    scenario = gains.equations.scenario
    candidates = [*_readings(), *changes(scenario), *drags_of_other_powers(scenario, gains.base)]
    candidates += _braking()
    found = Search(gains, candidates).one_or_two()
    return tuple(map(found.explanation, found.changes)) if found else ()


def _readings() -> Iterator[Change]:
    """Yield changes in which a step takes another time, or in which ω or velocity is misread.

    Each has one parameter: the factor less 1 by which time, ω or velocity is multiplied.
    """
    one, unit = np.ones(1), np.eye(3)
    yield Change("step", lambda h, n: h.of(step=1 + n[:, 0]), one)
    yield Change("omega", lambda h, n: h.of(read=scaled(1 + n, unit)), one)
    yield Change("velocity", lambda h, n: h.of(velocity=1 + n[:, 0]), one)


def _braking() -> Iterator[Change]:
    """Yield changes in which the com's velocity decays, alone or as fast as angular momentum."""
    one, slowed = np.ones(1), np.array([0.0, 1.0, 0.0])
    yield Change("braking", lambda h, n: h.of(braking=n[:, 0]), one)
    yield Change(
        "decay and braking",
        lambda h, n: h.of(braking=n[:, 0], slowing=h.slowing + n * slowed),
        one,
    )
