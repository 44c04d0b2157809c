"""What a study has to do: hard scenes are taken in passing where nobody asked for them."""

from dataclasses import replace

import pytest
from library_scenes import library_scene
from planted import Planted
from spincheck.reports.cli.run.running import scenes_of
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.ladder import MAX_STEPS, QUICK_STEPS
from spincheck.reports.harness.plan import plan
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


def test_hard_scenes_in_passing_are_run_but_not_timed(tmp_path):
    with open_store(tmp_path / "found.sqlite", create=True) as store:
        scenes = plan([HARD, PLAIN], LIBRARY, store).scenes
    assert [(scene.scenario.name, scene.to_time) for scene in scenes] == [
        (HARD.name, False),
        (PLAIN.name, True),
    ]
    assert all(scene.to_run for scene in scenes)


def test_hard_scenes_that_are_named_are_timed(tmp_path):
    with open_store(tmp_path / "found.sqlite", create=True) as store:
        (scene,) = plan([HARD], NAMED, store).scenes
    assert scene.to_time
