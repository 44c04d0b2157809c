"""Finds common mistakes in recording: each is undone, and named if the motion then fits.

Only the beginning is compared, before errors of an integrator have grown.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import pi

import numpy as np
from scipy.optimize import minimize_scalar

from ....reference.following import follow
from ....reference.other_equations import equations_of
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import decay_rate
from ....scenarios.rotation import conjugate, matrices, norms, rotation_vectors
from ..explaining.changes import EULER_ANGLES, OTHER_COMPONENTS
from ..explaining.search import LEFT
from .intervals import apart, states_of
from .motion import OmegaFrame, QuaternionOrder, Reading
from .other_readings import equal_times, other_readings

#: Turns of the exact motion, rad, in the beginnings that are compared: by other equations the
#: shorter one is nearer to it; and their least number of samples.
BEGINNINGS, FEWEST = (3.0, 0.75), 3
#: Least number of samples that must be left when a recording is read differently: steps show from
#: two samples on. At most one sample is left out: an ω that is half a sample older and half a
#: sample newer is smoothed, which is no mistake.
FEWEST_LEFT, LEFT_OUT = 2, 1
#: Largest turn of the body in the beginning, rad, with the times as they are read: more is not a
#: beginning.
FURTHEST = 3e3
#: Errors below this, relative or in rad, need no explanation.
FITS = 1e-9
#: How times may be wrong by a factor, in words.
TOO_SHORT = "too short, as where one state in so many is kept"
TOO_LONG = "too long, as of another timestep than that of the steps"
EPS = float(np.finfo(float).eps)
#: Mistakes, and the reading without them.
_Undone = tuple[list[str], Reading]
#: Units of times by mistake, as a column's heading names them, and their length in seconds.
UNITS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
#: What may be wrong with ω, in words, and the factor that corrects it.
RATES = {
    "in degrees a second; wx [deg/s] says so": pi / 180,
    "in rad/s already, and was converted from deg/s": 180 / pi,
    "in turns a second": 2 * pi,
    "in rpm; wx [rpm] says so": pi / 30,
    "half of what it should be": 2.0,
    "twice what it should be": 0.5,
}
#: What makes left-handed axes of right-handed ones, those of the world and of the body.
LEFT_HANDED = {
    **{f"with {axis} reversed": np.diag(1.0 - 2.0 * np.eye(3)[k]) for k, axis in enumerate("xyz")},
    **{
        f"with {axes[0]} and {axes[1]} exchanged": np.eye(3)[order]
        for axes, order in (("xy", [1, 0, 2]), ("yz", [0, 2, 1]), ("xz", [2, 1, 0]))
    },
}


def mistakes(scenario: Scenario, exact: Trajectory, reading: Reading) -> list[str]:
    """Return the mistakes that explain why a recording is not the exact motion; often none.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """
    beginning = _Beginning(scenario, exact)
    given, shorter = (reading.rows(slice(_beginning(exact, turn))) for turn in BEGINNINGS)

    def undone(words: list[str], one: Reading, of: Reading = given) -> Iterator[_Undone]:
        fewest = max(FEWEST_LEFT, len(of.t) - LEFT_OUT)
        for word, other in _undone(one, scenario) if len(one.t) >= fewest else ():
            if len(other.t) >= fewest:
                yield [*words, word], other

    best = beginning.better(undone([], given), ([], given))
    if not best[0]:
        rare = other_readings(given, scenario, matrices(beginning.start[:, :4])[0])
        best = beginning.better((([word], one) for word, one in rare if len(one.t) >= FEWEST), best)
    if not best[0]:
        # Few samples tell mistakes of ω apart less well; without them the attitude follows ω.
        every = undone([], shorter, shorter)
        of_attitudes = ((words, one) for words, one in every if one.omega is shorter.omega)
        if words := beginning.better(of_attitudes, ([], shorter))[0]:
            return words
    if best[0]:
        return beginning.better(undone(*best), best)[0]
    if beginning.error(given) > LEFT:
        twice = (two for one in undone([], given) for two in undone(*one))
        best = beginning.better(twice, best)
    return best[0] or beginning.other_times(given)


def without(
    words: Sequence[str], reading: Reading, scenario: Scenario, first: FloatArray
) -> Reading | None:
    """Return a whole recording without mistakes; None if they do not show in all of it.

    Parameters
    ----------
    words : of the mistakes, as `mistakes` returns them
    first : the exact attitude at the first sample, body to world, (3, 3)
    """
    for one in words:
        every = chain(_undone(reading, scenario), other_readings(reading, scenario, first))
        undone = next((other for word, other in every if word == one), None)
        if undone is None:
            return None
        reading = undone
    return reading


def followed(reading: Reading, scenario: Scenario) -> list[_Undone]:
    """Return mistakes without which the attitude follows ω, whatever torques act; the best first.

    The attitude of samples that are near turns by the mean of their ω, to third order.
    """
    usual = _astray(reading)
    found = [(_astray(other), [words], other) for words, other in _undone(reading, scenario)]
    kept = [one for one in found if one[0] < LEFT * min(1.0, usual)]
    return [one[1:] for one in sorted(kept, key=lambda one: one[0])]


def rounded_times(reading: Reading) -> list[str]:
    """Return that times are rounded, where by others the attitudes follow ω far better."""
    enough = LEFT * min(1.0, _astray(reading))
    return [words for words, other in equal_times(reading) if _astray(other) < enough][:1]


def _astray(reading: Reading) -> float:
    """How far rates at which the attitude turns are from ω, relative; inf without ω."""
    if (omega := reading.omega_body) is None or len(omega) < FEWEST:
        return np.inf
    rates = rotation_vectors(reading.q[:-1], reading.q[1:]) / np.diff(reading.t)[:, None]
    off = rates - (omega[1:] + omega[:-1]) / 2
    size = np.sqrt(np.mean(rates**2))
    return float(np.sqrt(np.mean(off**2)) / size) if size else np.inf


class _Beginning:
    """The beginning of the exact motion, and how far recordings are from it.

    Parameters
    ----------
    exact : the exact motion at the recording's times
    """

    def __init__(self, scenario: Scenario, exact: Trajectory) -> None:
        self.scenario, self.begins_at = scenario, float(exact.t[0])
        self.start = states_of(exact.until(1))
        self.fastest = float(norms(exact.omega_body).max())
        self._at: dict[bytes, tuple[FloatArray, float, float]] = {}
        self._turned: dict[tuple[bytes, bytes], float] = {}

    def at(self, t: FloatArray) -> tuple[FloatArray, float, float]:
        """Exact states, (n, 7), at times, s, (n,), the largest speed, and how far it turns."""
        if (times := t.tobytes()) not in self._at:
            spans = np.diff(t, prepend=self.begins_at)[None]
            made = follow(equations_of(self.scenario), self.start, spans)[0]
            speed = norms(made[:, 4:]).max() or 1.0
            turns = float(norms(apart(np.repeat(made[:1], len(made), axis=0), made)[:, :3]).max())
            turns = min(1.0, max(turns, EPS)) if self.fastest else 1.0
            self._at[times] = made, speed, turns
        return self._at[times]

    def turned(self, q: FloatArray, t: FloatArray) -> float:
        """The largest error of attitudes, (n, 4), at times, s, (n,).

        It is relative to how far the body turns, which is taken to be 1 rad at most: by times that
        hardly pass it hardly turns, and so does what stands still.
        """
        key = q.tobytes(), t.tobytes()
        if key not in self._turned:
            made, _, turns = self.at(t)
            self._turned[key] = float(norms(rotation_vectors(made[:, :4], q)).max() / turns)
        return self._turned[key]

    def error(self, reading: Reading, enough: float = np.inf) -> float:
        """The largest error in attitude and ω; infinite if the times are too far to follow.

        Parameters
        ----------
        enough : if the error in attitude is as large as that, ω is not compared
        """
        if (reading.t[-1] - self.begins_at) * self.fastest > FURTHEST:
            return np.inf
        off = [self.turned(reading.q, reading.t)]
        if off[0] >= enough:
            return off[0]
        (made, speed, _), omega = self.at(reading.t), reading.omega_body
        if omega is not None:
            off.append(norms(omega - made[:, 4:]).max() / speed)
        if reading.spins is not None:
            scenario = self.scenario
            spins = scenario.spins(made[:, 4:], scenario.kept_at_start)
            off.append(norms(reading.spins - spins).max() / max(speed, norms(spins).max()))
        largest = float(max(off))
        return np.inf if np.isnan(largest) else largest

    def better(self, readings: Iterable[_Undone], best: _Undone) -> _Undone:
        """Return the mistakes without which the error is smallest; the given ones if none explains.

        Of those alike the first is named.
        """
        given = best[1]
        usual = least = self.error(given)
        # Of as many samples; what stands still is off by one, whatever is recorded.
        of_given = {0: min(1.0, usual)}
        for words, reading in readings if least > FITS else ():
            # A reading that has fewer samples must be better than one without the worst.
            if (fewer := len(given.t) - len(reading.t)) not in of_given:
                parts = slice(fewer, None), slice(None, len(given.t) - fewer)
                errors = (self.error(given.rows(part)) for part in parts)
                of_given[fewer] = min(1.0, usual, *errors)
            enough = min(LEFT * of_given[fewer], least - FITS)
            if (left := self.error(reading, enough)) < enough:
                least, best = left, (words, reading)
        return best

    def other_times(self, reading: Reading) -> list[str]:
        """Say how many times too short, or too long, times are, by how attitudes follow ω."""
        least = self.error(reading)
        if least <= FITS or (factor := _longer(reading)) is None:
            return []
        # By explicit Euler an oscillation by an angle θ a step is slower by a part of θ²/3, and a
        # decay by a part of r a step is faster by r/2.
        nearly = float(norms(rotation_vectors(reading.q[:-1], reading.q[1:])).max()) ** 2 / 3
        nearly += decay_rate(self.scenario) * float(np.diff(reading.t).max()) / 2
        bounds = factor * (1 - nearly), factor * (1 + nearly)
        fit = minimize_scalar(
            lambda factor: self.error(reading._replace(t=factor * reading.t)),
            bounds=bounds,
            method="bounded",
            options={"xatol": FITS * factor},
        )
        omega = self.at(fit.x * reading.t)[0][:, 4:]
        # Where ω does not change it is as well that the attitude does not follow it.
        changes = norms(omega - omega[0]).max() / (norms(omega).max() or 1.0)
        if fit.fun >= LEFT * min(least, changes) or abs(fit.x - 1) < nearly:
            return []
        times, how = (fit.x, TOO_SHORT) if fit.x > 1 else (1 / fit.x, TOO_LONG)
        return [f"the times are {times:.4g} times {how}"]


def _beginning(exact: Trajectory, turn: float) -> int:
    """Return the number of samples that are compared, in which the motion turns so far, rad."""
    turned = np.cumsum(norms(exact.omega_body)[1:] * np.diff(exact.t))
    return max(FEWEST + LEFT_OUT, int(np.searchsorted(turned, turn)) + 1)


def _undone(reading: Reading, scenario: Scenario) -> Iterator[tuple[str, Reading]]:
    """Yield every mistake in words, and the reading without it."""
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
        # Axial vectors change their sign where axes do not turn.
        q = np.hstack([reading.q[:, :1], -reading.q[:, 1:] @ mirror])
        omega = None if reading.omega is None else -reading.omega @ mirror
        yield f"its axes are left-handed, {which}", reading._replace(q=q, omega=omega)
    if reading.omega is not None:
        yield from _of_omega(reading, reading.omega)
    if reading.spins is not None:
        yield from _of_spins(reading, reading.spins, scenario)


def _longer(reading: Reading) -> float | None:
    """Return by how much longer times would have to be for attitudes to follow ω, nearly."""
    if (omega := reading.omega_body) is None:
        return None
    turned = norms(rotation_vectors(reading.q[:-1], reading.q[1:])).sum()
    wanted = np.sum(norms(omega[1:] + omega[:-1]) / 2 * np.diff(reading.t))
    return float(turned / wanted) if turned and wanted else None


def _of_spins(
    reading: Reading, spins: FloatArray, scenario: Scenario
) -> Iterator[tuple[str, Reading]]:
    yield "the spins have the opposite sign", reading._replace(spins=-spins)
    for words, factor in RATES.items():
        of_spins = words.replace("wx", "spin1").replace("was", "were")
        yield f"the spins are {of_spins}", reading._replace(spins=spins * factor)
    if (omega_body := reading.omega_body) is not None:
        of_body = omega_body @ scenario.rotors.axes_body.T
        yield (
            "the spins are those in space; they are to be relative to the body",
            reading._replace(spins=spins - of_body),
        )


def _of_omega(reading: Reading, omega: FloatArray) -> Iterator[tuple[str, Reading]]:
    frame: OmegaFrame = "world" if reading.frame == "body" else "body"
    yield f"ω is in {frame} axes (state 'omega = {frame}')", reading._replace(frame=frame)
    yield "ω has the opposite sign", reading._replace(omega=-omega)
    for words, factor in RATES.items():
        yield f"ω is {words}", reading._replace(omega=omega * factor)
    for components in OTHER_COMPONENTS:
        columns = ", ".join(f"{'-' * (one < 0)}w{' xyz'[abs(one)]}" for one in components)
        picked = omega[:, np.abs(components) - 1] * np.sign(components)
        yield f"ω is [{columns}] of its columns", reading._replace(omega=picked)
    for axes in EULER_ANGLES:
        of_angles = "".join("xyz"[axis] for axis in axes)
        omega_world = _of_rates(matrices(reading.q), omega, axes)
        yield (
            f"ω is the rates of Euler angles {of_angles}",
            reading._replace(omega=omega_world, frame="world"),
        )
    # It is undone by pairing each attitude with the ω that belongs to it; at one end there is none.
    earlier, later = slice(None, -1), slice(1, None)
    for age, mine, other in (("older", earlier, later), ("newer", later, earlier)):
        kept = reading.rows(mine)
        yield f"ω is one sample {age} than the attitude", kept._replace(omega=omega[other])
        yield (
            f"ω is half a sample {age} than the attitude, as of semi-implicit Euler or leapfrog",
            kept._replace(omega=(omega[mine] + omega[other]) / 2),
        )


def _of_rates(R_world_body: FloatArray, rates: FloatArray, axes: tuple[int, ...]) -> FloatArray:
    """Return ω along world axes from rates of angles a, b, c, with R = R_i(a) R_j(b) R_k(c)."""
    i, j, k = axes
    a, b, c = rates.T if i == k else rates.T[[i, j, k]]
    first = np.eye(3)[i]
    third = R_world_body[:, :, k]
    node = np.cross(third, first) if i != k and (i + 1) % 3 == j else np.cross(first, third)
    node /= np.maximum(norms(node), EPS)[:, None]
    return np.asarray(np.outer(a, first) + b[:, None] * node + c[:, None] * third)
