"""A ladder in one signal, as it is judged: read from the evidence that is stored of its rungs."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....scenarios import SIGNAL, FloatArray, Signal
from ...results.evidence import Deviation, JudgedLadder


@dataclass(frozen=True, eq=False)
class SignalSequence:
    """A ladder of n rungs in one signal, coarse to fine.

    Attributes
    ----------
    timesteps, errors, roundoff_bounds : s; distance from the exact motion; largest effect of
        rounding at every step; (n,)
    differences : between neighbouring rungs, (n − 1,)
    orders, limit_errors, limit_changes, is_clean, rounding, deviations : as in `Refinement`,
        (n − 2,), one for each rung from the third on
    declared_order : of accuracy
    uncertainty : of the reference, plus that of start and body as the engine holds them
    duration : s, of the window
    rate : rad/s, the fastest of the motion
    """

    signal: Signal
    timesteps: FloatArray
    errors: FloatArray
    roundoff_bounds: FloatArray
    differences: FloatArray
    orders: FloatArray
    limit_errors: FloatArray
    limit_changes: FloatArray
    is_clean: NDArray[np.bool_]
    rounding: FloatArray
    deviations: tuple[Deviation | None, ...]
    declared_order: int
    uncertainty: float
    duration: float
    rate: float

    def __len__(self) -> int:
        return len(self.timesteps)


def sequence(ladder: JudgedLadder, name: str) -> SignalSequence:
    """A ladder in one signal."""
    rungs, basis = ladder.rungs, ladder.basis
    k = basis.signals.index(name)
    refinements = [rung.refinement for rung in rungs if rung.refinement]

    def column(rows: Iterable[FloatArray | None]) -> FloatArray:
        return np.array([row[k] for row in rows if row is not None])

    return SignalSequence(
        SIGNAL[name],
        np.array([rung.timestep for rung in rungs]),
        column(rung.errors for rung in rungs),
        column(rung.roundoff_bounds for rung in rungs),
        column(rung.differences for rung in rungs),
        column(one.orders for one in refinements),
        column(one.limit_error for one in refinements),
        column(one.limit_change for one in refinements),
        np.array([one.is_clean[k] for one in refinements], dtype=bool),
        column(one.rounding for one in refinements),
        tuple(one.deviations[k] for one in refinements),
        int(basis.declared_orders[k]),
        float(basis.uncertainty[k]),
        basis.duration,
        basis.rate,
    )
