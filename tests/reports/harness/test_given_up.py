"""A ladder that is given up reports the timestep that would resolve it, below its last rung."""

import re

from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reports.harness.ladder import MAX_STEPS
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from studies import verdict_of


def test_what_would_tell_is_finer_than_the_ladder_where_one_signal_alone_is_out_of_reach():
    """Of Toutatis under Euler ω would soon be told; the attitude, off by half a turn, would not.

    Of the ladder alone: single steps and pieces decide it.
    """
    scene = library_scene("toutatis")
    engine = engines()["mujoco"]
    prepared = prepare(scene, [], MAX_STEPS)
    study = convergence_study_of(scene, engine, engine.method("Euler"), prepared)
    study.places = None
    verdict = verdict_of(study)
    assert (verdict.verdict, verdict.signal) == ("unresolved", "attitude")
    finest = study.ladder.rungs[-1].timestep
    assert len(study.rows) < len(study.ladder.rungs)
    needed = re.search(r"a timestep of (\S+) s would resolve it", verdict.reason)
    assert needed is not None
    assert float(needed[1]) < finest
