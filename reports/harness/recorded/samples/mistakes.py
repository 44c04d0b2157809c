"""Finds common mistakes in recording, such as a wrong unit, order of components or frame.

Each mistake is corrected on trial. It is named if the corrected motion then agrees with the exact
one far better. Only the beginning of a motion is compared, before an integrator's errors grow.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, combinations
from math import pi

import numpy as np
from scipy.optimize import minimize_scalar

from .....reference.deviations import apart
from .....reference.following import follow
from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.fastest_rate import decay_rate
from .....scenarios.rotation import conjugate, matrices, norms, rotation_vectors
from ...explaining.changes import EULER_ANGLES, OTHER_COMPONENTS
from ...explaining.search import LEFT, PROMISING
from ..files.motion import OmegaFrame, QuaternionOrder, Reading
from .intervals import NEAR, states_of
from .other_readings import equal_times, other_readings

#: The exact motion turns by these angles, rad, over the two beginnings that are compared. A motion
#: by other equations is closer to the exact one over the shorter one. The least number of samples
#: in a beginning.
BEGINNINGS, FEWEST = (3.0, 0.75), 3
#: Least number of samples of a corrected reading. The most samples that all corrections together
#: may leave out: if it were two, an ω that is smoothed over three samples would count as two
#: mistakes, half a sample older and half a sample newer than the attitude.
FEWEST_LEFT, LEFT_OUT = 2, 1
#: Largest turn of the body, rad, up to the last time of a reading. If its times are so wrong that
#: the body turns further, the exact motion is not computed.
FURTHEST = 3e3
#: Errors below this, relative or in rad, need no explanation.
FITS = 1e-9
#: Evenly spaced times count as those of samples whose times are rounded if they are exp(`LIKELIER`)
#: times as likely, and make the deviations smaller by the factor exp(−`EVENER`) at least.
LIKELIER, EVENER = 30.0, 0.1
#: That is asked only if the body turns by this many units of the last digit of quaternions in the
#: time by which times are rounded.
OF_DIGITS = 100.0
#: Words for times that are too short, or too long, by a factor.
TOO_SHORT = "too short, as where one state in so many is kept"
TOO_LONG = "too long, as of another timestep than that of the steps"
EPS = float(np.finfo(float).eps)
#: A correction: sentences on mistakes, and the reading corrected for them.
_Correction = tuple[list[str], Reading]
#: Units that times may be in by mistake, as a column's heading names them, and their lengths, s.
UNITS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
#: Words that follow "ω is", for mistakes by a factor, and the factor that corrects each of them.
RATES = {
    "in degrees a second; wx [deg/s] says so": pi / 180,
    "in rad/s already, and was converted from deg/s": 180 / pi,
    "in turns a second": 2 * pi,
    "in rpm; wx [rpm] says so": pi / 30,
    "half of what it should be": 2.0,
    "twice what it should be": 0.5,
}
#: Mistakes in the order and the signs of the columns of ω: a sentence, and the columns and signs
#: that correct the mistake.
COLUMNS_OF_OMEGA = [
    (
        "ω is [{}] of its columns".format(
            ", ".join(f"{'-' * (one < 0)}w{' xyz'[abs(one)]}" for one in components)
        ),
        np.abs(components) - 1,
        np.sign(components),
    )
    for components in OTHER_COMPONENTS
]
#: Reflections that make right-handed axes, of world and body, left-handed, by words on them.
LEFT_HANDED = {
    **{f"with {axis} reversed": np.diag(1.0 - 2.0 * np.eye(3)[k]) for k, axis in enumerate("xyz")},
    **{
        f"with {axes[0]} and {axes[1]} exchanged": np.eye(3)[order]
        for axes, order in (("xy", [1, 0, 2]), ("yz", [0, 2, 1]), ("xz", [2, 1, 0]))
    },
}


def mistakes(scenario: Scenario, exact: Trajectory, reading: Reading) -> list[str]:
    """Return sentences on the mistakes that explain why a recording is not the exact motion.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    reading : the samples of the recording as they were read

    Returns
    -------
    Sentences on one or two mistakes; often none
    """
    words = _of_beginning(scenario, exact, reading)
    states = states_of(exact)
    for k, word in enumerate(words):
        if word in (words_of_columns for words_of_columns, *_ in COLUMNS_OF_OMEGA):
            undone = without(words[:k], reading, scenario, states)
            words[k] = _columns_of_omega(undone, word) if undone else word
    return words


def _columns_of_omega(reading: Reading, found: str) -> str:
    """Return the sentence on the order and signs of ω's columns that suit all samples best.

    In its beginning a motion may have an ω of nearly one direction, which shows the others badly.

    Parameters
    ----------
    reading : all samples of the recording, with attitudes that are right
    found : the sentence that suits the beginning. It is returned unless with another order the
        deviation of ω from the rates of the attitudes is smaller by more than the fraction `LEFT`,
        and less than `PROMISING`
    """
    omega = np.asarray(reading.omega)
    # Between samples that are far apart the body may turn otherwise than the shortest way.
    if (norms(omega[:-1]) * np.diff(reading.t)).max() > NEAR:
        return found
    readings = {
        words: reading._replace(omega=omega[:, columns] * signs)
        for words, columns, signs in COLUMNS_OF_OMEGA
    }
    best = min(readings, key=lambda words: _kinematic_error(readings[words]))
    error, of_found = (_kinematic_error(readings[words]) for words in (best, found))
    return best if error < min(PROMISING, (1 - LEFT) * of_found) else found


def _of_beginning(scenario: Scenario, exact: Trajectory, reading: Reading) -> list[str]:
    """Return sentences on one or two mistakes that the beginning of a recording shows; often none.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    reading : the samples of the recording as they were read
    """
    beginning = _Beginning(scenario, exact)
    given, shorter = (reading.rows(slice(_samples_until(exact, turn))) for turn in BEGINNINGS)

    def corrected(
        words: list[str], one: Reading, original: Reading = given
    ) -> Iterator[_Correction]:
        fewest = max(FEWEST_LEFT, len(original.t) - LEFT_OUT)
        if len(one.t) >= fewest:
            # A correction of ω does not make up for wrong attitudes. Of two mistakes, that of the
            # attitude is corrected first.
            is_right = beginning.error_of_attitude(one) < LEFT
            for word, other in _corrections(one, scenario, is_right=is_right):
                if len(other.t) >= fewest:
                    yield [*words, word], other

    best = beginning.better(corrected([], given), ([], given))
    if not best[0]:
        rare = other_readings(given, scenario, states_of(exact))
        best = beginning.better((([word], one) for word, one in rare if len(one.t) >= FEWEST), best)
    if not best[0]:
        # Mistakes of ω cannot be told apart by few samples. Only mistakes of times and attitude are
        # tried with the shorter beginning.
        every = corrected([], shorter, shorter)
        of_attitudes = ((words, one) for words, one in every if one.omega is shorter.omega)
        if words := beginning.better(of_attitudes, ([], shorter))[0]:
            return words
    if best[0]:
        return beginning.better(corrected(*best), best)[0]
    if beginning.error(given) > LEFT:
        pairs = (two for one in corrected([], given) for two in corrected(*one))
        # With two factors of spins almost any spins would agree.
        pairs = (two for two in pairs if sum("spins are" in words for words in two[0]) < 2)
        best = beginning.better(pairs, best)
    return best[0] or beginning.other_times(given)


def without(
    words: Sequence[str], reading: Reading, scenario: Scenario, exact: FloatArray
) -> Reading | None:
    """Return a whole recording corrected for mistakes; None if one of them cannot be corrected.

    Parameters
    ----------
    words : the sentences on the mistakes, as `mistakes` or `rounded_times` returned them
    reading : the samples of the recording as they were read
    exact : the exact states at the n samples: q, scalar first, and ω, rad/s, body axes, (n, 7)
    """
    for one in words:
        every = chain(_corrections(reading, scenario), other_readings(reading, scenario, exact))
        corrected = next((other for word, other in every if word == one), None)
        if corrected is None:
            return None
        reading = corrected
    return reading


def followed(reading: Reading, scenario: Scenario) -> list[_Correction]:
    """Return corrections of one mistake each, after which the attitude turns at the recorded ω.

    No equations of motion are used. Whatever torques act, the attitude turns between two samples at
    the mean of their ω, except for terms of third order in the time between them.

    Parameters
    ----------
    reading : the samples of the recording as they were read

    Returns
    -------
    For each correction a list of the sentence on the mistake, and the corrected samples; the
    correction after which ω deviates least comes first
    """
    baseline = _kinematic_error(reading)
    found = [
        (_kinematic_error(other), [words], other)
        for words, other in _corrections(reading, scenario)
    ]
    kept = [one for one in found if one[0] < LEFT * min(1.0, baseline)]
    return [one[1:] for one in sorted(kept, key=lambda one: one[0])]


def rounded_times(reading: Reading, resolution: float) -> list[str]:
    """Return the sentence that the times of a recording are rounded.

    They are if evenly spaced times are found, at which the attitude follows ω far better; or better
    to such a degree that, with normally distributed deviations, these times are exp(`LIKELIER`)
    times as likely, if times are far more coarsely rounded than quaternions.

    Parameters
    ----------
    resolution : the relative resolution with which attitude and ω are printed

    Returns
    -------
    A list of one sentence; empty if the times are not rounded
    """
    error, freedom = _kinematic_error(reading), 3 * (len(reading.t) - 1)
    clearly = LEFT * min(1.0, error)
    likelier = error * np.exp(-max(LIKELIER / freedom, EVENER))
    speed = float(np.median(norms(reading.omega))) if reading.omega is not None else 0.0
    printed = OF_DIGITS * resolution
    for words, other in equal_times(reading):
        is_coarse = speed * np.abs(other.t - reading.t).max() > printed
        if _kinematic_error(other) < (max(clearly, likelier) if is_coarse else clearly):
            return [words]
    return []


def _kinematic_error(reading: Reading) -> float:
    """Return the deviation of ω from the rate at which the attitude turns, relative to that rate.

    Deviation and rate are root mean squares over all samples. The result is infinite if ω was not
    recorded, if there are too few samples, or if the attitude is constant.
    """
    if (omega := reading.omega_body) is None or len(omega) < FEWEST:
        return np.inf
    rates = rotation_vectors(reading.q[:-1], reading.q[1:]) / np.diff(reading.t)[:, None]
    deviations = rates - (omega[1:] + omega[:-1]) / 2
    size = np.sqrt(np.mean(rates**2))
    return float(np.sqrt(np.mean(deviations**2)) / size) if size else np.inf


class _Beginning:
    """The errors of the first samples of a motion, read in several ways, against the exact motion.

    The exact motion is computed at the times of each reading, from the exact first state.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """

    def __init__(self, scenario: Scenario, exact: Trajectory) -> None:
        self.scenario, self.begins_at = scenario, float(exact.t[0])
        self.start = states_of(exact.until(1))
        self.fastest = float(norms(exact.omega_body).max())
        self._at: dict[bytes, tuple[FloatArray, float, float]] = {}
        self._attitude_errors: dict[tuple[bytes, bytes], float] = {}

    def at(self, t: FloatArray) -> tuple[FloatArray, float, float]:
        """Return the exact motion at n times t, s, (n,), with its largest ‖ω‖ and its turn.

        Returns
        -------
        The states, q and ω, (n, 7); the largest ‖ω‖, rad/s, or 1 if that is zero; and the largest
        turn from the first of these times, rad, but at most 1
        """
        if (times := t.tobytes()) not in self._at:
            spans = np.diff(t, prepend=self.begins_at)[None]
            states = follow(equations_of(self.scenario), self.start, spans)[0]
            speed = norms(states[:, 4:]).max() or 1.0
            turns = float(
                norms(apart(np.repeat(states[:1], len(states), axis=0), states)[:, :3]).max()
            )
            turns = min(1.0, max(turns, EPS)) if self.fastest else 1.0
            self._at[times] = states, speed, turns
        return self._at[times]

    def turned(self, q: FloatArray, t: FloatArray) -> float:
        """Return the largest error of attitudes q, (n, 4), at n times t, s, (n,), per angle turned.

        It is divided by the angle by which the exact motion turns in these times, at most 1 rad.
        The error itself would be small at times that are too short for either motion to turn.
        """
        key = q.tobytes(), t.tobytes()
        if key not in self._attitude_errors:
            states, _, turns = self.at(t)
            self._attitude_errors[key] = float(
                norms(rotation_vectors(states[:, :4], q)).max() / turns
            )
        return self._attitude_errors[key]

    def error_of_attitude(self, reading: Reading) -> float:
        """Return the largest error of a reading's attitude, relative to the exact motion's turn.

        That turn counts as 1 rad if it is larger. The error is infinite if the times are so long
        that the exact motion is not computed.
        """
        if (reading.t[-1] - self.begins_at) * self.fastest > FURTHEST:
            return np.inf
        return self.turned(reading.q, reading.t)

    def error(self, reading: Reading, enough: float = np.inf) -> float:
        """Return the largest relative error of attitude, ω and spins of a reading.

        It is infinite if the times are so long that the exact motion is not computed, or if the
        error is nan.

        Parameters
        ----------
        enough : if the error of the attitude is as large as this, it is returned, and ω and spins
            are not compared
        """
        deviations = [self.error_of_attitude(reading)]
        if deviations[0] >= enough:
            return deviations[0]
        (states, speed, _), omega = self.at(reading.t), reading.omega_body
        if omega is not None:
            deviations.append(norms(omega - states[:, 4:]).max() / speed)
        if reading.spins is not None:
            scenario = self.scenario
            spins = scenario.spins(states[:, 4:], scenario.kept_at_start)
            deviations.append(norms(reading.spins - spins).max() / max(speed, norms(spins).max()))
        largest = float(np.max(deviations))
        return np.inf if np.isnan(largest) else largest

    def better(self, readings: Iterable[_Correction], best: _Correction) -> _Correction:
        """Return the correction with the smallest error; `best` if none has a far smaller error.

        The first of several equally good corrections is returned.

        Parameters
        ----------
        readings : the corrections that are tried
        best : the correction to be improved upon. If there is none, an empty list of sentences and
            the reading as it is
        """
        given = best[1]
        baseline = least = self.error(given)
        # The keys are numbers of samples left out. Errors of more than 1 count as 1, which is that
        # of a body at rest.
        baselines = {0: min(1.0, baseline)}
        for words, reading in readings if least > FITS else ():
            # A reading with fewer samples is compared with the given one, from which as many are
            # left out at the end where they are worse.
            if (fewer := len(given.t) - len(reading.t)) not in baselines:
                parts = slice(fewer, None), slice(None, len(given.t) - fewer)
                errors = (self.error(given.rows(part)) for part in parts)
                baselines[fewer] = min(1.0, baseline, *errors)
            enough = min(LEFT * baselines[fewer], least - FITS)
            if (deviation := self.error(reading, enough)) < enough:
                least, best = deviation, (words, reading)
        return best

    def other_times(self, reading: Reading) -> list[str]:
        """Return a list of the sentence that recorded times are too short or too long by a factor.

        If the times are multiplied by it, attitudes turn at the rate ω, and the motion is the exact
        one. The list is empty if there is no such factor, or if ω was not recorded.
        """
        least = self.error(reading)
        if least <= FITS or (factor := _factor_of_times(reading)) is None:
            return []
        # With explicit Euler an oscillation by θ rad a step is slower by the fraction θ²/3, and a
        # decay by the fraction r a step is faster by the fraction r/2.
        tolerance = float(norms(rotation_vectors(reading.q[:-1], reading.q[1:])).max()) ** 2 / 3
        tolerance += decay_rate(self.scenario) * float(np.diff(reading.t).max()) / 2
        bounds = factor * (1 - tolerance), factor * (1 + tolerance)
        fit = minimize_scalar(
            lambda factor: self.error(reading._replace(t=factor * reading.t)),
            bounds=bounds,
            method="bounded",
            options={"xatol": FITS * factor},
        )
        omega = self.at(fit.x * reading.t)[0][:, 4:]
        # If ω hardly changes, the attitude may as well be wrong, not the times.
        changes = norms(omega - omega[0]).max() / (norms(omega).max() or 1.0)
        if fit.fun >= LEFT * min(least, changes) or abs(fit.x - 1) < tolerance:
            return []
        times, how = (fit.x, TOO_SHORT) if fit.x > 1 else (1 / fit.x, TOO_LONG)
        return [f"the times are {times:.4g} times {how}"]


def _samples_until(exact: Trajectory, turn: float) -> int:
    """Return the number of samples until the exact motion has turned by an angle, rad.

    It is `FEWEST` + `LEFT_OUT` at least, and may exceed the number of samples.
    """
    turned = np.cumsum(norms(exact.omega_body)[1:] * np.diff(exact.t))
    return max(FEWEST + LEFT_OUT, int(np.searchsorted(turned, turn)) + 1)


def _corrections(
    reading: Reading, scenario: Scenario, *, is_right: bool = True
) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence on each mistake that is tried, and the reading corrected for it.

    Parameters
    ----------
    reading : the samples of the recording as they were read
    is_right : whether attitudes and times may be right as they are. If not, mistakes of ω are tried
        only if their correction leaves out a sample, which may be the wrong one; and mistakes of
        spins are not tried
    """
    other: QuaternionOrder = "xyzw" if reading.order == "wxyz" else "wxyz"
    letters = " ".join(other)
    swapped = np.roll(reading.q, 1 if other == "xyzw" else -1, axis=1)
    yield (
        f"the quaternion's order is {letters} (state 'quaternion = {other}')",
        reading._replace(order=other, q=swapped),
    )
    yield (
        "the quaternion takes world to body components (it is conjugated)",
        reading._replace(q=conjugate(reading.q)),
    )
    yield (
        f"the quaternion's order is {letters}, and it takes world to body components",
        reading._replace(order=other, q=conjugate(swapped)),
    )
    for name, unit in UNITS.items():
        yield f"the times are in {name}; t [{name}] says so", reading._replace(t=unit * reading.t)
    step = float(np.diff(reading.t).min())
    for samples, words in ((1.0, "one sample"), (0.5, "half a sample")):
        for sign, when in ((1, "after"), (-1, "before")):
            later = reading.t + sign * samples * step
            yield f"each state is that of {words} {when} its time", reading._replace(t=later)
    for which, mirror in LEFT_HANDED.items():
        # A reflection changes the sign of axial vectors.
        q = np.hstack([reading.q[:, :1], -reading.q[:, 1:] @ mirror])
        omega = None if reading.omega is None else -reading.omega @ mirror
        yield f"its axes are left-handed, {which}", reading._replace(q=q, omega=omega)
    if reading.omega is not None:
        if is_right:
            yield from _of_omega(reading, reading.omega)
        yield from _of_other_samples(reading, reading.omega)
    if reading.spins is not None and is_right:
        yield from _of_spins(reading, reading.spins, scenario)


