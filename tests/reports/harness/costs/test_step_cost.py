"""The cost of a step is measured correctly, by clocks of any resolution, with others timed too."""

import os
from itertools import accumulate, cycle

import numpy as np
import pytest
from clockwork import METHOD, SCENE, Clock, Clockwork, Works, steadily
from library_scenes import library_scene
from planted import METHOD as METHOD_OF_PLANTED
from planted import HeunSession, RaisingSession, SegfaultSession, planted
from spincheck.engines import EngineError, engines
from spincheck.reports.harness.costs import step_cost as cost
from spincheck.reports.harness.costs.step_cost import measure, step_costs
from spincheck.reports.harness.executors import Executor, InProcess, LocalWorkers
from spincheck.reports.results.cost_records import StepCost

pytestmark = pytest.mark.slow

#: s a step.
TAKES = 3e-6
#: A stretch is off by a tick of its clock at either end, and by the looks at it.
TICK = 2 / cost.RESOLUTIONS
#: CPU time of one thread, at most, in wall times of other passes, on a machine that is busy; two
#: threads that share the work take up to 2.
SHARED = 1.25


def costs_of(*sessions: Clockwork) -> list[StepCost | None]:
    return step_costs(SCENE, [(Works(lambda _, s=s: s), METHOD) for s in sessions])


def cost_of(session: Clockwork) -> StepCost:
    (measured,) = costs_of(session)
    assert measured is not None
    return measured


@pytest.mark.parametrize("takes", [1e-8, TAKES, 1e-3])
def test_a_step_costs_what_it_takes(clock: Clock, takes: float) -> None:
    measured = cost_of(Clockwork(clock, steadily(takes)))
    assert measured.seconds_per_step == pytest.approx(takes, rel=TICK)
    assert cost_of(Clockwork(clock, steadily(2 * takes))).seconds_per_step > takes * (1 + TICK)


@pytest.mark.parametrize("resolution", [2.0**-20, 2.0**-7])
def test_a_stretch_lasts_long_by_the_clock_however_coarse(clock: Clock, resolution: float) -> None:
    clock.resolution = resolution
    assert cost.resolution() == resolution
    session = Clockwork(clock, steadily(TAKES))
    assert cost_of(session).seconds_per_step == pytest.approx(TAKES, rel=TICK)
    timed = [steps for _, what, steps in session.diary if what == "advance"][-cost.REPEATS :]
    # By engines that take a power of two of steps a call, in few calls.
    assert all(len(f"{steps:b}".rstrip("0")) <= cost.DIGITS_OF_STEPS for steps in timed)
    # The count was found by a stretch that the clock may have called a tick too long.
    assert min(timed) * TAKES >= (1 - TICK) * max(cost.RESOLUTIONS * resolution, cost.STRETCH)


def test_what_a_call_costs_however_many_steps_is_not_counted(clock: Clock) -> None:
    """As of a compiled loop that an interpreter calls; nor if single stretches are disturbed."""
    for takes in (1e-7, TAKES, 1e-3):
        measured = cost_of(Clockwork(clock, lambda n, _, takes=takes: 100 * TAKES + n * takes))
        assert measured.seconds_per_step == pytest.approx(takes, rel=cost.SHARE_OF_CALL + TICK)
    noise = iter(np.tile([1.5, 1.0, 4.0], 1000))
    disturbed = Clockwork(clock, lambda steps, _: (100 + steps) * TAKES * float(next(noise)))
    measured = cost_of(disturbed)
    assert measured.seconds_per_step == pytest.approx(TAKES, rel=cost.SHARE_OF_CALL + TICK)


def test_the_least_is_quoted_and_the_spread_beside_it_but_for_the_first_steps(clock: Clock) -> None:
    slow = Clockwork(clock, lambda steps, taken: steps * TAKES * (1 if taken else 1000))
    measured = cost_of(slow)
    assert measured.seconds_per_step + measured.seconds_spread == pytest.approx(TAKES, rel=TICK)
    noise = iter(np.tile([1.5, 1.0, 1.25], 100))
    measured = cost_of(Clockwork(clock, lambda steps, _: steps * TAKES * float(next(noise))))
    assert measured.seconds_per_step == pytest.approx(TAKES, rel=TICK)
    assert measured.seconds_spread == pytest.approx(0.5 * TAKES, rel=2 * TICK)
    assert measured.wall_seconds_per_step == pytest.approx(TAKES, rel=TICK)


