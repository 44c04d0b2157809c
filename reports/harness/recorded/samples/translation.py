"""Checks the recorded com and its velocity, and finds mistakes that explain their errors."""

from collections.abc import Iterator

import numpy as np

from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import cross, matrices, norms, rotation_vectors, turned
from ...explaining.search import LEFT
from ...measuring.noise import ULPS
from ..files.recording import LENGTHS, SPEEDS, Recording
from .digits import resolution
from .mistakes import FITS
from .other_readings import EVERY_AXES, named

#: Least error of com or velocity that is reported: in multiples of the error that a method and the
#: attitude's error explain, and as a fraction of the com's largest displacement or speed.
FAR, PART = 10.0, 0.01
#: Least error of the first velocity that is reported as another start, in multiples of the error
#: that a method and the attitude's error explain. Later the error must change by less than that.
AT_START = 2.0


def mistakes_of_translation(
    scenario: Scenario, exact: Trajectory, recording: Recording, motion: Trajectory
) -> list[str]:
    """Return sentences on the mistakes in recording that explain errors of com and velocity.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    recording : the recording, which says whether com and velocity were recorded
    motion : the recorded motion

    Returns
    -------
    At most one sentence on the com and one on the velocity; often none
    """
    words = []
    # Errors of the com are compared with its distances from the origins of body and world.
    lever = float(np.linalg.norm(scenario.constraint.lever))
    speed = float(norms(exact.omega_body).max()) * lever
    for name, candidates, scale in (
        ("com", _coms(scenario, motion), lever + _largest(exact.com_world)),
        ("velocity", _velocities(scenario, motion), speed + _largest(exact.velocity_world)),
    ):
        if name not in recording.arrays:
            continue
        reference = getattr(exact, f"{name}_world")
        least = float(norms(getattr(motion, f"{name}_world") - reference).max())
        if not scale or least <= FITS * scale:
            continue
        # What a correction leaves of the error is compared with the error in the same unit.
        left, word = min(
            (_largest(other - reference) / min(unit * least, scale), word)
            for word, other, unit in candidates
        )
        if left < LEFT:
            words.append(word)
    return words


def other_translation(
    scenario: Scenario,
    exact: Trajectory,
    recording: Recording,
    motion: Trajectory,
    timestep: float | None,
) -> list[str]:
    """Return sentences on errors of com and velocity that are too large for a method; often none.

    Errors that follow from errors of attitude and ω are allowed. So is a constant displacement of
    the com, along the axes of the world along which it moves freely.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    recording : the recording, of which com and velocity are checked if they were recorded
    motion : the recorded motion
    timestep : timestep with which the motion was computed, s; None if unknown
    """
    t, arrays = exact.t, recording.arrays
    lever = float(np.linalg.norm(scenario.constraint.lever))
    step = float(np.diff(t).max())
    h = min(timestep or step, step)
    attitude_error = norms(
        rotation_vectors(exact.q_world_body_wxyz, motion.q_world_body_wxyz)
    ).max()
    omega_error = norms(motion.omega_body - exact.omega_body).max()
    speed = _largest(exact.omega_body)
    spans = np.diff(t)[:, None]
    acceleration = _largest(np.diff(exact.velocity_world, axis=0) / spans)
    duration = t[-1] - t[0]
    # A method of order 1 is late by one step in velocity at most. The error of the com adds up that
    # of the velocity.
    of_velocity = acceleration * h + lever * (omega_error + speed * attitude_error)
    of_com = (acceleration * h + lever * omega_error) * duration + lever * attitude_error
    added = _added_acceleration(scenario, exact, motion, h)
    of_velocity, of_com = of_velocity + added * duration, of_com + added * duration**2 / 2
    # Along axes that a constraint holds, the com follows from the attitude and adds up no error.
    of_held = _largest(exact.velocity_world) * h + lever * attitude_error
    words, later = list[str](), t[:, None] - t[0]
    flown, is_held = np.zeros_like(exact.com_world), np.array(scenario.constraint.is_held)
    if "velocity" in arrays:
        off, extent = arrays["velocity"] - exact.velocity_world, _largest(exact.velocity_world)
        rounding = rounding_of(arrays["velocity"], SPEEDS, len(t) * step / h)
        most = max(AT_START * of_velocity, PART * extent) + rounding
        if _largest(off[:1]) > most >= _largest(off - off[0]):
            is_off = f"it is off by {_largest(off[:1]):.3g} m/s at t = {t[0]:.4g} s"
            words, flown = [f"the com started with another velocity: {is_off}"], off[0] * later
        else:
            is_off = "the velocity is not that of the motion: it is"
            words = far_off(is_off, "m/s", off, of_velocity, rounding, extent)
    if "com" in arrays:
        off, moved = arrays["com"] - exact.com_world, exact.com_world - exact.com_world[0]
        rounding = rounding_of(arrays["com"], LENGTHS, len(t) * step / h)
        is_off = "the com is not that of the motion: it is"
        # The error of a soft constraint is compared with the lever: the com may not move at all.
        for axes, other, allowed, extent in (
            (is_held, off, of_held, max(lever, _largest(moved[:, is_held]))),
            (~is_held, off - off[0] - flown, of_com, _largest(moved[:, ~is_held])),
        ):
            if said := far_off(is_off, "m", other[:, axes], allowed, rounding, extent):
                return said + words
    return words


