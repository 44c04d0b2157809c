"""Rare mistakes in recording: ways to read a recording that are tried alone, not in combination.

Each function yields a sentence on a mistake together with the reading that is corrected for it.
"""

import warnings
from collections.abc import Iterator
from itertools import permutations, product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .....scenarios import FloatArray, Scenario
from .....scenarios.rotation import matrix, norms, rotation_vectors
from ...explaining.changes import OTHER_COMPONENTS
from ...explaining.search import LEFT
from ..files.motion import Reading
from ..files.recording import unit_of

#: The numbers of samples by which ω may be older or newer than the attitude, or states may be early
#: or late; one sample is tried in `mistakes.py`.
SAMPLES = range(2, 6)
#: Evenly spaced times that are fitted by least squares are further than half a unit from those that
#: are rounded to that unit, by this fraction at most.
FITTED = 0.25
#: Tolerance of entries of matrices, of attitudes, rad, and of ω, relative to its size. Number of
#: samples in which axes that are turned by any angle must make the motion the exact one.
ALIKE, CHECKED = 1e-6, 12
#: All orders and signs of three axes, as matrices; and those of them that are rotations.
EVERY_AXES = [
    np.array(signs)[:, None] * np.eye(3)[list(order)]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
]
AXES = [R for R in EVERY_AXES if np.linalg.det(R) > 0]
COLUMNS = np.array(["qw", "qx", "qy", "qz"])


def other_readings(
    reading: Reading, scenario: Scenario, exact: FloatArray
) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence on each rare mistake, and the recording corrected for it.

    Parameters
    ----------
    reading : the samples of the recording as they were read
    exact : the exact states at the n samples: q, scalar first, and ω, rad/s, body axes, (n, 7)
    """
    yield from equal_times(reading)
    yield from _of_columns(reading)
    yield from _of_angles(reading)
    yield from _of_shifts(reading)
    if reading.omega is not None:
        yield from _of_age(reading, reading.omega)
    yield from _of_components(reading)
    if reading.frame == "body":
        yield from _of_axes(reading, scenario, exact)


def equal_times(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Yield the sentence that times are rounded, and the recording at evenly spaced times.

    Two spacings are tried: 1/n s, with an integer n, and the one that fits the recorded times best.
    A spacing is left out if its times, when rounded, are not the recorded ones, or if these have
    not been rounded.
    """
    t, count = reading.t, np.arange(len(reading.t))
    unit = unit_of(np.diff(t))
    slope, start = np.polyfit(count, t, 1)
    rate = max(1, round(1 / slope))
    for first, distance, words in (
        (t[0], 1 / rate, f"1/{rate} s"),
        (start, slope, f"{slope:.6g} s"),
    ):
        even = first + distance * count
        # If times are multiples of the spacing itself, they are not rounded.
        is_rounded = 0 < unit < (1 - LEFT**2) * slope
        if is_rounded and np.abs(t - even).max() < (1 + FITTED) * unit / 2:
            words = f"the times are rounded to {unit:.6g} s: samples are {words} apart"
            yield words, reading._replace(t=even)


