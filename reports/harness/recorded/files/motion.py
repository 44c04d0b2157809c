"""Converts a recording to a motion, by the frames and the order of components of its columns."""

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

#: Numbers of samples, of which one is chosen, from which ω is computed; and the quantile of errors
#: by which it is chosen: at either end of the recording errors are larger.
STENCILS, NEARLY_ALL = (5, 7, 9), 0.9
#: Largest turn between two samples, rad: over the four intervals of a stencil the direction of a
#: turn must not be ambiguous.
FURTHEST = 0.75

QuaternionOrder = Literal["wxyz", "xyzw"]
OmegaFrame = Literal["body", "world"]


class Reading(NamedTuple):
    """The n samples of a recording, read in one way.

    Attributes
    ----------
    t : s, (n,)
    q : attitude, body to world, unit quaternions with the scalar first, (n, 4)
    omega : rad/s, along the axes of `frame`, (n, 3); None if it was not recorded
    order, frame : the order of the recorded quaternion's components, and the axes of ω
    spins : of rotors, relative to the body, rad/s, (n, rotors); None if they were not recorded
    """

    t: FloatArray
    q: FloatArray
    omega: FloatArray | None
    order: QuaternionOrder
    frame: OmegaFrame
    spins: FloatArray | None

    def rows(self, rows: slice | NDArray[np.intp]) -> "Reading":
        """Return the samples of a slice, or with given indices."""
        omega, spins = (None if one is None else one[rows] for one in (self.omega, self.spins))
        return self._replace(t=self.t[rows], q=self.q[rows], omega=omega, spins=spins)

    @property
    def omega_body(self) -> FloatArray | None:
        """ω along body axes, rad/s, (n, 3); None if it was not recorded."""
        if self.omega is None or self.frame == "body":
            return self.omega
        return turned_back(matrices(self.q), self.omega)


def reading_of(recording: Recording) -> Reading:
    """Return a recording as its settings say to read it; by default q as w x y z, ω in body axes.

    Quaternions are normalised.
    """
    stated = recording.settings
    order: QuaternionOrder = "xyzw" if stated.get("quaternion") == "xyzw" else "wxyz"
    frame: OmegaFrame = "world" if stated.get("omega") == "world" else "body"
    q = np.roll(recording.arrays["q"], order == "xyzw", axis=1)
    q = q / norms(q)[:, None]
    arrays = recording.arrays
    return Reading(arrays["t"], q, arrays.get("omega"), order, frame, arrays.get("spins"))


class DerivedOmega(NamedTuple):
    """ω that is computed from attitudes.

    Attributes
    ----------
    omega_body : rad/s, body axes, (n, 3)
    error : estimated error of nearly all samples, rad/s: the difference from ω computed from more
        samples
    reach : how many samples on each side ω is computed from
    """

    omega_body: FloatArray
    error: float
    reach: int


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A recorded motion, and which of its quantities were recorded.

    Attributes
    ----------
    trajectory : at the file's own times; a com or velocity that was not recorded follows from
        attitude and ω along axes that a constraint holds, and is the exact one along others
    derived : ω as the derivative of the attitudes; None if it was recorded
    has_spins : whether spins were recorded; if not, they follow from ω by what hinges conserve
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
    """Return a recording as a motion in the scene's frames, with what was not recorded added.

    Parameters
    ----------
    exact : the exact motion at the recording's times

    Raises
    ------
    RecordingError
        If attitudes are too far apart to compute ω from them, or the number of recorded spins is
        not that of the scene's rotors.
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
    """Return ω as the derivative of attitudes, (n, 4), at times t, s, (n,).

    Longer stencils have smaller errors if attitudes have enough digits. The shortest is used whose
    error is at most twice the smallest.

    Raises
    ------
    RecordingError
        If the body turns too far between two samples.
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
    """Return ω in body axes, rad/s, (n, 3), by polynomials through `samples` attitudes at a time.

    ω is 2 q⁻¹ q', with weights of q' by B. Fornberg, Math. Comp. 51 (1988) 699.
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
    """Return the derivative, at each sample, of the Lagrange polynomial of stencil point j, (n,).

    It is in 1/s. The weight of the sample itself is not needed, as differences from it are added
    up.

    Parameters
    ----------
    first : index of the first point of each sample's stencil, (n,)
    points : how many points each stencil has
    j : the point's number in each stencil, from 0
    """
    own = np.arange(len(t)) - first
    weight = np.where(own == j, 0.0, 1.0)
    for i in range(points):
        if i != j:
            spacing = t[first + j] - t[first + i]
            weight *= np.where(own == i, 1.0, t - t[first + i]) / spacing
    return weight
