"""The exact motion at the times of a recording."""

from .....reference import ExactMotion, IntegrationError, Solution
from .....scenarios import FloatArray, Misfit, Scenario, check_scales
from .recording import RecordingError

#: Largest time, in durations of the scene's window. Later times must be in another unit than s, and
#: the motion would take long to solve. Times in ms reach 1000 windows, and are recognised as ms.
MOST_WINDOWS = 2000


def exact_at(scenario: Scenario, times: FloatArray) -> Solution:
    """Return the exact motion of a scene at n given times, s, (n,).

    Raises
    ------
    RecordingError
        If the exact motion is not known at all of these times, or if the last one is later than
        `MOST_WINDOWS` windows of the scene, so that the times must be in another unit than s.
    """
    windows = float(times[-1]) / scenario.window.duration
    if windows > MOST_WINDOWS:
        raise RecordingError(
            f"its times reach {times[-1]:.6g} s, {windows:.3g} times the "
            f"{scenario.window.duration:g} s of {scenario.name}; they must be counted from its "
            "start, and another unit than s named in the heading, such as t [us]"
        )
    try:
        check_scales(scenario, until=max(scenario.window.duration, float(times[-1])))
        solution = ExactMotion(scenario).solve(times)
    except (Misfit, IntegrationError) as error:
        raise RecordingError(f"{scenario.name} until {times[-1]:g} s: {error}") from None
    known = len(solution.trajectory.t)
    if known < len(times):
        raise RecordingError(
            f"the exact motion of {scenario.name} is not known at sample {known + 1}, at "
            f"{times[known]:.6g} s: {solution.ending}; leave out what comes after"
        )
    return solution
