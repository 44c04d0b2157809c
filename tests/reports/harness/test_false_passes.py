"""No planted fault converges, whenever and wherever it acts; no honest engine is called wrong.

An honest engine is stepped with one fault at a time (`stepped_faults`). At first order each is told
as well, though the method's own error is larger than most of them.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial

import pytest
import stepped_faults as planted
from library_scenes import library_scene
from spincheck.reports.harness import study
from spincheck.reports.harness.measuring.examine import examine_or_refuse
from spincheck.reports.harness.prepared import Prepared, prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario, loads
from stepped import METHODS, Stepped, SteppedEngine
from studies import verdict_of
from top_scenes import scene

pytestmark = pytest.mark.slow

#: Of the longest run.
MOST_STEPS = 1 << 12

BOOK, TOP = "book-middle-axis", "nutation-loops"
#: Kinds of faults, by the scene that each acts on, with sizes.
FAULTS = [
    (BOOK, planted.ButForTinySteps, 1e-3),
    (BOOK, planted.AtFineSteps, 1e-3),
    (BOOK, planted.InShortSteps, 1e-5),
    (BOOK, planted.InStepsBelowTwiceThat, 1e-3),
    (BOOK, planted.InStepsBelowSevenTimesThat, 1e-3),
    (BOOK, planted.InOneShortStep, 1e-9),
    (BOOK, planted.InAnotherShortStep, 1e-9),
    (BOOK, planted.AtTwoMilliseconds, 1e-3),
    (BOOK, planted.FromHalfway, 1e-5),
    (BOOK, planted.InOneInterval, 1e-3),
    (BOOK, planted.InTheLastTenth, 1e-4),
    (BOOK, planted.InAnOctant, 1e-4),
    (BOOK, planted.InAnOctantOfOmega, 1e-4),
    (BOOK, planted.AtOneAttitude, 1e-2),
    (BOOK, planted.AboveASpeed, 1e-4),
    (BOOK, planted.EveryThousandthStep, 1e-4),
    (BOOK, planted.AfterAHundredSteps, 1e-4),
    (BOOK, planted.InLongStrides, 1e-4),
    (BOOK, planted.ByChanceARun, 1e-3),
    (BOOK, planted.WrongWhenOpenedTwice, 1e-3),
    (BOOK, planted.Slowed, 1e-5),
    (BOOK, planted.SmoothlyLater, 1e-4),
    (BOOK, planted.LeavesOneGyroscopicTermOut, 1e-4),
    (BOOK, planted.Remembers, 1e-3),
    (BOOK, planted.Jumps, 0.1),
    (BOOK, planted.Jumps, 1e-3),
    (BOOK, planted.JumpsInTheLastStep, 1e-3),
    (BOOK, planted.JumpsOnceByChance, 1e-3),
    (BOOK, planted.Clamped, -0.05),
    (BOOK, planted.AnotherMoment, 1e-5),
    (BOOK, planted.AMomentBySignOfTheRung, 1e-5),
    (BOOK, planted.AMomentByChance, 1e-3),
    (BOOK, planted.AMomentAtFineSteps, 1e-5),
    (BOOK, planted.TurnsTooFar, 1e-5),
    (BOOK, planted.SkipsSteps, 1e-2),
    (BOOK, planted.HalfAnOrder, 1e-2),
    (BOOK, planted.HalfAnOrder, 1e-6),
    (BOOK, planted.ReadsConjugated, 1.0),
    (BOOK, planted.ReadsPermuted, 1.0),
    (BOOK, planted.ReadsScattered, 1e-4),
    (BOOK, planted.ReadsOmegaOff, 1e-5),
    (BOOK, planted.ReadsOmegaDrifting, 1e-4),
    (BOOK, planted.ReadsTurned, 1e-4),
    (BOOK, planted.ComJumps, 1e-3),
    (BOOK, planted.Single, 1e-3),
    (TOP, planted.GravityInclined, 1e-4),
    ("tiring-top", planted.FallsAsleep, 0.8),
]
#: At fourth order these are faults; at first order they are as good as the method.
OF_FIRST_ORDER = [
    (BOOK, planted.LagsAStep, 1.0),
    (BOOK, planted.ForgetsWithTheTimestep, 0.1),
    (BOOK, planted.EulerLater, 1.0),
]
#: Their limits are right: what is wrong are some of the longest steps, or steps of one length.
NOT_DETECTED = [
    (planted.InTheLongestSteps, 1e-3),
    (planted.InLongSteps, 1e-3),
]

#: Of an engine as shipped, on a motion that no run follows to its end.
CHAOS = "chaos-beyond-the-horizon"
OF_AN_ENGINE_AS_SHIPPED = [
    (planted.Remembers, 1e-3),
    (planted.FromHalfway, 1e-3),
    (planted.Jumps, 0.1),
    (planted.EveryThousandthStep, 1e-4),
    (planted.AfterAHundredSteps, 1e-4),
    (planted.AnotherMoment, 1e-5),
    (planted.ReadsScattered, 1e-4),
]

HONEST_SCENES = [BOOK, TOP, CHAOS, "drag-until-rest", "flying-disc"]
#: With the methods that each is stepped by: noise and rounding are alike in all, and of noise less
#: is hidden by the method's own error at fourth order.
HONEST = [
    (Stepped, 0.0, {}, ("Euler", "Heun", "RK4")),
    (planted.Noisy, 1e-12, {}, ("RK4",)),
    (planted.HonestSingle, 0.0, {"single_precision": True}, ("Euler", "RK4")),
]


@pytest.fixture(autouse=True, scope="module")
def _nothing_is_explained() -> Iterator[None]:
    """Verdicts are looked at, and not the words of what would explain them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "examine_or_refuse", partial(examine_or_refuse, explains=False))
        yield


