"""Finds mistakes from the digits of recorded numbers: repeats, coarse rounding and zeros.

Rows and columns that are the same to the last digit are found without physics. The exact motion
only tells whether they should have changed, by far more than the numbers are rounded. They stay the
same, for instance, if the body is at rest, or turns about a principal axis.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .....scenarios import FloatArray, Trajectory
from .....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ...explaining.search import LEFT
from ..files.motion import Reading
from ..files.recording import FEWEST_VALUES, RATES, Recording, digits_of, unit_of

#: Numbers that stay the same are a finding only if they should have changed by more than this
#: many units of their last digit.
CHANGES = 10.0
#: Least number of different values by which coarse rounding is recognised.
FEWEST = 3
#: Numbers are coarse if the largest is less than this multiple of the unit that they are rounded
#: to. Eight bits hold such numbers with their signs; printed, they have less than three digits.
COARSE = 128
#: Standard deviation of the error of rounding to integers.
ROUNDING_ERROR = 1 / np.sqrt(12)
#: The most numbers of a column whose digits are counted, spread over all.
MOST_COUNTED = 1000
#: Coarse rounding of the three smaller components of quaternions: decimals to which components are
#: compared, least unit that is recognised, and tolerance of multiples of that unit.
DIGITS, FINEST, NEAR = 6, 1e-4, 0.1
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Numbers:
    """The columns of a recording, with numbers as in its file, and those of the exact motion.

    Attributes
    ----------
    t : times of the samples, s, (n,)
    q : recorded quaternions, with components in the order of the file, (n, 4)
    omega : recorded ω, along the axes that the file states, rad/s, (n, 3); None if ω was not
        recorded
    q_exact : exact attitudes, scalar first, (n, 4)
    omega_exact : exact ω, along the axes that the file states, rad/s, (n, 3)
    rates : mean ω from each sample to the next, computed from the recorded attitudes, along the
        same axes, rad/s, (n - 1, 3)
    """

    t: FloatArray
    q: FloatArray
    omega: FloatArray | None
    q_exact: FloatArray
    omega_exact: FloatArray
    rates: FloatArray

    @cached_property
    def spans(self) -> FloatArray:
        """The time from each of n samples to the next, s, (n - 1,)."""
        return np.diff(self.t)

    @cached_property
    def resolution_q(self) -> float:
        """The resolution with which the components of quaternions are printed (`resolution`)."""
        return resolution(self.q, (1.0,))

    @cached_property
    def resolution_omega(self) -> float:
        """The resolution with which ω is printed, rad/s (`resolution`); 0 if ω was not recorded."""
        return 0.0 if self.omega is None else resolution(self.omega, RATES.values())

    @cached_property
    def step_omega(self) -> float:
        """The resolution of ω, rad/s, or the step of a sensor that counts, if that is larger.

        A column is left out if the exact ω has such a step, too, as one that grows linearly has.
        """
        printed = self.resolution_omega
        if self.omega is None:
            return printed
        columns = zip(self.omega.T, self.omega_exact.T, strict=True)
        steps = (_step_of(one, printed) for one, exact in columns if not _step_of(exact, printed))
        return max([printed, *steps])

    @cached_property
    def should_turn(self) -> Flags:
        """Whether the exact motion turns from each of n samples to the next, (n - 1,).

        Turns count if they change quaternions by far more than a unit of the last recorded digit.
        """
        least = 2 * CHANGES * self.resolution_q
        return norms(rotation_vectors(self.q_exact[:-1], self.q_exact[1:])) > least

    @cached_property
    def turns(self) -> Flags:
        """Whether the body turns from each of n samples to the next, (n - 1,).

        It does if the exact motion turns, and if the ω of the earlier sample is large enough: the
        recorded ω, or the exact one if none was recorded.
        """
        least = 2 * CHANGES * self.resolution_q
        speeds = norms(self.omega_exact if self.omega is None else self.omega)[:-1]
        return self.should_turn & (speeds * self.spans > least)

    @cached_property
    def same_q(self) -> Flags:
        """Whether attitude repeats that of the sample before, to the last digit, (n - 1,).

        There is an entry for each of the n samples but the first.
        """
        return np.asarray((self.q[1:] == self.q[:-1]).all(axis=1))

    @cached_property
    def same_omega(self) -> Flags:
        """Whether ω repeats that of the sample before, to the last digit, (n - 1,).

        There is an entry for each of the n samples but the first. All are true if ω was not
        recorded.
        """
        if self.omega is None:
            return np.ones(len(self.spans), dtype=bool)
        return np.asarray((self.omega[1:] == self.omega[:-1]).all(axis=1))


@dataclass(frozen=True)
class Shown:
    """A finding from the numbers of a recording.

    Attributes
    ----------
    words : a sentence on the finding
    wrong : indices of the wrong samples, (k,); the motion of the others may be explained by physics
    rounding : standard deviations of the errors of attitude, rad, and ω, rad/s, by coarse rounding;
        0 if numbers are not rounded coarsely
    mended : the reading with the mistake corrected in all samples; None if it cannot be corrected
    """

    words: str
    wrong: NDArray[np.intp]
    rounding: tuple[float, float] = (0.0, 0.0)
    mended: Reading | None = None


def numbers_of(recording: Recording, reading: Reading, exact: Trajectory) -> Numbers:
    """Return the columns of a recording, with those of the exact motion.

    Parameters
    ----------
    recording : the recording, from which quaternions are taken as they are in the file
    reading : the same samples, as they are read
    exact : the exact motion at the times of the reading
    """
    rates = rotation_vectors(reading.q[:-1], reading.q[1:]) / np.diff(reading.t)[:, None]
    omega_exact = exact.omega_body
    if reading.frame == "world":
        omega_exact = turned(matrices(exact.q_world_body_wxyz), omega_exact)
        rates = turned(matrices(reading.q[:-1]), rates)
    q = recording.arrays["q"]
    return Numbers(reading.t, q, reading.omega, exact.q_world_body_wxyz, omega_exact, rates)


def resolution(numbers: FloatArray, units: Iterable[float]) -> float:
    """Return the resolution of printed numbers, in the unit of `numbers`.

    With d significant digits it is the largest number times 10^(1 − d), which is one to ten units
    of the last digit of that number. It is at least the largest number times the machine epsilon,
    which is that of single precision if single precision holds all numbers.

    Parameters
    ----------
    numbers : numbers of one quantity, of any shape
    units : the units in which the numbers may have been printed, in the unit of `numbers`. The one
        in which the numbers have the fewest digits is taken
    """
    flat = numbers.ravel()
    counted = flat[:: max(1, len(flat) // MOST_COUNTED)]
    digits = min(max(digits_of(float(f"{x / unit:.15g}")) for x in counted) for unit in units)
    is_single = np.array_equal(flat, flat.astype(np.float32))
    eps = float(np.finfo(np.float32 if is_single else float).eps)
    return float(np.abs(flat).max()) * max(eps, 10.0 ** (1 - digits))


def shown_by_digits(numbers: Numbers) -> list[Shown]:
    """Return findings of repeated numbers, coarse rounding, and zero ω in a recording's columns."""
    found = [_still(numbers) or _stale(numbers), _rounded_attitude(numbers)]
    if numbers.omega is not None:
        found += [_zeros(numbers, numbers.omega), _rounded_omega(numbers, numbers.omega)]
    return [one for one in found if one]


