"""Examines a method by single steps from known states, with the model of `gain_series.py`."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ....engines import Engine, EngineError, Method, UnsupportedError
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import norms
from ...results.evidence import CONSISTENT, LEVEL, StepEvidence, StepFault
from ...results.reasons import fault_in_words
from ..stock import stock_timesteps
from .look import Look
from .noise import SIGMAS, SOLVED, ULPS, noise_of, noise_of_steps, rounding_of_body
from .places import FINER, Places, places
from .readings import misreading
from .shapes import SURE
from .step_evidence import evidence_of
from .steps import (
    Open,
    Sessions,
    Steps,
    apart,
    off_the_constraint,
    sessions_of,
    step_gains,
    steps_from,
)

#: Steps until a constraint has settled, and more steps that show what was left. Bullet removes a
#: fifth of its error in a step: 0.8^96 = 5e-10 of it is left. Half as many in single precision.
SETTLING, FURTHER = 96, 16
#: States or intervals at most where a scene is opened anew for each, which takes long.
OPENED = 8
#: Times that each state is repeated in single precision: no more than it takes.
REPEATS = (4, 16, 64)
#: Four times the repeats halve what chance leaves. Where more than this is left, it is no chance.
STILL_GAINING = 0.75
#: Halved timesteps in single precision: shorter steps show rounding alone.
HALVINGS_SINGLE = 7
#: rad, and relative to the spin, by which the repeats of a state differ: of a step's change of
#: state they alter many ulps in single precision, and little of the step's error.
NUDGE = 2.0**-7
#: Relative change of a state that draws an engine's noise anew: 64 ulp.
REDRAWN = 2.0**-46


def examine(
    engine: Engine, scenario: Scenario, method_name: str, at: Places
) -> StepEvidence | None:
    """Examine a method from exact states; None where it cannot be opened at them."""
    try:
        return _examined_where_supported(engine, scenario, engine.method(method_name), at)
    except EngineError:
        # What an engine refuses, its runs tell.
        return None


def _examined_where_supported(
    engine: Engine, scenario: Scenario, method: Method, at: Places
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
        with suppress(UnsupportedError):
            return examined(
                lambda scene, timestep: engine.open(scene, method, timestep),
                engine,
                scenario,
                tried,
                method,
            )
    return None


def physics_in_words(engine: Engine, scenario: Scenario, method: Method) -> str:
    """How single steps violate a scene's equations of motion, in words; empty if they do not.

    It is empty, too, for an engine as shipped, which need not obey these equations.
    """
    if method.as_shipped:
        return ""
    outline = ExactMotion(scenario).outline(scenario.times)
    at = places(scenario, outline, None)
    try:
        found = _examined_where_supported(engine, scenario, method, at)
    except EngineError as error:
        return f"steps from states of the motion cannot be taken: {error}"
    return fault_in_words(found.fault) if found and found.fault else ""


def examined(
    open_at: Open, engine: Engine, scenario: Scenario, at: Places, method: Method
) -> StepEvidence:
    """What single steps show of a method whose sessions are opened by a function.

    Raises
    ------
    EngineError
        If a session cannot be opened or stepped.
    """
    with sessions_of(open_at, scenario, float(at.timesteps[0])) as sessions:
        if not sessions.first.can_restart:
            at = at.thinned(OPENED)
        if fault := _misread(sessions, engine, at):
            return StepEvidence(len(at.times), 0.0, 0.0, 0.0, 0, fault=fault)
        order = 0 if engine.single_precision else method.order
        return evidence_of(_Examination(sessions, engine, at).look, at, order)


@dataclass(frozen=True, eq=False)
class _Examination:
    """A method that is examined from states."""

    sessions: Sessions
    engine: Engine
    at: Places

    @property
    def look(self) -> Look:
        """The steps and series by which the method is judged: taken anew until they suffice."""
        is_single = self.engine.single_precision
        look = self._taken(0, REPEATS[0] if is_single else 1)
        settle = 0
        if self.at.gives_way or gives_way(look.equations, self.engine, look.steps):
            settle = SETTLING // (1 + is_single)
            look = self._settled(settle, look.steps.repeats)
        elif look.tail < LEVEL and not is_single and not _is_plain(look):
            return self._taken_again()
        for repeats in REPEATS[1:] if is_single else ():
            # What explains a fault is known better with more of them, too.
            if look.is_known:
                break
            more = self._settled(settle, repeats) if settle else self._taken(0, repeats)
            is_in_vain = max(more.known_to) > STILL_GAINING * max(look.known_to)
            look = more
            if is_in_vain:
                break
        return look

    def _taken(self, settle: int, repeats: int) -> Look:
        steps = self._steps(settle, repeats, self._timesteps(self.at.timesteps))
        # Another look with shorter steps shows that.
        return replace(self._look(steps, settle), may_split=False)

    def _settled(self, settle: int, repeats: int) -> Look:
        """Steps after a constraint has settled; what further settling changes is their noise.

        In double precision the longest timesteps are left out, with which the body turns by many
        radians meanwhile. A difference may be small by accident, so that those with neighbouring
        timesteps count as well.
        """
        halved = self.at.timesteps[0 if self.engine.single_precision else FINER :]
        timesteps = self._timesteps(halved)
        look = self._look(self._steps(settle, repeats, timesteps), settle)
        further = self._look(self._steps(settle + FURTHER, repeats, timesteps), settle)
        left = np.sqrt(((further.gains - look.gains) ** 2).mean(axis=(1, 3)))
        around = np.pad(left, ((1, 1), (0, 0)), mode="edge")
        seen = SIGMAS * np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])
        # What is larger is no residual of a solver.
        seen = np.minimum(seen, CONSISTENT * look.sizes)
        noise = np.sqrt(look.noise**2 + seen[:, None] ** 2 + (SOLVED * look.sizes) ** 2)
        # What a solver leaves of one state it leaves of others alike.
        return replace(look, noise=noise, is_pooled=False)

    def _taken_again(self) -> Look:
        """Steps with shorter timesteps too, taken twice: again from states changed by 64 ulp.

        What that change makes of a gain is noise of the engine, and up to `NOISE` a step no fault.
        The shorter steps show whether a method computes short steps otherwise.
        """
        finer = self.at.timesteps[-1] / 2.0 ** np.arange(1, FINER + 1)
        timesteps = self._timesteps(np.concatenate([self.at.timesteps, finer]))
        look = self._look(self._steps(0, 1, timesteps), 0)
        changed = self.at.changed(self.sessions.scenario, REDRAWN)
        again = self._look(steps_from(self.sessions, changed, timesteps), 0)
        drawn = np.sqrt(((again.gains - look.gains) ** 2).mean(axis=(1, 3)))[:, None]
        seen = np.minimum(drawn, noise_of_steps(look.equations, look.steps))
        return replace(look, noise=np.hypot(look.noise, seen))

    def _steps(self, settle: int, repeats: int, timesteps: FloatArray) -> Steps:
        states = self.at.states
        if repeats > 1:
            states = self.at.changed(self.sessions.scenario, NUDGE, repeats)
        return steps_from(self.sessions, states, timesteps, settle, repeats)

    def _look(self, steps: Steps, settle: int) -> Look:
        equations = Equations(self.sessions.scenario)
        gains = step_gains(equations, steps).mean(axis=1)
        noise = noise_of(equations, steps, self.engine, self.at.condition, settled=bool(settle))
        is_single = self.engine.single_precision
        # What short steps leave out of a turn is less than rounding of 24 bits.
        split = not is_single
        return Look(equations, steps, gains, noise, settle, is_single, split, self.at.are_apart)

    def _timesteps(self, halved: FloatArray) -> FloatArray:
        """The timesteps of steps, s, long to short.

        They are the halved ones, one between two of these, and the engine's stock timesteps where
        they lie among them.
        """
        if self.engine.single_precision:
            halved = halved[:HALVINGS_SINGLE]
        between = float(halved[3]) / 2**0.5
        stock = [h for h in stock_timesteps(self.engine) if halved[-1] < h < halved[0]]
        return np.array(sorted({*map(float, halved), between, *stock}, reverse=True))


def gives_way(equations: Equations, engine: Engine, steps: Steps) -> bool:
    """Whether a constraint gives way: how far com or velocity are off it depends on the timestep.

    Where the engine holds another body, or misreads it, they are off by as much at any timestep.
    After a short step the com is off by rounding alone, and the velocity by what an impulse left.
    """
    velocity, place = (
        steps.by_timestep(norms(off)) for off in off_the_constraint(equations, steps.after)
    )
    within = 2 * ULPS * engine.slack * equations.reach
    if np.ptp(place, axis=0).max() > within:
        return True
    fastest = max(float(norms(state.omega_body).max()) for state in (steps.before, steps.after))
    # What a misreading makes of it changes by less than itself.
    change = np.ptp(velocity, axis=0).max()
    return bool(change > max(within * fastest, velocity.max() / 2))


def _is_plain(look: Look) -> bool:
    """Whether most of what the shortest steps gain is a limit that is well above noise.

    No other steps are needed then.
    """
    noise = noise_of_steps(look.equations, look.steps)[-1]
    for q, series in enumerate(look.series):
        sizes, left = norms(series.limit), norms(look.gains[-1, :, q] - series.limit)
        if ((sizes > 2 * left) & (sizes > SURE * noise[:, q])).any():
            return True
    return False


def _misread(sessions: Sessions, engine: Engine, at: Places) -> StepFault | None:
    """The fault that a state reads back otherwise than it was set; None if none does."""
    starts = []
    for k in range(len(at.times)):
        with sessions.at(at.states.rows(k), float(at.timesteps[0])) as one:
            starts.append(one.read_state())
    reach = Equations(sessions.scenario).reach
    # A contact or a joint puts the com where it belongs.
    read = stacked(starts)
    off = apart(at.states, read, reach)[:, [0, 1, 4]]
    k = int(np.abs(off).max(axis=(1, 2)).argmax())
    if np.abs(off[k]).max() <= 2 * ULPS * max(engine.slack, rounding_of_body(at.condition)):
        return None
    turn, omega, spins = norms(off[k])
    is_single = engine.single_precision
    zero, changes = (0.0, 0.0, 0.0), misreading(read, at.states, reach, is_single=is_single)
    time = None if np.isnan(at.times[k]) else float(at.times[k])
    return StepFault(
        "misread", "attitude", time, 0.0, (float(omega), float(turn), float(spins)), zero, changes
    )
