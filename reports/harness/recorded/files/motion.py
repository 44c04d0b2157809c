"""Converts a recording to a motion in the scene's frames, and computes ω where it is missing."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import (
    matrices,
    norms,
    rotation_vectors,
    turned,
    turned_back,
    turning_of,
)
from .recording import Recording, RecordingError

#: The numbers of attitudes that ω at a sample may be computed from, of which one is chosen. It is
#: chosen by this quantile of the errors, as the errors at either end of a recording are larger.
STENCILS, NEARLY_ALL = (5, 7, 9), 0.9
#: Largest turn between two samples, rad. Over the four intervals of the shortest stencil the body
#: then turns by less than half a turn, so that the direction of the turn is known.
FURTHEST = 0.75

QuaternionOrder = Literal["wxyz", "xyzw"]
OmegaFrame = Literal["body", "world"]


class Reading(NamedTuple):
    """The n samples of a recording, read in one way.

    Attributes
    ----------
    t : times of the samples, s, (n,)
    q : attitudes, body to world, unit quaternions with the scalar first, (n, 4)
    omega : ω along the axes of `frame`, rad/s, (n, 3); None if it was not recorded
    order : the order of the quaternion's components in the recording
    frame : the axes that `omega` is along
    spins : spins of the rotors, rad/s, (n, rotors); None if they were not recorded
    """

    t: FloatArray
    q: FloatArray
    omega: FloatArray | None
    order: QuaternionOrder
    frame: OmegaFrame
    spins: FloatArray | None

    def rows(self, rows: slice | NDArray[np.intp]) -> "Reading":
        """Return the reading with only the samples of a slice, or with k given indices, (k,)."""
        omega, spins = (None if one is None else one[rows] for one in (self.omega, self.spins))
        return self._replace(t=self.t[rows], q=self.q[rows], omega=omega, spins=spins)

    @property
    def omega_body(self) -> FloatArray | None:
        """ω of the n samples along body axes, rad/s, (n, 3); None if it was not recorded."""
        if self.omega is None or self.frame == "body":
            return self.omega
        return turned_back(matrices(self.q), self.omega)


def reading_of(recording: Recording) -> Reading:
    """Return a recording, read as its settings state, with quaternions normalised.

    If they do not say otherwise, quaternions are w x y z, and ω is along body axes.
    """
    stated = recording.settings
    order: QuaternionOrder = "xyzw" if stated.get("quaternion") == "xyzw" else "wxyz"
    frame: OmegaFrame = "world" if stated.get("omega") == "world" else "body"
    q = np.roll(recording.arrays["q"], order == "xyzw", axis=1)
    q = q / norms(q)[:, None]
    arrays = recording.arrays
    return Reading(arrays["t"], q, arrays.get("omega"), order, frame, arrays.get("spins"))


class DerivedOmega(NamedTuple):
    """The ω of n samples that is computed from attitudes.

    Attributes
    ----------
    omega_body : ω, rad/s, body axes, (n, 3)
    error : estimated bound on the error of nearly all samples, rad/s, from the difference to an ω
        that is computed from two more attitudes
    reach : the number of samples on each side of a sample from which its ω is computed
    """

    omega_body: FloatArray
    error: float
    reach: int


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A recorded motion, and which of its quantities were recorded.

    Attributes
    ----------
    trajectory : the motion at the times of the recording. A com or velocity that was not recorded
        is computed from attitude and ω along axes that a constraint holds, and is taken from the
        exact motion along the others
    derived : ω as computed from the attitudes; None if ω was recorded
    has_spins : whether spins were recorded. If not, they are computed from ω and from the angular
        momenta or spins that the rotors' hinges conserve
    """

    trajectory: Trajectory
    derived: DerivedOmega | None
    has_spins: bool

    @property
    def has_omega(self) -> bool:
        """Whether ω was recorded."""
        return self.derived is None


