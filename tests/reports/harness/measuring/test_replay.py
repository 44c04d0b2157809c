"""Runs are replayed from their own states: what depends on more than the state is told, and when.

Verified is what is measured of a run; verdicts on it are in `test_false_passes.py`.
"""

import numpy as np
import pytest
import stepped_faults as planted
from box import BOX
from library_scenes import library_scene
from looked_at import in_words
from spincheck.engines import EngineError, State
from spincheck.reports.harness.convergence_study import ConvergenceStudy
from spincheck.reports.harness.judging import judge
from spincheck.reports.harness.measuring import intervals, replay
from spincheck.reports.harness.measuring.places import changed_at_random
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.evidence import LEVEL, ReplayEvidence
from spincheck.scenarios import Scenario, loads
from stepped import Stepped, SteppedEngine
from studies import verdict_of

pytestmark = pytest.mark.slow

BOOK, TOP = "book-middle-axis", "nutation-loops"
#: Steps of the longest run.
FEW = 1 << 12


def studied(
    kind: type[Stepped], size: float = 0.0, method: str = "RK4", name: str = BOOK, **as_if: object
) -> ConvergenceStudy:
    """A study that has been run."""
    planted.begin()
    engine, scene = SteppedEngine(kind, size, **as_if), library_scene(name)
    solved = prepare(scene, (), FEW, [engine.stock_timestep] if engine.stock_timestep else [])
    study = convergence_study_of(scene, engine, engine.method(method), solved)
    verdict_of(study)
    return study


def replayed(*given: object, **as_if: object) -> ReplayEvidence:
    """What the finest run of a ladder does otherwise than its replays."""
    (found,) = studied(*given, **as_if).replays
    return found


@pytest.mark.parametrize("samples", [3, 4, 5, 12, 101, 401, 2001])
@pytest.mark.parametrize("can_restart", [True, False])
def test_intervals_cover_a_run_and_are_of_irregular_length(samples: int, can_restart: bool) -> None:
    edges = intervals._edges(samples, can_restart)
    lengths = np.diff(edges)
    assert (edges[0], edges[-1]) == (0, samples - 1)
    assert (lengths > 0).all()
    most = intervals.INTERVALS if can_restart else intervals.FEW
    assert 1 <= len(lengths) <= most
    assert samples < 100 or np.ptp(lengths) >= 5


@pytest.mark.parametrize("name", [BOOK, TOP, "chaos-beyond-the-horizon", "drag-until-rest"])
@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_an_honest_run_is_the_same_from_its_own_states(name: str, method: str) -> None:
    found = replayed(Stepped, method=method, name=name)
    assert (found.since, found.spread, found.order, found.is_wrong) == (None, 0.0, 0, False)
    # But for the rounding of an attitude's norm when it is set.
    assert found.off < 1e-12


def test_no_engine_is_asked_for_no_steps() -> None:
    """Drake refuses them."""

    class TakesSome(Stepped):
        def advance(self, steps):
            if not steps:
                raise EngineError("no steps were asked for")
            super().advance(steps)

    study = studied(TakesSome)
    assert study.refusal is None
    assert study.own_steps is not None


def test_a_run_at_the_stock_timestep_that_an_expectation_names_as_well_is_replayed_once() -> None:
    engine = SteppedEngine(Stepped, 0.0, stock_timestep=0.02)
    names = f'engine = "{engine.name}"\nmethod = "RK4"\ntimestep = 0.02\nomega = 1.0\n'
    scene = loads(f"{BOX}[[expect]]\n{names}", "box")
    solved = prepare(scene, (0.02,), FEW, [0.02])
    study = convergence_study_of(scene, engine, engine.method("RK4"), solved)
    verdict_of(study)
    assert [one.timestep for one in study.replays].count(0.02) == 1


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_noise_of_a_step_is_no_memory(method: str) -> None:
    assert not replayed(planted.Noisy, 1e-12, method).is_wrong
    # Single steps show more of it, and are not run again.
    assert studied(planted.Noisy, 1e-9, method).steps.fault


