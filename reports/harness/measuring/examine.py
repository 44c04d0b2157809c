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
from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import norms
from ...results.evidence import CONSISTENT, LEVEL, StepEvidence, StepFault, is_known
from ...results.reasons import fault_in_words
from ..explaining.readings import misreading
from ..timesteps.stock import stock_timesteps
from .look import Look
from .noise import SURE, ULPS, noise_of, noise_of_steps, rounding_of_body, roundings
from .places import FINER, HALVINGS, Places, places
from .step_evidence import evidence_of, kind_of
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

#: Steps until a constraint has settled. Bullet removes a fifth of its error in a step: 5e-10 of it
#: is left after so many. Half as many in single precision.
SETTLING = 96
#: Times that each state is repeated in single precision: no more than it takes.
REPEATS = (4, 16, 64)
#: Size of the random changes, in ulp, by which the repeats of a state differ: many ulp of what a
#: step adds, so that its rounding is another one, and too little to change the error of the step.
NUDGE = 2.0**16


def examine(
    engine: Engine, scenario: Scenario, method_name: str, at: Places, *, explains: bool = True
) -> StepEvidence | None:
    """Examine a method from exact states; None where it cannot be opened at them.

    Parameters
    ----------
    explains : whether changes of the equations of motion that explain a fault are looked for, which
        takes longer than finding it
    """
    with suppress(EngineError):
        return _examined(engine, scenario, engine.method(method_name), at, explains=explains)
    # The method's runs will tell why the engine refuses.
    return None


def physics_in_words(engine: Engine, scenario: Scenario, method: Method) -> str:
    """How single steps violate a scene's equations of motion, in words; empty if they do not.

    An engine as shipped need not obey these equations: for it the words are empty, too.
    """
    if method.as_shipped:
        return ""
    outline = ExactMotion(scenario).outline(scenario.times)
    try:
        found = _examined(engine, scenario, method, places(scenario, outline, None))
    except EngineError as error:
        return f"steps from states of the motion cannot be taken: {error}"
    return fault_in_words(found.fault) if found and found.fault else ""


