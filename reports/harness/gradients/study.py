"""Studies every derivative of a method on a scene: verdict, cost, and gradients over a window."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ....engines import Engine, EngineError, Method, Session, UnsupportedError
from ....engines.checks.equations import Equations
from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario
from ....scenarios.fastest_rate import fastest_rate
from ...results.verdict_words import VerdictWord
from ..executors import CallFailed, Executor
from ..measuring.examine import FURTHER, SETTLING, gives_way
from ..measuring.places import FINER, Places, places
from ..measuring.steps import Sessions, sessions_of, steps_from
from .candidates import Exact
from .jacobians import (
    CHART,
    Own,
    Units,
    exact_jacobians,
    own_jacobian,
    own_jacobians,
    settled_jacobians,
    stepped_by_rate,
    units_of,
)
from .verdict import Judged, beside_own, judged, noise_of
from .window import STEPS, Gradient, chained, cut_in_words, gradients_along, run_along, useless_from

#: Number of exact states that steps are taken from.
STATES = 4
#: The name of the derivative that spincheck itself computes, for engines without any.
OURS = "central differences by spincheck"
#: Number of steps of a derivative through many steps, and those numbers over windows.
MANY = 8
TAPED = (MANY, 64)
#: The reason why an engine's derivative is not judged if a constraint or a contact gives way.
UNSETTLED = (
    "a constraint gives way: by attitude and ω with the com where it is, as the engine "
    "differentiates, no motion is allowed; only differences of its runs are judged"
)
#: Number of plain steps that are timed before each derivative, and how often.
TIMED, TIMES = 200, 5
#: Index of the halved timestep that a window is stepped with: some 0.05 rad a step.
FINE = 2


@dataclass(frozen=True)
class GradientRow:
    """The result for one derivative of one method on one scene.

    Attributes
    ----------
    derivative : the engine's name for it, or `OURS`
    judged : the verdict; failed or unsupported if nothing was computed
    cost : CPU time, in plain steps; None if it could not be measured
    seconds : wall time until the row was made, including compilation
    timestep : timestep of the window's steps, s
    window : gradients along a run
    useless_from : time from which on gradients are as wrong as none, s; None if they are not
    """

    scene: str
    engine: str
    method: str
    derivative: str
    judged: Judged
    cost: float | None = None
    seconds: float = 0.0
    timestep: float = 0.0
    window: tuple[Gradient, ...] = ()
    useless_from: float | None = None


def gradients_by(
    executor: Executor, scenario: Scenario, engine: Engine, method: str, timestep: float | None
) -> list[GradientRow]:
    """Return `gradients_of` run in another process; a crash, or time out, gives a row too."""
    began = time.perf_counter()
    answer = executor.call_at(engine.site, gradients_of, scenario, engine, method, timestep)
    if isinstance(answer.value, CallFailed):
        failed = Judged("failed", answer.value.reason)
        seconds = time.perf_counter() - began
        return [GradientRow(scenario.name, engine.name, method, OURS, failed, seconds=seconds)]
    return answer.value


def gradients_of(
    scenario: Scenario, engine: Engine, method_name: str, timestep: float | None = None
) -> list[GradientRow]:
    """Judge every derivative of one method; one that cannot be judged has a row with the reason.

    Parameters
    ----------
    timestep : timestep of the window's steps, s; chosen by the motion's fastest rate if None
    """
    method, began = engine.method(method_name), time.perf_counter()

    def ended(verdict: VerdictWord, reason: str) -> list[GradientRow]:
        seconds = time.perf_counter() - began
        one = Judged(verdict, reason)
        return [GradientRow(scenario.name, engine.name, method_name, OURS, one, seconds=seconds)]

    if reason := engine.unsupported(scenario, method):
        return ended("unsupported", reason)
    outline = ExactMotion(scenario).outline(scenario.times)
    at = places(scenario, outline, None).thinned(STATES)
    rate = fastest_rate(scenario, outline.omega_body) or 1 / scenario.window.duration
    try:
        with sessions_of(
            lambda scene, h: engine.open(scene, method, h), scenario, float(at.timesteps[0])
        ) as sessions:
            return _Study(sessions, engine, method, at, units_of(engine, rate), timestep).rows()
    except UnsupportedError as error:
        return ended("unsupported", str(error))
    except EngineError as error:
        return ended("failed", str(error))


@dataclass(frozen=True, eq=False)
class _Target:
    """What derivatives should be: the exact Jacobians, and those of the engine's own steps."""

    exact: Exact
    own: Own
    timesteps: FloatArray


