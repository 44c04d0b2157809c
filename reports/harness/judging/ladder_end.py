"""Decides where a ladder ends: when it shows the errors that a method reaches, or a blow-up."""

from ..timesteps.ladder import DECIDED_STEPS, EXCESS, LEAST_RUNGS, MIN_RUNGS
from .records import Records

#: If the errors of all signals are below this, relative or in rad, no finer rung is needed.
GOAL = 1e-9
#: The runs of methods of this order or higher may have twice as many steps, as their errors become
#: far smaller than those of other methods.
HIGH_ORDER = 4


def is_finished(records: Records) -> bool:
    """Return whether the ladder ends with its last row.

    It ends if no finer rung can succeed; if none is needed, because the errors are below `GOAL` or
    have grown from rung to rung twice; or if a finer rung would take more than about
    `DECIDED_STEPS` steps.

    Parameters
    ----------
    records : with at least one row of the ladder
    """
    last, count = records.rows[-1], len(records.rows)
    if records.is_hopeless(last) or _diverges_at_any_timestep(records):
        return True
    most = DECIDED_STEPS * (2 if records.order >= HIGH_ORDER else 1)
    # If the last run has blown up, a finer one may show whether all timesteps do, so that more
    # steps are allowed.
    if 2 * last.steps > (EXCESS if count < LEAST_RUNGS or last.outcome != "ok" else 1) * most:
        return True
    errors = [max(value for _, value in row.errors) for row in records.rows[-3:] if row.errors]
    if count < MIN_RUNGS or len(errors) < 3:
        return False
    return errors[-1] <= GOAL or errors[0] < errors[1] < errors[2]


def cut_short(records: Records) -> bool:
    """Return whether the ladder ended only at the step limit, so that finer rungs are missing."""
    return records.has_ladder and not (records.rows and is_finished(records))


def _diverges_at_any_timestep(records: Records) -> bool:
    """Return whether halving the timestep has not delayed the blow-up.

    In an unstable integrator, errors grow by a factor per step that tends to 1 faster than the
    number of steps increases, so that halving delays the blow-up. A bound at which the engine cuts
    off velocities, for example, is reached at the same time at any timestep.
    """
    ends = [row.stopped_at for row in records.rows[-2:] if row.outcome == "diverged"]
    coarse, fine = ends if len(ends) == 2 else (None, None)
    return coarse is not None and fine is not None and fine <= coarse