def where(t: FloatArray, samples: NDArray[np.int_]) -> str:
    """Return the number of some samples, and the times of the first and the last one, in words.

    Parameters
    ----------
    t : times of all n samples, s, (n,)
    samples : indices of the k samples that are counted, increasing, (k,)
    """
    first, last = t[samples[[0, -1]]]
    if len(samples) == 1:
        return f"at 1 sample, at t = {first:.6g} s"
    return f"at {len(samples)} samples, the first at t = {first:.6g} s, the last at {last:.6g} s"


def runs(flags: Flags) -> list[tuple[int, int]]:
    """Return the first and the last sample of each run of samples that are flagged as alike.

    A flag says that a sample is like the one before it, so that a run begins one sample before its
    first flag.

    Parameters
    ----------
    flags : flags of all n samples but the first, (n - 1,)

    Returns
    -------
    For each run the indices of its first and its last sample
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags, [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _still(numbers: Numbers) -> Shown | None:
    """Return the finding that recorded rows repeat those before, or that a body is put to sleep.

    A body is asleep if an engine holds it in place because it moves slowly.

    Returns
    -------
    None if neither is so
    """
    t, count = numbers.t, len(numbers.t)
    same = numbers.same_q & numbers.same_omega
    omega = numbers.omega
    for first, last in runs(same & numbers.should_turn):
        if omega is None or omega[first].any() or last < count - 1 or not first:
            continue
        # If ω was almost zero just before, the body came to rest and was not put to sleep.
        if norms(omega[[first - 1]])[0] > CHANGES * numbers.resolution_omega:
            return Shown(
                f"from t = {t[first]:.6g} s on, for {last + 1 - first} samples, it is asleep: ω is "
                "exactly 0, and the attitude stays the same to the last digit",
                np.arange(first, count),
            )
    found = runs(same & numbers.turns)
    # Two cases are left to other checks: a first state that is written twice, which shifts all
    # later times; and a file with the same state throughout.
    found = [(a, b) for a, b in found if a or 1 < b < count - 1]
    if not found:
        return None
    if len(found) == 1:
        return _one_run(numbers, *found[0])
    again = np.concatenate([np.arange(a + 1, b + 1) for a, b in found])
    return Shown(
        f"rows are those before them again, to the last digit, {where(t, again)}: leave them out",
        again,
    )


def _one_run(numbers: Numbers, a: int, b: int) -> Shown:
    """Return the finding that the samples with indices `a` to `b` of a recording are the same.

    It says whether the states of the samples after `b` are late, as if the motion had paused.
    """
    t, q = numbers.t, numbers.q / norms(numbers.q)[:, None]
    samples = "1 sample" if b == a + 1 else f"{b - a} samples"
    if b == len(t) - 1:
        return Shown(
            f"from t = {t[a]:.6g} s on it stands still, to the last digit, for {samples}",
            np.arange(a + 1, len(t)),
        )
    turn = float(2 * np.arccos(min(1.0, abs(float(q[a] @ q[b + 1])))))
    speeds = norms(numbers.omega_exact if numbers.omega is None else numbers.omega)
    if_paused, if_running = speeds[b + 1] * (t[b + 1] - t[b]), speeds[b + 1] * (t[b + 1] - t[a])
    is_late, after = abs(turn - if_paused) < abs(turn - if_running), np.arange(a + 1, len(t))
    if b == a + 1:
        late = f", and what follows is {t[b] - t[a]:.6g} s late" if is_late else ""
        how = "a row is repeated" if is_late else "leave it out"
        return Shown(
            f"the row at t = {t[b]:.6g} s is the one before it again, to the last digit{late}: "
            f"{how}",
            after if is_late else np.array([b]),
        )
    how = (
        f", and goes on from there, {t[b] - t[a]:.6g} s late, as a simulation that is paused while "
        "the clock runs"
        if is_late
        else ": leave these out"
    )
    return Shown(
        f"it stands still, to the last digit, for {samples}, from t = {t[a]:.6g} s to "
        f"{t[b]:.6g} s{how}",
        after if is_late else np.arange(a + 1, b + 1),
    )


def _stale(numbers: Numbers) -> Shown | None:
    """Return the finding that recorded attitudes repeat those before them, though ω changes.

    None is returned if none do.
    """
    if numbers.omega is None:
        return None
    flags = numbers.same_q & ~numbers.same_omega & numbers.turns
    found = [(a, b) for a, b in runs(flags) if a or b > 1]
    # A single run of equal attitudes at one end fills up columns that were shifted in time.
    is_end = len(found) == 1 and (not found[0][0] or found[0][1] == len(numbers.t) - 1)
    if not found or is_end:
        return None
    repeated = np.concatenate([np.arange(a + 1, b + 1) for a, b in found])
    new = np.flatnonzero(~flags) + 1
    lengths = np.unique(np.diff(new))
    if len(lengths) == 1 and lengths[0] > 1:
        words = (
            f"the attitude is held: it is new at one sample in {lengths[0]} only; record those "
            "alone"
        )
        is_new = np.arange(len(numbers.t)) % lengths[0] == new[0] % lengths[0]
        return Shown(words, np.flatnonzero(~is_new))
    which = where(numbers.t, repeated)
    words = f"the attitude is that of the sample before, to the last digit, {which}"
    return Shown(words, repeated)


def _zeros(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that ω is exactly zero at some samples, though the body turns.

    The body turns if both the recorded attitude and the exact motion do.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)

    Returns
    -------
    None if there is no such sample, or if ω is zero at all samples
    """
    is_zero = ~omega.any(axis=1)
    turned_since = ~numbers.same_q & numbers.should_turn
    around = np.concatenate([[False], turned_since]) & np.concatenate([turned_since, [True]])
    should = norms(numbers.omega_exact) > CHANGES * numbers.resolution_omega
    zeros = np.flatnonzero(is_zero & around & should)
    if is_zero.all() or not len(zeros):
        return None
    words = f"ω is exactly 0, though the attitude goes on turning, {where(numbers.t, zeros)}"
    return Shown(f"{words}: leave {'it' if len(zeros) == 1 else 'them'} out", zeros)