def _factor_of_times(reading: Reading) -> float | None:
    """Return the approximate factor by which to multiply times so that attitudes turn at rates ω.

    Returns
    -------
    None if ω was not recorded or is zero, or if the attitude is constant
    """
    if (omega := reading.omega_body) is None:
        return None
    turned = norms(rotation_vectors(reading.q[:-1], reading.q[1:])).sum()
    expected = np.sum(norms(omega[1:] + omega[:-1]) / 2 * np.diff(reading.t))
    return float(turned / expected) if turned and expected else None


def _of_spins(
    reading: Reading, spins: FloatArray, scenario: Scenario
) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each mistake that may be in the spins, and the reading without it.

    Parameters
    ----------
    reading : the samples as they were read
    spins : spins of the n samples, rad/s, (n, rotors)
    """
    yield "the spins have the opposite sign", reading._replace(spins=-spins)
    for words, factor in RATES.items():
        of_spins = words.replace("wx", "spin1").replace("was", "were").replace("it s", "they s")
        yield f"the spins are {of_spins}", reading._replace(spins=spins * factor)
    for first, second in combinations(range(spins.shape[1]), 2):
        exchanged = spins.copy()
        exchanged[:, [first, second]] = spins[:, [second, first]]
        yield (
            f"spin{first + 1} and spin{second + 1} are exchanged",
            reading._replace(spins=exchanged),
        )
    if (omega_body := reading.omega_body) is not None:
        of_body = omega_body @ scenario.rotors.axes_body.T
        yield (
            "the spins are those in space; they are to be relative to the body",
            reading._replace(spins=spins - of_body),
        )


def _of_omega(reading: Reading, omega: FloatArray) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each mistake that may be in the recorded ω, and the reading without it.

    Examples are wrong axes, a wrong unit, and a wrong sign or order of components.

    Parameters
    ----------
    reading : the samples as they were read
    omega : ω of the n samples, rad/s, (n, 3)
    """
    frame: OmegaFrame = "world" if reading.frame == "body" else "body"
    yield f"ω is in {frame} axes (state 'omega = {frame}')", reading._replace(frame=frame)
    yield "ω has the opposite sign", reading._replace(omega=-omega)
    for words, factor in RATES.items():
        yield f"ω is {words}", reading._replace(omega=omega * factor)
    for words, columns, signs in COLUMNS_OF_OMEGA:
        yield words, reading._replace(omega=omega[:, columns] * signs)
    for axes in EULER_ANGLES:
        of_angles = "".join("xyz"[axis] for axis in axes)
        omega_world = _of_rates(matrices(reading.q), omega, axes)
        yield (
            f"ω is the rates of Euler angles {of_angles}",
            reading._replace(omega=omega_world, frame="world"),
        )