@cache
def prepared(name: str) -> tuple[Scenario, Prepared]:
    scenario = library_scene(name)
    return scenario, prepare(scenario, (), MOST_STEPS)


def judged(name: str, kind: type[Stepped], size: float, method: str, **as_if: object) -> Verdict:
    planted.begin()
    engine = SteppedEngine(kind, size, **as_if)
    scenario, solved = prepared(name)
    return verdict_of(convergence_study_of(scenario, engine, engine.method(method), solved))


def kind_of(value: object) -> str | None:
    return value.__name__ if isinstance(value, type) else None


@pytest.mark.parametrize(("name", "kind", "size"), [*FAULTS, *OF_FIRST_ORDER], ids=kind_of)
def test_at_fourth_order_every_fault_is_told(name: str, kind: type[Stepped], size: float) -> None:
    verdict = judged(name, kind, size, "RK4")
    assert verdict.verdict in ("disagrees", "failed"), verdict.reason


@pytest.mark.parametrize(("name", "kind", "size"), FAULTS, ids=kind_of)
def test_at_first_order_every_fault_is_told(name: str, kind: type[Stepped], size: float) -> None:
    verdict = judged(name, kind, size, "Euler")
    assert verdict.verdict in ("disagrees", "failed"), verdict.reason


@pytest.mark.parametrize(("name", "kind", "size"), OF_FIRST_ORDER, ids=kind_of)
def test_at_first_order_what_vanishes_so_is_no_fault(
    name: str, kind: type[Stepped], size: float
) -> None:
    verdict = judged(name, kind, size, "Euler")
    assert verdict.verdict == "converges", verdict.reason


@pytest.mark.parametrize("method", ["Euler", "RK4"])
@pytest.mark.parametrize(("kind", "size"), NOT_DETECTED, ids=kind_of)
def test_what_a_method_may_do_in_its_longest_or_shortest_steps_is_not_detected(
    kind: type[Stepped], size: float, method: str
) -> None:
    """Long steps are beyond a series' radius, and a method may compute the shortest otherwise."""
    verdict = judged(BOOK, kind, size, method)
    assert verdict.verdict == "converges", verdict.reason


