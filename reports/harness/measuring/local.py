"""Measures a method locally: single steps and short pieces from exact states along the motion."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace

import numpy as np

from ....engines import Engine, EngineError, Method, UnsupportedError
from ....engines.checks.consistency import Excess
from ....engines.checks.equation_residuals import differing, leap, rounding_of, settled
from ....engines.checks.equations import Equations
from ....engines.checks.extrapolation import ABOVE, COARSER
from ....engines.checks.read_back import State, stacked
from ....engines.checks.steps import Open, Steps
from ....engines.session import Session
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.scenario import started_at
from ...results.evidence import JudgedLadder, LocalEvidence
from ..judging.ladder import LadderJudgement
from ..judging.local import CONSISTENT, PIECE_GOAL, PIECE_RUNGS, is_known
from ..stock import stock_timesteps
from .places import (
    PIECE_STEPS,
    SAMPLE_EVERY,
    Places,
    apart,
    flowed,
    rounding_of_body,
)
from .richardson import RichardsonLadder

#: Halvings of all timesteps where the coarsest are refused, and of the finest where it surprises.
FINER = 3
#: Gains have no limit that become larger by such a factor at each of two halvings of the timestep.
GROWTH = 1.5
#: Times that each state is repeated in single precision: no more than it takes.
REPEATS = (1, 4, 16, 64)


def examine(
    engine: Engine, scenario: Scenario, method_name: str, at: Places
) -> LocalEvidence | None:
    """Examine a method from exact states; None where it cannot be opened at them."""
    method = engine.method(method_name)
    if engine.unsupported(scenario, method):
        return None
    for tried in (at, _milder(at)):
        try:
            return _examined(engine, scenario, method, tried)
        except UnsupportedError:
            continue
        except EngineError:
            break
    # What an engine refuses, its runs tell.
    return None


def _milder(at: Places) -> Places:
    """Finer timesteps from states of the motion alone: a method may not bear others."""
    along = ~np.isnan(at.times)
    timesteps = at.timesteps / 2.0**FINER
    states, times = at.states.rows(along), at.times[along]
    return replace(at, states=states, times=times, timesteps=timesteps, finer=FINER)


def _examined(engine: Engine, scenario: Scenario, method: Method, at: Places) -> LocalEvidence:
    equations = Equations(scenario)
    with engine.open(scenario, method, float(at.timesteps[0])) as session:

        def open_at(scene: Scenario, timestep: float) -> AbstractContextManager[Session]:
            # Opening takes as long as some hundred steps: where it can be, one is restarted.
            if session.can_restart:
                return nullcontext(session)
            return engine.open(scene, method, timestep)

        misread = _misread(engine, scenario, method, at, session)
        steps, found = _consistency(open_at, engine, scenario, at)
        if found.unsmooth[-FINER:].max() > 1 and not engine.single_precision:
            # Whether finer steps are computed otherwise is seen from both sides alone.
            finer = at.timesteps[-1] / 2.0 ** np.arange(1, FINER + 1)
            longer = replace(at, timesteps=np.concatenate([at.timesteps, finer]))
            seen, both = _consistency(open_at, engine, scenario, longer)
            if both.branched.any():
                at, steps, found = longer, seen, both
        is_smooth = not found.is_constrained
        wrong = misread or _wrong(engine, equations, steps, found, at, is_smooth=is_smooth)
        eps = rounding_of(steps.before, engine.single_precision)
        pieces = None if wrong else _pieces(engine, scenario, method, at, session, eps)
    return LocalEvidence(
        finding=wrong,
        excess=float(found.by_tolerance.max()),
        tolerance=found.at_most,
        is_open=found.is_open,
        states=len(at.times),
        starts=len(at.starts),
        pieces=pieces,
        remark="" if wrong else _branch(engine, found, at, is_smooth=is_smooth),
        of_an_effect=found.of_an_effect,
    )


def acts_at_any_timestep(open_at: Open, engine: Engine, scenario: Scenario, at: Places) -> bool:
    """Whether a session's settings alter the equations of motion, however short its steps are.

    Where gains of steps grow as timesteps vanish they have no limit that could be found to be off:
    a motor that stops a body within any step gives it any acceleration.

    Raises
    ------
    EngineError
        If it cannot be opened or stepped.
    """
    _, found = _consistency(open_at, engine, scenario, at)
    last = found.by_timestep[-3:]
    grows = (last[1:] > GROWTH * last[:-1]).all(axis=0) & (last[-1] > CONSISTENT)
    return bool(grows.any() or found.by_tolerance.max() > 1)


def _consistency(
    open_at: Open, engine: Engine, scenario: Scenario, at: Places
) -> tuple[Steps, Excess]:
    """Steps from exact states, and what they gain; in single precision from many near them."""
    return settled(
        open_at,
        scenario,
        lambda repeats: at.repeated(scenario, repeats),
        (_halved(engine, at), np.array(_others(engine, at))),
        lambda states, spans: flowed(scenario, states, spans),
        _slack(engine, at),
        is_single=engine.single_precision,
        least_turn=engine.least_turn,
        repeats=REPEATS if engine.single_precision else REPEATS[:1],
        is_enough=is_known,
    )


def _slack(engine: Engine, at: Places) -> float:
    """Relative to the largest terms, what the body as an engine holds it leaves."""
    rounding = rounding_of_body(at.condition, engine.ulp)
    # In single precision what is read back may be off by far more than rounding of moments does.
    return rounding if engine.single_precision else max(engine.slack, rounding)


def _halved(engine: Engine, at: Places) -> FloatArray:
    """The timesteps of single steps; in single precision finer ones show rounding alone."""
    return at.timesteps[:PIECE_RUNGS] if engine.single_precision else at.timesteps


def _others(engine: Engine, at: Places) -> list[float]:
    """One timestep between two rungs, and the engine's stock ones that are within the ladder's."""
    finest, coarsest = _halved(engine, at)[-1], at.timesteps[0]
    stock = [h for h in stock_timesteps(engine) if finest <= h < coarsest]
    return [float(at.timesteps[COARSER]) / 2**0.5, *stock]


@contextmanager
def _started(
    engine: Engine,
    scenario: Scenario,
    method: Method,
    session: Session,
    state: State,
    timestep: float,
) -> Iterator[Session]:
    """The session set to a state; another one, closed after use, where that cannot be."""
    if session.can_restart:
        session.restart(state, timestep)
        yield session
        return
    with engine.open(started_at(scenario, **vars(state)), method, timestep) as own:
        yield own


def _misread(
    engine: Engine, scenario: Scenario, method: Method, at: Places, session: Session
) -> str:
    """The sentence on a state that reads back otherwise than it was set; empty if none does."""
    timestep, count = float(at.timesteps[0]), len(at.times)
    starts = []
    for k in range(count):
        with _started(engine, scenario, method, session, at.states.rows(k), timestep) as one:
            starts.append(one.read_state())
    off = apart(at.states, stacked(starts))
    if off.max() <= ABOVE * max(engine.slack, rounding_of_body(at.condition)):
        return ""
    k = int(np.argmax(off))
    return (
        f"a state that is set reads back otherwise, {_when(at.times[k])}: off by {off[k]:.2g} in "
        f"ω, relative, or {np.degrees(off[k]):.2g}° in attitude"
    )


def _wrong(
    engine: Engine,
    equations: Equations,
    steps: Steps,
    found: Excess,
    at: Places,
    *,
    is_smooth: bool,
) -> str:
    """How steps are inconsistent with the equations of motion, in words; else empty."""
    if wrong := leap(found, steps) or differing(equations, steps, found, [*map(_when, at.times)]):
        return wrong
    unsmooth = np.vstack([found.unsmooth, found.unsmooth_others])
    if is_smooth and unsmooth.max() > 1:
        timestep, quantity, _ = _largest(engine, unsmooth, at)
        return (
            f"with a timestep of {timestep:.3g} s a step gains what steps of other lengths do not "
            f"predict, in {quantity}: what acts depends on the timestep"
        )
    return ""


def _branch(engine: Engine, found: Excess, at: Places, *, is_smooth: bool) -> str:
    """The sentence on steps that are computed otherwise above and below some length; else empty."""
    timestep, quantity, change = _largest(engine, found.branched, at)
    if not is_smooth or change == 0:
        return ""
    return (
        f"from a timestep of about {timestep:.3g} s on a step is computed otherwise: by "
        f"{change:.1e} of the largest terms in {quantity}, which vanishes with the timestep"
    )


def _largest(engine: Engine, table: FloatArray, at: Places) -> tuple[float, str, float]:
    """The timestep, s, the quantity and the value of the largest of (J + …, 4)."""
    j, quantity = np.unravel_index(int(np.argmax(table)), table.shape)
    timestep = [*_halved(engine, at), *_others(engine, at)][j]
    return float(timestep), QUANTITY_NAMES[quantity], float(table[j, quantity])


QUANTITY_NAMES = ("dR/dt", "I dω/dt", "the com's velocity", "the com's place")


def _when(time: float) -> str:
    return "at the start with ω along a skew axis" if np.isnan(time) else f"at t = {time:.3g} s"


def _pieces(
    engine: Engine, scenario: Scenario, method: Method, at: Places, session: Session, eps: float
) -> JudgedLadder:
    """A ladder of short runs from some of the states, all judged together."""
    ladder = RichardsonLadder(
        scenario, at.pieces, method.order, method.attitude_order, engine.slack, eps
    )
    for k in range(PIECE_RUNGS):
        ladder.add(float(at.timesteps[k]), *_run_pieces(engine, scenario, method, at, session, k))
        if LadderJudgement(ladder.judged).converges_to(PIECE_GOAL):
            break
    return ladder.judged


def _run_pieces(
    engine: Engine, scenario: Scenario, method: Method, at: Places, session: Session, k: int
) -> tuple[Trajectory, int]:
    """The motion from each start, and its steps."""
    strides = [0, *[SAMPLE_EVERY << (k + at.finer)] * (PIECE_STEPS // SAMPLE_EVERY)]
    snapshots: list[object] = []
    for start in at.starts:
        state = at.states.rows(int(start))
        timestep = float(at.timesteps[k])
        with _started(engine, scenario, method, session, state, timestep) as one:
            one.record(strides, snapshots.append)
    states = session.states(snapshots)
    return Trajectory(at.pieces.trajectory.t, *vars(states).values()), PIECE_STEPS << (k + at.finer)
