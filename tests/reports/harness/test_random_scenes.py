"""The bench of random scenes: some scenes of it, and what it counts."""

import measure_random
import pytest
from kinds_of_engines import installed
from measure_random import Counts, is_wrong, measured, random_scene
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.evidence import LEVEL, ReplayEvidence, StepEvidence
from spincheck.reports.results.records import Key
from spincheck.reports.results.verdicts import Verdict
from studies import verdict_of

pytestmark = pytest.mark.slow

#: Scenes that are run; `make random` runs a thousand.
FEW = 2
KEY = Key("random-0", "engine", "method")
STEPS = StepEvidence(3, 0.5, 0.0, 0.0, 1)


@pytest.fixture(scope="module")
def counts() -> Counts:
    return measured(range(FEW))


def test_no_honest_method_is_accused_on_some_random_scenes(counts: Counts) -> None:
    assert counts.wrong == []
    assert counts.scenes == FEW
    # Of the engines that are always there.
    assert sum(counts.words.values()) >= 3 * FEW


@pytest.mark.parametrize(
    ("number", "name", "method"),
    [
        (418, "mujoco", "RK4"),
        # One state is near the pole of roll, pitch and yaw.
        (409, "drake", "runge_kutta3"),
        (112, "drake", "runge_kutta3"),
        # Coarse steps cross that pole: rounding of the attitude grows 1e7 times, of ω less.
        (2279, "drake", "runge_kutta3"),
        # Drag is stiff, and short steps are computed otherwise.
        (515, "dartpy", "semi-implicit"),
        (336, "dartpy", "semi-implicit"),
        (564, "dartpy", "semi-implicit"),
        # What is short is what a step turns the body by, and not its rate before the step.
        (2436, "dartpy", "semi-implicit"),
        # A body nearly at rest has a limit in another quantity, which a series explains as well.
        (2660, "dartpy", "semi-implicit"),
        # Rounding of the force on a fast body turns it as well.
        (200, "mujoco", "RK4"),
    ],
)
def test_honest_methods_that_were_accused_are_not(number: int, name: str, method: str) -> None:
    engine, scene = installed(name), random_scene(number)
    prepared = prepare(scene, [], measure_random.MOST_STEPS)
    study = convergence_study_of(scene, engine, engine.method(method), prepared)
    verdict = verdict_of(study)
    assert verdict.verdict in ("converges", "diverges")
    assert verdict.tail is not None
    assert verdict.tail > 10 * LEVEL


def test_scenes_are_of_wide_ranges() -> None:
    scenes = [random_scene(number) for number in range(100)]
    assert random_scene(7).text == scenes[7].text
    sets = {frozenset(scene.called_for) for scene in scenes}
    assert len(sets) > 16
    stretched = [
        max(moments) / min(moments) for moments in (s.body.principal_moments for s in scenes)
    ]
    assert max(stretched) > 50 > 2 > min(stretched)


def test_parts_that_are_kept_are_joined(counts: Counts) -> None:
    assert Counts.read(counts.written) == counts
    both = counts.joined(counts)
    assert both.scenes == 2 * FEW
    assert both.tails == sorted(both.tails)


def test_the_page_has_what_was_counted(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(measure_random, "PAGES", tmp_path)
    monkeypatch.setattr(measure_random, "METHODS", (("mujoco", "RK4"),))
    for first in ("0", "1"):
        assert measure_random.main(["1", first]) == 0
    page = (tmp_path / "random-scenes.md").read_text(encoding="utf-8")
    assert "from 2 scenes" in page
    assert "False accusations (`disagrees` or `failed`): 0." in page
    assert "| mujoco RK4 | 2 |" in page


@pytest.mark.parametrize("word", ["disagrees", "failed"])
def test_an_accusation_is_counted_with_its_tail(word: str) -> None:
    counts = Counts()
    counts.add(Verdict(KEY, "converges", "", STEPS))
    unlikely = (ReplayEvidence(0.1, 4, 1e-20, 1e-3),)
    accusing = Verdict(KEY, word, "why", STEPS, replays=unlikely)
    counts.add(accusing)
    assert is_wrong(accusing)
    assert counts.tails[0] == (2e-20, "random-0", "engine method")
    assert len(counts.wrong) == 1
    assert counts.wrong[0].startswith(f"random-0, engine method: {word}: ")
