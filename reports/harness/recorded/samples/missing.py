"""Describes the torque, or angular velocity, that a recorded motion has and the equations lack.

Such sentences are used if no change of the equations explains the motion.
"""

import numpy as np

from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ....results.change_words import vector
from ...explaining.search import LEFT, SAME
from .intervals import Intervals
from .mistakes import FITS

#: Significant digits of missing torques and rates, and of axes. They are few, as torques and rates
#: are means over intervals.
DIGITS, OF_AXES = 3, 2
KINEMATICS = "ω obeys Euler's equations, but the attitude does not follow ω"
DYNAMICS = "the attitude follows ω, but ω does not obey Euler's equations"


#: The sentence on dissipation, with the loss of energy and the change of angular momentum, in %.
DISSIPATED = (
    "its energy falls by {:.3g} % while its angular momentum is kept to {:.2g} %, which no torque "
    "from outside does: something moves within the body and takes energy, such as fuel that "
    "sloshes, or a part that bends"
)
#: The mean energies over this fraction of a motion, at its beginning and at its end, are compared.
#: They differ significantly if they do so by more than `SURE` standard errors.
PART, SURE = 0.1, 8.0
#: Largest relative change of the angular momentum, in units of the relative loss of energy. It is
#: not zero, as parts that move within the body take up some; a torque against ω changes it by twice
#: as much.
KEPT = 0.25


def dissipated(scenario: Scenario, motion: Trajectory) -> list[str]:
    """Return a list of the sentence that a free body loses energy but keeps its angular momentum.

    The list is empty if the body does not, or if the scene has a com off the pivot, a table, a
    torque, drag, or a constant angular momentum of rotors.
    """
    e = equations_of(scenario)
    if e.mobility:
        return []
    if e.pull.any() or e.torque.any() or e.torque_world.any() or e.slowing.any() or e.kept.any():
        return []
    omega, count = motion.omega_body, max(2, int(PART * len(motion.t)))
    L_body = omega @ e.inertia
    energy = np.sum(omega * L_body, axis=1) / 2
    L_world = turned(matrices(motion.q_world_body_wxyz), L_body)
    parts = slice(count), slice(-count, None)
    first, last = (float(energy[part].mean()) for part in parts)
    error = max(float(np.std(energy[part])) for part in parts) / np.sqrt(count)
    begins, ends = (L_world[part].mean(axis=0) for part in parts)
    lost = (first - last) / (first or 1.0)
    kept = float(np.linalg.norm(ends - begins) / (np.linalg.norm(begins) or 1.0))
    if first - last < SURE * error or lost < FITS or kept > KEPT * lost:
        return []
    return [DISSIPATED.format(100 * lost, 100 * kept)]


def missing(data: Intervals) -> list[str]:
    """Return a sentence on the angular velocity, or on the torque, that the equations lack.

    A torque is missing if the attitude follows ω, but ω does not obey Euler's equations. An angular
    velocity is missing if ω obeys them, but the attitude does not follow ω.

    Parameters
    ----------
    data : intervals of the recorded motion; `data.base` has the equations

    Returns
    -------
    A list of one sentence; empty if neither is so
    """
    deviations = data.apart(data.base)
    turned, omega = (np.sqrt(np.mean(part**2, axis=1)) for part in np.split(deviations, 2, axis=1))
    mean_squares = np.mean((deviations / data.scale) ** 2, axis=0)
    if mean_squares[3:].mean() <= 1:
        return [f"{KINEMATICS}: {_rate(data)}"]
    # A torque that reverses within an interval changes the attitude at its end, but not ω.
    by_omega = np.hypot(data.spans[:, 0] * omega, data.scale[:, 0])
    if np.mean(turned**2) <= np.mean(by_omega**2):
        return [f"{DYNAMICS}: {_torque(data)}"]
    return []


def is_attitude_off(motion: Trajectory, exact: Trajectory) -> bool:
    """Return whether the attitude is wrong, and ω is not.

    The relative error of ω must be far smaller than the error of the attitude, rad.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times
    """
    omega_errors, fastest = motion.omega_body - exact.omega_body, norms(exact.omega_body)
    return bool(norms(omega_errors).max() < LEFT**2 * turned_off(motion, exact) * fastest.max())


def turned_off(motion: Trajectory, exact: Trajectory) -> float:
    """Return the largest turn between the attitudes of two motions at the same times, rad."""
    deviations = rotation_vectors(motion.q_world_body_wxyz, exact.q_world_body_wxyz)
    return float(norms(deviations).max())


