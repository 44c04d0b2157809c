"""Expected failures in a scene's file pass while they occur, and are reported when gone."""

from dataclasses import replace

import pytest
from kinds_of_engines import why_missing
from spincheck.engines import engines
from spincheck.reports.harness.judging.expected_failures import compared_with_expected_failures
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from spincheck.reports.results.records import Key
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Known, find, load
from studies import verdict_of

KEY = Key("scene", "engine", "method")
FAULT = Known(engine="engine", method="method", verdict="disagrees", reason="it creeps on")


def held(word: str, key: Key = KEY) -> Verdict:
    return compared_with_expected_failures([FAULT], Verdict(key, word, "as found"))


def test_a_known_disagreement_passes_and_says_why_and_is_reported_when_it_is_gone():
    verdict = held("disagrees")
    assert verdict.agrees
    assert verdict.reason == "as found; known: it creeps on"
    # Others are not excused.
    for other in ("engine", "method"):
        assert not held("disagrees", replace(KEY, **{other: "another"})).agrees
    verdict = held("converges")
    assert not verdict.agrees
    assert verdict.unmet == ("it converges; delete the [[known]] that it disagrees: it creeps on",)


@pytest.mark.parametrize("word", ["unresolved", "diverges", "unsupported"])
def test_an_unresolved_ladder_says_nothing_of_it_and_a_crash_is_no_known_disagreement(word):
    assert held(word) == Verdict(KEY, word, "as found")
    assert not held("failed").agrees


KNOWN = [(scene, fault) for scene in map(load, find(["hard"])) for fault in scene.document.known]


@pytest.mark.parametrize(
    ("scene", "fault"), KNOWN, ids=[f"{scene.name}-{fault.engine}" for scene, fault in KNOWN]
)
def test_what_the_library_knows_of_engines_is_so(scene, fault):
    if reason := why_missing(fault.engine):
        pytest.skip(reason)
    engine, prepared = engines()[fault.engine], prepare(scene, [], QUICK_STEPS)
    study = convergence_study_of(scene, engine, engine.method(fault.method), prepared)
    assert verdict_of(study).expected_failure