def _added_acceleration(
    scenario: Scenario, exact: Trajectory, motion: Trajectory, h: float
) -> float:
    """Return the largest acceleration of the com, m/s², that a method or rounding may add.

    On a table engines step the body's tip. By a method's error of ω the tip swings about the com,
    and a method of order 1 takes the acceleration of this swing at a time that is wrong by one step
    at most. Forces between rotors and body cancel, but for their rounding.

    Parameters
    ----------
    exact, motion : the exact and the recorded motion
    h : the length of a step, s
    """
    added = 0.0
    if exact.spins.size:
        force, _ = scenario.cancelling(np.abs(exact.spins))
        added = ULPS * float(np.finfo(float).eps * force.max()) / scenario.body.mass
    if not (scenario.constraint.is_pivot or scenario.constraint.is_free):
        off = motion.omega_body - exact.omega_body
        swing = cross(off, np.broadcast_to(scenario.constraint.lever, off.shape))
        added += _largest(swing) * _largest(exact.omega_body) ** 2 * h
    return added


def far_off(
    is_off: str,
    unit: str,
    deviation: FloatArray,
    allowed: float,
    rounding: float,
    extent: float,
) -> list[str]:
    """Return a list of the sentence that the error of a quantity is far larger than a method's.

    The list is empty if it is not, or if the error alternates from sample to sample, as noise does.
    The numbers below are in `unit`.

    Parameters
    ----------
    is_off : the beginning of the sentence, up to the words "off by"
    unit : unit of the quantity
    deviation : deviations of the quantity's k components from the exact motion at n samples, (n, k)
    allowed : the largest error that a method and the error of the attitude explain
    rounding : the largest error by rounding
    extent : the largest size of the quantity, or its largest change
    """
    largest = _largest(deviation)
    if not (_is_smooth(deviation) and largest > max(FAR * allowed, PART * extent) + rounding):
        return []
    return [
        f"{is_off} off by up to {largest:.3g} {unit}, where a method and the attitude make "
        f"{allowed + rounding:.1g} {unit} at most"
    ]


def _is_smooth(deviation: FloatArray) -> bool:
    """Return whether the deviations of n samples change little from one to the next, unlike noise.

    Parameters
    ----------
    deviation : the deviations, with k components, (n, k)
    """
    changes = float(np.median(norms(np.diff(deviation, axis=0))))
    return changes < LEFT * _largest(deviation)


def rounding_of(numbers: FloatArray, units: dict[str, float], steps: float) -> float:
    """Return the largest error by rounding, in the unit of `numbers`.

    A number is rounded once when it is printed. If an engine adds it up in single precision, it is
    also rounded in each step. Numbers of few digits may be due to either, so both errors are added.

    Parameters
    ----------
    numbers : recorded numbers of one quantity, of any shape
    units : the units in which the numbers may have been printed: their sizes, by name, in the unit
        of `numbers`
    steps : the number of steps that the engine took
    """
    once = resolution(numbers, units.values())
    return once + min(once, float(np.finfo(np.float32).eps) * float(np.abs(numbers).max())) * steps


def _coms(scenario: Scenario, motion: Trajectory) -> Iterator[tuple[str, FloatArray, float]]:
    """Yield sentences on possible mistakes of the com, each with the corrected com.

    The corrected com of n samples is in m, along world axes, (n, 3). After it comes the size of the
    unit of the recorded numbers, m, but at most 1. The error that remains is compared in this unit,
    as conversion from a small unit makes any number small.
    """
    R = matrices(motion.q_world_body_wxyz)
    yield (
        "x y z are those of the body's origin; they are to be those of the com",
        motion.com_world + R @ scenario.constraint.lever,
        1.0,
    )
    yield "x y z are along body axes", turned(R, motion.com_world), 1.0
    for name, unit in LENGTHS.items():
        yield f"x y z are in {name}; x [{name}] says so", unit * motion.com_world, min(unit, 1.0)
    for axes in EVERY_AXES:
        yield f"x y z are along the world's axes {named(axes)}", motion.com_world @ axes.T, 1.0


def _velocities(scenario: Scenario, motion: Trajectory) -> Iterator[tuple[str, FloatArray, float]]:
    """Yield sentences on possible mistakes of the velocity, each with the corrected velocity.

    The corrected velocity is that of the com at n samples, in m/s, along world axes, (n, 3). After
    it comes the size of the unit of the recorded numbers, m/s, but at most 1. The error that
    remains is compared in this unit.
    """
    R, v = matrices(motion.q_world_body_wxyz), motion.velocity_world
    swing_world = turned(R, np.cross(motion.omega_body, scenario.constraint.lever))
    yield "the velocity is in body axes; it is to be in world axes", turned(R, v), 1.0
    yield (
        "the velocity is that of the body's origin; it is to be that of the com",
        v + swing_world,
        1.0,
    )
    yield (
        "the velocity is that of the body's origin, in body axes; it is to be that of the com, in "
        "world axes",
        turned(R, v) + swing_world,
        1.0,
    )
    for name, unit in SPEEDS.items():
        yield f"the velocity is in {name}; vx [{name}] says so", unit * v, min(unit, 1.0)
    for axes in EVERY_AXES:
        yield f"the velocity is along the world's axes {named(axes)}", v @ axes.T, 1.0


def _largest(vectors: FloatArray) -> float:
    """Return the largest norm of n vectors, (n, 3)."""
    return float(norms(vectors).max())
