"""What the numbers of a recorded motion show by themselves, as they were recorded.

Of rows and columns that are the same to the last digit it takes no physics to say so. The exact
motion only tells whether they should have changed, by far more than the numbers are rounded: a body
at rest, and the ω of a body about a principal axis, stay the same.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray, Trajectory
from ....scenarios.rotation import matrices, norms, rotation_vectors, turned
from ..explaining.search import LEFT
from .motion import Reading
from .recording import FEWEST_VALUES, RATES, Recording, digits_of, unit_of

#: By how many units of their last digit numbers should have changed where they are the same.
CHANGES = 10.0
#: Least number of values that a column of rounded numbers has.
FEWEST = 3
#: Numbers that are multiples of a unit are coarse if the largest is fewer units than this, as eight
#: bits hold: fewer than the three digits of any print.
COARSE = 128
#: Standard deviation of what rounding to a multiple of one makes.
ROUNDED = 1 / np.sqrt(12)
#: Most numbers of which digits are counted, spread over all.
COUNTED = 1000
#: Digits that three components are compared by, the least unit that they are rounded to, and the
#: error of multiples of it.
DIGITS, FINEST, NEAR = 6, 1e-4, 0.1
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Numbers:
    """The columns of a recording, and of the exact motion, as they were recorded.

    Attributes
    ----------
    t : s, (n,)
    q, omega : as in the file, (n, 4) and, rad/s, (n, 3); `omega` is None if it was not recorded
    q_exact, omega_exact : the exact motion, scalar first, and ω in the axes that the file states
    rates : mean ω from each sample to the next by the attitudes, in those axes, rad/s, (n - 1, 3)
    """

    t: FloatArray
    q: FloatArray
    omega: FloatArray | None
    q_exact: FloatArray
    omega_exact: FloatArray
    rates: FloatArray

    @cached_property
    def spans(self) -> FloatArray:
        """Distances of the samples, s, (n - 1,)."""
        return np.diff(self.t)

    @cached_property
    def resolution_q(self) -> float:
        """The unit of the last digit of the quaternion's largest component."""
        return resolution(self.q, (1.0,))

    @cached_property
    def resolution_omega(self) -> float:
        """The unit of the last digit of the largest component of ω, rad/s."""
        return 0.0 if self.omega is None else resolution(self.omega, RATES.values())

    @cached_property
    def should_turn(self) -> Flags:
        """Whether the body turns from each sample to the next, by far more than digits, (n - 1,).

        It does in the exact motion.
        """
        least = 2 * CHANGES * self.resolution_q
        return norms(rotation_vectors(self.q_exact[:-1], self.q_exact[1:])) > least

    @cached_property
    def turns(self) -> Flags:
        """Whether it should turn, and does by the ω of the earlier sample, (n - 1,)."""
        least = 2 * CHANGES * self.resolution_q
        speeds = norms(self.omega_exact if self.omega is None else self.omega)[:-1]
        return self.should_turn & (speeds * self.spans > least)

    @cached_property
    def same_q(self) -> Flags:
        """Whether the attitude is that of the sample before, to the last digit, (n - 1,)."""
        return np.asarray((self.q[1:] == self.q[:-1]).all(axis=1))

    @cached_property
    def same_omega(self) -> Flags:
        """Whether ω is that of the sample before, to the last digit, (n - 1,)."""
        if self.omega is None:
            return np.ones(len(self.spans), dtype=bool)
        return np.asarray((self.omega[1:] == self.omega[:-1]).all(axis=1))


@dataclass(frozen=True)
class Shown:
    """What the numbers show.

    Attributes
    ----------
    words : a sentence
    wrong : indices of the samples that it is about; the others may be explained, (k,)
    rounding : standard deviations of attitude, rad, and ω, rad/s, if the numbers are rounded
        coarsely
    mended : all samples without what is wrong, if they can be mended
    """

    words: str
    wrong: NDArray[np.intp]
    rounding: tuple[float, float] = (0.0, 0.0)
    mended: Reading | None = None


def numbers_of(recording: Recording, reading: Reading, exact: Trajectory) -> Numbers:
    """Return the columns of a recording beside those of the exact motion.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """
    rates = rotation_vectors(reading.q[:-1], reading.q[1:]) / np.diff(reading.t)[:, None]
    omega_exact = exact.omega_body
    if reading.frame == "world":
        omega_exact = turned(matrices(exact.q_world_body_wxyz), omega_exact)
        rates = turned(matrices(reading.q[:-1]), rates)
    q = recording.arrays["q"]
    return Numbers(reading.t, q, reading.omega, exact.q_world_body_wxyz, omega_exact, rates)


