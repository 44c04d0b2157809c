"""Usual mistakes in recording a motion: each is undone, and named if the motion then fits.

What is compared is the beginning, before errors of an integrator have grown.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np

from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario, Trajectory, error_series
from ....scenarios.mechanics import RECENT
from ....scenarios.rotation import matrices, turned_back
from ..measuring.changes import EULER_ANGLES
from .measured import started_elsewhere
from .motion import OmegaFrame, QuaternionOrder, RecordedMotion, recorded_motion
from .recording import Recording, RecordingError

#: rad that the exact motion turns in the beginning that is compared, and samples of it at least.
BEGINNING, FEWEST = 3.0, 3
#: Samples that must be left of what is read otherwise: steps are told from two.
FEWEST_LEFT = 2
#: A mistake explains the motion if undoing it makes the errors smaller by this factor.
EXPLAINS = 10.0
#: Errors below this, relative or in rad, need no explanation.
FITS = 1e-9
#: Relative or in rad; a first sample that is this far off is another start.
STARTS = 1e-3
#: Mistakes that are looked for in one file at the same time.
MOST = 2
EPS = float(np.finfo(float).eps)
#: Units that times may be in by mistake, as a column's heading names them, and their seconds.
UNITS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}


@dataclass(frozen=True, eq=False)
class Reading:
    """One way to read a recording.

    Attributes
    ----------
    unit : s, of the times
    late : by which the times are to be put back, in their unit
    """

    recording: Recording
    quaternion: QuaternionOrder
    omega: OmegaFrame
    unit: float = 1.0
    late: float = 0.0

    def with_arrays(self, **arrays: FloatArray) -> "Reading":
        """The same with other numbers."""
        changed = replace(self.recording, arrays=self.recording.arrays | arrays)
        return replace(self, recording=changed)


def mistakes(scenario: Scenario, exact: Trajectory, reading: Reading) -> list[str]:
    """The mistakes that explain why a recording is not the exact motion; often none.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """
    samples = _beginning(exact)
    beginning = exact.until(samples)
    reading = reading.with_arrays(**{k: v[:samples] for k, v in reading.recording.arrays.items()})
    readings: list[tuple[list[str], Reading]] = [([], reading)]
    best, least = [], _error(scenario, beginning, reading)
    for _ in range(MOST):
        if least <= FITS:
            break
        readings = [
            ([*words, word], other)
            for words, one in readings
            if len(one.recording.arrays["t"]) >= FEWEST_LEFT
            for word, other in _undone(one)
        ]
        errors = [_error(scenario, beginning, other) for _, other in readings]
        if min(errors) < least / EXPLAINS:
            best, least = readings[int(np.argmin(errors))][0], min(errors)
    return best


def starts_elsewhere(scenario: Scenario, exact: Trajectory, reading: Reading) -> list[str]:
    """The message that the first sample is not on the scene's motion; empty if it nearly is.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """
    first = reading.with_arrays(**{k: v[:1] for k, v in reading.recording.arrays.items()})
    if "omega" not in first.recording.arrays:
        return []
    recorded = _recorded(scenario, first, exact.until(1))
    off = error_series(scenario, recorded.trajectory, exact.until(1)).worst()
    speed = float(np.linalg.norm(exact.omega_body[0] - recorded.trajectory.omega_body[0]))
    if max(off["attitude"], off["omega"]) < STARTS:
        return []
    return [started_elsewhere(exact.t[0], (off["attitude"], speed))]


def _beginning(exact: Trajectory) -> int:
    rates = np.linalg.norm(exact.omega_body, axis=1)
    turned = np.cumsum(rates[1:] * np.diff(exact.t))
    # Each ω that goes with another attitude takes a sample away.
    return min(len(exact.t), max(FEWEST + MOST, int(np.searchsorted(turned, BEGINNING)) + 1))


def _error(scenario: Scenario, exact: Trajectory, reading: Reading) -> float:
    """The largest error in ω and attitude; infinite if it cannot be read this way."""
    exact = exact.at(np.flatnonzero(np.isin(exact.t, reading.recording.arrays["t"])))
    if np.count_nonzero(exact.t + reading.late >= 0) < FEWEST_LEFT:
        return np.inf
    if reading.late or reading.unit != 1.0:
        # A state before the start is none of the exact motion's.
        is_after = exact.t + reading.late >= 0
        times = exact.t[is_after] * reading.unit
        shifted = _exact(scenario, tuple(times + reading.late * reading.unit))
        if len(shifted.t) < len(times):
            return np.inf
        exact = replace(shifted, t=times)
        arrays = reading.recording.arrays
        kept = {name: rows[is_after] for name, rows in arrays.items()}
        reading = reading.with_arrays(**kept | {"t": times})
    try:
        recorded = _recorded(scenario, reading, exact)
    except RecordingError:
        return np.inf
    return early_error(scenario, recorded, exact)


