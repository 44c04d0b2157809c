"""A run says at its start which engines it uses, and an estimate that grows with their steps."""

import os
from dataclasses import replace

import pytest
from spincheck.engines import engines
from spincheck.reports.cli.run.running import announcement
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.ladder import QUICK_STEPS
from spincheck.reports.harness.plan import Plan, SceneLeft
from spincheck.suite.contract_scenes import SCENES

CHOICE = Choice((engines()["mujoco"], engines()["pybullet"]), max_steps=QUICK_STEPS)


def plan(scenes: int = 1, *, timed: bool = False) -> Plan:
    pairs = [(engine, engine.methods[0]) for engine in CHOICE.engines]
    scene_left = SceneLeft(SCENES["free"], pairs, to_time=timed)
    return Plan([scene_left] * scenes, 0, 0)


def minutes(choice: Choice) -> int:
    return int(announcement(plan(100_000), choice, 1).partition("roughly ")[2].split()[0])


def test_it_names_the_engines_and_counts_what_is_to_be_made_as_the_progress() -> None:
    words = announcement(plan(), CHOICE, 2)
    assert words.startswith("2 verdicts of 2 engines (mujoco, pybullet) on 1 scene: roughly ")
    assert announcement(Plan([], 3, 0), CHOICE, 2) == ""
    left = plan(3, timed=True)
    words = announcement(left, CHOICE, 2)
    assert left.total == 6 + 3
    assert words.startswith("6 verdicts of ")
    assert " on 3 scenes, and 3 scenes to be timed: roughly " in words


def test_of_a_cluster_no_time_is_estimated() -> None:
    assert (
        announcement(plan(), CHOICE, None)
        == "2 verdicts of 2 engines (mujoco, pybullet) on 1 scene"
    )


def test_many_scenes_are_reported_in_minutes_and_longer_ladders_take_more() -> None:
    assert "min with 2 workers" in announcement(plan(2000), CHOICE, 2)
    assert minutes(replace(CHOICE, max_steps=2 * QUICK_STEPS)) > minutes(CHOICE)


def test_on_a_busy_machine_it_takes_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    estimates = []
    for load in (0.0, 3.0, 15.0):
        monkeypatch.setattr(os, "getloadavg", lambda load=load: (load, load, load))
        estimates.append(minutes(CHOICE))
    idle, almost_full, four_to_a_core = estimates
    assert idle == almost_full
    assert four_to_a_core == pytest.approx(4 * idle, rel=0.1)