def test_a_change_that_hardly_grows_by_chance_does_not_make_noise_a_memory(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first change does not grow at all; another one does."""
    drawn: list[State] = []

    def changed(scenario: Scenario, states: State, *how: object) -> State:
        drawn.append(states)
        return states if len(drawn) == 1 else changed_at_random(scenario, states, *how)

    monkeypatch.setattr(replay, "changed_at_random", changed)
    found = replayed(planted.Noisy, 1e-12, "RK4")
    assert len(drawn) > 1
    assert not found.is_wrong


def test_a_memory_that_an_engine_refuses_to_show_leaves_the_verdict_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A run that differs from its replays is no fault before a memory has been tried."""

    def refuse(*_: object) -> ReplayEvidence:
        raise EngineError("it cannot be set to this state")

    monkeypatch.setattr(replay, "explained_by_memory", refuse)
    study = studied(planted.ForgetsWithTheTimestep, 0.1, "Euler")
    verdict = judge(study.records)
    assert verdict.verdict == "unresolved"
    assert "it cannot be set to this state" in verdict.reason


def test_rounding_to_24_bits_is_none_either() -> None:
    assert not replayed(planted.HonestSingle, 0.0, "Euler", single_precision=True).is_wrong


@pytest.mark.parametrize("name", [BOOK, TOP, "rod-1e-6"])
def test_nor_is_rounding_of_the_gyroscopic_torque(name: str) -> None:
    """About the axis of a moment that is much smaller than the others it is most of the torque."""
    found = replayed(planted.RoundedGyroscopic, 0.0, "Euler", name, single_precision=True)
    assert not found.is_wrong


@pytest.mark.parametrize(
    ("kind", "size", "is_wrong"),
    [
        (planted.HeldByImpulses, 1.0, False),
        (planted.in_single(planted.FromHalfway), 1e-3, True),
    ],
)
def test_a_pivot_that_is_rounded_is_no_memory(kind: type[Stepped], size: float, is_wrong: bool):
    found = replayed(kind, size, "Euler", "spherical-pendulum", single_precision=True)
    assert found.is_wrong == is_wrong


@pytest.mark.parametrize(
    ("kind", "size", "share"),
    [
        (planted.FromHalfway, 1e-6, 0.5),
        (planted.InTheLastTenth, 1e-6, 0.9),
        (planted.InOneInterval, 1e-6, 0.37),
        (planted.ComJumps, 1e-6, 0.5),
        (planted.JumpsInTheLastStep, 1e-6, 1.0),
    ],
)
@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_since_when_a_run_goes_on_otherwise_is_said(
    kind: type[Stepped], size: float, share: float, method: str
) -> None:
    """To the start of the interval: the longest of them is a tenth of the window."""
    found = replayed(kind, size, method)
    assert found.is_wrong
    assert found.tail < LEVEL
    duration = library_scene(BOOK).window.duration
    assert found.since is not None
    assert share - 0.1 <= found.since / duration <= share
    assert found.spread == 0.0


def test_a_fault_that_grows_smoothly_from_nothing_is_told() -> None:
    """At any time it is as small as one likes at first."""
    for size in (1e-3, 1e-6):
        assert replayed(planted.SmoothlyLater, size, "Euler").is_wrong


def place() -> np.ndarray:
    """An attitude of the exact motion that no exact step begins near."""
    exact = prepare(library_scene(BOOK), (), FEW).solution.trajectory
    return np.array(exact.q_world_body_wxyz[len(exact.t) * 61 // 100])


class ThereAlone(planted.Pushed):
    """A torque acts near that attitude."""

    there, cosine = np.zeros(4), 0.9999

    def is_on(self) -> bool:
        return abs(self.there @ self.y[:4]) > self.cosine


class ScattersThere(ThereAlone):
    """What acts there is drawn by chance in each step."""

    def torque(self):
        push = super().torque()
        return None if push is None else planted.CHANCE.normal() * push


@pytest.mark.parametrize("size", [1e-4, 1e-2])
def test_an_engine_that_is_not_deterministic_is_said_to_be_so(size: float, monkeypatch) -> None:
    monkeypatch.setattr(ThereAlone, "there", place())
    study = studied(ScattersThere, size)
    (found,) = study.replays
    assert found.spread > 0
    assert found.is_wrong
    assert "not deterministic" in judge(study.records).reason


@pytest.mark.parametrize("size", [1e-8, 1e-4])
def test_noise_that_begins_later_is_not_taken_for_grown_rounding(size: float) -> None:
    class ScattersLater(planted.Noisy):
        def after_step(self):
            if self.taken > 20:
                super().after_step()

    assert replayed(ScattersLater, size, "Euler").is_wrong


@pytest.mark.parametrize(
    ("kind", "size"), [(planted.LagsAStep, 1.0), (planted.ForgetsWithTheTimestep, 0.1)]
)
def test_a_memory_that_vanishes_with_the_timestep_is_of_an_order(
    kind: type[Stepped], size: float
) -> None:
    """Of first order, which is as good as Euler's method, and not what fourth order declares."""
    first, fourth = (replayed(kind, size, method) for method in ("Euler", "RK4"))
    assert (first.order, first.declared, first.is_wrong) == (1, 1, False)
    assert (fourth.order, fourth.declared, fourth.is_wrong) == (1, 4, True)


@pytest.mark.parametrize(
    ("kind", "name", "timestep"),
    [
        (planted.LagsAStep, TOP, 0.0035),
        (planted.ForgetsWithTheTimestep, "spherical-pendulum", 0.035),
    ],
)
def test_a_memory_that_vanishes_explains_runs_with_longer_timesteps_than_single_steps(
    kind: type[Stepped], name: str, timestep: float
) -> None:
    study = studied(kind, 1e-2, "Euler", name, stock_timestep=timestep)
    assert study.replays[-1].timestep > study.places.timesteps[0]
    assert [(one.order, one.is_wrong) for one in study.replays] == [(1, False)] * 2


@pytest.mark.parametrize("size", [1e-8, 1e-5])
def test_a_torque_that_oscillates_with_time_is_no_memory(size: float) -> None:
    """A clock that begins anew at each restart is off by less, the shorter the timestep is."""

    class Oscillates(planted.Pushed):
        def torque(self):
            return super().torque() * np.sin(self.rate * self.time)

    assert replayed(Oscillates, size, "Euler").is_wrong


def test_a_memory_of_long_steps_alone_vanishes_and_is_told() -> None:
    class RemembersLongSteps(planted.Remembers):
        def after_step(self):
            if self.timestep > 1e-3:
                super().after_step()

    study = studied(RemembersLongSteps, 1e-4, "RK4", TOP, stock_timestep=0.0035)
    finest, stock = study.replays
    assert (finest.off, finest.is_wrong) == (pytest.approx(0, abs=1e-12), False)
    assert (stock.order > 0, stock.is_wrong) == (True, False)
    assert f"to {stock.off:.1e} a radian, which vanishes" in judge(study.records).reason


@pytest.mark.parametrize(("size", "is_wrong"), [(1e-11, False), (1e-8, True)])
def test_no_more_than_a_solver_leaves_is_explained_by_its_size_alone(
    size: float, is_wrong: bool
) -> None:
    """It begins with the step before, and ends somewhere within its tolerance."""

    class EndsSomewhere(planted.Remembers):
        def after_step(self):
            if self.timestep > 1e-3 and self.last is not None:
                where = np.sin(1e14 * (self.omega - self.last) / self.rate)
                self.omega[:] += self.size * self.rate * where
            self.last = self.omega.copy()

    study = studied(EndsSomewhere, size, "RK4", TOP, stock_timestep=0.0035)
    assert study.replays[-1].off > 1e-12
    assert study.replays[-1].is_wrong == is_wrong


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_a_memory_that_does_not_vanish_is_none_of_any_order(method: str) -> None:
    found = replayed(planted.Remembers, 1e-3, method)
    assert (found.order, found.is_wrong) == (0, True)


def test_a_fault_that_begins_later_is_not_excused_by_a_memory_that_vanishes() -> None:
    class LagsAndJumps(planted.LagsAStep):
        def after_step(self):
            if self.taken == 1500:
                self.omega[:] *= 1 + 1e-2

    found = replayed(LagsAndJumps, 1.0, "Euler")
    assert (found.order, found.is_wrong) == (0, True)


@pytest.mark.parametrize(("method", "cosine"), [("RK4", 0.9999), ("Euler", 0.995)])
def test_what_acts_where_no_exact_state_is_is_found_from_the_states_of_runs(
    method: str, cosine: float, monkeypatch
) -> None:
    """Replays do the same. An interval gains less from it than from Euler's method itself."""
    monkeypatch.setattr(ThereAlone, "there", place())
    monkeypatch.setattr(ThereAlone, "cosine", cosine)
    study = studied(ThereAlone, 1e-6, method)
    assert study.steps is not None
    assert study.steps.fault is None
    assert not any(one.is_wrong for one in study.replays)
    assert study.own_steps is not None
    assert "I dω/dt" in in_words(study.own_steps)
