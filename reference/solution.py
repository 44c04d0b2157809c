"""A scene's exact motion, and how exact it is."""

from dataclasses import dataclass

from ..scenarios import Errors, Trajectory
from .taylor import IntegrationError


@dataclass(frozen=True, eq=False)
class Solution:
    """The exact motion of a scene at given times, with its uncertainty.

    Attributes
    ----------
    trajectory : the motion
    method : how it was solved, in words
    uncertainty : bound on the trajectory's own errors, in the norms that runs are judged by
    conditioning : change of the motion by a relative change of one ulp in the start and the body,
        to first order and in the worst direction. A symmetric body stays symmetric, because
        rounding in an engine's steps changes the state and not the body
    horizon : s, the first of the given times at which the uncertainty of a chaotic motion exceeds
        `MAX_UNCERTAINTY`, or the time at which a body leaves its table; the trajectory ends before
        it. None if neither happens
    lifts_off : whether the trajectory ends because the body leaves its table
    """

    trajectory: Trajectory
    method: str
    uncertainty: Errors
    conditioning: Errors
    horizon: float | None = None
    lifts_off: bool = False

    @property
    def ending(self) -> str:
        """Why the motion is only known until its horizon, in words; empty if it has no horizon."""
        if self.horizon is None:
            return ""
        if self.lifts_off:
            return f"the body leaves the table, or falls flat on it, at t = {self.horizon:.6g} s"
        return (
            f"it is chaotic, and from t = {self.horizon:.6g} s on not known to {MAX_UNCERTAINTY:g}"
        )

    def require_more_than_the_start(self) -> None:
        """Raise `IntegrationError` if the motion ends before the first time after its start."""
        if self.horizon is not None and len(self.trajectory.t) < 2:
            raise IntegrationError(
                f"no sample but the first is known: {self.ending}; "
                "shorten '[window] duration', or raise its number of samples"
            )

    def ends_before(self, duration: float) -> str:
        """Return a message that the motion is not known to the end of a window; empty if it is.

        This solution must have been computed at the times of that window: the horizon is not
        compared with `duration`.

        Parameters
        ----------
        duration : length of the window, s, which the message states
        """
        if self.horizon is None:
            return ""
        return (
            f"{self.ending}, before the window ends at {duration:g} s: nothing is compared from "
            "there on; shorten '[window] duration'"
        )


#: A motion whose uncertainty is larger than this, relative or in rad, is not used as a reference.
MAX_UNCERTAINTY = 1e-9
