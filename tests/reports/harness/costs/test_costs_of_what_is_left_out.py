"""What steps cost with what engines leave out is measured, and whether that changes the motion.

That it does not, of MuJoCo and PyBullet, is verified in `engines/test_left_out`.
"""

from collections.abc import Collection
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
from clockwork import METHOD, SCENE, Clock, Clockwork, Works, steadily
from kinds_of_engines import required_engines
from library_scenes import library_scene
from spincheck.engines import Engine, EngineError, Method, State
from spincheck.reports.harness.costs import step_cost as cost
from spincheck.reports.harness.costs.left_out import (
    MOST_STEPS,
    motions_apart,
    with_all_left_in,
)
from spincheck.reports.harness.costs.step_cost import step_costs
from spincheck.reports.results.cost_records import Ratio
from spincheck.scenarios import Scenario

#: s a step with nothing left in.
TAKES = 3e-6
#: What each pass adds to that by itself, as a part of it.
PASSES = {"contact": 0.25, "sensor": 0.0625}
#: Two stretches are compared, each off by a tick at either end.
TICK = 4 / cost.RESOLUTIONS


def priced(clock: Clock, **unpruned: float) -> Works:
    """An engine that charges for what is left in; unpruned, it may behave otherwise besides."""

    def make(left_in: Collection[str]) -> Clockwork:
        price = 1 + sum(PASSES[name] for name in left_in)
        return Clockwork(clock, steadily(TAKES * price), **(unpruned if left_in else {}))

    return Works(make, tuple(PASSES))


def ratio(engine: Engine) -> Ratio | None:
    """What a step takes with all left in, over that of the engine as it is."""
    pairs = [(engine, METHOD)]
    plain, whole = step_costs(SCENE, [*pairs, *with_all_left_in(SCENE, pairs)])
    assert plain is not None
    assert plain.ratio is None
    return whole and whole.ratio


def test_all_that_is_left_out_has_its_price(clock: Clock) -> None:
    measured = ratio(priced(clock))
    assert measured is not None
    assert measured.median == pytest.approx(1 + sum(PASSES.values()), rel=TICK)
    assert measured.spread <= TICK
    # Without the cheapest of the passes it would be told apart.
    assert min(PASSES.values()) > TICK


def test_one_disturbed_round_does_not_change_the_ratio(clock: Clock) -> None:
    expected = 1 + sum(PASSES.values())
    stretches: list[int] = []

    def make(left_in: Collection[str]) -> Clockwork:
        def seconds(steps: int, _: int) -> float:
            price = expected if left_in else 1.0
            if steps * TAKES < cost.STRETCH:
                return steps * TAKES * price
            stretches.append(steps)
            # Of those that are long enough, two find how many steps that takes.
            return steps * TAKES * price * (10 if len(stretches) == 5 else 1)

        return Clockwork(clock, seconds)

    pairs = [(engine := Works(make, tuple(PASSES)), METHOD)]
    _, charged = step_costs(SCENE, [*pairs, *with_all_left_in(SCENE, pairs)])
    assert engine.left_out(SCENE, METHOD)
    assert charged.ratio.median == pytest.approx(expected, rel=TICK)
    assert len(stretches) > 5


def test_the_spread_of_the_ratio_is_between_its_quartiles(clock: Clock) -> None:
    noise = cycle([1.5, 1.0, 1.25])

    def make(left_in: Collection[str]) -> Clockwork:
        return Clockwork(clock, lambda n, _: n * TAKES * (next(noise) if left_in else 1.0))

    measured = ratio(Works(make, tuple(PASSES)))
    assert measured.median == pytest.approx(1.25, rel=TICK)
    assert measured.spread == pytest.approx(0.5, rel=4 * TICK)


def apart(engine: Engine, method: Method = METHOD, scene: Scenario = SCENE) -> object:
    """The time until which motions were compared, and how far they are apart."""
    ((varied, _),) = with_all_left_in(scene, [(engine, method)])
    return motions_apart(scene, varied, method.name)


def test_a_motion_is_the_same_to_the_last_bit_or_another_as_far_as_both_go(clock: Clock) -> None:
    assert apart(priced(clock)) == (SCENE.window.duration, 0.0)
    until, difference = apart(priced(clock, drift=2.0**-52))
    assert difference > 0
    assert round(difference / 2.0**-52) == difference / 2.0**-52
    assert until == SCENE.window.duration
    until, difference = apart(priced(clock, gives_up_after=8))
    assert 0 < until < SCENE.window.duration
    assert difference == 0.0


class DeviatesAtFirst(Clockwork):
    """For eight steps, if it drifts."""

    def read_state(self) -> State:
        omega = np.array([0.0, 0.0, 1.0 + self.drift * (self.steps <= 8)])
        return replace(super().read_state(), omega_body=omega)


def test_motions_that_meet_again_are_told_apart_and_fast_ones_take_no_longer(clock: Clock) -> None:
    opened: list[Clockwork] = []

    def make(left_in: Collection[str]) -> Clockwork:
        opened.append(DeviatesAtFirst(clock, steadily(TAKES), drift=float(bool(left_in))))
        return opened[-1]

    engine, fast = Works(make, tuple(PASSES)), library_scene("gyroscope-at-24000-rpm")
    assert apart(engine) == (SCENE.window.duration, 1.0)
    apart(engine, scene=fast)
    assert [session.steps for session in opened[-2:]] == [MOST_STEPS] * 2


def test_where_it_does_not_load_with_what_is_left_out_there_is_nothing_to_tell(
    clock: Clock,
) -> None:
    def make(left_in: Collection[str]) -> Clockwork:
        if left_in:
            raise EngineError("refused")
        return Clockwork(clock, steadily(TAKES))

    engine = Works(make, tuple(PASSES))
    assert ratio(engine) is None
    assert apart(engine) is None
    assert with_all_left_in(SCENE, [(Works(make), METHOD)]) == []


class Various(Works):
    """Its methods leave out different things, the last two the same."""

    methods = tuple(
        Method(name, 1, 1, name, frozenset()) for name in ("bare", "one", "both", "both-again")
    )

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        return tuple(PASSES)[: {"bare": 0, "one": 1}.get(method.name, 2)]


def test_every_distinct_set_of_what_is_left_out_is_timed_once(clock: Clock) -> None:
    engine = Various(lambda _: Clockwork(clock, steadily(TAKES)), tuple(PASSES))
    chosen = with_all_left_in(SCENE, [(engine, method) for method in engine.methods])
    contact, sensor = PASSES
    assert [(method.name, one.varied["left_in"]) for one, method in chosen] == [
        ("one", [contact]),
        ("both", [contact, sensor]),
    ]


@pytest.mark.parametrize("engine", required_engines(), ids=lambda engine: engine.name)
def test_real_engines_are_timed_for_all_that_they_leave_out(engine) -> None:
    scenario = library_scene("fast-top")
    able = [m for m in engine.methods if not (m.reader or engine.unsupported(scenario, m))]
    chosen = with_all_left_in(scenario, [(engine, method) for method in able])
    sets = [tuple(one.varied["left_in"]) for one, _ in chosen]
    assert set(sets) == {engine.left_out(scenario, method) for method in able} - {()}
    highest = max((m for m in able if engine.left_out(scenario, m)), key=lambda m: m.order)
    names = [method.name for _, method in chosen]
    assert len(names) == len(set(names))
    assert highest.name in names