@pytest.mark.parametrize(
    ("kind", "size", "as_if", "method"),
    [(*honest, method) for *honest, methods in HONEST for method in methods],
    ids=kind_of,
)
@pytest.mark.parametrize("name", HONEST_SCENES)
def test_no_honest_engine_is_called_wrong(
    name: str, kind: type[Stepped], size: float, as_if: dict[str, object], method: str
) -> None:
    verdict = judged(name, kind, size, method, **as_if)
    assert verdict.verdict in ("converges", "unresolved"), verdict.reason


#: Its drag stops it within a few of the coarsest steps.
STIFF_DRAG = scene(
    "mass = 1.78\ninertia = [0.504, 0.44, 0.0679]\ncom = [0.173, -0.0106, 0.0754]",
    "rotation_vector_deg = [-72.7, 6.02, -87.9]\nomega_body = [5.67, -5.79, 2.68]",
    "[effects.pivot]\n[effects.drag]\nrotational = 16.0\n"
    "[effects.torque]\nbody = [0.91, 40.9, 10.7]",
    "duration = 6.08\nsamples = 41",
)


def test_a_formula_for_small_turns_is_no_physics_that_depends_on_the_timestep() -> None:
    engine = SteppedEngine(planted.TruncatesSmallTurns, 1e-3)
    solved = prepare(STIFF_DRAG, (), MOST_STEPS)
    verdict = verdict_of(convergence_study_of(STIFF_DRAG, engine, engine.method("Euler"), solved))
    assert verdict.verdict == "converges", verdict.reason


#: Its moments differ by a factor of 2 500; those of the other by one of 10 000, so that rounding to
#: 24 bits changes its angular acceleration by more than what is to be known.
PENDULUM = "pendulum-over-by-a-millionth"
THICK, THIN = "0.0001220703125", "0.000030517578125"


def judged_in_single(kind: type[Stepped], size: float, *, is_thin: bool) -> Verdict:
    planted.begin()
    text = library_scene(PENDULUM).text
    assert THICK in text
    scenario = loads(text.replace(THICK, THIN) if is_thin else text, PENDULUM)
    engine = SteppedEngine(kind, size, single_precision=True)
    solved = prepare(scenario, (), MOST_STEPS)
    return verdict_of(convergence_study_of(scenario, engine, engine.method("Euler"), solved))


@pytest.mark.parametrize(
    ("kind", "size", "verdicts"),
    [
        (planted.HonestSingle, 0.0, ("converges", "unsupported")),
        (planted.LeavesOneGyroscopicTermOut, 1.0, ("disagrees", "disagrees")),
        (planted.GravityInclined, 1.0, ("disagrees", "disagrees")),
        (planted.Jumps, 1.0, ("disagrees", "disagrees")),
    ],
    ids=kind_of,
)
def test_a_body_that_single_precision_does_not_hold_is_no_reason_to_accuse_an_engine(
    kind: type[Stepped], size: float, verdicts: tuple[str, str]
) -> None:
    for verdict, is_thin in zip(verdicts, (False, True), strict=True):
        found = judged_in_single(kind, size, is_thin=is_thin)
        assert found.verdict == verdict, found.reason
        assert ("in single precision" in found.reason) == (verdict == "unsupported")


def as_shipped(kind: type[Stepped], size: float) -> Verdict:
    methods = tuple(replace(method, as_shipped=True) for method in METHODS)
    return judged(CHAOS, kind, size, "RK4", methods=methods)


def test_an_honest_engine_as_shipped_converges_where_motion_is_chaotic() -> None:
    verdict = as_shipped(Stepped, 0.0)
    assert verdict.verdict == "converges", verdict.reason


@pytest.mark.parametrize(("kind", "size"), OF_AN_ENGINE_AS_SHIPPED, ids=kind_of)
def test_every_fault_of_an_engine_as_shipped_is_told(kind: type[Stepped], size: float) -> None:
    verdict = as_shipped(kind, size)
    assert verdict.verdict == "disagrees", verdict.reason