def _rounded_attitude(numbers: Numbers) -> Shown | None:
    """Return the finding that recorded quaternions are rounded coarsely; None if they are not.

    They are if all components, or the three smaller ones, are multiples of a coarse unit.
    """
    unit, values = unit_of(numbers.q), len(np.unique(numbers.q))
    which = "the quaternions"
    if not unit:
        unit, which = _unit_of_three(numbers.q), "the three smaller components of quaternions"
    elif values < FEWEST or unit * COARSE < 1.0:
        return None
    if not unit:
        return None
    # The quaternions of a body that hardly turns have few different values.
    turns = rotation_vectors(np.broadcast_to(numbers.q_exact[0], numbers.q.shape), numbers.q_exact)
    if norms(turns).max() < CHANGES * unit:
        return None
    rounding = 2 * ROUNDING_ERROR * unit
    words = f"{which} are rounded to {unit:.4g}, which makes attitudes off by {rounding:.2g} rad"
    return Shown(words, np.arange(0), (rounding, 0.0))


def _unit_of_three(q: FloatArray) -> float:
    """Return the unit to which the three smaller components of n quaternions, (n, 4), are rounded.

    It is 0 if there is no such unit. Compressed quaternions store only these three, in few bits
    each, as the largest follows from them. The differences of the components are multiples of the
    unit.
    """
    largest = np.abs(q).argmax(axis=1)
    others = np.abs(q[np.arange(4) != largest[:, None]]).round(DIGITS)
    return _step_of(others, FINEST)


