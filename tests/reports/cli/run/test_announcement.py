"""A run says at its start which engines it uses and what is to be made."""

from spincheck.engines import engines
from spincheck.reports.cli.run.running import announcement
from spincheck.reports.harness.plan import Plan, SceneLeft
from spincheck.suite.contract_scenes import SCENES


def plan(*names: str, scenes: int = 1, timed: bool = False) -> Plan:
    pairs = [(engines()[name], engines()[name].methods[0]) for name in names]
    return Plan([SceneLeft(SCENES["free"], pairs, to_time=timed)] * scenes, 0, 0)


def test_it_names_the_engines_and_counts_what_is_to_be_made_as_the_progress() -> None:
    left = plan("mujoco", "pybullet", scenes=3, timed=True)
    assert left.total == 6 + 3
    assert announcement(left) == (
        "6 verdicts of 2 engines (mujoco, pybullet) on 3 scenes, and 3 scenes to be timed"
    )
    # One at most is not announced.
    assert announcement(Plan([], 3, 0)) == announcement(plan("mujoco")) == ""
