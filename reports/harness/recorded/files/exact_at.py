"""The exact motion at the times of a recording."""

from .....reference import ExactMotion, IntegrationError, Solution
from .....scenarios import FloatArray, Misfit, Scenario, check_scales
from .recording import RecordingError

#: Largest time, in windows of the scene. Longer times are in another unit than s, and would take
#: long to solve; times of one window in ms reach 1000 windows, and are explained.
MOST_WINDOWS = 2000


def exact_at(scenario: Scenario, times: FloatArray) -> Solution:
    """Return the exact motion at given times, s, (n,).

    Raises
    ------
    RecordingError
        If the motion is not known up to the last time, or the times are in another unit.
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
