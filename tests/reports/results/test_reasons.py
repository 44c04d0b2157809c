"""The words of a verdict's reason."""

from spincheck.reports.results.evidence import ReplayEvidence, StepEvidence, StepFault
from spincheck.reports.results.reasons import fault_in_words, reason_in_words


def test_a_fault_that_a_run_tells_is_not_told_twice() -> None:
    fault = StepFault("limit", "attitude", 0.0, 1e-3, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), ())
    steps = StepEvidence(3, 0.0, 0.0, 0.0, 1, fault=fault)
    told = fault_in_words(fault)
    assert reason_in_words("disagrees", "it blew up", steps, None, ()) == f"{told}; it blew up"
    quoted = f"it blew up; {told}"
    assert reason_in_words("disagrees", quoted, steps, None, ()) == quoted


def test_what_is_open_is_told_before_what_acts_besides() -> None:
    steps = StepEvidence(3, 1.0, 0.06, 0.0, 1)
    reason = reason_in_words("unresolved", "damping acts", steps, None, ())
    assert reason.startswith("the limit of what steps gain is known to 0.06 of the largest terms")
    assert reason.endswith("; damping acts")


def test_what_replays_of_several_timesteps_show_alike_is_said_once():
    replays = [
        ReplayEvidence(timestep, 40, 0.2, 1e-3, order=1, declared=4) for timestep in (1e-3, 1e-4)
    ]
    reason = reason_in_words("disagrees", "", None, None, replays)
    assert reason.count("a step depends on more than the state") == 1
