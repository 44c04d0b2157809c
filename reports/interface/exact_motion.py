"""The exact motion of a scene at any times, with its uncertainty."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike
from spincheck.reference import ExactMotion as Solver
from spincheck.reference import Sensitivity, Solution, sensitivity
from spincheck.scenarios import (
    Errors,
    FloatArray,
    Scenario,
    angular_momentum_world,
    check_scales,
    energy,
    read_only,
)


@final
@dataclass(frozen=True, eq=False)
class ExactStates:
    """States of the exact motion at n times, in SI units; arrays are read-only.

    Attributes
    ----------
    t : times, s, (n,)
    q_world_body_wxyz : attitudes, (n, 4): unit quaternions, scalar first, that take body to world
        components
    omega_body, omega_world : angular velocity, rad/s, (n, 3), in body and in world axes
    com_world, velocity_world : position, m, and velocity, m/s, of the centre of mass, (n, 3), world
        axes
    spins : angular velocity of each rotor relative to the body, rad/s, (n, rotors)
    angular_momentum_world : angular momentum about the pivot, or about the com if there is no
        pivot, kg m²/s, (n, 3), world axes
    energy : kinetic and potential energy, J, (n,); the potential is zero at the world's origin
    uncertainty : an upper bound on the error in each signal: `uncertainty["attitude"]` in rad,
        others relative
    method : how the motion was solved, in words
    """

    t: FloatArray
    q_world_body_wxyz: FloatArray
    omega_body: FloatArray
    omega_world: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray
    spins: FloatArray
    angular_momentum_world: FloatArray
    energy: FloatArray
    uncertainty: Errors
    method: str


@final
class ExactMotion:
    """The exact motion of one scene; `at` returns its states, `sensitivity` their derivatives."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._solver = scenario, Solver(scenario)

    def at(self, times: ArrayLike) -> ExactStates:
        """Return the exact states at given times.

        Parameters
        ----------
        times : s, (n,), increasing, none negative; or a single time

        Raises
        ------
        ValueError
            If the times do not increase or one is negative; if one is later than the time up to
            which a chaotic motion is known, or at which the body leaves its table; or if one is so
            late that the motion cannot be computed.
        spincheck.reference.IntegrationError
            If the motion cannot be integrated that far.
        """
        solution = self._known(times)
        motion = solution.trajectory
        return ExactStates(
            motion.t,
            motion.q_world_body_wxyz,
            motion.omega_body,
            read_only(motion.to_world(motion.omega_body)),
            motion.com_world,
            motion.velocity_world,
            motion.spins,
            angular_momentum_world(self._scenario, motion),
            energy(self._scenario, motion),
            solution.uncertainty,
            solution.method,
        )

    def sensitivity(self, times: ArrayLike) -> Sensitivity:
        """Return the exact derivatives of the states with respect to start and parameters.

        The first call on a machine compiles for some ten seconds.

        Parameters
        ----------
        times : s, (n,), increasing, none negative; or a single time

        Raises
        ------
        ValueError
            If the exact motion is not known at one of the times, as for `at`.
        spincheck.reference.IntegrationError
            If the motion cannot be integrated that far, or if the derivatives take too many steps
            or leave the range of doubles.
        """
        return sensitivity(self._scenario, self._known(times).trajectory)

    def _known(self, times: ArrayLike) -> Solution:
        """Return the exact motion at given times; raise `ValueError` if it is unknown at one."""
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
        if wanted.ndim > 1 or not len(wanted):
            raise ValueError(f"'times' must have the shape (n,), n > 0, got {wanted.shape}.")
        check_scales(self._scenario, until=max(self._scenario.window.duration, float(wanted[-1])))
        solution = self._solver.solve(wanted)
        if len(solution.trajectory.t) < len(wanted):
            raise ValueError(
                f"'times' must not reach {solution.horizon:.6g} s, got {wanted[-1]:.6g}: "
                f"{solution.ending}."
            )
        return solution
