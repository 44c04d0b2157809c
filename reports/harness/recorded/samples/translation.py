"""Checks a recorded com and its velocity, and finds mistakes in recording that explain errors."""

from collections.abc import Iterator

import numpy as np

from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ...explaining.search import LEFT
from ..files.recording import LENGTHS, SPEEDS, Recording
from .digits import resolution
from .mistakes import FITS
from .other_readings import EVERY_AXES, named

#: Least error of com or velocity that is named: as a multiple of the error that the method and the
#: attitude explain, and as a fraction of the com's largest displacement, or of its largest speed.
FAR, PART = 10.0, 0.01


def mistakes_of_translation(
    scenario: Scenario, exact: Trajectory, recording: Recording, motion: Trajectory
) -> list[str]:
    """Return the mistakes in recording that explain errors of com and velocity, in words.

    Parameters
    ----------
    exact, motion : the exact and the recorded motion, at the recording's times
    """
    words = []
    # Errors are relative to the distance of the com from the origin, and to speeds.
    speed = float(norms(exact.omega_body).max()) * float(np.linalg.norm(scenario.constraint.lever))
    for name, candidates, scale in (
        ("com", _coms(scenario, motion), float(np.linalg.norm(scenario.constraint.lever))),
        ("velocity", _velocities(scenario, motion), speed + _largest(exact.velocity_world)),
    ):
        if name not in recording.arrays:
            continue
        reference = getattr(exact, f"{name}_world")
        least = float(norms(getattr(motion, f"{name}_world") - reference).max())
        residuals = {word: _largest(other - reference) for word, other in candidates}
        word = min(residuals, key=residuals.__getitem__)
        if least > FITS * scale and residuals[word] < LEFT * least:
            words.append(word)
    return words


def other_translation(
    exact: Trajectory,
    recording: Recording,
    motion: Trajectory,
    lever: float,
    timestep: float | None,
) -> list[str]:
    """Return that com or velocity have errors that no method explains, in words; often none.

    The error of the attitude is allowed for, and a constant displacement of the com. Errors that
    alternate are noise, which is not judged.

    Parameters
    ----------
    exact, motion : the exact and the recorded motion, at the recording's times
    lever : distance of the com from the body's origin or pivot, m
    timestep : the timestep that the motion was computed with, s; None if unknown
    """
    t, arrays = exact.t, recording.arrays
    step = float(np.diff(t).max())
    h = min(timestep or step, step)
    attitude_error = norms(
        rotation_vectors(exact.q_world_body_wxyz, motion.q_world_body_wxyz)
    ).max()
    omega_error = norms(motion.omega_body - exact.omega_body).max()
    speed = norms(exact.omega_body).max()
    spans = np.diff(t)[:, None]
    acceleration = float(norms(np.diff(exact.velocity_world, axis=0) / spans).max())
    # A method of order 1 is late by one step in velocity at most, which the com's place adds up.
    of_velocity = acceleration * h + lever * (omega_error + speed * attitude_error)
    of_com = (acceleration * h + lever * omega_error) * (t[-1] - t[0]) + lever * attitude_error
    words = []
    for name, word, unit, allowed, units in (
        ("com", "the com", "m", of_com, LENGTHS),
        ("velocity", "the velocity", "m/s", of_velocity, SPEEDS),
    ):
        if name not in arrays:
            continue
        reference = getattr(exact, f"{name}_world")
        deviation = arrays[name] - reference
        extent = _largest(reference - reference[0]) if name == "com" else _largest(reference)
        if name == "com":
            deviation = deviation - deviation[0]
        allowed += resolution(arrays[name], units.values()) * len(t) * step / h
        largest = _largest(deviation)
        is_smooth = float(np.median(norms(np.diff(deviation, axis=0)))) < LEFT * largest
        if is_smooth and largest > max(FAR * allowed, PART * extent):
            words.append(
                f"{word} is not that of the motion: it is off by up to {largest:.3g} {unit}, where "
                f"a method and the attitude make {allowed:.1g} {unit} at most"
            )
    return words


def _coms(scenario: Scenario, motion: Trajectory) -> Iterator[tuple[str, FloatArray]]:
    """Yield mistakes of the com, in words, each with the corrected com, m, world axes, (n, 3)."""
    R = matrices(motion.q_world_body_wxyz)
    yield (
        "x y z are those of the body's origin; they are to be those of the com",
        motion.com_world + R @ scenario.constraint.lever,
    )
    yield "x y z are along body axes", turned(R, motion.com_world)
    for name, factor in LENGTHS.items():
        yield f"x y z are in {name}; x [{name}] says so", factor * motion.com_world
    for axes in EVERY_AXES:
        yield f"x y z are along the world's axes {named(axes)}", motion.com_world @ axes.T


def _velocities(scenario: Scenario, motion: Trajectory) -> Iterator[tuple[str, FloatArray]]:
    """Yield possible mistakes of the velocity, in words, each with the corrected velocity.

    The corrected velocity is that of the com, m/s, world axes, (n, 3).
    """
    R, v = matrices(motion.q_world_body_wxyz), motion.velocity_world
    swing_world = turned(R, np.cross(motion.omega_body, scenario.constraint.lever))
    yield "the velocity is in body axes; it is to be in world axes", turned(R, v)
    yield (
        "the velocity is that of the body's origin; it is to be that of the com",
        v + swing_world,
    )
    yield (
        "the velocity is that of the body's origin, in body axes; it is to be that of the com, in "
        "world axes",
        turned(R, v) + swing_world,
    )
    for name, factor in SPEEDS.items():
        yield f"the velocity is in {name}; vx [{name}] says so", factor * v
    for axes in EVERY_AXES:
        yield f"the velocity is along the world's axes {named(axes)}", v @ axes.T


def _largest(vectors: FloatArray) -> float:
    """Return the largest norm of vectors, (n, 3)."""
    return float(norms(vectors).max())