@dataclass(frozen=True, eq=False)
class _Study:
    """A method whose derivatives are judged at exact states."""

    sessions: Sessions
    engine: Engine
    method: Method
    at: Places
    units: Units
    timestep: float | None

    def rows(self) -> list[GradientRow]:
        """Return a row for each of the engine's derivatives, and one for differences of steps."""
        began, offered = time.perf_counter(), self.sessions.first.derivatives()
        steps = steps_from(self.sessions, self.at.states, self.at.timesteps)
        if gives_way(Equations(self.sessions.scenario), self.engine, steps):
            rows = [self._row(name, Judged("unresolved", UNSETTLED)) for name in offered]
            return [*rows, self._own_row(self._settled_target(), began)]
        target = self._target(1)
        rows = [self._engines_row(target, name) for name in offered]
        if taped := [name for name, one in offered.items() if one.through]:
            many = self._target(MANY)
            rows += [self._engines_row(many, name) for name in taped]
        return [*rows, self._own_row(target, time.perf_counter())]

    def _target(self, steps: int) -> _Target:
        """Return the target over `steps` steps, which last as long as one longer timestep."""
        scenario, at, units = self.sessions.scenario, self.at, self.units
        timesteps = at.timesteps[at.timesteps <= at.timesteps[0] / steps]
        spans = steps * timesteps
        jacobians = exact_jacobians(scenario, at.states, spans)
        own = own_jacobians(self.sessions, at.states, timesteps, units, steps)
        exact = Exact(scenario, at.states, spans, jacobians, units, steps)
        return _Target(exact, own, timesteps)

    def _settled_target(self) -> _Target:
        """Return the target of a step after others, without timesteps that turn the body far."""
        scenario, at, units = self.sessions.scenario, self.at, self.units
        settling, timesteps = (SETTLING, SETTLING + FURTHER), at.timesteps[FINER:]
        own, jacobians = settled_jacobians(self.sessions, at.states, timesteps, units, settling)
        return _Target(Exact(scenario, at.states, timesteps, jacobians, units), own, timesteps)

    def _engines_row(self, target: _Target, name: str) -> GradientRow:
        """Return the row of an engine's derivative, with what its code raises as the reason."""
        began, steps = time.perf_counter(), target.exact.steps
        called = name if steps == 1 else f"{name}, through {steps} steps"
        try:
            found, is_step = self._found(name, target)
            if found is None:
                words = "four numbers of a quaternion instead of the three of a turn"
                row = self._row(called, Judged("disagrees", f"it is not 6 by 6: {words}?"))
            else:
                one = self._judged(target, found, is_step, name)
                row = replace(self._row(called, one), cost=self._cost(name, steps))
                row = self._with_window(row, name, is_taped=steps > 1)
        except UnsupportedError as error:
            row = self._row(called, Judged("unsupported", str(error)))
        except (EngineError, MemoryError, RuntimeError, ValueError, TypeError) as error:
            row = self._row(called, Judged("failed", " ".join(str(error).split())))
        return replace(row, seconds=time.perf_counter() - began)

    def _judged(self, target: _Target, found: FloatArray, is_step: bool, name: str) -> Judged:
        epsilon = self.sessions.first.derivatives()[name].epsilon
        noise = noise_of(self.units, target.timesteps, self.at.condition, epsilon)
        one = judged(target.exact, found, noise)
        return beside_own(one, target.exact, found, target.own, noise) if is_step else one

    def _own_row(self, target: _Target, began: float) -> GradientRow:
        exact, own = target.exact, target.own
        noise = noise_of(self.units, target.timesteps, self.at.condition, 0.0)
        one = judged(exact, own.jacobians, noise + (own.known_to / exact.spans)[:, None])
        if one.reason:
            one = replace(one, reason=f"its steps themselves: {one.reason}")
        row = self._row(OURS, one)
        # If a scene must be opened anew for each difference, a window would take minutes.
        if self.sessions.first.can_restart:
            row = self._with_window(row)
        return replace(row, seconds=time.perf_counter() - began)

    @property
    def window_timestep(self) -> float:
        """The timestep of a window, s."""
        return self.timestep or float(self.at.timesteps[FINE])

    def _row(self, derivative: str, one: Judged) -> GradientRow:
        names = self.sessions.scenario.name, self.engine.name, self.method.name, derivative
        return GradientRow(*names, one, timestep=self.window_timestep)

    def _found(self, name: str, target: _Target) -> tuple[FloatArray | None, bool]:
        """Return Jacobians by a derivative, (J, K, 6, 6), and whether it is of steps or dω/dt."""
        states, jacobians, is_step = self.at.states, np.empty_like(target.exact.jacobians), True
        for j, k in np.ndindex(jacobians.shape[:2]):
            h, state = float(target.timesteps[j]), states.rows(k)
            with self.sessions.at(state, h) as session:
                found = np.asarray(_by(session, name, target.exact.steps)(), dtype=float)
            if found.shape not in ((CHART, CHART), (3, CHART)):
                return None, is_step
            is_step = len(found) == CHART
            jacobians[j, k] = found if is_step else stepped_by_rate(found, state.omega_body, h)
        return jacobians, is_step

    def _jacobian(self, session: Session, name: str) -> FloatArray:
        """Return the Jacobian of the next step of a window, in units, (6, 6)."""
        found = np.asarray(session.derivatives()[name].compute(), dtype=float)
        if len(found) != CHART:
            omega_body = session.read_state().omega_body
            found = stepped_by_rate(found, omega_body, self.window_timestep)
        return self.units.of(found)

    def _with_window(self, row: GradientRow, name: str = "", is_taped: bool = False) -> GradientRow:
        """Return a row with gradients along a run, by the derivative or by differences of runs."""
        sessions, h, units, one = self.sessions, row.timestep, self.units, row.judged
        counts = TAPED if is_taped else STEPS
        of_step = partial(self._jacobian, name=name) if name else None
        try:
            with sessions.open_at(sessions.scenario, h) as session:
                if is_taped:
                    found = [units.of(_by(session, name, count)()) for count in counts]
                elif not name:
                    start = session.read_state()
                    found = [*units.of(own_jacobian(sessions, start, h, units, counts))]
                states, each = run_along(session, counts, of_step)
            if name and not is_taped:
                multiplied = chained(each)
                found = [multiplied[count] for count in counts]
            for count, taped in zip(counts, found, strict=True) if is_taped else ():
                if cut := cut_in_words(each[:count], taped, units.ulp):
                    one = replace(one, reason=one.reason or cut, is_own=False)
            along = gradients_along(sessions.scenario, h, units, counts, found, states)
        except EngineError as error:
            return replace(row, judged=replace(one, reason=one.reason or f"no window: {error}"))
        return replace(row, judged=one, window=along, useless_from=useless_from(along))

    def _cost(self, name: str, steps: int) -> float:
        """Return CPU time of a derivative over that of as many steps, the median of ratios."""
        with self.sessions.at(self.at.states.rows(0), float(self.at.timesteps[-1])) as session:
            session.advance(TIMED)
            compute, ratios = _by(session, name, steps), []
            for _ in range(TIMES):
                a_step, began = session.timed(TIMED)[0] / TIMED, time.process_time()
                compute()
                ratios.append((time.process_time() - began) / max(a_step, 1e-9))
        return float(np.median(ratios)) / steps


def _by(session: Session, name: str, steps: int) -> Callable[[], FloatArray]:
    """Return a function that computes the derivative of steps, by a tape if they are many."""
    one = session.derivatives()[name]
    return one.compute if steps == 1 or one.through is None else partial(one.through, steps)