@lru_cache(maxsize=RECENT)
def _exact(scenario: Scenario, times: tuple[float, ...]) -> Trajectory:
    return ExactMotion(scenario).solve(np.array(times)).trajectory


def _recorded(scenario: Scenario, reading: Reading, exact: Trajectory) -> RecordedMotion:
    return recorded_motion(scenario, reading.recording, exact, reading.quaternion, reading.omega)


def early_error(scenario: Scenario, recorded: RecordedMotion, exact: Trajectory) -> float:
    """The largest error in attitude and, where it was recorded, in ω."""
    series = error_series(scenario, recorded.trajectory, exact)
    return float(
        max(series["attitude"].max(), series["omega"].max() if recorded.has_omega else 0.0)
    )


def _undone(reading: Reading) -> Iterator[tuple[str, Reading]]:
    """Every mistake in words, and the reading without it."""
    arrays = reading.recording.arrays
    other_order: QuaternionOrder = "xyzw" if reading.quaternion == "wxyz" else "wxyz"
    order = " ".join(other_order)
    conjugated = arrays["q"] * np.where(_scalar(reading.quaternion), 1.0, -1.0)
    swapped = arrays["q"] * np.where(_scalar(other_order), 1.0, -1.0)
    yield (
        f"the quaternion's order is {order} (state 'quaternion = {other_order}')",
        replace(reading, quaternion=other_order),
    )
    yield (
        "the quaternion takes world to body components (it is conjugated)",
        reading.with_arrays(q=conjugated),
    )
    yield (
        f"the quaternion's order is {order}, and it takes world to body components",
        replace(reading.with_arrays(q=swapped), quaternion=other_order),
    )
    for name, unit in UNITS.items():
        yield f"the times are in {name}; t [{name}] says so", replace(reading, unit=unit)
    step = float(np.diff(arrays["t"]).min())
    for samples, words in ((1.0, "one sample"), (0.5, "half a sample")):
        yield (
            f"each state is that of {words} after its time",
            replace(reading, late=samples * step),
        )
        yield (
            f"each state is that of {words} before its time",
            replace(reading, late=-samples * step),
        )
    if "omega" in arrays:
        yield from _of_omega(reading, arrays["omega"])


def _of_omega(reading: Reading, omega: FloatArray) -> Iterator[tuple[str, Reading]]:
    other_frame: OmegaFrame = "world" if reading.omega == "body" else "body"
    yield (
        f"ω is in {other_frame} axes (state 'omega = {other_frame}')",
        replace(reading, omega=other_frame),
    )
    yield "ω has the opposite sign", reading.with_arrays(omega=-omega)
    for words, factor in (
        ("in degrees a second; wx [deg/s] says so", pi / 180),
        ("in rad/s already, and was converted from deg/s", 180 / pi),
        ("in turns a second", 2 * pi),
    ):
        yield f"ω is {words}", reading.with_arrays(omega=omega * factor)
    for i, j, k in EULER_ANGLES:
        yield (
            f"ω is the rates of Euler angles {'xyz'[i]}{'xyz'[j]}{'xyz'[k]}",
            reading.with_arrays(omega=_of_rates(reading, (i, j, k))),
        )
    # Undone by pairing each attitude with the ω that goes with it, of which one end has none.
    earlier, later = slice(None, -1), slice(1, None)
    for age, mine, other in (("older", earlier, later), ("newer", later, earlier)):
        kept = {name: rows[mine] for name, rows in reading.recording.arrays.items()}
        yield (
            f"ω is one sample {age} than the attitude",
            reading.with_arrays(**kept | {"omega": omega[other]}),
        )
        yield (
            f"ω is half a sample {age} than the attitude, as of semi-implicit Euler or leapfrog",
            reading.with_arrays(**kept | {"omega": (omega[mine] + omega[other]) / 2}),
        )


def _of_rates(reading: Reading, axes: tuple[int, int, int]) -> FloatArray:
    """ω along the axes of a reading from rates of angles a, b, c, R = R_i(a) R_j(b) R_k(c)."""
    i, j, k = axes
    q = np.roll(reading.recording.arrays["q"], reading.quaternion == "xyzw", axis=1)
    R_world_body = matrices(q / np.linalg.norm(q, axis=1)[:, None])
    rates = reading.recording.arrays["omega"]
    a, b, c = rates.T if i == k else rates.T[[i, j, k]]
    first = np.eye(3)[i]
    third = R_world_body[:, :, k]
    node = np.cross(third, first) if i != k and (i + 1) % 3 == j else np.cross(first, third)
    node /= np.maximum(np.linalg.norm(node, axis=1), EPS)[:, None]
    omega_world = np.outer(a, first) + b[:, None] * node + c[:, None] * third
    return omega_world if reading.omega == "world" else turned_back(R_world_body, omega_world)


def _scalar(order: QuaternionOrder) -> list[bool]:
    return [letter == "w" for letter in order]