def _of_other_samples(reading: Reading, omega: FloatArray) -> Iterator[tuple[str, Reading]]:
    """Yield a sentence for each time by which ω may be too old or new, and the corrected reading.

    In the latter each attitude has the ω of its own time. One sample at an end has none and is left
    out.

    Parameters
    ----------
    reading : the samples as they were read
    omega : ω of the n samples, rad/s, (n, 3)
    """
    earlier, later = slice(None, -1), slice(1, None)
    for age, own, other in (("older", earlier, later), ("newer", later, earlier)):
        kept = reading.rows(own)
        yield f"ω is one sample {age} than the attitude", kept._replace(omega=omega[other])
        yield (
            f"ω is half a sample {age} than the attitude, as of semi-implicit Euler or leapfrog",
            kept._replace(omega=(omega[own] + omega[other]) / 2),
        )


def _of_rates(R_world_body: FloatArray, rates: FloatArray, axes: tuple[int, ...]) -> FloatArray:
    """Return ω of n samples along world axes, rad/s, (n, 3), from rates of Euler angles a, b, c.

    Parameters
    ----------
    R_world_body : the attitudes R_i(a) R_j(b) R_k(c), (n, 3, 3)
    rates : rates of the angles, rad/s, (n, 3); in the order x, y, z if all three axes differ
    axes : indices i, j, k of the axes
    """
    i, j, k = axes
    a, b, c = rates.T if i == k else rates.T[[i, j, k]]
    first = np.eye(3)[i]
    third = R_world_body[:, :, k]
    node = np.cross(third, first) if i != k and (i + 1) % 3 == j else np.cross(first, third)
    node /= np.maximum(norms(node), EPS)[:, None]
    return np.asarray(np.outer(a, first) + b[:, None] * node + c[:, None] * third)