def resolution(numbers: FloatArray, units: Iterable[float]) -> float:
    """Return the unit of the last digit of the largest number, as the numbers were printed.

    Parameters
    ----------
    units : factors of the units that they may have been printed in
    """
    flat = numbers.ravel()
    counted = flat[:: max(1, len(flat) // COUNTED)]
    digits = min(max(digits_of(float(f"{x / unit:.15g}")) for x in counted) for unit in units)
    is_single = np.array_equal(flat, flat.astype(np.float32))
    eps = float(np.finfo(np.float32 if is_single else float).eps)
    return float(np.abs(flat).max()) * max(eps, 10.0 ** (1 - digits))


def shown_by_digits(numbers: Numbers) -> list[Shown]:
    """Return all that is certain by digits alone."""
    found = [_still(numbers) or _stale(numbers), _rounded_attitude(numbers)]
    if numbers.omega is not None:
        found += [_zeros(numbers, numbers.omega), _rounded(numbers, numbers.omega)]
    return [one for one in found if one]


def where(t: FloatArray, samples: NDArray[np.int_]) -> str:
    """Return how many samples there are, and the first and last of their times, in words."""
    first, last = t[samples[[0, -1]]]
    if len(samples) == 1:
        return f"at 1 sample, at t = {first:.6g} s"
    return f"at {len(samples)} samples, the first at t = {first:.6g} s, the last at {last:.6g} s"


def runs(flags: Flags) -> list[tuple[int, int]]:
    """Return the first and last sample of each run whose samples are all flagged as the one before.

    Parameters
    ----------
    flags : of each sample but the first, (n - 1,)
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags, [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _still(numbers: Numbers) -> Shown | None:
    """Say where rows are those before, to the last digit, or that the body falls asleep."""
    t, count = numbers.t, len(numbers.t)
    same = numbers.same_q & numbers.same_omega
    omega = numbers.omega
    for first, last in runs(same & numbers.should_turn):
        if omega is None or omega[first].any() or last < count - 1 or not first:
            continue
        # What slows down to zero is no sleep.
        if norms(omega[[first - 1]])[0] > CHANGES * numbers.resolution_omega:
            return Shown(
                f"from t = {t[first]:.6g} s on, for {last + 1 - first} samples, it is asleep: ω is "
                "exactly 0, and the attitude stays the same to the last digit",
                np.arange(first, count),
            )
    found = runs(same & numbers.turns)
    # A first state that is written twice is of times that count on; of a whole file it is a start.
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
    """Say that samples a to b are the same."""
    t, q = numbers.t, numbers.q / norms(numbers.q)[:, None]
    samples = "1 sample" if b == a + 1 else f"{b - a} samples"
    if b == len(t) - 1:
        return Shown(
            f"from t = {t[a]:.6g} s on it stands still, to the last digit, for {samples}",
            np.arange(a + 1, len(t)),
        )
    turn = float(2 * np.arccos(min(1.0, abs(float(q[a] @ q[b + 1])))))
    speeds = norms(numbers.omega_exact if numbers.omega is None else numbers.omega)
    goes_on, counts_on = speeds[b + 1] * (t[b + 1] - t[b]), speeds[b + 1] * (t[b + 1] - t[a])
    is_late, after = abs(turn - goes_on) < abs(turn - counts_on), np.arange(a + 1, len(t))
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
    """Say where the attitude alone is that of the sample before, though ω goes on."""
    if numbers.omega is None:
        return None
    flags = numbers.same_q & ~numbers.same_omega & numbers.turns
    found = [(a, b) for a, b in runs(flags) if a or b > 1]
    # Where it is some samples older or newer than ω, one end is filled up.
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
    """Say where ω is exactly zero, though the attitude turns and the body does."""
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
    """Say that quaternions are multiples of a unit so coarse that eight bits hold them."""
    unit, values = unit_of(numbers.q), len(np.unique(numbers.q))
    which = "the quaternions"
    if not unit:
        unit, which = _unit_of_three(numbers.q), "the three smaller components of quaternions"
    elif values < FEWEST or unit * COARSE < 1.0:
        return None
    if not unit:
        return None
    # A body that hardly turns has few values.
    turns = rotation_vectors(np.broadcast_to(numbers.q_exact[0], numbers.q.shape), numbers.q_exact)
    if norms(turns).max() < CHANGES * unit:
        return None
    rounding = 2 * ROUNDED * unit
    words = f"{which} are rounded to {unit:.4g}, which makes attitudes off by {rounding:.2g} rad"
    return Shown(words, np.arange(0), (rounding, 0.0))


def _unit_of_three(q: FloatArray) -> float:
    """Return the unit by multiples of which the three smaller components differ; 0 if none.

    The largest one follows from them, as of the smallest three in so many bits each.
    """
    largest = np.abs(q).argmax(axis=1)
    others = np.abs(q[np.arange(4) != largest[:, None]]).round(DIGITS)
    distances = np.diff(np.unique(others))
    if len(distances) < FEWEST_VALUES or distances.min() < FINEST:
        return 0.0
    multiples = distances / distances.min()
    return float(distances.min()) if np.abs(multiples - np.rint(multiples)).max() < NEAR else 0.0


def _rounded(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Say that ω is multiples of a unit so coarse that it has less than three digits."""
    # An ω that nothing changes but rounding is as round as it started.
    if max(len(np.unique(np.round(column, 9))) for column in omega.T) < FEWEST:
        return None
    found = {}
    for name, factor in RATES.items():
        unit = unit_of(omega / factor)
        largest = float(np.abs(omega).max()) / factor
        if unit and largest < COARSE * unit and numbers.resolution_q < LEFT * unit / largest:
            found[name] = unit
    if not found:
        return None
    # Multiples of one unit are multiples of a less round number of another.
    name = min(found, key=lambda name: digits_of(found[name]))
    unit = found[name]
    rounding = 0.0, ROUNDED * unit * RATES[name]
    return Shown(f"ω is rounded to {unit:.6g} {name}", np.arange(0), rounding)
