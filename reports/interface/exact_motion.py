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
    t : (n,) s
    q_world_body_wxyz : (n, 4) unit quaternions, scalar first: body to world components
    omega_body, omega_world : (n, 3) rad/s
    com_world, velocity_world : (n, 3) m and m/s, of the centre of mass
    spins : (n, rotors) rad/s, of the rotors, relative to the body
    angular_momentum_world : (n, 3) kg m²/s, about the pivot, or the com where there is none
    energy : (n,) J, kinetic and potential, the latter zero at the world's origin
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
    """The exact motion of one scene."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._solver = scenario, Solver(scenario)

    def at(self, times: ArrayLike) -> ExactStates:
        """Return the states at times, s, (n,), increasing and not negative, or at a single time.

        Raises
        ------
        ValueError
            If the times do not increase, or one is negative; if they go beyond the time up to
            which a chaotic motion is known, or at which the body leaves its table; or if they are
            so late that the motion cannot be computed.
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
        """Return the exact derivatives of the states by the start and by the scene's parameters.

        The first call on a machine compiles for some ten seconds.

        Parameters
        ----------
        times : as for `at`

        Raises
        ------
        ValueError
            As for `at`.
        spincheck.reference.IntegrationError
            As for `at`, or if the derivatives take too many steps or leave the range of doubles.
        """
        return sensitivity(self._scenario, self._known(times).trajectory)

    def _known(self, times: ArrayLike) -> Solution:
        """Return the exact motion at given times; raise as `at` unless it is known at each."""
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
