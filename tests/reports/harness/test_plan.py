"""What a study has to do: hard scenes are taken in passing where nobody asked for them."""

from dataclasses import replace

import pytest
from library_scenes import library_scene
from planted import Planted
from spincheck.reports.cli.run.running import scenes_of
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.timesteps.ladder import MAX_STEPS, QUICK_STEPS
from spincheck.reports.results.store import open_store

HARD, PLAIN = (library_scene(name) for name in ("toutatis", "tennis-racket"))
NAMED = Choice((Planted(),))
LIBRARY = replace(NAMED, hard_in_passing=True)


@pytest.mark.parametrize(
    ("choice", "scenario", "steps"),
    [
        (LIBRARY, HARD, QUICK_STEPS),
        (LIBRARY, PLAIN, MAX_STEPS),
        (NAMED, HARD, MAX_STEPS),
        (replace(LIBRARY, max_steps=QUICK_STEPS // 2), HARD, QUICK_STEPS // 2),
    ],
    ids=["in passing", "not hard", "named", "quicker still"],
)
def test_a_ladder_is_as_long_as_asked_for(choice, scenario, steps):
    assert choice.max_steps_on(scenario) == steps


def test_a_quick_run_leaves_hard_scenes_out_unless_they_are_named():
    everything, quick = (scenes_of([], quick=quick) for quick in (False, True))
    assert [scene.name for scene in quick] == [s.name for s in everything if not s.hard]
    assert len(quick) < len(everything)
    assert [scene.name for scene in scenes_of(["toutatis"], quick=True)] == ["toutatis"]


def test_hard_scenes_in_passing_are_run_but_not_timed_unless_they_are_named(path):
    with open_store(path, create=True) as store:
        hard, plain = plan([HARD, PLAIN], LIBRARY, store).scenes
        (named,) = plan([HARD], NAMED, store).scenes
    assert (hard.scenario.name, plain.scenario.name) == (HARD.name, PLAIN.name)
    assert (hard.to_time, plain.to_time, named.to_time) == (False, True, True)
    assert hard.to_run
    assert plain.to_run
