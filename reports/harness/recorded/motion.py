"""A recording as a motion: frames and order of components as its columns have them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import matrices, turned_back
from .recording import Recording, RecordingError

QuaternionOrder = Literal["wxyz", "xyzw"]
OmegaFrame = Literal["body", "world"]


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A motion, and which of its quantities were recorded.

    Attributes
    ----------
    trajectory : at the file's own times; a com or velocity that was not recorded is the exact one
    has_omega : else ω is the derivative of the attitudes
    """

    trajectory: Trajectory
    has_omega: bool


def recorded_motion(
    scenario: Scenario,
    recording: Recording,
    exact: Trajectory,
    quaternion: QuaternionOrder = "wxyz",
    omega: OmegaFrame = "body",
) -> RecordedMotion:
    """A recording as a motion in the scene's frames.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    quaternion, omega : how the file's columns are to be read

    Raises
    ------
    RecordingError
        If attitudes are too far apart to tell ω from them.
    """
    arrays = recording.arrays
    q = arrays["q"] if quaternion == "wxyz" else np.roll(arrays["q"], 1, axis=1)
    q = q / np.linalg.norm(q, axis=1)[:, None]
    com = arrays.get("com", exact.com_world)
    velocity = arrays.get("velocity", exact.velocity_world)
    R_world_body, constraint = matrices(q), scenario.constraint
    if "com" not in arrays:
        com = constraint.com_world(R_world_body @ constraint.lever, com)
    has_omega = "omega" in arrays
    omega_body = arrays["omega"] if has_omega else omega_of_attitudes(arrays["t"], q)
    if has_omega and omega == "world":
        omega_body = turned_back(R_world_body, omega_body)
    if "velocity" not in arrays:
        arm_world = R_world_body @ constraint.lever
        omega_world = np.einsum("nij,nj->ni", R_world_body, omega_body)
        velocity = constraint.velocity_world(np.cross(omega_world, arm_world), velocity)
    # A recording has none: those with which parts keep what they should.
    spins = scenario.spins(omega_body, scenario.kept_at_start)
    motion = Trajectory(arrays["t"], q, omega_body, com, velocity, spins)
    return RecordedMotion(motion, has_omega)


def omega_of_attitudes(t: FloatArray, q_world_body_wxyz: FloatArray) -> FloatArray:
    """ω along body axes, rad/s, (n, 3), from n attitudes, of fourth order in their distance.

    At a sample the rotation vector to its neighbours has the derivative ω; it is that of the
    polynomial through five of them (B. Fornberg, Math. Comp. 51 (1988) 699, for its weights).

    Raises
    ------
    RecordingError
        If the body turns too far between two samples for that.
    """
    attitudes = Rotation.from_quat(q_world_body_wxyz, scalar_first=True)
    turns = np.atleast_1d((attitudes[:-1].inv() * attitudes[1:]).magnitude())
    if turns.max() > FURTHEST:
        k = int(np.argmax(turns))
        raise RecordingError(
            f"the body turns by {np.degrees(turns[k]):.0f}° between samples {k + 1} and {k + 2}: "
            "ω cannot be told from attitudes so far apart; write ω, or more samples"
        )
    points = min(STENCIL, len(t))
    first = np.clip(np.arange(len(t)) - points // 2, 0, len(t) - points)
    omega_body = np.zeros((len(t), 3))
    for j in range(points):
        to_neighbour = (attitudes.inv() * attitudes[first + j]).as_rotvec()
        omega_body += _weight(t, first, points, j)[:, None] * to_neighbour
    return omega_body


def _weight(t: FloatArray, first: NDArray[np.intp], points: int, j: int) -> FloatArray:
    """The derivative at each sample of the Lagrange polynomial of its stencil's point j, 1/s, (n,).

    That of the sample's own point is not needed: its rotation vector is zero.
    """
    own = np.arange(len(t)) - first
    weight = np.where(own == j, 0.0, 1.0)
    for i in range(points):
        if i != j:
            apart = t[first + j] - t[first + i]
            weight *= np.where(own == i, 1.0, t - t[first + i]) / apart
    return weight


#: Samples that ω is found from.
STENCIL = 5
#: rad between two samples: over a stencil's four the direction of a turn must not be ambiguous.
FURTHEST = 0.75
