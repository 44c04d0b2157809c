"""Judges, of a ladder so far, whether a finer rung is needed, or can succeed."""

from ..ladder import DECIDED_STEPS, EXCESS, LEAST_RUNGS, MIN_RUNGS, QUICK_STEPS
from .best_window import SHARP
from .records import Records

#: A ladder continues until every limit is known to `GOAL`, relative or in rad, or steps run out; to
#: `FINE_GOAL` for methods of `HIGH_ORDER`, which need few rungs for it; to `SHARP`, enough for a
#: judgement, for engines as shipped.
GOAL, FINE_GOAL = 1e-4, 1e-9
HIGH_ORDER = 4


def is_down(records: Records) -> bool:
    """Whether no finer rung is needed, or can succeed; there must be a row."""
    if _is_settled(records):
        return True
    if len(records.rows) < MIN_RUNGS:
        return False
    return _is_known(records) or records.ladder.is_out_of_reach(records.finest)


def cut_short(records: Records) -> bool:
    """Whether finer rungs would have been run if the step limit allowed them."""
    if not records.rows:
        return bool(records.least_steps)
    return not (_is_settled(records) or _is_known(records))


def _is_settled(records: Records) -> bool:
    last = records.rows[-1]
    return records.is_hopeless(last) or _diverges_at_any_timestep(records) or _is_decided(records)


def _is_known(records: Records) -> bool:
    """Whether the ladder has reached its goal."""
    goal = FINE_GOAL if records.order >= HIGH_ORDER else GOAL
    return records.ladder.is_known(SHARP if records.as_shipped else goal)


def _is_decided(records: Records) -> bool:
    """Whether steps and pieces decide, and a longer ladder has no more to show.

    Errors of finer rungs, and their costs, follow by the order. Of a method of `HIGH_ORDER` the
    ladder of a quick study tells faults of 1e-8, which are too small for steps and pieces.
    """
    if records.local is None or not records.local.converges:
        return False
    last, count = records.rows[-1], len(records.rows)
    most = QUICK_STEPS if records.order >= HIGH_ORDER else DECIDED_STEPS
    finest = last.timestep * last.steps / most
    in_vain = count >= MIN_RUNGS and records.ladder.is_out_of_reach(finest)
    return in_vain or 2 * last.steps > (EXCESS if count < LEAST_RUNGS else 1) * most


def _diverges_at_any_timestep(records: Records) -> bool:
    """Whether the blow-up comes at the same time after the timestep was halved.

    In an unstable integrator, errors grow by a factor a step that tends to 1 faster than the number
    of steps increases, so halving delays the blow-up. A clamp is reached at the same time.
    """
    ends = [row.stopped_at for row in records.rows[-2:] if row.outcome == "diverged"]
    coarse, fine = ends if len(ends) == 2 else (None, None)
    return coarse is not None and fine is not None and fine <= coarse