def _step_of(numbers: FloatArray, finest: float) -> float:
    """Return the step of which all differences of numbers are multiples; 0 if there is none.

    Parameters
    ----------
    numbers : of any shape
    finest : the least step that is recognised
    """
    distances = np.diff(np.unique(numbers))
    if len(distances) < FEWEST_VALUES or distances.min() < finest:
        return 0.0
    multiples = distances / distances.min()
    return float(distances.min()) if np.abs(multiples - np.rint(multiples)).max() < NEAR else 0.0


def _rounded_omega(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that ω is rounded to less than three digits; None if it is not.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)
    """
    found = {}
    for name, factor in RATES.items():
        unit = unit_of(omega / factor)
        largest = float(np.abs(omega).max()) / factor
        if not unit or largest >= COARSE * unit or numbers.resolution_q >= LEFT * unit / largest:
            continue
        # An ω that is nearly constant is a multiple of its own size, and not rounded.
        multiples = np.rint(omega / factor / unit)
        if max(len(np.unique(column)) for column in multiples.T) >= FEWEST:
            found[name] = unit
    if not found:
        return None
    # Multiples of a round number in one unit are multiples of a less round number in another.
    name = min(found, key=lambda name: digits_of(found[name]))
    unit = found[name]
    rounding = 0.0, ROUNDING_ERROR * unit * RATES[name]
    return Shown(f"ω is rounded to {unit:.6g} {name}", np.arange(0), rounding)
