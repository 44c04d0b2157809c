"""Decides where a ladder ends: once it shows the errors that a method reaches, or a blow-up."""

from ..timesteps.ladder import DECIDED_STEPS, EXCESS, LEAST_RUNGS, MIN_RUNGS
from .records import Records

#: If the errors of all signals are below this, relative or in rad, no finer rung is needed.
GOAL = 1e-9
#: Ladders of methods of this order or higher may have twice as many steps, as their errors become
#: far smaller than those of other methods.
HIGH_ORDER = 4


def is_finished(records: Records) -> bool:
    """Whether the ladder ends with its last row: no finer rung is needed, or none can succeed.

    No finer rung is needed if the errors are below `GOAL`, or if they have grown from rung to rung
    twice. The ladder also ends if a finer rung would take more than about `DECIDED_STEPS` steps.

    Parameters
    ----------
    records : with at least one row of the ladder
    """
    last, count = records.rows[-1], len(records.rows)
    if records.is_hopeless(last) or _diverges_at_any_timestep(records):
        return True
    most = DECIDED_STEPS * (2 if records.order >= HIGH_ORDER else 1)
    # If the run has blown up, a finer run may show whether the method blows up at any timestep.
    if 2 * last.steps > (EXCESS if count < LEAST_RUNGS or last.outcome != "ok" else 1) * most:
        return True
    errors = [max(value for _, value in row.errors) for row in records.rows[-3:] if row.errors]
    if count < MIN_RUNGS or len(errors) < 3:
        return False
    return errors[-1] <= GOAL or errors[0] < errors[1] < errors[2]


def cut_short(records: Records) -> bool:
    """Whether the ladder ended only at the step limit, so that finer rungs were not run."""
    return records.has_ladder and not (records.rows and is_finished(records))


def _diverges_at_any_timestep(records: Records) -> bool:
    """Whether halving the timestep has not delayed the blow-up.

    In an unstable integrator, errors grow by a factor per step that tends to 1 faster than the
    number of steps increases, so that halving delays the blow-up. A clamp is reached at the same
    time at any timestep.
    """
    ends = [row.stopped_at for row in records.rows[-2:] if row.outcome == "diverged"]
    coarse, fine = ends if len(ends) == 2 else (None, None)
    return coarse is not None and fine is not None and fine <= coarse
