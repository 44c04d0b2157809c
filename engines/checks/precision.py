"""Detects states that are held in single precision by an engine that declares double precision."""

import numpy as np

from ...scenarios import FloatArray
from ...scenarios.rotation import norms
from .read_back import State

#: Relative spacing of single-precision numbers.
EPS_SINGLE = float(np.finfo(np.float32).eps)
#: Root mean square of the norm's rounding, in `EPS_SINGLE`: rounding four components to 24 bits
#: gives about an eighth. Smaller values mean double precision, larger ones another cause.
LEAST, MOST = 1 / 64, 4.0
#: Number of samples needed.
FEWEST = 16
#: Rounding is as large in the first quarter of a run as in all of it; a drift of the norm is not.
SHARE_AT_FIRST = 0.5


def single_precision(states: State) -> str:
    """The message that attitudes have unit norm to 24 bits only; else empty.

    Parameters
    ----------
    states : the samples of a run, (n, 4) and (n, 3)
    """
    deviations = norms(states.q_world_body_wxyz) - 1
    if len(deviations) < FEWEST:
        return ""
    first, whole = _rms(deviations[: len(deviations) // 4]), _rms(deviations)
    if not LEAST * EPS_SINGLE <= whole <= MOST * EPS_SINGLE or first < SHARE_AT_FIRST * whole:
        return ""
    return (
        f"the state is held in 24 bits: the attitude's norm is off by {whole:.1e}, as single "
        "precision rounds, while the engine declares double precision"
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
