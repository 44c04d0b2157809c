"""Where a ladder ends: it shows what errors come to and cost, and when a method blows up."""

from ..timesteps.ladder import DECIDED_STEPS, EXCESS, LEAST_RUNGS, MIN_RUNGS
from .records import Records

#: Errors below this, relative or in rad, in every signal need no finer rung.
GOAL = 1e-9
#: From this order on ladders are twice as long: errors are far below what others come to.
HIGH_ORDER = 4


def is_down(records: Records) -> bool:
    """Whether the ladder ends here: no finer rung is needed, or none can succeed.

    There must be a row.
    """
    last, count = records.rows[-1], len(records.rows)
    if records.is_hopeless(last) or _diverges_at_any_timestep(records):
        return True
    most = DECIDED_STEPS * (2 if records.order >= HIGH_ORDER else 1)
    # Where a run blew up a finer one may tell whether the method does.
    if 2 * last.steps > (EXCESS if count < LEAST_RUNGS or last.outcome != "ok" else 1) * most:
        return True
    errors = [max(value for _, value in row.errors) for row in records.rows[-3:] if row.errors]
    if count < MIN_RUNGS or len(errors) < 3:
        return False
    return errors[-1] <= GOAL or errors[0] < errors[1] < errors[2]


def cut_short(records: Records) -> bool:
    """Whether finer rungs would have been run if the step limit allowed them."""
    return records.has_ladder and not (records.rows and is_down(records))


def _diverges_at_any_timestep(records: Records) -> bool:
    """Whether the blow-up comes at the same time after the timestep was halved.

    In an unstable integrator, errors grow by a factor a step that tends to 1 faster than the number
    of steps increases, so halving delays the blow-up. A clamp is reached at the same time.
    """
    ends = [row.stopped_at for row in records.rows[-2:] if row.outcome == "diverged"]
    coarse, fine = ends if len(ends) == 2 else (None, None)
    return coarse is not None and fine is not None and fine <= coarse
