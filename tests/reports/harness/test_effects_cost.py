"""The cost of passes left out is measured, and whether leaving them out changes the motion."""

from collections.abc import Collection

import pytest
from clockwork import METHOD, SCENE, Clock, Clockwork, Works, steadily
from kinds_of_engines import required_engines
from library_scenes import library_scene
from spincheck.engines import Engine, EngineError, Method
from spincheck.reports.harness import effects_cost
from spincheck.reports.harness import step_cost as cost
from spincheck.reports.harness.effects_cost import effects_costs, first_pass_costs, pass_costs
from spincheck.reports.results.cost_records import EffectsCost, PassCosts
from spincheck.reports.results.records import Key
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


def measured(engine: Engine) -> EffectsCost:
    measured_cost = effects_cost.effects_cost(SCENE, engine, METHOD)
    assert measured_cost is not None
    return measured_cost


def test_the_ratio_is_that_of_the_two_times(clock: Clock) -> None:
    measured_cost = measured(priced(clock))
    expected = 1 + sum(PASSES.values())
    assert measured_cost.pruned == pytest.approx(TAKES, rel=TICK)
    assert measured_cost.unpruned == pytest.approx(TAKES * expected, rel=TICK)
    assert measured_cost.ratio.median == pytest.approx(expected, rel=TICK)
    assert measured_cost.ratio.spread <= TICK
    # Without the cheapest of the passes it would be told apart.
    assert abs(measured_cost.ratio.median - (expected - min(PASSES.values()))) > TICK


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

    charged = measured(Works(make, tuple(PASSES)))
    assert charged.ratio.median == pytest.approx(expected, rel=TICK)
    assert len(stretches) > 5


def test_a_motion_is_the_same_to_the_last_bit_or_another(clock: Clock) -> None:
    same, drifting = measured(priced(clock)), measured(priced(clock, drift=2.0**-52))
    assert (same.difference, same.compared_until) == (0.0, SCENE.window.duration)
    assert same.same_motion == "the motion is identical to the last bit"
    assert same.sentence.startswith("+31% a step; ")
    steps = round(drifting.compared_until / drifting.timestep)
    assert drifting.difference == steps * 2.0**-52
    assert drifting.same_motion.startswith("the motion differs by ")


def test_motions_are_compared_as_far_as_both_go(clock: Clock) -> None:
    opened: list[Clockwork] = []
    undisturbed = measured(Works(lambda _: Clockwork(clock, steadily(TAKES)), tuple(PASSES)))
    gives_up_after = round(SCENE.window.duration / undisturbed.timestep) // 2

    def make(left_in: Collection[str]) -> Clockwork:
        # The first two are timed, the next two compared.
        is_compared = len(opened) >= 2
        opened.append(Clockwork(clock, steadily(TAKES)))
        if left_in and is_compared:
            opened[-1].gives_up_after = gives_up_after
        return opened[-1]

    measured_cost = measured(Works(make, tuple(PASSES)))
    assert measured_cost.difference == 0.0
    until, end = measured_cost.compared_until, gives_up_after * measured_cost.timestep
    assert 0 < until <= end < SCENE.window.duration


@pytest.mark.parametrize("left_out", [(), tuple(PASSES)], ids=["nothing", "does not load with it"])
def test_where_nothing_is_left_out_or_can_be_left_in_there_is_nothing_to_tell(
    clock: Clock, left_out: tuple[str, ...]
) -> None:
    def make(left_in: Collection[str]) -> Clockwork:
        if left_in:
            raise EngineError("refused")
        return Clockwork(clock, steadily(TAKES))

    engine = Works(make, left_out)
    assert effects_cost.effects_cost(SCENE, engine, METHOD) is None
    assert pass_costs(SCENE, engine, METHOD) is None


def by_pass(passes: PassCosts | None) -> dict[str, tuple[float, float]]:
    assert passes is not None
    return {one.name: (one.added, one.saved) for one in passes.passes}


