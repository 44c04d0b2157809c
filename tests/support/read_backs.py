"""What the run loop does before the first step of any method but one as shipped."""

from spincheck.engines import BodyReading, EngineError, State
from spincheck.engines.checks.read_back import READ_BACK_SLACK, differences
from spincheck.scenarios import Scenario


def check_read_back(scene: Scenario, held: BodyReading, state: State) -> None:
    """Raise at the first difference."""
    for difference in differences(scene, held, state, READ_BACK_SLACK):
        raise EngineError(difference.complaint)
