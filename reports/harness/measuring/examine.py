"""Examines a method by single steps from known states, with the model of `gain_series.py`."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d

from ....engines import Engine, EngineError, Method, UnsupportedError
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import State
from ....reference import ExactMotion, IntegrationError
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import norms
from ...results.evidence import (
    CONSISTENT,
    LEVEL,
    QUANTITIES,
    StepEvidence,
    StepFault,
    is_known,
)
from ...results.reasons import fault_in_words
from ..executors import CallFailed
from ..explaining.readings import first_step_alone, misreading
from ..explaining.search import LEFT
from ..timesteps.stock import stock_timesteps
from .look import Look
from .noise import SURE, ULPS, noise_of, noise_of_steps, rounding_of_body, roundings
from .places import FINER, HALVINGS, Places, places
from .step_evidence import evidence_of, kind_of, random_fault
from .steps import (
    FEW,
    Sessions,
    Steps,
    off_the_constraint,
    sessions_of,
    state_differences,
    step_gains,
    steps_from,
)

#: Number of steps in which a constraint settles; half as many in single precision. Bullet removes a
#: fifth of a constraint's error in each step, so that 5e-10 of the error remains.
SETTLING = 96
#: Numbers of repeats of each state in single precision, tried in order until the limit is known.
REPEATS = (4, 16, 64)
#: Size of the random changes, in ulp, by which the repeats of a state differ: so large that each
#: repeat is rounded differently, and too small to change the gain.
NUDGE = 2.0**16


def examine(
    engine: Engine, scenario: Scenario, method_name: str, at: Places, *, explains: bool = True
) -> StepEvidence | None:
    """Examine the single steps of a method from exact states, and return the evidence.

    Parameters
    ----------
    at : the exact states, and the timesteps of the steps that are taken from them
    explains : whether changes of the equations of motion that explain a fault are looked for, which
        takes longer than finding the fault

    Returns
    -------
    None if the method does not support the scene, or the engine refuses a state or a step
    """
    return examine_or_refuse(engine, scenario, method_name, at, explains=explains)[0]


def examine_or_refuse(
    engine: Engine, scenario: Scenario, method_name: str, at: Places, *, explains: bool = True
) -> tuple[StepEvidence | None, CallFailed | None]:
    """Examine the single steps of a method from exact states, and return any refusal, too.

    Parameters
    ----------
    at : the exact states, and the timesteps of the steps that are taken from them
    explains : whether changes of the equations of motion that explain a fault are looked for

    Returns
    -------
    The evidence, None if there is none; and why the engine refuses a state or a step, None if it
    refuses none
    """
    method = engine.method(method_name)
    try:
        return _examine_or_raise(engine, scenario, method, at, explains=explains), None
    except (EngineError, IntegrationError) as error:
        return None, refusal_of(error)


def refusal_of(error: EngineError | IntegrationError) -> CallFailed:
    """Return why an examination failed: the engine refused it, or an exact motion is not found."""
    cause = error.cause or "refused" if isinstance(error, EngineError) else "unsolved"
    return CallFailed(str(error), cause)


def physics_in_words(engine: Engine, scenario: Scenario, method: Method) -> str:
    """Return how a method's single steps violate a scene's equations of motion, in words.

    If steps cannot be taken, the words say so. They are empty if the steps obey the equations, if
    the method does not support the scene, and for an engine as shipped, which need not obey them.
    """
    if method.as_shipped:
        return ""
    outline = ExactMotion(scenario).outline(scenario.times)
    try:
        found = _examine_or_raise(engine, scenario, method, places(scenario, outline, None))
    except EngineError as error:
        return f"steps from states of the motion cannot be taken: {error}"
    return fault_in_words(found.fault) if found and found.fault else ""


def _examine_or_raise(
    engine: Engine, scenario: Scenario, method: Method, at: Places, *, explains: bool = True
) -> StepEvidence | None:
    """Return the evidence from steps; None if the method does not support the scene or the states.

    Parameters
    ----------
    at : the exact states, and the timesteps of the steps that are taken from them
    explains : whether changes of the equations of motion that explain a fault are looked for

    Raises
    ------
    EngineError
        If a session cannot be opened or stepped.
    """
    if engine.unsupported(scenario, method):
        return None

    for tried in (at, at.milder()):
        longest = float(tried.timesteps[0])
        with suppress(UnsupportedError), sessions_of(engine, method, scenario, longest) as sessions:
            states = tried if sessions.first.can_restart else tried.thinned(FEW)
            examination = _Examination(sessions, states)
            if fault := examination.misread:
                return StepEvidence(len(states.times), 0.0, 0.0, 0.0, 0, fault=fault)
            order = 0 if engine.single_precision else method.order
            found = evidence_of(examination.look, states, order, explains=explains)
            found = examination.unless_random(found)
            return examination.unless_first_alone(found) if explains else found
    return None


@dataclass(frozen=True, eq=False)
class _Examination:
    """The examination of a method's single steps from given states.

    Attributes
    ----------
    at : the states, and the timesteps of the steps that are taken from them
    """

    sessions: Sessions
    at: Places

    @cached_property
    def first(self) -> Look:
        """The steps that are taken first: no constraint settles before, and repeats are fewest."""
        return self._take(0, self._repeats[0], self.at.timesteps)

    @property
    def _repeats(self) -> Sequence[int]:
        """The numbers of repeats of each state that are tried in order; (1,) in double precision.

        Repeats differ a little, so that their mean gain has less rounding noise.
        """
        return REPEATS if self.sessions.engine.single_precision else (1,)

    @property
    def misread(self) -> StepFault | None:
        """The fault that a state reads back differently from how it was set; None if none does."""
        look, engine, states = self.first, self.sessions.engine, self._states(self._repeats[0])
        # Com and velocity are left out, as a contact or joint may correct them before a step.
        read = look.steps.before.rows(slice(len(states.omega_body)))
        off = state_differences(states, read, look.equations.reach)[:, [0, 1, 4]]
        worst = int(np.abs(off).max(axis=(1, 2)).argmax())
        within = 2 * ULPS * max(engine.slack, rounding_of_body(self.at.condition))
        if np.abs(off[worst]).max() <= within:
            return None
        turn, omega, spins = map(float, norms(off[worst]))
        changes = misreading(read, states, is_single=engine.single_precision)
        at = float(self.at.times[worst % len(self.at.times)])
        time, zero = None if np.isnan(at) else at, (0.0, 0.0, 0.0)
        return StepFault("misread", "attitude", time, 0.0, (omega, turn, spins), zero, changes)

    def unless_random(self, found: StepEvidence) -> StepEvidence:
        """Return the evidence; its fault becomes `random` if the engine is not deterministic.

        The steps that show the fault are taken twice more from the same states. The engine is not
        deterministic if the two results differ by a quarter of the fault or more: as the fault is
        the largest deviation among many steps, two steps rarely differ by all of it. If the engine
        refuses these steps, the evidence is returned as it is.
        """
        if (fault := found.fault) is None:
            return found
        single = self.sessions.engine.single_precision
        halved = self.at.timesteps if single else self._halved_further
        try:
            one, again = (self._take(found.settled, self._repeats[0], halved) for _ in range(2))
        except EngineError:
            # Without these steps, the fault that was found stands.
            return found
        j = int(np.abs(one.steps.timesteps - fault.timestep).argmin())
        timestep = float(one.steps.timesteps[j])
        apart = (again.gains - one.gains)[j, :, QUANTITIES.index(fault.quantity)]
        off = np.linalg.norm(np.subtract(fault.got, fault.wanted))
        k = int(norms(apart).argmax())
        if norms(apart)[k] < off / (timestep if fault.kind == "leap" else 1.0) / 4:
            return found
        return replace(found, fault=random_fault(self.at, k, fault.quantity, timestep, apart[k]))

    def unless_first_alone(self, found: StepEvidence) -> StepEvidence:
        """Return the evidence; its fault is explained as that of first steps if it is theirs alone.

        The first step is the one from a state that was set. The fault is that of first steps if the
        gains of second steps tend to at most the fraction `LEFT` of what those of first steps do.
        A reading is late then, or a step depends on the one before. What explains a fault of second
        steps is added. If the engine refuses to take two steps, the evidence is returned as it is.
        """
        fault, first = found.fault, self.first
        if fault is None or fault.kind != "limit" or found.settled:
            return found
        try:
            second = self._take(1, self._repeats[0], self.at.timesteps)
        except EngineError:
            return found
        if second.known_to[0] > LEFT * first.known_to[0]:
            return found
        steps, ulp = first.steps, self.sessions.engine.ulp
        change = first_step_alone(steps.before, steps.after, steps.exact, ulp)
        again = evidence_of(second, self.at, found.declared).fault
        changes = change, *(again.changes if again else ())
        return replace(found, fault=replace(fault, changes=changes))

    @property
    def look(self) -> Look:
        """The steps, and the series of their gains, by which the method is judged.

        Constraints that give way settle before these steps. If a fault is not clear, shorter steps
        are taken as well, but only in double precision. In single precision more repeats are taken,
        until the limits are known well enough for a verdict, or until further repeats no longer
        help.
        """
        is_single, look, repeats = self.sessions.engine.single_precision, self.first, self._repeats
        settle, settling = 0, SETTLING // (1 + is_single)
        if self.at.gives_way or gives_way(look.equations, self.sessions.engine, look.steps):
            settle, look = settling, self._take_after_settling(settling, repeats[0])
        elif self._hinges_may_explain(look) and gives_in(
            look, settled := self._take_after_settling(settling, repeats[0])
        ):
            settle, look = settling, settled
        elif look.tail < LEVEL and not is_single and not _is_clear_fault(look):
            return self._take_shorter_steps()
        for count in repeats[1:]:
            if is_known(*look.known_to):
                break
            before = look
            if settle:
                look = self._take_after_settling(settle, count)
            else:
                look = self._take(0, count, self.at.timesteps)
            # Four times as many repeats halve a random error; any other error does not decrease.
            if max(look.known_to) ** 2 > max(before.known_to) ** 2 / 2:
                break
        return self._as_if_biased(look) if is_single and look.tail < LEVEL else look

    def _hinges_may_explain(self, look: Look) -> bool:
        """Return whether hinges that give way, as soft constraints do, may explain a look's fault.

        A look is steps with their gains.

        They may if there are rotors, if the fault is of the kind `limit`, that is, if gains tend to
        a limit other than zero, and if none of the `HALVINGS` timesteps has been left out.
        """
        has_hinges = look.steps.before.spins.size and len(self.at.timesteps) == HALVINGS
        return bool(has_hinges and look.tail < LEVEL and kind_of(look) == "limit")

    def _as_if_biased(self, look: Look) -> Look:
        """Return the steps of `look` with the noise of a bias in rounding added.

        The bias is alike in all repeats and states, so that the mean of repeats contains all of it.
        In every step, whatever the timestep, rounding was measured to add up to 3 ulp to the
        angular momentum in the engine Newton, and 2 to 3 ulp in Rapier.
        """
        biased = ULPS * self.sessions.engine.ulp * roundings(look.equations, look.steps)
        return replace(look, noise=np.hypot(look.noise, biased), is_pooled=False)

    def _take_after_settling(self, settle: int, repeats: int) -> Look:
        """Take steps after a constraint has settled for `settle` steps.

        The change of the gains by a few more steps of settling counts as noise of the constraint's
        solver, up to `CONSISTENT` of the largest terms, as the residual of a solver is not larger.
        In double precision the longest timesteps are left out, because at these the body turns by
        many radians while a constraint settles.

        Parameters
        ----------
        repeats : number of repeats of each state
        """
        halved = self.at.timesteps[0 if self.sessions.engine.single_precision else FINER :]
        look, further = (
            self._take(count, repeats, halved, may_split=True) for count in (settle, settle + FEW)
        )
        # A solver's residuals are alike in all states, so that the limits are not independent.
        return replace(_with_noise(look, further, CONSISTENT * look.sizes), is_pooled=False)

    @property
    def _halved_further(self) -> FloatArray:
        """The timesteps of `at`, s, and `FINER` more, each half of the one before."""
        finer = self.at.timesteps[-1] / 2.0 ** np.arange(1, FINER + 1)
        return np.concatenate([self.at.timesteps, finer])

    def _take_shorter_steps(self) -> Look:
        """Take steps with shorter timesteps, too, to see if their gains follow a second series.

        All steps are taken twice, the second time from states that are changed a little. The
        difference between the two gains counts as noise of the engine, up to `NOISE` a step.
        """
        look, again = (
            self._take(0, 1, self._halved_further, may_split=True, is_changed=is_changed)
            for is_changed in (False, True)
        )
        return _with_noise(look, again, noise_of_steps(look.equations, look.steps)[:, 0])

    def _take(
        self,
        settle: int,
        repeats: int,
        halved: FloatArray,
        *,
        may_split: bool = False,
        is_changed: bool = False,
    ) -> Look:
        """Take steps from each state, and return them with their gains and noise.

        If there are several repeats of a state, the gains are their mean, and each repeat starts
        from the state changed by a little.

        Parameters
        ----------
        settle : number of steps in which a constraint settles first
        repeats : number of repeats of each state; if it is 1, the state itself is used
        halved : timesteps, each half of the one before, s
        may_split : whether two series may be fitted to the gains, one at long and one at short
            timesteps, as a method may compute short steps by another formula
        is_changed : whether the state is changed even if it is used only once
        """
        engine, states = self.sessions.engine, self._states(repeats, is_changed=is_changed)
        steps = steps_from(self.sessions, states, self._timesteps(halved), settle, repeats)
        equations, is_single = Equations(self.sessions.scenario), engine.single_precision
        gains = step_gains(equations, steps).mean(axis=1)
        noise = noise_of(equations, steps, engine, self.at.condition, settled=bool(settle))
        # A second formula for small angles differs by less than single precision shows.
        split, apart = may_split and not is_single, self.at.are_apart
        return Look(equations, steps, gains, noise, settle, is_single, split, apart)

    def _states(self, repeats: int, *, is_changed: bool = False) -> State:
        """Return the K states from which steps are taken, R times: all K, then all K again, (R K).

        If R > 1 or `is_changed`, each repeat of all states is changed a little, by a random change.

        Parameters
        ----------
        repeats : R
        is_changed : whether the states are changed even if R is 1
        """
        if repeats == 1 and not is_changed:
            return self.at.states
        return self.at.changed(self.sessions.scenario, NUDGE * self.sessions.engine.ulp, repeats)

    def _timesteps(self, halved: FloatArray) -> FloatArray:
        """Return the timesteps at which steps are taken, s, long to short.

        These are the halved timesteps, one timestep between two of them, and the engine's stock
        timesteps in the same range. In single precision the shortest are left out.

        Parameters
        ----------
        halved : timesteps, each half of the one before, s
        """
        engine = self.sessions.engine
        if engine.single_precision:
            # Still shorter steps would show rounding alone.
            halved = halved[:-FINER]
        between = float(halved[3]) / 2**0.5
        stock = [h for h in stock_timesteps(engine) if halved[-1] < h < halved[0]]
        return np.array(sorted({*map(float, halved), between, *stock}, reverse=True))


def gives_way(equations: Equations, engine: Engine, steps: Steps) -> bool:
    """Return whether a soft constraint gives way, so that it must settle before steps are judged.

    If it does, the distance of com or velocity from the values that the constraint demands depends
    on the timestep. If instead the engine holds another body, or misreads it, that distance is the
    same at all timesteps.

    Parameters
    ----------
    steps : single steps at several timesteps, before which no constraint has settled
    """
    velocity, position = (
        steps.by_timestep(norms(off)) for off in off_the_constraint(equations, steps.after)
    )
    within = 2 * ULPS * engine.slack * equations.reach
    if np.ptp(position, axis=0).max() > within:
        return True
    fastest = max(float(norms(state.omega_body).max()) for state in (steps.before, steps.after))
    # The error of a misread velocity is nearly the same at all timesteps.
    change = np.ptp(velocity, axis=0).max()
    return bool(change > max(within * fastest, velocity.max() / 2))


def gives_in(look: Look, settled: Look) -> bool:
    """Return whether hinges give way, so that they must settle before steps are judged.

    How far a hinge gives way cannot be read from an engine. If hinges give way, the limits of gains
    in the quantity with the smallest tail shrink to less than half once the hinges have settled. If
    a fault makes the limits, they remain.

    Parameters
    ----------
    look, settled : the steps without settling, and those after settling
    """
    q = int(np.argmin([one.tail for one in look.series]))
    before, after = (norms(one.series[q].limit).max() for one in (look, settled))
    return bool(after < before / 2)


def _is_clear_fault(look: Look) -> bool:
    """Return whether gains of the shortest steps in `look` are mainly a limit, well above noise.

    That is a fault beyond doubt, and no further steps are needed.
    """
    noise = noise_of_steps(look.equations, look.steps)[-1]
    for q, series in enumerate(look.series):
        # The fitted limit means nothing where a series that vanishes explains the gains.
        if series.tail >= look.level:
            continue
        sizes, remainders = norms(series.limit), norms(look.gains[-1, :, q] - series.limit)
        if ((sizes > 2 * remainders) & (sizes > SURE * noise[:, q])).any():
            return True
    return False


def _with_noise(look: Look, again: Look, most: FloatArray) -> Look:
    """Return steps whose noise includes the difference of their gains from those of other steps.

    As that difference may be small by accident at one timestep, the largest difference at a
    timestep and its neighbours is used, up to a bound.

    Parameters
    ----------
    look : the steps
    again : steps from the same states, after further settling or a small change
    most : the bound, in the units of gains, for J timesteps and Q quantities, (J, Q) or (Q,)
    """
    difference = np.sqrt(((again.gains - look.gains) ** 2).mean(axis=(1, 3)))
    around = maximum_filter1d(difference, 3, axis=0, mode="nearest")
    noise = np.hypot(look.noise, np.minimum(around, most)[:, None])
    return replace(look, noise=noise)
