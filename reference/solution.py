"""A scene's exact motion, and how exact it is."""

from dataclasses import dataclass

from ..scenarios import Errors, Trajectory


@dataclass(frozen=True, eq=False)
class Solution:
    """The exact motion of a scene at given times, with its uncertainty.

    Attributes
    ----------
    trajectory : the motion
    method : how it was solved, in words
    uncertainty : bound on its own errors, in the norms that runs are judged by
    conditioning : what a relative change of one ulp in the start and the body does to the motion,
        to first order and in its worst direction. Symmetric bodies stay symmetric: rounding, step
        by step, changes states and not the body
    horizon : s, the time at which the uncertainty of a chaotic motion exceeds `MAX_UNCERTAINTY`;
        the trajectory ends before it. None where it never does
    """

    trajectory: Trajectory
    method: str
    uncertainty: Errors
    conditioning: Errors
    horizon: float | None = None


#: A motion whose uncertainty is larger than this, relative or in rad, is not used as a reference.
MAX_UNCERTAINTY = 1e-9
