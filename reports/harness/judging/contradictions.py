"""What forbids that a ladder converges: a rung that is worse than coarser ones predict.

Errors and defects of a run are looked at alike: both shrink at the declared order down to
round-off. Defects do so where errors have long saturated, too, and where the motion is chaotic.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice

import numpy as np

from ....scenarios import FloatArray
from ...results.records import Row
from ..measuring.asymptotic import ASYMPTOTIC, DISTINCT, ORDER_SLACK, WHOLE
from .observed_order import FITTED_RUNGS, SETTLING_ORDER
from .sequences import SignalSequence
from .signal_ladder import SHORTFALL, SHOWN_OVER

#: Times that a rung is worse, where only two coarser ones say how it should be.
FAR_WORSE = 1e3


@dataclass(frozen=True, eq=False)
class _Series:
    """One number a rung, (n,), coarse to fine, what round-off may make of it, and of what it is.

    Attributes
    ----------
    of : the ladder
    times : s, by which it is reached; None where it is of the whole run
    defects : the largest by signal, (n, signals)
    """

    of: SignalSequence
    name: str
    values: FloatArray
    floors: FloatArray
    defects: FloatArray
    times: FloatArray | None = None

    def when(self, k: int) -> str:
        """The time by which a rung's number is reached, in words; empty where it is of the run."""
        return "" if self.times is None else f", by t = {self.times[k]:.3g} s"


def contradictions(
    rows: Sequence[Row], sequences: Sequence[SignalSequence], slack: float, interval: float
) -> Iterator[str]:
    """What of the judged rows no method that converges would do, in words.

    Parameters
    ----------
    rows : of the ladder, all of them ok, coarse to fine
    sequences : the same in each signal
    slack : relative, to which the engine holds a state
    interval : s, between two samples
    """
    with np.errstate(all="ignore"):
        yield from _all(rows, sequences, slack, interval)


def _all(
    rows: Sequence[Row], sequences: Sequence[SignalSequence], slack: float, interval: float
) -> Iterator[str]:
    yield from _lost(rows, sequences)
    is_lost = any(sequence.errors[-1] >= WHOLE for sequence in sequences)
    for sequence in sequences:
        floors = sequence.roundoff_bounds + sequence.uncertainty
        names = [one.signal.name for one in sequences]
        largest = np.array([_largest_defects(row, names) for row in rows[-len(sequence) :]])
        name = f"{sequence.signal.label}: the error"
        yield from _worse(_Series(sequence, name, sequence.errors, floors, largest))
        if len(rows) == len(sequence) and all(row.defects for row in rows):
            found = [row.defects[sequence.signal.name] for row in rows if row.defects]
            floors = np.array([max(one.floor, slack) for one in found])
            defects = _Series(
                sequence,
                f"{sequence.signal.label}: the largest defect between two samples",
                np.array([one.max for one in found]),
                np.where(sequence.errors < ASYMPTOTIC, floors, floors + _own(sequence, interval)),
                largest,
                np.array([one.at for one in found]),
            )
            yield from _worse(defects)
            yield from _level(
                defects, follows=bool(sequence.errors[-1] < ASYMPTOTIC), is_lost=is_lost
            )


def _own(sequence: SignalSequence, interval: float) -> FloatArray:
    """What a method of the order may commit between two samples, on whatever way it is, (n,).

    A run that has lost the exact motion goes where another timestep would not, and its defects
    scatter up to that: their size there says nothing.
    """
    rate = sequence.rate
    return rate * interval * (rate * sequence.timesteps) ** sequence.declared_order


def _largest_defects(row: Row, names: Sequence[str]) -> list[float]:
    """The largest defects by signal; infinite in a run that cannot be followed."""
    found = row.defects or {}
    return [found[name].max if found else np.inf for name in names]