def _of_components(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each other order and signs of x, y, z, and the corrected reading.

    Orders and signs are those of the components of both q and ω.
    """
    for components in OTHER_COMPONENTS:
        names = ", ".join(f"{'-' * (one < 0)}{' xyz'[abs(one)]}" for one in components)
        axes, signs = np.abs(components) - 1, np.sign(components)
        q = np.hstack([reading.q[:, :1], reading.q[:, 1:][:, axes] * signs])
        omega = None if reading.omega is None else reading.omega[:, axes] * signs
        words = f"x, y, z of the quaternion and of ω are [{names}] of their columns"
        yield words, reading._replace(q=q, omega=omega)


def _of_columns(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each order and signs of q's components, and the corrected reading."""
    for order in map(list, permutations(range(4))):
        for signs in product((1.0, -1.0), repeat=3):
            picked = zip((1.0, *signs), COLUMNS[order], strict=True)
            names = ", ".join(f"{'-' * int(sign < 0)}{name}" for sign, name in picked)
            q = reading.q[:, order] * [1.0, *signs]
            yield f"the quaternion is [{names}] of its columns", reading._replace(q=q)


def _of_angles(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each wrong convention of Euler angles, and the corrected reading.

    Either angles of the right convention were converted to quaternions in a wrong order, or angles
    were taken for those of a wrong convention.
    """
    R = Rotation.from_quat(reading.q, scalar_first=True)
    # The type is Any, as scipy's stubs declare literal types of conventions.
    conventions: list[Any] = list(map("".join, permutations("XYZ")))
    for used in conventions:
        with warnings.catch_warnings(action="ignore"):
            angles = R.as_euler(used)
        for right in conventions:
            by_axis = angles[:, [used.index(axis) for axis in right]]
            for given, how in ((by_axis, "composed in the order"), (angles, "taken for those of")):
                q = Rotation.from_euler(right, given).as_quat(scalar_first=True)
                words = f"the attitude's Euler angles {right} were {how} {used}"
                yield words, reading._replace(q=q)


def _of_shifts(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each number of samples by which states may be early or late.

    Each sentence comes with the reading at corrected times.
    """
    step = float(np.diff(reading.t).min())
    for samples in SAMPLES:
        for sign, when in ((1, "after"), (-1, "before")):
            words = f"each state is that of {samples} samples {when} its time"
            yield words, reading._replace(t=reading.t + sign * samples * step)


def _of_age(reading: Reading, omega: FloatArray) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each number of samples by which ω may be old or new, and the correction.

    `omega` is the ω of n samples, rad/s, (n, 3). In the corrected reading each attitude has the
    ω of its own time. Samples at an end that have none are left out.
    """
    for samples in SAMPLES:
        earlier, later = slice(None, -samples), slice(samples, None)
        for age, own, other in (("older", earlier, later), ("newer", later, earlier)):
            words = f"ω is {samples} samples {age} than the attitude"
            yield words, reading.rows(own)._replace(omega=omega[other])


def _of_axes(
    reading: Reading, scenario: Scenario, exact: FloatArray
) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each choice of axes that corrects the first attitude, and the reading.

    The axes of world and body are the scene's in another order or with other signs; those of the
    body may be its principal axes instead, or any that make the first state the exact one. If the
    first recorded attitude is the identity, all attitudes may have been recorded relative to the
    first.

    Parameters
    ----------
    exact : the exact states at the n samples: q, scalar first, and ω, rad/s, body axes, (n, 7)
    """
    R, first = matrix(reading.q[0]), matrix(exact[0, :4])
    if np.abs(R - np.eye(3)).max() < ALIKE:
        words = "the attitude is relative to that of the first sample, as where it was set to zero"
        yield f"{words}, along body axes", _turned(reading, first, np.eye(3))
        q = _turned(reading, np.eye(3), first).q
        yield f"{words}, along world axes", reading._replace(q=q)

    def fits(world: FloatArray, body: FloatArray) -> bool:
        return bool(np.abs(world @ R @ body - first).max() < LEFT)

    for world, body in product(AXES, AXES):
        if fits(world, body):
            which = [
                f"the {of}'s axes are {named(R)} of the scene's"
                for of, R in (("world", world), ("body", body))
                if not np.array_equal(R, np.eye(3))
            ]
            words, other = " and ".join(which), _turned(reading, world, body)
            yield words, other
            yield f"{words}, except for ω", other._replace(omega=reading.omega)
    axes = np.linalg.eigh(scenario.body.inertia_com)[1]
    axes[:, 2] *= np.linalg.det(axes)
    for body in AXES:
        if fits(np.eye(3), body @ axes.T):
            words = "attitude and ω are those of the tensor's principal axes, not of the body's"
            yield words, _turned(reading, np.eye(3), body @ axes.T)
    yield from _of_any_axes(reading, exact, R.T @ first)


def _of_any_axes(
    reading: Reading, exact: FloatArray, body: FloatArray
) -> Iterator[tuple[str, Reading]]:
    """Yield the sentence that axes are turned in the body, and the reading along the body's own.

    The sentence is on attitude and ω, or on the attitude alone, whichever makes the first states
    the exact ones. Nothing is yielded if neither does, as with noise, or if both do.

    Parameters
    ----------
    exact : the exact states at the n samples: q, scalar first, and ω, rad/s, body axes, (n, 7)
    body : the rotation that makes the first attitude the exact one, from the right, (3, 3)
    """
    checked = slice(min(CHECKED, len(reading.t), len(exact)))
    both, states = _turned(reading, np.eye(3), body), exact[checked]
    turn = ", ".join(f"{angle:.4g}" for angle in Rotation.from_matrix(body.T).as_rotvec(True))
    turn = f"of axes that are turned in the body by [{turn}]°"
    off = norms(rotation_vectors(both.q[checked], states[:, :4])).max()
    if reading.omega is None or both.omega is None or off > ALIKE:
        return
    least = ALIKE * norms(states[:, 4:]).max()
    omegas = both.omega, reading.omega
    fits = [bool(norms(one[checked] - states[:, 4:]).max() <= least) for one in omegas]
    if fits == [True, False]:
        yield f"attitude and ω are those {turn}", both
    if fits == [False, True]:
        words = f"the attitude is that {turn}, and ω is not"
        yield words, both._replace(omega=reading.omega)


def _turned(reading: Reading, world: FloatArray, body: FloatArray) -> Reading:
    """Return a recording along other axes: each attitude R becomes world @ R @ body.

    ω, which is along body axes, becomes ω @ body.

    Parameters
    ----------
    world, body : rotation matrices, (3, 3)
    """
    R = Rotation.from_quat(reading.q, scalar_first=True)
    q = Rotation.from_matrix(world) * R * Rotation.from_matrix(body)
    omega = None if reading.omega is None else reading.omega @ body
    return reading._replace(q=q.as_quat(scalar_first=True), omega=omega)


def named(R: FloatArray) -> str:
    """Return the axis that each column of the matrix `R`, (3, 3), is along, like [x, -z, y]."""
    at = np.abs(R).argmax(axis=0)
    return f"[{', '.join('-' * int(R[k, j] < 0) + 'xyz'[k] for j, k in enumerate(at))}]"
