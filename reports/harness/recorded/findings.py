"""Finds mistakes in a recording, and what remains to be explained once they are corrected.

The equations of motion are those of the scene: other equations are tried elsewhere, and later.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....scenarios.rotation import norms
from .case import Case
from .samples.columns import saturated, stuck
from .samples.digits import Shown, shown_by_digits, where
from .samples.interpolated import interpolated
from .samples.intervals import states_of
from .samples.mistakes import mistakes, rounded_times, without
from .samples.odd_samples import across_signs, exchanged, jitter, lost_sign, warped, wrapped

#: Mistakes in recording are looked for if they have been corrected at most this many times before.
MOST_UNDONE = 2
#: An ω that is more than `OFF_SCALE` times the exact one, or less than the exact one divided by it,
#: is in none of the units that are tried for it. It is divided by the factor if the attitudes turn
#: no more than `FASTER` times as fast, or as slowly, as the exact ones.
OFF_SCALE, FASTER = 100.0, 2.0
#: Largest root mean square difference of ω, divided by the factor, from the rates of the attitudes,
#: relative to these, both less their means; and an angle between samples, rad, that no recording
#: has.
ALIKE, ABSURD = 0.5, 1e3
#: Small units of angular velocity, how many of them are 1 rad/s, and the relative tolerance with
#: which they are recognised.
SCALES, UNIT_SLACK = {"mrad/s": 1e3, "m°/s": 180e3 / np.pi}, 0.01


class Finding(NamedTuple):
    """Something found in a recording, such as a mistake.

    Attributes
    ----------
    words : sentences on the finding
    left : the recording with the mistake corrected or the wrong samples left out, in one or more
        alternative cases. They are explained in turn, until one is explained fully. Empty if
        nothing remains to be explained, or too few samples do
    is_beyond : whether the finding alone shows that the motion differs from the exact one by more
        than a method's error; None if the size of that difference decides this
    is_all : whether each case in `left` has all samples of the recording, and not only some
    """

    words: tuple[str, ...]
    left: tuple[Case, ...] = ()
    is_beyond: bool | None = None
    is_all: bool = False


def finding(case: Case) -> Finding | None:
    """Return the first finding in a recording; None if there is none.

    What the numbers alone show is looked for first, and then what the equations of motion show.
    """
    found = _of_scale(case) or _of_absurd_samples(case) or _of_numbers(case)
    return found or _of_mistakes(case) or _of_times(case) or _of_jumps(case)


def _of_scale(case: Case) -> Finding | None:
    """Return the finding that ω is far larger, or smaller, than the attitudes turn; else None.

    `Finding.left` has the case with ω divided by the factor, and the case without ω.
    """
    omega, factor = case.reading.omega, _factor_of_omega(case)
    if omega is None or not factor:
        return None
    units = (unit for unit, size in SCALES.items() if abs(factor / size - 1) < UNIT_SLACK)
    unit = next(units, "")
    words = f"ω is {factor:.4g} times as large as the attitudes turn"
    words += f", as in {unit}" if unit else ": look at its unit, or at its sensor's scale"
    by_factor = case.reading._replace(omega=omega / SCALES.get(unit, factor))
    cases = (case.read(one) for one in (by_factor, case.reading._replace(omega=None)))
    return Finding((words,), tuple(filter(None, cases)), is_beyond=True, is_all=True)


def _factor_of_omega(case: Case) -> float:
    """Return by which factor ω is too large; 0 if it is so, or too small, by `OFF_SCALE` at most.

    The attitudes must turn at most twice as fast, or half as fast, as the exact ones. Besides, ω
    divided by the factor must vary as the rates of the attitudes do, perhaps along other axes, so
    that it is no bias; or the body would turn by more than `ABSURD` from sample to sample.
    """
    omega, exact = case.reading.omega, norms(case.exact.omega_body)[:-1]
    turns, rates = exact > 0, case.numbers.rates
    if omega is None or not turns.any():
        return 0.0
    factor, turned = (
        float(np.median(norms(each)[turns] / exact[turns])) for each in (omega[:-1], rates)
    )
    is_of_scale = 1 / OFF_SCALE <= factor <= OFF_SCALE
    if not factor or is_of_scale or not 1 / FASTER < turned < FASTER:
        return 0.0
    if np.median(norms(omega[:-1]) * case.numbers.spans) > ABSURD:
        return factor
    varying, scaled = (each - each.mean(axis=0) for each in (rates, omega[:-1] / factor))
    # Of all rotations and reflections of one of them, the smallest difference (Kabsch 1976).
    overlap = float(np.linalg.svd(varying.T @ scaled, compute_uv=False).sum())
    apart = np.sum(varying**2) + np.sum(scaled**2) - 2 * overlap
    return factor if apart <= ALIKE**2 * np.sum(varying**2) else 0.0


def _of_absurd_samples(case: Case) -> Finding | None:
    """Return the finding that ω is absurd at some samples, as where a packet is lost; else None.

    With such an ω the body would turn by more than `ABSURD` from sample to sample. `Finding.left`
    has the case without these samples.
    """
    omega, spans = case.reading.omega, case.numbers.spans
    if omega is None:
        return None
    is_absurd = np.abs(omega).max(axis=1) > ABSURD / np.append(spans, spans[-1])
    wrong = np.flatnonzero(is_absurd)
    if not len(wrong) or 2 * len(wrong) > len(omega):
        return None
    words = f"ω is up to {np.abs(omega).max():.4g} rad/s {where(case.reading.t, wrong)}"
    left = parts_of(case, np.flatnonzero(~is_absurd))
    return Finding(
        (f"{words}: leave {'it' if len(wrong) == 1 else 'them'} out",), left, is_beyond=True
    )


def _of_numbers(case: Case) -> Finding | None:
    """Return the mistake, or coarse rounding, that numbers alone show; None if there is none.

    Digits are looked at first, and then single samples and columns that differ from the others.
    `Finding.left` has one case if all samples can be corrected: the corrected recording. It also
    has one if no sample is wrong: the recording as it is. Otherwise it has two cases: the recording
    without its wrong samples, and the samples before the first wrong one. Cases with too few
    samples are left out.
    """
    shown = shown_by_digits(case.numbers)
    if case.noise.any():
        shown = [one for one in shown if not any(one.rounding)]
    if not shown and (odd := _odd_samples(case)):
        shown = [odd]
    if not shown:
        return None
    noise = np.max([case.noise, *(np.array(one.rounding) for one in shown)], axis=0)
    if mended := shown[0].mended:
        whole = tuple(filter(None, [case.read(mended)]))
        return Finding((shown[0].words,), whole, is_beyond=True, is_all=True)
    every, wrong = np.arange(len(case.motion.t)), np.concatenate([one.wrong for one in shown])
    samples = [np.setdiff1d(every, wrong)]
    samples += [every[: wrong.min()]] if len(wrong) else []
    left = parts_of(replace(case, noise=noise), *samples)
    # Coarse rounding may be within a method's error; no other finding is.
    is_beyond = None if all(any(one.rounding) for one in shown) else True
    words = tuple(one.words for one in shown)
    return Finding(words, left, is_beyond, is_all=not len(wrong))


def _odd_samples(case: Case) -> Shown | None:
    """Return the mistake that single samples or columns show, as they differ from the others.

    None is returned if there is no such mistake.
    """
    numbers = case.numbers
    found = interpolated(numbers) or lost_sign(case.reading, numbers) or across_signs(numbers)
    if found or numbers.omega is None:
        return found
    return (
        saturated(numbers, numbers.omega)
        or stuck(numbers, numbers.omega)
        or wrapped(numbers, numbers.omega)
        or exchanged(case.scenario, case.motion)
        or jitter(case.reading, case.motion.omega_body)
    )


def _of_mistakes(case: Case) -> Finding | None:
    """Return mistakes in recording, such as a wrong unit; None if none is found.

    `Finding.left` has the case in which they are corrected; it is empty if they cannot be. If
    mistakes have been corrected more than `MOST_UNDONE` times before, no more are looked for.
    """
    reading, scenario = case.reading, case.scenario
    if case.undone > MOST_UNDONE:
        return None
    wrong = mistakes(scenario, case.exact, reading) or rounded_times(
        reading, case.recording.resolution
    )
    if not wrong:
        return None
    undone = without(wrong, reading, scenario, states_of(case.exact))
    left = case.read(undone) if undone else None
    remaining = (replace(left, undone=case.undone + 1),) if left else ()
    return Finding(tuple(wrong), remaining, is_all=True)


def _of_times(case: Case) -> Finding | None:
    """Return the finding that each recorded state is the exact one at another time.

    None is returned if the states are not exact ones at other times.
    """
    words = warped(case.scenario, case.motion, case.exact, case.of_intervals)
    return Finding((words,)) if words else None


def _of_jumps(case: Case) -> Finding | None:
    """Return the finding that the motion jumps; None if it does not.

    The samples before the first jump remain to be explained. If only the first sample is before
    it, that sample is wrong, and all others remain. No jump is looked for if samples have been left
    out because of an earlier jump, or if a clamp of ω explains the motion.
    """
    if case.is_smooth or case.physics.clamps or not (found := case.jumps()):
        return None
    first = int(np.searchsorted(case.motion.t, min(one.at for one in found)))
    samples = np.arange(first) if first > 1 else np.arange(1, len(case.motion.t))
    left = parts_of(replace(case, is_smooth=True), samples)
    return Finding(tuple(one.words for one in found), left, is_beyond=True)


def parts_of(case: Case, *samples: NDArray[np.intp]) -> tuple[Case, ...]:
    """Return a case for each of several sets of k samples, given by their indices, (k,).

    Sets for which `Case.of` returns None, such as those with too few samples, are left out.
    """
    return tuple(filter(None, map(case.of, samples)))