def test_every_pass_is_reported_at_its_own_price(clock: Clock) -> None:
    passes = pass_costs(SCENE, priced(clock), METHOD)
    for name, (added, saved) in by_pass(passes).items():
        assert added == pytest.approx(PASSES[name], abs=TICK)
        assert saved == pytest.approx(PASSES[name], abs=TICK)
    assert set(by_pass(passes)) == set(PASSES)


def test_a_pass_that_costs_only_beside_another_is_saved_and_not_added(clock: Clock) -> None:
    def make(left_in: Collection[str]) -> Clockwork:
        price = 1.25 if set(left_in) == set(PASSES) else 1.0
        return Clockwork(clock, steadily(TAKES * price))

    for added, saved in by_pass(pass_costs(SCENE, Works(make, tuple(PASSES)), METHOD)).values():
        assert added == pytest.approx(0.0, abs=TICK)
        assert saved == pytest.approx(0.25, abs=TICK)


def test_the_noise_is_what_equal_sessions_differ_by(clock: Clock) -> None:
    opened: list[Clockwork] = []

    def make(left_in: Collection[str]) -> Clockwork:
        price = 1.125 if len(opened) == 1 else 1.0
        opened.append(Clockwork(clock, steadily(TAKES * price)))
        return opened[-1]

    passes = pass_costs(SCENE, Works(make, tuple(PASSES)), METHOD)
    assert passes is not None
    assert passes.noise == pytest.approx(0.125, abs=TICK)


class Various(Works):
    """Its methods leave out different things, the last two the same, the first cannot do it."""

    methods = tuple(
        Method(name, 1, 1, name, frozenset(), frozenset({"pivot"} if name == "tied" else ()))
        for name in ("tied", "bare", "one", "both", "both-again")
    )

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        return tuple(PASSES)[: {"bare": 0, "one": 1}.get(method.name, 2)]


def test_every_distinct_set_of_what_is_left_out_is_timed_once(clock: Clock) -> None:
    """And pass by pass, the first method that can do it."""
    engine = Various(lambda _: Clockwork(clock, steadily(TAKES)), tuple(PASSES))
    timed = effects_costs(SCENE, engine, engine.methods)
    named = [(one.key.method, one.left_out) for one in timed]
    assert named == [("one", tuple(PASSES)[:1]), ("both", tuple(PASSES))]
    (charged,) = first_pass_costs(SCENE, engine, [m for m in engine.methods if m.name != "bare"])
    assert charged.key.method == "one"


REAL = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine in required_engines()
    for method in engine.methods
]


@pytest.mark.parametrize(("engine", "method"), REAL)
def test_real_engines_move_alike_with_and_without_what_is_left_out(engine, method) -> None:
    scenario = library_scene("tiring-top")
    measured_cost = effects_cost.effects_cost(scenario, engine, method)
    if method.as_shipped or engine.unsupported(scenario, method):
        assert measured_cost is None
        return
    assert measured_cost is not None
    assert measured_cost.key == Key("tiring-top", engine.name, method.name)
    assert measured_cost.left_out == engine.left_out(scenario, method)
    assert measured_cost.difference == 0.0
    assert measured_cost.compared_until == scenario.window.duration


@pytest.mark.parametrize("engine", required_engines(), ids=lambda engine: engine.name)
def test_real_engines_are_timed_for_all_that_they_leave_out(engine) -> None:
    scenario = library_scene("fast-top")
    able = [m for m in engine.methods if not engine.unsupported(scenario, m)]
    by_method = effects_costs(scenario, engine, able)
    sets = [one.left_out for one in by_method]
    assert set(sets) == {engine.left_out(scenario, method) for method in able} - {()}
    highest = max((m for m in able if engine.left_out(scenario, m)), key=lambda m: m.order)
    names = [one.key.method for one in by_method]
    assert len(names) == len(set(names))
    assert highest.name in names
