"""Comparisons of sessions and runs, from which the tests of adapters are built."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import pytest
from spincheck.engines import Engine, Method, Session
from spincheck.scenarios import FloatArray, Scenario, Trajectory
from spincheck.scenarios.rotation import norms, rotation_vectors
from spincheck.suite.contract_scenes import SCENES

#: Timestep of sessions that are compared, s.
TIMESTEP = 1e-3
#: Time over which orders are observed, s; and, for each declared order, a number of steps over that
#: time with which a method of this order is in its asymptotic range.
SPAN = 0.25
COARSEST = {1: 1024, 2: 128, 3: 128, 4: 16, 5: 32}
#: Least relative difference of two runs from which an order is computed, in machine epsilons:
#: smaller differences consist of round-off.
ABOVE_ROUND_OFF = 1000
#: A number of steps that is not a power of two.
ODD_STEPS = 115
#: Numbers of steps taken one after the other from a restart; states are compared after each. The
#: first is a single step, as an incomplete restart may change that step alone.
RESTART_STRIDES = (1, ODD_STEPS - 1)
#: Number of samples of a run.
SAMPLES = 8


def able_scenes(
    engine: Engine, method: Method, names: Iterable[str] = SCENES
) -> Iterator[Scenario]:
    """Yield the scenes of `SCENES` that a method can simulate; fail the test if there is none.

    Parameters
    ----------
    names : names of the scenes to choose from
    """
    able = [SCENES[name] for name in names if not engine.unsupported(SCENES[name], method)]
    require(bool(able), engine, method, None, "it can simulate none of the contract's scenes")
    yield from able


def moves_as_opened(engine: Engine, method: Method, scene: Scenario, session: Session) -> None:
    """Fail the test unless a restarted session steps like one that is opened at the same state.

    They must agree to the last bit, or to `engine.slack` if the session's restarts round.

    Parameters
    ----------
    scene : the scene with the start from which the session was restarted
    session : the restarted session
    """
    with engine.open(scene, method, TIMESTEP) as opened:
        for steps in RESTART_STRIDES:
            opened.advance(steps)
            session.advance(steps)
            is_same = same(session, opened)
            if not session.restarts_to_the_last_bit:
                is_same |= apart(session, opened) <= engine.slack
            require(is_same, engine, method, scene, "a restart is not a scene opened there")


def apart(first: Session, second: Session) -> float:
    """Return the largest difference of the states of two sessions.

    The attitude's is an angle, rad. Those of ω and other vectors are relative to the norm of the
    second session's vector, or absolute if this is zero.
    """
    one, other = first.read_state(), second.read_state()
    turn = rotation_vectors(one.q_world_body_wxyz[None], other.q_world_body_wxyz[None])
    pairs = list(zip(vars(one).values(), vars(other).values(), strict=True))[1:]
    apart = [float(np.linalg.norm(a - b) / (np.linalg.norm(b) or 1.0)) for a, b in pairs]
    return max(float(np.abs(turn).max()), *apart)


def moves_apart(engine: Engine, method: Method, other: Method, scene: Scenario) -> bool:
    """Return whether two methods, run on a scene, are in different states after a few steps."""
    with (
        engine.open(scene, method, TIMESTEP) as first,
        engine.open(scene, other, TIMESTEP) as second,
    ):
        first.advance(SAMPLES)
        second.advance(SAMPLES)
        return not same(first, second)


def observed_orders(engine: Engine, method: Method, scene: Scenario) -> tuple[float, float] | None:
    """Return the orders of convergence of ω and of attitude, from runs at three halved timesteps.

    None is returned if the runs differ by so little that round-off hides the orders. The test fails
    if a run does not reach its end.
    """
    coarsest = COARSEST.get(method.order, SAMPLES)
    motions: list[Trajectory] = []
    for refinement in (1, 2, 4):
        steps = coarsest * refinement
        run = engine.run(scene, method, SPAN / steps, np.arange(SAMPLES + 1) * (steps // SAMPLES))
        require(run.trajectory is not None, engine, method, scene, run.reason)
        assert run.trajectory is not None
        motions.append(run.trajectory)
    pairs = list(pairwise(motions))
    omega = [float(norms(a.omega_body - b.omega_body).max()) for a, b in pairs]
    turns = [rotation_vectors(a.q_world_body_wxyz, b.q_world_body_wxyz) for a, b in pairs]
    attitude = [float(norms(turn).max()) for turn in turns]
    numbers = np.float32 if engine.single_precision else np.float64
    visible = ABOVE_ROUND_OFF * float(np.finfo(numbers).eps)
    speed = float(norms(motions[0].omega_body).max())
    if omega[1] < visible * speed or attitude[1] < visible:
        return None
    return float(np.log2(omega[0] / omega[1])), float(np.log2(attitude[0] / attitude[1]))


def numbers(session: Session) -> FloatArray:
    """Return all numbers of a session's state in one array, (n,)."""
    return np.concatenate([np.ravel(column) for column in vars(session.read_state()).values()])


def same(first: Session, second: Session) -> bool:
    """Return whether two sessions are in the same state, to the last bit."""
    return np.array_equal(numbers(first), numbers(second))


def require(
    holds: bool, engine: Engine, method: Method, scene: Scenario | None, words: str
) -> None:
    """Fail the test, without a stack trace, unless a condition holds.

    Parameters
    ----------
    holds : whether it holds
    engine, method : the engine and method under test, which the message names
    scene : the scene that the condition is about; None if it is not about one scene
    words : what is wrong if the condition does not hold
    """
    if not holds:
        where = f" on '{scene.name}'" if scene is not None else ""
        pytest.fail(f"{engine.name} {method.name}{where}: {words}.", pytrace=False)