def _lost(rows: Sequence[Row], sequences: Sequence[SignalSequence]) -> Iterator[str]:
    """A finest run no better than no motion, where a coarser one was asymptotic in all signals."""
    if not rows or rows[-1].survived or not sequences:
        return
    errors = np.array([sequence.errors for sequence in sequences])
    k = int(np.argmin(errors.max(axis=0)))
    worst = int(np.argmax(errors[:, k]))
    if errors[worst, k] < ASYMPTOTIC:
        signal, coarser = sequences[worst].signal, sequences[worst].timesteps[k]
        yield (
            f"errors grow as the timestep shrinks: at {rows[-1].timestep:.1e} s a run is no better "
            f"than no motion, at {coarser:.1e} s it was off by at most "
            f"{signal.words(errors[worst, k])}, {signal.label}"
        )


def _worse(series: _Series) -> Iterator[str]:
    """A rung that is worse than the last of some coarser ones that shrink as they should.

    Three of these are enough for one that is a little worse; two, if of the declared order, for one
    that is far worse.
    """
    by_three = _worse_than(series, FITTED_RUNGS, DISTINCT, np.inf)
    by_two = _worse_than(series, 2, FAR_WORSE, SHORTFALL)
    yield from islice(chain(by_three, by_two), 1)


def _worse_than(series: _Series, rungs: int, factor: float, off_order: float) -> Iterator[str]:
    values, floors, words = series.values, series.floors, series.of.signal.words
    steps = series.of.timesteps
    for end in range(rungs - 1, len(values) - 1):
        window = slice(end - rungs + 1, end + 1)
        if not ((values < ASYMPTOTIC) & (values > floors))[window].all():
            continue
        slopes = -np.diff(np.log2(values[window]))
        if np.ptp(slopes) > 2 * ORDER_SLACK or slopes.min() < SETTLING_ORDER:
            continue
        if np.abs(slopes - series.of.declared_order).max() > off_order:
            continue
        # Where no interval is worse, errors of another sign have added up, or noise has.
        larger = series.defects > DISTINCT * series.defects[end]
        has_cause = (larger | np.isinf(series.defects)).any(axis=1)
        worse = np.flatnonzero(has_cause & (values > factor * np.maximum(values[end], floors)))
        if len(worse) and worse[-1] > end:
            k = int(worse[-1])
            yield (
                f"{series.name} is {words(values[k])} at a timestep of {steps[k]:.1e} s"
                f"{series.when(k)}, though it has come down to {words(values[end])} at "
                f"{steps[end]:.1e} s, at order {slopes.mean():.2f}"
            )


def _level(series: _Series, *, follows: bool, is_lost: bool) -> Iterator[str]:
    """The finest rungs, if they do not shrink, or at a lower order than declared.

    At a rate Ω a method of order p commits an error of Ω (hΩ)^p a second. After that has added up
    to one each run may have a wobble of its own, damped or grown, and defects of other sizes.

    Parameters
    ----------
    follows : whether the runs follow the exact motion; where not, each takes a way of its own, with
        defects of other sizes
    """
    values, floors = series.values[-SHOWN_OVER:], series.floors[-SHOWN_OVER:]
    is_used = (values < ASYMPTOTIC) & (values > DISTINCT * floors)
    if len(values) < SHOWN_OVER or not is_used.all() or series.times is None:
        return
    turn = series.of.rate * series.of.timesteps[-SHOWN_OVER]
    committed = series.of.rate * series.times[-SHOWN_OVER:] * turn**series.of.declared_order
    is_within = bool((committed <= WHOLE).all())
    if follows and is_lost and not is_within:
        return
    follows = follows and is_within
    slopes = -np.diff(np.log2(values))
    is_clean = np.ptp(slopes) <= ORDER_SLACK and slopes.max() < series.of.declared_order - SHORTFALL
    words = series.of.signal.words
    is_level = slopes.max() < (SETTLING_ORDER if follows else SETTLING_ORDER / 2)
    if is_level or (is_clean and follows):
        yield (
            f"{series.name} shrinks at order {slopes.mean() + 0.0:.2f} over {SHOWN_OVER} rungs, "
            f"though {series.of.declared_order} is declared: {words(values[0])} at "
            f"{series.of.timesteps[-SHOWN_OVER]:.1e} s, {words(values[-1])} at "
            f"{series.of.timesteps[-1]:.1e} s{series.when(-1)}"
        )