def recorded_motion(
    scenario: Scenario, recording: Recording, reading: Reading, exact: Trajectory
) -> RecordedMotion:
    """Return a recording as a motion in the scene's frames, with missing quantities computed.

    Parameters
    ----------
    recording : the recording, from which com and velocity are taken
    reading : times, attitudes, ω and spins as they are read
    exact : the exact motion at the times of the reading

    Raises
    ------
    RecordingError
        If ω was not recorded and the attitudes are too far apart to compute it, or if the number of
        recorded spins is not that of the scene's rotors.
    """
    arrays, t, q = recording.arrays, reading.t, reading.q
    R_world_body, constraint = matrices(q), scenario.constraint
    com = arrays.get("com", exact.com_world)
    if "com" not in arrays:
        com = constraint.com_world(R_world_body @ constraint.lever, com)
    omega_body, derived = reading.omega_body, None
    if omega_body is None:
        derived = omega_of_attitudes(t, q)
        omega_body = derived.omega_body
    velocity = arrays.get("velocity", exact.velocity_world)
    if "velocity" not in arrays:
        swing_world = turned(R_world_body, np.cross(omega_body, constraint.lever))
        velocity = constraint.velocity_world(swing_world, velocity)
    spins = scenario.spins(omega_body, scenario.kept_at_start)
    if reading.spins is not None:
        if reading.spins.shape != spins.shape:
            raise RecordingError(
                f"must have a spin for each of the scene's {spins.shape[1]} rotors, got "
                f"{reading.spins.shape[1]}"
            )
        spins = reading.spins
    motion = Trajectory(t, q, omega_body, com, velocity, spins)
    return RecordedMotion(motion, derived, reading.spins is not None)


def omega_of_attitudes(t: FloatArray, q_world_body_wxyz: FloatArray) -> DerivedOmega:
    """Return ω as the derivative of attitudes, with an estimate of its error.

    ω is computed from 5, 7 or 9 attitudes around each sample: the fewest whose error is at most
    twice the smallest. More of them have a smaller error if attitudes have enough digits.

    Parameters
    ----------
    t : times of the n attitudes, s, (n,)
    q_world_body_wxyz : attitudes, scalar first, (n, 4)

    Raises
    ------
    RecordingError
        If the body turns by more than `FURTHEST` between two samples.
    """
    turns = norms(rotation_vectors(q_world_body_wxyz[:-1], q_world_body_wxyz[1:]))
    if turns.max(initial=0.0) > FURTHEST:
        k = int(np.argmax(turns))
        raise RecordingError(
            f"the body turns by {np.degrees(turns[k]):.0f}° between samples {k + 1} and {k + 2}: "
            "ω cannot be told from attitudes so far apart; write ω, or more samples"
        )
    derivatives = [
        _derived(t, q_world_body_wxyz, samples) for samples in (*STENCILS, STENCILS[-1] + 2)
    ]
    errors = [float(np.quantile(norms(a - b), NEARLY_ALL)) for a, b in pairwise(derivatives)]
    best = next(k for k, error in enumerate(errors) if error <= 2 * min(errors))
    return DerivedOmega(derivatives[best], errors[best], STENCILS[best] // 2)


def _derived(t: FloatArray, q_world_body_wxyz: FloatArray, samples: int) -> FloatArray:
    """Return ω, rad/s, body axes, (n, 3), as 2 q⁻¹ q' from n attitudes q.

    The derivative q' at a sample is that of the polynomial through the attitudes around it. Its
    weights are those of B. Fornberg, Math. Comp. 51 (1988) 699.

    Parameters
    ----------
    t : times of the attitudes, s, (n,)
    q_world_body_wxyz : the attitudes, scalar first, (n, 4)
    samples : the number of attitudes through which the polynomial passes; all n if they are fewer
    """
    # q and -q are one attitude.
    signs = np.sign(np.sum(q_world_body_wxyz[:-1] * q_world_body_wxyz[1:], axis=1))
    q = np.cumprod([1.0, *signs])[:, None] * q_world_body_wxyz
    points = min(samples, len(t))
    first = np.clip(np.arange(len(t)) - points // 2, 0, len(t) - points)
    rates = np.zeros_like(q)
    for j in range(points):
        rates += _weight(t, first, points, j)[:, None] * (q[first + j] - q)
    return turning_of(q, rates)


def _weight(t: FloatArray, first: NDArray[np.intp], points: int, j: int) -> FloatArray:
    """Return the derivative at n samples of the Lagrange polynomial of one stencil point, 1/s.

    The result, (n,), is the weight of that point in the derivative. It is 0 where the point is the
    sample itself: the caller adds up differences from the sample, and needs no such weight.

    Parameters
    ----------
    t : times of the samples, s, (n,)
    first : index of the first point of each sample's stencil, (n,)
    points : the number of points of each stencil
    j : the number of the point in each stencil, from 0
    """
    own = np.arange(len(t)) - first
    weight = np.where(own == j, 0.0, 1.0)
    for i in range(points):
        if i != j:
            spacing = t[first + j] - t[first + i]
            weight *= np.where(own == i, 1.0, t - t[first + i]) / spacing
    return weight
