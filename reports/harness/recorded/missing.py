"""What is missing where no change explains a recorded motion: a torque, a rate, or time."""

import numpy as np

from ....reference.other_equations import equations_of
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ...results.change_words import vector
from ..explaining.search import LEFT, SAME
from .intervals import Intervals
from .mistakes import FITS

#: Digits of what is missing, and of axes: a mean over a span is known to few.
DIGITS, OF_AXES = 3, 2
KINEMATICS = "ω obeys Euler's equations, but the attitude does not follow ω"
DYNAMICS = "the attitude follows ω, but ω does not obey Euler's equations"


#: That energy is lost though the angular momentum is kept: by which percentage, and to which.
DISSIPATED = (
    "its energy falls by {:.3g} % while its angular momentum is kept to {:.2g} %, which no torque "
    "from outside does: something moves within the body and takes energy, such as fuel that "
    "sloshes, or a part that bends"
)
#: The part of a motion, at its beginning and its end, of which means are compared, and the least
#: number of their standard errors by which they differ.
PART, SURE = 0.1, 8.0
#: The largest change of the angular momentum relative to that of the energy: half of what
#: a torque against ω makes. What moves within the body exchanges some with it.
KEPT = 0.25


def dissipated(scenario: Scenario, motion: Trajectory) -> list[str]:
    """Say that a free body loses energy and keeps its angular momentum; nothing if it does not."""
    e = equations_of(scenario)
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
    """Return in words what is missing, if kinematics or dynamics alone differ; else nothing."""
    off = data.apart(data.base.equations)
    turned, omega = (np.sqrt(np.mean(part**2, axis=1)) for part in np.split(off, 2, axis=1))
    left = np.mean((off / data.scale) ** 2, axis=0)
    if left[3:].mean() <= 1:
        return [f"{KINEMATICS}: {_rate(data)}"]
    # By a torque that reverses within an interval the attitude is off, and ω is not.
    by_omega = np.hypot(data.spans[:, 0] * omega, data.scale[:, 0])
    if np.mean(turned**2) <= np.mean(by_omega**2):
        return [f"{DYNAMICS}: {_torque(data)}"]
    return []


def is_attitude_off(motion: Trajectory, exact: Trajectory) -> bool:
    """Whether ω is nearly that of the exact motion at its times, and the attitude is not."""
    faster, fastest = motion.omega_body - exact.omega_body, norms(exact.omega_body)
    return bool(norms(faster).max() < LEFT**2 * turned_off(motion, exact) * fastest.max())


def turned_off(motion: Trajectory, exact: Trajectory) -> float:
    """Return the largest turn between the attitudes of two motions, rad."""
    off = rotation_vectors(motion.q_world_body_wxyz, exact.q_world_body_wxyz)
    return float(norms(off).max())


def is_omega_off(motion: Trajectory, exact: Trajectory) -> bool:
    """Whether attitudes are those of the exact motion at their times, and ω is far from it."""
    faster, fastest = motion.omega_body - exact.omega_body, norms(exact.omega_body)
    off, speed = norms(faster).max(), fastest.max()
    return bool(max(turned_off(motion, exact) / SAME, FITS) * speed < off)


def _torque(data: Intervals) -> str:
    """Return in words the torque that is missing, its size and what it is along.

    It is a mean over each interval, of I ω' in the body's axes.
    """
    base = data.base.equations
    off = data.apart(base) / data.spans
    torque = off[:, 3:] @ base.inertia.T
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
    """Return in words the angular velocity by which the attitude does not follow ω.

    It is a mean over each interval, in the body's axes.
    """
    rate = data.apart(data.base.equations)[:, :3] / data.spans
    return _largest("a rate", data, rate, "rad/s") + _along_axes(data, rate, "rad/s")


def _largest(what: str, data: Intervals, missing: FloatArray, unit: str) -> str:
    k = int(np.argmax(norms(missing)))
    return (
        f"{what} of {norms(missing)[k]:.{DIGITS}g} {unit} at most is missing, at t = "
        f"{data.t[k]:.4g} s; "
    )


def _along_axes(data: Intervals, missing: FloatArray, unit: str) -> str:
    """Return in words what a vector in the body's axes, (S, 3), is along, or across."""
    signs = np.sign(np.sum(data.starts[:, :4] * data.ends[:, :4], axis=1, keepdims=True))
    halfway = data.starts[:, :4] + signs * data.ends[:, :4]
    halfway /= norms(halfway)[:, None]
    in_world = turned(matrices(halfway), missing)
    every = {"body": missing, "world": in_world}
    whole = float(np.sum(missing**2))
    for axes, vectors in every.items():
        mean = vectors.mean(axis=0)
        if np.sum((vectors - mean) ** 2) < LEFT * whole:
            return f"along {axes} axes it is nearly constant, {_rounded(mean)} {unit}"
    parts = {axes: np.linalg.svd(vectors)[1:] for axes, vectors in every.items()}
    for axes, (sizes, directions) in parts.items():
        if sizes[0] ** 2 > (1 - LEFT**2) * whole:
            return f"it changes along one axis of the {axes}, {_axis(directions[0])}"
    for axes, (sizes, directions) in parts.items():
        if sizes[2] ** 2 < LEFT**3 * whole:
            return f"it is across one axis of the {axes}, {_axis(directions[2])}"
    return "it is along no axes of the body or the world for long"


def _share(of: FloatArray, along: FloatArray) -> float:
    """Return the part of squares of vectors, (S, 3), that is along others."""
    lengths = np.maximum(norms(along), np.finfo(float).tiny)
    parts = np.sum(of * along, axis=1) / lengths
    return float(np.sum(parts**2) / np.sum(of**2))


def _rounded(numbers: FloatArray, digits: int = DIGITS) -> str:
    """Return a vector to few digits."""
    least = np.abs(numbers).max() / 10**digits
    return vector([float(f"{n:.{digits}g}") if abs(n) > least else 0.0 for n in numbers])


def _axis(numbers: FloatArray) -> str:
    """Return an axis whose largest component is positive."""
    return _rounded(numbers * np.sign(numbers[np.argmax(np.abs(numbers))]), OF_AXES)
