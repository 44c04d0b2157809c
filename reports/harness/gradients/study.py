"""Every derivative of a method on a scene: its verdict, its cost, and gradients over a window."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from ....engines import Engine, EngineError, Method, Session, UnsupportedError
from ....engines.checks.equations import Equations
from ....engines.derivative import Derivative
from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario
from ....scenarios.fastest_rate import fastest_rate
from ...results.verdict_words import VerdictWord
from ..executors import CallFailed, Executor
from ..measuring.examine import gives_way
from ..measuring.places import Places, places
from ..measuring.steps import Sessions, sessions_of, steps_from
from .candidates import Exact
from .jacobians import (
    CHART,
    Own,
    Units,
    exact_jacobians,
    own_jacobian,
    own_jacobians,
    stepped_by_rate,
    units_of,
)
from .verdict import Judged, beside_own, judged, noise_of
from .window import Gradient, TapeCut, gradients_along, useless_from

#: Exact states that steps are taken from.
STATES = 4
#: The name of what is found where an engine gives nothing.
OURS = "central differences by spincheck"
#: Why steps that a constraint or a contact takes are not judged here.
SETTLES = (
    "a constraint holds the body and has to settle: a step from an exact state is none of a run"
)
#: Steps that are timed, and derivatives.
TIMED, TIMES = 200, 5
#: Which of the halved timesteps a window is taken with: some 0.05 rad a step.
FINE = 2


@dataclass(frozen=True)
class GradientRow:
    """One derivative of one method on one scene.

    Attributes
    ----------
    derivative : the engine's name for it, or `OURS`
    judged : what was found of it; failed or unsupported where nothing was
    cost : CPU time in plain steps, of each step that it goes through; None where none was taken
    seconds : until the row was made, with what was compiled
    timestep : s, of the window's steps
    window : gradients along a run
    useless_from : s, from when on they are as wrong as none; None if they are not
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
    """As `gradients_of`, in another process: a crash, or running out of time, is a row."""
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
    """Judge every derivative of one method; what cannot be judged is a row with the reason.

    Parameters
    ----------
    timestep : s, of the window's steps; chosen by the motion's fastest rate if None
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
class _Study:
    """A method whose derivatives are taken at exact states."""

    sessions: Sessions
    engine: Engine
    method: Method
    at: Places
    units: Units
    timestep: float | None

    def rows(self) -> list[GradientRow]:
        """One of each derivative that the engine gives, and that by differences of its steps."""
        at, units = self.at, self.units
        steps = steps_from(self.sessions, at.states, at.timesteps)
        if gives_way(Equations(self.sessions.scenario), self.engine, steps):
            return [self._row(OURS, Judged("unresolved", SETTLES))]
        jacobians = exact_jacobians(self.sessions.scenario, at.states, at.timesteps)
        exact = Exact(self.sessions.scenario, at.states, at.timesteps, jacobians, units)
        own = cache(partial(own_jacobians, self.sessions, at.states, at.timesteps, units))
        rows = [
            self._engines_row(replace(exact, steps=one.steps), own, name, one)
            for name, one in self.sessions.first.derivatives().items()
        ]
        has_window = any(row.window for row in rows)
        return [*rows, self._own_row(exact, own(1), has_window)]

    def _engines_row(
        self, exact: Exact, own: Callable[[int], Own], name: str, one: Derivative
    ) -> GradientRow:
        """A derivative of the engine's; whatever its own code raises is the reason."""
        began = time.perf_counter()
        try:
            found, is_step = self._found(name, exact)
            if found is None:
                words = "four numbers of a quaternion instead of the three of a turn"
                row = self._row(name, Judged("disagrees", f"it is not 6 by 6: {words}?"))
            else:
                noise = noise_of(
                    self.units, exact.timesteps, self.at.condition, one.epsilon, one.steps
                )
                found_to_be = judged(exact, found, noise)
                if is_step:
                    found_to_be = beside_own(found_to_be, exact, found, own(one.steps), noise)
                row = replace(self._row(name, found_to_be), cost=self._cost(name))
                row = self._with_window(row, partial(self._jacobian, name=name), one.steps)
        except UnsupportedError as error:
            row = self._row(name, Judged("unsupported", str(error)))
        except (EngineError, MemoryError, RuntimeError, ValueError, TypeError) as error:
            row = self._row(name, Judged("failed", " ".join(str(error).split())))
        return replace(row, seconds=time.perf_counter() - began)

    def _own_row(self, exact: Exact, own: Own, has_window: bool) -> GradientRow:
        began = time.perf_counter()
        noise = noise_of(self.units, exact.timesteps, self.at.condition, 0.0)
        one = judged(exact, own.jacobians, noise + (own.known_to / exact.timesteps)[:, None])
        if one.reason:
            one = replace(one, reason=f"its steps themselves: {one.reason}")
        row = self._row(OURS, one)
        # Where a scene is opened anew for each difference, a window would take minutes.
        if self.sessions.first.can_restart and not has_window:
            row = self._with_window(row, self._own, 1)
        return replace(row, seconds=time.perf_counter() - began)

    @property
    def window_timestep(self) -> float:
        """The timestep of a window, s."""
        return self.timestep or float(self.at.timesteps[FINE])

    def _row(self, derivative: str, one: Judged) -> GradientRow:
        names = self.sessions.scenario.name, self.engine.name, self.method.name, derivative
        return GradientRow(*names, one, timestep=self.window_timestep)

    def _found(self, name: str, exact: Exact) -> tuple[FloatArray | None, bool]:
        """Jacobians of steps by a derivative, (J, K, 6, 6), and whether it is one of a step."""
        states, jacobians, is_step = self.at.states, np.empty_like(exact.jacobians), True
        for j, k in np.ndindex(jacobians.shape[:2]):
            h, state = float(exact.timesteps[j]) / exact.steps, states.rows(k)
            with self.sessions.at(state, h) as session:
                found = np.asarray(session.derivatives()[name].compute(), dtype=float)
            if found.shape not in ((CHART, CHART), (3, CHART)):
                return None, is_step
            is_step = len(found) == CHART
            jacobians[j, k] = found if is_step else stepped_by_rate(found, state.omega_body, h)
        return jacobians, is_step

    def _jacobian(self, session: Session, name: str) -> FloatArray:
        found = session.derivatives()[name].compute()
        if len(found) == CHART:
            return found
        return stepped_by_rate(found, session.read_state().omega_body, self.window_timestep)

    def _own(self, session: Session) -> FloatArray:
        state = session.read_state()
        return own_jacobian(self.sessions, state, self.window_timestep, self.units, 1)

    def _with_window(
        self, row: GradientRow, jacobian: Callable[[Session], FloatArray], at_once: int
    ) -> GradientRow:
        scenario = self.sessions.scenario
        try:
            with self.sessions.open_at(scenario, row.timestep) as session:
                along = gradients_along(
                    session, scenario, row.timestep, self.units, jacobian, at_once
                )
        except TapeCut as error:
            one = row.judged
            words = one.reason or str(error)
            return replace(row, judged=replace(one, verdict="disagrees", reason=words))
        except EngineError as error:
            one = row.judged
            return replace(row, judged=replace(one, reason=one.reason or f"no window: {error}"))
        return replace(row, window=along, useless_from=useless_from(along))

    def _cost(self, name: str) -> float:
        """CPU time of a derivative, in plain steps, for each of its own."""
        with self.sessions.at(self.at.states.rows(0), float(self.at.timesteps[-1])) as session:
            session.advance(TIMED)
            a_step = session.timed(TIMED)[0] / TIMED
            one, began = session.derivatives()[name], time.process_time()
            for _ in range(TIMES):
                one.compute()
            taken = time.process_time() - began
            return taken / TIMES / one.steps / max(a_step, 1e-9)