def _examined(
    engine: Engine, scenario: Scenario, method: Method, at: Places, *, explains: bool = True
) -> StepEvidence | None:
    """Examine a method from exact states; None where it does not support them.

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
            return evidence_of(examination.look, states, order, explains=explains)
    return None


@dataclass(frozen=True, eq=False)
class _Examination:
    """A method that is examined from states."""

    sessions: Sessions
    at: Places

    @cached_property
    def first(self) -> Look:
        """Steps from the states themselves, or from few repeats of them in single precision."""
        return self._taken(0, self._repeats[0], self.at.timesteps)

    @property
    def _repeats(self) -> Sequence[int]:
        return REPEATS if self.sessions.engine.single_precision else (1,)

    @property
    def misread(self) -> StepFault | None:
        """The fault that a state is not read back as it was set; None if every state is."""
        look, engine, states = self.first, self.sessions.engine, self._states(self._repeats[0])
        # Com and velocity are left out, as a contact or a joint may move them to where it holds
        # them.
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

    @property
    def look(self) -> Look:
        """The steps and series by which the method is judged.

        More steps are taken until a limit is known well enough for a verdict.
        """
        is_single, look, repeats = self.sessions.engine.single_precision, self.first, self._repeats
        settle, settling = 0, SETTLING // (1 + is_single)
        if self.at.gives_way or gives_way(look.equations, self.sessions.engine, look.steps):
            settle, look = settling, self._settled(settling, repeats[0])
        elif self._may_give_in(look) and gives_in(
            look, settled := self._settled(settling, repeats[0])
        ):
            settle, look = settling, settled
        elif look.tail < LEVEL and not is_single and not _is_clear_fault(look):
            return self._with_shorter_steps()
        for count in repeats[1:]:
            if is_known(*look.known_to):
                break
            before = look
            if settle:
                look = self._settled(settle, count)
            else:
                look = self._taken(0, count, self.at.timesteps)
            # Four times as many repeats halve an error that is random; else more are in vain.
            if max(look.known_to) ** 2 > max(before.known_to) ** 2 / 2:
                break
        return self._as_if_biased(look) if is_single and look.tail < LEVEL else look

    def _may_give_in(self, look: Look) -> bool:
        """Whether hinges may be what makes gains a fault: they have a limit, and are no leaps."""
        has_hinges = look.steps.before.spins.size and len(self.at.timesteps) == HALVINGS
        return bool(has_hinges and look.tail < LEVEL and kind_of(look) == "limit")

    def _as_if_biased(self, look: Look) -> Look:
        """Judge the same steps as if rounding went one way in all repeats, and in all states.

        Then the mean of repeats has the whole of it. Newton's was measured to add up to 3 ulp to
        the angular momentum in every step, and Rapier's 2 to 3, whatever the timestep.
        """
        biased = ULPS * self.sessions.engine.ulp * roundings(look.equations, look.steps)
        return replace(look, noise=np.hypot(look.noise, biased), is_pooled=False)

    def _settled(self, settle: int, repeats: int) -> Look:
        """Take steps after a constraint has settled for so many steps.

        What some more steps of settling change is the noise of the constraint's solver; what is
        larger than `CONSISTENT` is no residual of a solver. In double precision the longest
        timesteps are left out, as the body turns by many radians while a constraint settles.
        """
        halved = self.at.timesteps[0 if self.sessions.engine.single_precision else FINER :]
        look, further = (
            self._taken(count, repeats, halved, may_split=True) for count in (settle, settle + FEW)
        )
        # What a solver leaves is alike in all states, so that their limits are not independent.
        return replace(_noisier(look, further, CONSISTENT * look.sizes), is_pooled=False)

    def _with_shorter_steps(self) -> Look:
        """Take steps with shorter timesteps, too, to see whether they follow a second series.

        All are taken twice, again from states that are changed a little. By how much a gain
        changes then is noise of the engine, which is no fault up to `NOISE` a step.
        """
        finer = self.at.timesteps[-1] / 2.0 ** np.arange(1, FINER + 1)
        halved = np.concatenate([self.at.timesteps, finer])
        look, again = (
            self._taken(0, 1, halved, may_split=True, is_changed=is_changed)
            for is_changed in (False, True)
        )
        return _noisier(look, again, noise_of_steps(look.equations, look.steps)[:, 0])

    def _taken(
        self,
        settle: int,
        repeats: int,
        halved: FloatArray,
        *,
        may_split: bool = False,
        is_changed: bool = False,
    ) -> Look:
        """Take steps from each state, and repeats of it that are changed a little.

        Parameters
        ----------
        settle : steps in which a constraint settles first
        may_split : whether a second series is looked for, as shorter steps are taken, too
        is_changed : whether a single repeat is changed as well
        """
        engine, states = self.sessions.engine, self._states(repeats, is_changed=is_changed)
        steps = steps_from(self.sessions, states, self._timesteps(halved), settle, repeats)
        equations, is_single = Equations(self.sessions.scenario), engine.single_precision
        gains = step_gains(equations, steps).mean(axis=1)
        noise = noise_of(equations, steps, engine, self.at.condition, settled=bool(settle))
        # A formula for small angles differs by less than single precision shows.
        split, apart = may_split and not is_single, self.at.are_apart
        return Look(equations, steps, gains, noise, settle, is_single, split, apart)

    def _states(self, repeats: int, *, is_changed: bool = False) -> State:
        if repeats == 1 and not is_changed:
            return self.at.states
        return self.at.changed(self.sessions.scenario, NUDGE * self.sessions.engine.ulp, repeats)

    def _timesteps(self, halved: FloatArray) -> FloatArray:
        """The timesteps of steps, s, long to short.

        They are the halved ones, one that is no power of two of them, and the engine's stock
        timesteps in the same range.
        """
        engine = self.sessions.engine
        if engine.single_precision:
            # Still shorter steps would show rounding alone.
            halved = halved[:-FINER]
        between = float(halved[3]) / 2**0.5
        stock = [h for h in stock_timesteps(engine) if halved[-1] < h < halved[0]]
        return np.array(sorted({*map(float, halved), between, *stock}, reverse=True))


def gives_way(equations: Equations, engine: Engine, steps: Steps) -> bool:
    """Whether a constraint gives way, so that it must settle before steps are judged.

    Then the distance of com or velocity from where the constraint should hold them depends on the
    timestep. If instead the engine holds another body, or misreads it, the distance is the same at
    any timestep.
    """
    velocity, place = (
        steps.by_timestep(norms(off)) for off in off_the_constraint(equations, steps.after)
    )
    within = 2 * ULPS * engine.slack * equations.reach
    if np.ptp(place, axis=0).max() > within:
        return True
    fastest = max(float(norms(state.omega_body).max()) for state in (steps.before, steps.after))
    # A misread velocity is off by nearly the same at all timesteps.
    change = np.ptp(velocity, axis=0).max()
    return bool(change > max(within * fastest, velocity.max() / 2))


def gives_in(look: Look, settled: Look) -> bool:
    """Whether hinges give way, so that they must settle before steps are judged.

    How far a hinge gives way is not read from an engine. Where one does, the limit that is the
    least likely is less than half as large after the hinge has settled; that of a fault remains.
    """
    q = int(np.argmin([one.tail for one in look.series]))
    before, after = (norms(one.series[q].limit).max() for one in (look, settled))
    return bool(after < before / 2)


def _is_clear_fault(look: Look) -> bool:
    """Whether the shortest steps gain mostly a limit well above noise: a fault beyond doubt.

    Then no further steps are needed.
    """
    noise = noise_of_steps(look.equations, look.steps)[-1]
    for q, series in enumerate(look.series):
        # A limit is none where a series that vanishes explains the gains.
        if series.tail >= look.level:
            continue
        sizes, left = norms(series.limit), norms(look.gains[-1, :, q] - series.limit)
        if ((sizes > 2 * left) & (sizes > SURE * noise[:, q])).any():
            return True
    return False


def _noisier(look: Look, again: Look, most: FloatArray) -> Look:
    """Steps, with the noise by which the same steps that are taken again differ.

    As that may be small by accident at one timestep, the largest of it and of those at the
    neighbouring timesteps is used.

    Parameters
    ----------
    most : what is no noise beyond, (J, Q) or (Q,)
    """
    drawn = np.sqrt(((again.gains - look.gains) ** 2).mean(axis=(1, 3)))
    around = maximum_filter1d(drawn, 3, axis=0, mode="nearest")
    noise = np.hypot(look.noise, np.minimum(around, most)[:, None])
    return replace(look, noise=noise)