def test_a_clock_that_is_looked_at_late_is_no_coarser(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = accumulate(cycle([3.0, 0.0, 1.0, 2.0]))
    monkeypatch.setattr(clock, "process_time", lambda: next(looks))
    assert cost.resolution() == 1.0


def test_the_wall_clocks_time_is_distinguished(clock: Clock) -> None:
    """Longer where something else had the processor, shorter where threads share the work."""
    for wall in (2.0, 0.5):
        measured = cost_of(Clockwork(clock, steadily(TAKES), wall=wall))
        assert measured.seconds_per_step == pytest.approx(TAKES, rel=TICK)
        assert measured.wall_seconds_per_step == pytest.approx(wall * TAKES, rel=TICK)


def test_methods_are_timed_in_turn_and_nothing_else_is_done_meanwhile(clock: Clock) -> None:
    diary: list[tuple[str, str, int]] = []
    sessions = [Clockwork(clock, steadily(TAKES), name=n, diary=diary) for n in "abc"]
    costs_of(*sessions)
    checks = [k for k, (_, what, _) in enumerate(diary) if what == "check"]
    timed = diary[checks[0] - 3 * cost.REPEATS : checks[0]]
    assert {what for _, what, _ in timed} == {"advance"}
    assert [name for name, _, _ in timed] == list("abc") * cost.REPEATS


def test_a_method_that_gives_up_costs_its_own_figure(clock: Clock) -> None:
    well = Clockwork(clock, steadily(TAKES))
    for after in (0, 300, 10 * cost.STRETCH / TAKES / cost.REPEATS):
        ill = Clockwork(clock, steadily(TAKES), gives_up_after=after)
        first, second = costs_of(ill, well)
        assert first is None
        assert second is not None


def test_a_step_that_the_engine_clamps_costs_the_same(clock: Clock) -> None:
    class Refusing(Clockwork):
        def check(self) -> None:
            raise EngineError("beyond its limit", self.name)

    costs = costs_of(*(Refusing(clock, steadily(TAKES), name=cause) for cause in ("clamp", "lag")))
    assert [measured is not None for measured in costs] == [True, False]


def test_steps_of_what_is_no_number_and_a_scene_that_does_not_load_have_no_cost(
    clock: Clock,
) -> None:
    assert costs_of(Clockwork(clock, steadily(TAKES), drift=np.nan)) == [None]

    def refuse(_: object) -> Clockwork:
        raise EngineError("refused")

    assert step_costs(SCENE, [(Works(refuse), METHOD)]) == [None]


# With the system's own clocks


def timed(executor: Executor, *kinds: type[HeunSession]) -> tuple[list[bool], list[str]]:
    """Which were, and the complaints."""
    pairs = [(planted(kind), METHOD_OF_PLANTED) for kind in kinds]
    costs, complaints = measure(executor, SCENE, pairs)
    return [measured is not None for measured in costs], complaints


def test_a_method_that_raises_costs_its_own_figure() -> None:
    costs, (complaint,) = timed(InProcess(), HeunSession, RaisingSession)
    assert costs == [True, False]
    assert complaint.startswith("Raising Heun could not be timed: ZeroDivisionError")


@pytest.mark.processes
def test_so_does_one_that_takes_its_process_with_it_and_processes_start_no_threads() -> None:
    with LocalWorkers(jobs=1) as workers:
        costs, (complaint,) = timed(workers, SegfaultSession, HeunSession)
        assert costs == [False, True]
        assert complaint.startswith("Segfault Heun could not be timed: ")
        assert workers.call(os.getenv, "OMP_NUM_THREADS").value == "1"


def test_engines_step_in_one_thread() -> None:
    """Threads that share the work take more CPU time than there is on the wall."""
    scenario = library_scene("fast-top")
    pairs = []
    # Of one package there is one answer to how many threads there are.
    for engine in {one.package or one.name: one for one in engines().values()}.values():
        can = [method for method in engine.methods if not engine.unsupported(scenario, method)]
        # One method of each, as some take a minute to compile all theirs.
        pairs += [(engine, method) for method in can[:1]]
    for (engine, method), measured in zip(pairs, step_costs(scenario, pairs), strict=True):
        assert measured is not None, (engine.name, method.name)
        assert measured.seconds_per_step <= measured.wall_seconds_per_step * SHARED


@pytest.mark.parametrize("name", ["fast-top", "earth-wobble"])
def test_steps_are_timed_that_turn_every_body_alike(name: str) -> None:
    scenario = library_scene(name)
    speed = float(np.linalg.norm(scenario.start.omega_body))
    assert speed * cost.timed_timestep(scenario) == pytest.approx(cost.TIMED_TURN)
