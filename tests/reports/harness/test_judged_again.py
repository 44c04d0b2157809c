"""A changed threshold or sentence judges stored ladders again, with no run."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from box import BOX
from planted import HeunSession, RaisingSession, planted
from spincheck.engines import Engine, Method, Session
from spincheck.reports.harness import study
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.judging import ladder_end
from spincheck.reports.results import fingerprints
from spincheck.reports.results.evidence import StepEvidence
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario, loads
from studies import study as study_of

pytestmark = pytest.mark.slow

#: Steps; Heun's method in Python takes some 30 µs each.
BUDGET = 1 << 9
ENGINES = (planted(HeunSession), planted(RaisingSession))
#: Errors that need no finer rung.
EASY = 1e-2
LADDER = Choice(ENGINES, max_steps=BUDGET, timed=False)


@pytest.fixture
def opened(monkeypatch) -> list[float]:
    """The timesteps that engines were opened with: of runs, single steps, replays and restarts."""
    timesteps: list[float] = []

    def counting(kind: type[Engine]) -> Callable[..., Session]:
        open_with = kind.open

        def opening(engine: Engine, scene: Scenario, method: Method, timestep: float) -> Session:
            timesteps.append(timestep)
            return open_with(engine, scene, method, timestep)

        return opening

    for kind in {type(engine) for engine in ENGINES}:
        monkeypatch.setattr(kind, "open", counting(kind))
    return timesteps


def verdicts(path: Path) -> list[Verdict]:
    return study_of(path, [loads(BOX, "box")], LADDER).verdicts


def nothing_is_known(patch: pytest.MonkeyPatch) -> None:
    """No limit is known well enough for a verdict."""
    patch.setattr(StepEvidence, "is_known", property(lambda _: False))


def judging_is_another(patch: pytest.MonkeyPatch) -> None:
    program: Callable[[str], str] = fingerprints.program
    patch.setattr(
        fingerprints, "program", lambda kind: program(kind) + "another" * (kind == "verdict")
    )


def test_a_changed_threshold_changes_the_verdict_without_a_run(path, monkeypatch, opened):
    with monkeypatch.context() as patch:
        nothing_is_known(patch)
        judging_is_another(patch)
        assert verdicts(path)[0].verdict == "unresolved"
    assert opened
    opened.clear()
    again = verdicts(path)
    assert (opened, again[0].verdict) == ([], "converges")
    assert again == verdicts(path.with_name("fresh.sqlite"))


def test_a_ladder_that_a_changed_threshold_makes_longer_is_run(path, monkeypatch, opened):
    choice = Choice(ENGINES[:1], max_steps=1 << 14, timed=False)
    scenes = [loads(BOX, "box")]
    with monkeypatch.context() as patch:
        patch.setattr(ladder_end, "GOAL", EASY)
        short = study_of(path, scenes, choice)
    assert opened
    opened.clear()
    judging_is_another(monkeypatch)
    longer = study_of(path, scenes, choice)
    assert len(longer.rows) > len(short.rows)
    assert opened
    assert longer.verdicts == study_of(path.with_name("fresh.sqlite"), scenes, choice).verdicts


def test_a_longer_ladder_takes_no_steps_from_exact_states_again(path, monkeypatch):
    choice, scenes = replace(LADDER, max_steps=1 << 12), [loads(BOX, "box")]
    fresh = study_of(path.with_name("fresh.sqlite"), scenes, choice)
    short = study_of(path, scenes, LADDER)
    monkeypatch.setattr(study, "examine_or_refuse", None)
    longer = study_of(path, scenes, choice)
    assert len(longer.rows) > len(short.rows)
    assert longer.verdicts == fresh.verdicts
