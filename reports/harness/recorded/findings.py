"""Finds mistakes in a recording before any equation is changed, and what remains without them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....scenarios.rotation import matrices
from .case import Case
from .samples.columns import saturated, stuck
from .samples.digits import Shown, shown_by_digits
from .samples.interpolated import interpolated
from .samples.mistakes import mistakes, rounded_times, without
from .samples.odd_samples import across_signs, exchanged, jitter, lost_sign, warped, wrapped

#: Mistakes are looked for as long as they have been undone at most so many times before.
MOST_UNDONE = 2


class Finding(NamedTuple):
    """Something found in a recording, such as a mistake.

    Attributes
    ----------
    words : sentences on the finding
    left : alternative cases without the finding, which remain to be explained: the first that is
        fully explained counts
    is_beyond : whether the finding exceeds the error of a method; None if that is to be decided
        from the motion
    is_all : whether the cases in `left` have all samples of the recording, and not only some
    """

    words: tuple[str, ...]
    left: tuple[Case, ...] = ()
    is_beyond: bool | None = None
    is_all: bool = False


def finding(case: Case) -> Finding | None:
    """Return the first finding in a recording; None if there is none.

    Findings that are certain by the numbers themselves come before those that need the motion.
    """
    return _of_numbers(case) or _of_mistakes(case) or _of_times(case) or _of_jumps(case)


def _of_numbers(case: Case) -> Finding | None:
    """Return what a recording's numbers show without an equation of motion; None if nothing.

    `Finding.left` has the corrected recording if all samples can be corrected, and the recording as
    it is if no sample is wrong. Else it has two cases: the recording without its wrong samples, and
    the samples before the first wrong one.
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
    # Only the effect of rounding may be within a method's error.
    is_beyond = None if all(any(one.rounding) for one in shown) else True
    words = tuple(one.words for one in shown)
    return Finding(words, left, is_beyond, is_all=not len(wrong))


def _odd_samples(case: Case) -> Shown | None:
    """Return what single samples show beside their neighbours; None if nothing."""
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
    """Return mistakes in recording, and the case without them; None if none is found.

    None are looked for if mistakes have been undone more than `MOST_UNDONE` times before.
    """
    reading, scenario = case.reading, case.scenario
    if case.undone > MOST_UNDONE:
        return None
    wrong = mistakes(scenario, case.exact, reading) or rounded_times(reading)
    if not wrong:
        return None
    first = matrices(case.exact.q_world_body_wxyz[:1])[0]
    undone = without(wrong, reading, scenario, first)
    left = case.read(undone) if undone else None
    remaining = (replace(left, undone=case.undone + 1),) if left else ()
    return Finding(tuple(wrong), remaining, is_all=True)


def _of_times(case: Case) -> Finding | None:
    """Return the finding that each state is the exact motion's at another time; None if not so."""
    words = warped(case.scenario, case.motion, case.exact, case.of_intervals)
    return Finding((words,)) if words else None


def _of_jumps(case: Case) -> Finding | None:
    """Return jumps of the motion; None if there is none.

    The samples before the first jump remain to be explained, or all but the first sample if that
    one is wrong. None are looked for if samples have been left out because of a jump before, or if
    a clamp explains the motion.
    """
    if case.is_smooth or case.physics.clamps or not (found := case.jumps()):
        return None
    first = int(np.searchsorted(case.motion.t, min(one.at for one in found)))
    samples = np.arange(first) if first > 1 else np.arange(1, len(case.motion.t))
    left = parts_of(replace(case, is_smooth=True), samples)
    return Finding(tuple(one.words for one in found), left, is_beyond=True)


def parts_of(case: Case, *samples: NDArray[np.intp]) -> tuple[Case, ...]:
    """Return a case for each set of samples, given by their indices, that has enough of them."""
    return tuple(filter(None, map(case.of, samples)))