def is_omega_off(motion: Trajectory, exact: Trajectory) -> bool:
    """Return whether ω is wrong, and the attitude is not.

    The error of the attitude, rad, must be far smaller than the relative error of ω.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times
    """
    omega_errors, fastest = motion.omega_body - exact.omega_body, norms(exact.omega_body)
    deviations, speed = norms(omega_errors).max(), fastest.max()
    return bool(max(turned_off(motion, exact) / SAME, FITS) * speed < deviations)


def _torque(data: Intervals) -> str:
    """Return in words the size and the direction of the missing torque.

    It is the tensor of inertia times the missing ω', averaged over each interval, in body axes.
    """
    base = data.base
    deviations = data.apart(base) / data.spans
    torque = deviations[:, 3:] @ base.inertia.T
    omega = (data.starts[:, 4:] + data.ends[:, 4:]) / 2
    L = omega @ base.inertia.T + base.kept
    words = [_along_axes(data, torque, "N m")]
    of_omega = _share(torque, omega)
    if of_omega > 1 - LEFT:
        against = np.sum(torque * omega) < 0
        words.append(f"it is {'against' if against else 'along'} ω")
    if of_omega < LEFT**2:
        words.append("it is across ω")
    if base.kept.any() or _share(L, omega) < 1 - LEFT**2:
        words += ["it is across L: ‖L‖ is kept"] if _share(torque, L) < LEFT**2 else []
    return _largest("a torque", data, torque, "N m") + "; ".join(words)


def _rate(data: Intervals) -> str:
    """Return in words the angular velocity with which the attitude turns in addition to ω.

    It is averaged over each interval, in body axes.
    """
    rate = data.apart(data.base)[:, :3] / data.spans
    return _largest("a rate", data, rate, "rad/s") + _along_axes(data, rate, "rad/s")


def _largest(what: str, data: Intervals, missing: FloatArray, unit: str) -> str:
    """Return in words the largest of several missing vectors, and its time.

    Parameters
    ----------
    what : what is missing, in words
    data : S intervals of the motion
    missing : the missing vector in each interval, (S, 3)
    unit : unit of the vectors
    """
    k = int(np.argmax(norms(missing)))
    return (
        f"{what} of {norms(missing)[k]:.{DIGITS}g} {unit} at most is missing, at t = "
        f"{data.t[k]:.4g} s; "
    )


def _along_axes(data: Intervals, missing: FloatArray, unit: str) -> str:
    """Return in words how vectors lie relative to the axes of the body or of the world.

    They are nearly constant along all axes, or along one axis, or across one, or none of these.

    Parameters
    ----------
    data : S intervals of the motion, whose attitudes turn the body's axes to the world's
    missing : the vectors, one for each interval, in body axes, (S, 3)
    unit : unit of the vectors
    """
    signs = np.sign(np.sum(data.starts[:, :4] * data.ends[:, :4], axis=1, keepdims=True))
    halfway = data.starts[:, :4] + signs * data.ends[:, :4]
    halfway /= norms(halfway)[:, None]
    in_world = turned(matrices(halfway), missing)
    by_frame = {"body": missing, "world": in_world}
    whole = float(np.sum(missing**2))
    for axes, vectors in by_frame.items():
        mean = vectors.mean(axis=0)
        if np.sum((vectors - mean) ** 2) < LEFT * whole:
            return f"along {axes} axes it is nearly constant, {_rounded(mean)} {unit}"
    parts = {axes: np.linalg.svd(vectors)[1:] for axes, vectors in by_frame.items()}
    for axes, (sizes, directions) in parts.items():
        if sizes[0] ** 2 > (1 - LEFT**2) * whole:
            return f"it changes along one axis of the {axes}, {_axis(directions[0])}"
    for axes, (sizes, directions) in parts.items():
        if sizes[2] ** 2 < LEFT**3 * whole:
            return f"it is across one axis of the {axes}, {_axis(directions[2])}"
    return "it is along no axes of the body or the world for long"


def _share(of: FloatArray, along: FloatArray) -> float:
    """Return the fraction of the sum of squares of vectors that is due to components along others.

    Parameters
    ----------
    of : the S vectors, (S, 3)
    along : for each of them the other vector, whose length does not matter, (S, 3)
    """
    lengths = np.maximum(norms(along), np.finfo(float).tiny)
    parts = np.sum(of * along, axis=1) / lengths
    return float(np.sum(parts**2) / np.sum(of**2))


def _rounded(components: FloatArray, digits: int = DIGITS) -> str:
    """Return a vector as text, with components to a number of significant digits."""
    least = np.abs(components).max() / 10**digits
    return vector([float(f"{n:.{digits}g}") if abs(n) > least else 0.0 for n in components])


def _axis(components: FloatArray) -> str:
    """Return an axis as text, with the sign that makes its largest component positive."""
    return _rounded(components * np.sign(components[np.argmax(np.abs(components))]), OF_AXES)
