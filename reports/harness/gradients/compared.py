"""Judges the derivatives of a method on a scene: verdict, cost, and gradients over a window."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from textwrap import shorten

import numpy as np

from ....engines import Engine, EngineError, Method, Session, UnsupportedError
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....engines.derivative import Derivative
from ....reference import IntegrationError
from ....scenarios import FloatArray
from ..executors.worker_main import error_in_words
from ..measuring.examine import SETTLING, gives_way
from ..measuring.places import FINER, Places
from ..measuring.steps import FEW, Sessions, state_differences, steps_from
from .candidates import Exact
from .jacobians import (
    CHART,
    Own,
    Units,
    exact_jacobians,
    own_jacobians,
    settled_jacobians,
    stepped_by_rate,
)
from .verdict import Judged, beside_own, judged, noise_of
from .window import (
    Gradient,
    chained,
    cut_in_words,
    exact_along,
    gradients_along,
    own_over,
    run_along,
    useless_from,
)

#: Name of the derivative that spincheck itself computes, with every engine.
OURS = "central differences by spincheck"
#: Name that stands for all derivatives of an engine if it fails to give any.
THEIRS = "derivatives by the engine"
#: Number of steps over which a derivative through many steps is judged, and numbers of steps over
#: which its gradients are compared.
MANY = 8
TAPED = (MANY, 64)
#: End of the name of a derivative through many steps.
THROUGH = f", through {MANY} steps"
#: Largest number of characters of a reason that quotes an exception from an engine's code.
SAID = 300
#: The reason why an engine's derivative is not judged if a constraint or a contact gives way.
UNSETTLED = (
    "a constraint gives way: by attitude and ω with the com where it is, as the engine "
    "differentiates, no motion is allowed; only differences of its runs are judged"
)
#: Number of plain steps that are timed before each derivative, and number of such measurements.
TIMED, TIMES = 200, 5


@dataclass(frozen=True)
class GradientRow:
    """The result for one derivative of one method on one scene.

    A derivative is one of the ways in which an engine, or spincheck, computes Jacobians of steps.

    Attributes
    ----------
    derivative : the engine's name for the derivative, or `OURS`
    judged : the verdict; failed or unsupported if nothing was computed
    costs : for each measurement, the CPU time of the derivative, divided by the CPU time of the
        plain steps that it covers
    seconds : wall time until the row was made, including compilation
    timestep : timestep of the window's steps, s
    window : gradients of losses by the start, along a run
    useless_from : time from which on gradients are no better than zero, s; None if the last
        gradient is better
    """

    scene: str
    engine: str
    method: str
    derivative: str
    judged: Judged
    costs: tuple[float, ...] = ()
    seconds: float = 0.0
    timestep: float = 0.0
    window: tuple[Gradient, ...] = ()
    useless_from: float | None = None


@dataclass(frozen=True, eq=False)
class _Target:
    """What the Jacobians that an engine or spincheck computes are compared with.

    Attributes
    ----------
    exact : the Jacobians of the exact motion
    own : the Jacobians that finite differences of the engine's own steps give
    timesteps : s, (J,)
    """

    exact: Exact
    own: Own
    timesteps: FloatArray


@dataclass(frozen=True, eq=False)
class MethodStudy:
    """A method whose derivatives are judged at exact states.

    Attributes
    ----------
    at : the states, and the timesteps of the steps that are taken from them
    units : units of attitude and ω in which Jacobians are compared
    timestep : timestep of the window's steps, s
    counts : numbers of steps of the window after which gradients are compared
    """

    sessions: Sessions
    engine: Engine
    method: Method
    at: Places
    units: Units
    timestep: float
    counts: list[int]

    def names(self) -> list[str]:
        """Return the names of all derivatives: those of the engine, then `OURS`.

        If a derivative can go through many steps at once, its name with `THROUGH` is among them. If
        the engine fails to give any derivative, `THEIRS` stands for them.
        """
        if self._none_given:
            return [THEIRS, OURS]
        own = self.sessions.first.derivatives()
        return [*own, *(name + THROUGH for name, one in own.items() if one.through), OURS]

    def row(self, called: str) -> GradientRow:
        """Judge a derivative, given its name, and return its row.

        Parameters
        ----------
        called : one of `names`
        """
        began, name = time.perf_counter(), called.removesuffix(THROUGH)
        if called == OURS:
            row = self._own_row(self._settled if self._gives_way else self._single)
        elif self._none_given:
            row = self._row(called, self._none_given)
        elif self._gives_way:
            row = self._row(called, Judged("unresolved", UNSETTLED))
        else:
            row = self._engines_row(self._single if name == called else self._many, name, called)
        return replace(row, seconds=time.perf_counter() - began)

    @cached_property
    def _none_given(self) -> Judged | None:
        """The verdict on an engine that fails to give its derivatives; None if it gives them."""
        try:
            own: Mapping[str, object] = self.sessions.first.derivatives()
            for name, one in own.items():
                if not isinstance(one, Derivative):
                    got = shorten(repr(one), SAID // 2, placeholder=" …")
                    return Judged("failed", f"'{name}' must be a Derivative, got {got}")
        # An adapter may raise anything.
        except Exception as error:
            return _raised(error)
        return None

    @cached_property
    def _gives_way(self) -> bool:
        """Whether a constraint is soft, so that it must settle before steps are judged."""
        steps = steps_from(self.sessions, self.at.states, self.at.timesteps)
        return gives_way(Equations(self.sessions.scenario), self.engine, steps)

    @cached_property
    def _single(self) -> _Target:
        """The Jacobians over single steps, with which those of derivatives are compared."""
        return self._target(1)

    @cached_property
    def _many(self) -> _Target:
        """The Jacobians over `MANY` steps, with which those of derivatives are compared."""
        return self._target(MANY)

    def _target(self, steps: int) -> _Target:
        """Return the Jacobians over several steps, with which those of derivatives are compared.

        Only those timesteps are used with which `steps` steps take no longer than one step with the
        longest timestep.

        Parameters
        ----------
        steps : number of steps that each Jacobian covers
        """
        scenario, at, units = self.sessions.scenario, self.at, self.units
        timesteps = at.timesteps[at.timesteps <= at.timesteps[0] / steps]
        spans = steps * timesteps
        jacobians = exact_jacobians(scenario, at.states, spans)
        own = own_jacobians(self.sessions, at.states, timesteps, units, steps)
        exact = Exact(scenario, at.states, spans, jacobians, units, steps)
        return _Target(exact, own, timesteps)

    @cached_property
    def _settled(self) -> _Target:
        """The Jacobians of a step after a constraint has settled, for comparison.

        The longest timesteps, at which the body turns far while the constraint settles, are left
        out.
        """
        scenario, at, units = self.sessions.scenario, self.at, self.units
        settling, timesteps = (SETTLING, SETTLING + FEW), at.timesteps[FINER:]
        own, jacobians = settled_jacobians(self.sessions, at.states, timesteps, units, settling)
        return _Target(Exact(scenario, at.states, timesteps, jacobians, units), own, timesteps)

    def _engines_row(self, target: _Target, name: str, called: str) -> GradientRow:
        """Return the row of a derivative that the engine computes.

        If the engine's code raises an error, the verdict is `failed` or `unsupported`, with the
        error as the reason. If `_found` returns a sentence in place of Jacobians, the verdict is
        `disagrees`, with the sentence as the reason.

        Parameters
        ----------
        target : the Jacobians that the derivative is compared with
        name : the engine's name for the derivative
        called : the derivative's name in the row
        """
        steps = target.exact.steps
        try:
            found, is_step = self._found(name, target)
            if isinstance(found, str):
                return self._row(called, Judged("disagrees", found))
            one = self._judged(target, found, is_step, name)
            row = replace(self._row(called, one), costs=self._costs(name, steps))
            return self._with_window(row, name, is_taped=steps > 1)
        except Exception as error:
            return self._row(called, _raised(error))

    def _judged(self, target: _Target, found: FloatArray, is_step: bool, name: str) -> Judged:
        """Return the verdict on the Jacobians that the engine computes.

        Parameters
        ----------
        target : the Jacobians that the engine's Jacobians are compared with
        found : the engine's Jacobians at J timesteps from K states, (J, K, 6, 6)
        is_step : whether the engine differentiates its steps, not dω/dt; if so, `found` are also
            compared with finite differences of these steps
        name : the engine's name for the derivative
        """
        epsilon = self.sessions.first.derivatives()[name].epsilon
        noise = noise_of(self.units, target.timesteps, self.at.condition, epsilon)
        one = judged(target.exact, found, noise)
        if not is_step or not np.isfinite(found).all():
            return one
        return beside_own(one, target.exact, found, target.own, noise)

    def _own_row(self, target: _Target) -> GradientRow:
        """Return the row of the derivative by central differences of the engine's own steps.

        Parameters
        ----------
        target : the Jacobians of these differences, and the exact ones
        """
        exact, own = target.exact, target.own
        noise = noise_of(self.units, target.timesteps, self.at.condition, 0.0)
        one = judged(exact, own.jacobians, noise + (own.known_to / exact.spans)[:, None])
        if one.reason:
            one = replace(one, reason=f"its steps themselves: {one.reason}")
        row = self._row(OURS, one)
        # If the scene must be opened anew for each difference, a window would take minutes.
        if self.sessions.first.can_restart:
            row = self._with_window(row)
        return row

    def _row(self, derivative: str, one: Judged) -> GradientRow:
        """Return a row with a verdict, and without costs and window.

        Parameters
        ----------
        derivative : the derivative's name in the row
        one : the verdict
        """
        names = self.sessions.scenario.name, self.engine.name, self.method.name, derivative
        return GradientRow(*names, one, timestep=self.timestep)

    def _found(self, name: str, target: _Target) -> tuple[FloatArray | str, bool]:
        """Return the Jacobians by a derivative, and whether it differentiates steps, not dω/dt.

        The Jacobians, from K states at J timesteps, have the shape (J, K, 6, 6). A sentence is
        returned in their place if those of the engine have a wrong shape, or if computing them
        changes the session's state.

        Parameters
        ----------
        name : the engine's name for the derivative
        target : the Jacobians to compare with, whose timesteps and numbers of steps are used
        """
        states, jacobians, is_step = self.at.states, np.empty_like(target.exact.jacobians), True
        reach = Equations(self.sessions.scenario).reach
        for j, k in np.ndindex(jacobians.shape[:2]):
            h, state = float(target.timesteps[j]), states.rows(k)
            with self.sessions.at(state, h) as session:
                before = stacked([session.read_state()])
                found = np.asarray(_by(session, name, target.exact.steps)(), dtype=float)
                after = stacked([session.read_state()])
            if np.abs(state_differences(after, before, reach)).max() > self.engine.slack:
                return "computing it changes the state of the session", is_step
            if found.shape not in ((CHART, CHART), (3, CHART)):
                numbers = ": four numbers of a quaternion for the three of a turn?"
                words = f"its shape is {found.shape}, not {(CHART, CHART)}"
                return words + numbers * (CHART + 1 in found.shape), is_step
            is_step = len(found) == CHART
            jacobians[j, k] = found if is_step else stepped_by_rate(found, state.omega_body, h)
        return jacobians, is_step

    def _jacobian(self, session: Session, name: str) -> FloatArray:
        """Return the Jacobian of the next step of a session, divided by `units`, (6, 6).

        Parameters
        ----------
        name : the engine's name for the derivative
        """
        found = np.asarray(session.derivatives()[name].compute(), dtype=float)
        if len(found) != CHART:
            omega_body = session.read_state().omega_body
            found = stepped_by_rate(found, omega_body, self.timestep)
        return self.units.of(found)

    def _with_window(self, row: GradientRow, name: str = "", is_taped: bool = False) -> GradientRow:
        """Return a row with `window` and `useless_from`, from gradients along a run.

        If no window can be computed, the verdict's reason says why, unless it has a reason already.

        Parameters
        ----------
        name : the engine's name for the derivative; if empty, differences of the engine's runs from
            changed starts are used
        is_taped : whether the derivative of many steps is computed at once. If so, it is also
            compared with the product of the Jacobians of the steps, and the verdict says whether
            they differ
        """
        sessions, h, units, one = self.sessions, row.timestep, self.units, row.judged
        of_step = partial(self._jacobian, name=name) if name else None
        try:
            counts = [*TAPED] if is_taped else self.counts
            exact, truth = exact_along(sessions.scenario, h, tuple(counts))
            counts = counts[: len(exact.t)]
            with sessions.open_at(sessions.scenario, h) as session:
                if is_taped:
                    found = [units.of(_by(session, name, count)()) for count in counts]
                elif not name:
                    start = session.read_state()
                    found = own_over(sessions, start, h, units, counts, truth.conditioning)
                states, each = run_along(session, counts, of_step)
            if name and not is_taped:
                multiplied = chained(each)
                found = [multiplied[count] for count in counts]
            for count, taped in zip(counts, found, strict=True) if is_taped else ():
                if cut := cut_in_words(each[:count], taped, units.ulp):
                    one = replace(one, reason=one.reason or cut, is_own=False)
            along = gradients_along(sessions.scenario, units, exact, truth, found, states)
        except (EngineError, IntegrationError) as error:
            return replace(row, judged=replace(one, reason=one.reason or f"no window: {error}"))
        return replace(row, judged=one, window=along, useless_from=useless_from(along))

    def _costs(self, name: str, steps: int) -> tuple[float, ...]:
        """Return CPU times of a derivative, divided by the CPU time of the steps that it covers.

        Plain steps and derivatives are timed in turns, `TIMES` times. Each time the derivative is
        computed until it has taken as long as the steps, so that a first call with cold caches is
        averaged.

        Parameters
        ----------
        name : the engine's name for the derivative
        steps : number of steps that the derivative covers
        """
        with self.sessions.at(self.at.states.rows(0), float(self.at.timesteps[-1])) as session:
            session.advance(TIMED)
            compute, ratios = _by(session, name, steps), []
            for _ in range(TIMES):
                plain, calls = max(session.timed(TIMED)[0], 1e-9), 0
                began = time.process_time()
                while not calls or time.process_time() - began < plain:
                    compute()
                    calls += 1
                ratios.append((time.process_time() - began) / calls / steps * TIMED / plain)
        return tuple(ratios)


def _raised(error: Exception) -> Judged:
    """Return the verdict, failed or unsupported, on a derivative that raises an error."""
    if isinstance(error, EngineError):
        is_unsupported = isinstance(error, UnsupportedError)
        return Judged("unsupported" if is_unsupported else "failed", str(error))
    return Judged("failed", shorten(error_in_words(error), SAID, placeholder=" …"))


def _by(session: Session, name: str, steps: int) -> Callable[[], FloatArray]:
    """Return a function that computes the Jacobian of a number of steps.

    Parameters
    ----------
    name : the engine's name for the derivative
    steps : number of steps, which are differentiated at once. If the engine cannot do that, the
        Jacobian is that of one step
    """
    one = session.derivatives()[name]
    return one.compute if steps == 1 or one.through is None else partial(one.through, steps)
