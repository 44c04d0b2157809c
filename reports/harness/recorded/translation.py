"""Whether a recorded com and its velocity are those of the motion, and what else they may be."""

from collections.abc import Iterator

import numpy as np

from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ..explaining.search import LEFT
from .digits import resolution
from .mistakes import FITS
from .other_readings import EVERY_AXES, named
from .recording import LENGTHS, SPEEDS, Recording

#: Factor by which a com or a velocity is further off than a method and the attitude make it, and
#: part of how far it moves, or how fast, before it is another one.
FAR, PART = 10.0, 0.01


def mistakes_of_translation(
    scenario: Scenario, exact: Trajectory, recording: Recording, motion: Trajectory
) -> list[str]:
    """Return what a com and a velocity are in place of those of the motion, in words; often none.

    Parameters
    ----------
    exact, motion : the exact and the recorded motion, at the recording's times
    """
    words = []
    # Errors are relative to how far the body's points are apart, and how fast they move.
    speed = float(norms(exact.omega_body).max()) * float(np.linalg.norm(scenario.constraint.lever))
    for name, which, scale in (
        ("com", _coms(scenario, motion), float(np.linalg.norm(scenario.constraint.lever))),
        ("velocity", _velocities(scenario, motion), speed + _largest(exact.velocity_world)),
    ):
        if name not in recording.arrays:
            continue
        right = getattr(exact, f"{name}_world")
        least = float(norms(getattr(motion, f"{name}_world") - right).max())
        left = {word: _largest(other - right) for word, other in which}
        word = min(left, key=left.__getitem__)
        if least > FITS * scale and left[word] < LEFT * least:
            words.append(word)
    return words


def other_translation(
    exact: Trajectory,
    recording: Recording,
    motion: Trajectory,
    lever: float,
    timestep: float | None,
) -> list[str]:
    """Say that a com, or a velocity, is further off than a method and the attitude make it.

    Places may be counted from elsewhere. Errors that alternate are noise, which is not judged.

    Parameters
    ----------
    lever : distance of the com from the body's origin or pivot, m
    timestep : the timestep that the motion was made with, s; None if unknown
    """
    t, arrays = exact.t, recording.arrays
    step = float(np.diff(t).max())
    h = min(timestep or step, step)
    turned_off = norms(rotation_vectors(exact.q_world_body_wxyz, motion.q_world_body_wxyz)).max()
    faster = norms(motion.omega_body - exact.omega_body).max()
    speed = norms(exact.omega_body).max()
    spans = np.diff(t)[:, None]
    accelerated = float(norms(np.diff(exact.velocity_world, axis=0) / spans).max())
    # A step of order 1 is off by its length in velocity at most, and so throughout in place.
    of_velocity = accelerated * h + lever * (faster + speed * turned_off)
    of_com = (accelerated * h + lever * faster) * (t[-1] - t[0]) + lever * turned_off
    words = []
    for name, word, unit, allowed, units in (
        ("com", "the com", "m", of_com, LENGTHS),
        ("velocity", "the velocity", "m/s", of_velocity, SPEEDS),
    ):
        if name not in arrays:
            continue
        right = getattr(exact, f"{name}_world")
        off = arrays[name] - right
        moved = _largest(right - right[0]) if name == "com" else _largest(right)
        if name == "com":
            off = off - off[0]
        allowed += resolution(arrays[name], units.values()) * len(t) * step / h
        largest = _largest(off)
        is_smooth = float(np.median(norms(np.diff(off, axis=0)))) < LEFT * largest
        if is_smooth and largest > max(FAR * allowed, PART * moved):
            words.append(
                f"{word} is not that of the motion: it is off by up to {largest:.3g} {unit}, where "
                f"a method and the attitude make {allowed:.1g} {unit} at most"
            )
    return words


def _coms(scenario: Scenario, motion: Trajectory) -> Iterator[tuple[str, FloatArray]]:
    """Yield what places may be, in words, and the com, m, world axes, (n, 3), if they are."""
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
    """Yield what velocities may be, in words, and that of the com, m/s, world axes, (n, 3)."""
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
    """Return the largest norm of rows, (n, 3)."""
    return float(norms(vectors).max())
