"""The requirements: each is a function of an engine and a method that raises if it is not met.

A method as shipped has fewer requirements: it may hold another body and apply other effects than
the scene has, but must do so every time.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise

import numpy as np

from ...scenarios import FloatArray, Scenario, Trajectory
from ...scenarios.rotation import norms, rotation_vectors
from ..checks.read_back import start_state
from ..engine import Engine, Method
from ..session import Session
from .scenes import SCENES, from_elsewhere

Check = Callable[[Engine, Method], None]

TIMESTEP = 1e-3
#: Number of steps, and timestep, neither of them a power of two.
ODD_STEPS, ODD_TIMESTEP = 115, 1e-4
#: s, and steps over it at which a method of this order is in its asymptotic range.
SPAN = 0.25
COARSEST = {1: 1024, 2: 128, 3: 128, 4: 16, 5: 32}
#: How far an order may fall short of the declared one, as for the verdict of a ladder.
ORDER_SLACK = 0.25
#: Differences that an order is computed from are at least this many roundings.
ABOVE_ROUND_OFF = 1000
#: For requirements that do not depend on the scene: free and on a pivot, with changing torques.
FEW = ("free", "free-torque-body", "heavy-tilted", "everything")
#: For restarts: also a body whose com is not its origin, free to move.
RESTARTED = (*FEW, "free-falling", "pivot-drag", "free-rotors", "pivot-rotors")
#: Steps after a restart: what it left out may show in the first alone.
RESTART_STRIDES = (1, ODD_STEPS - 1)
#: Samples of a run.
SAMPLES = 8


class ContractBroken(AssertionError):
    """An engine does not meet a requirement on every engine."""


def holds_the_scene_and_only_its_effects_act(engine: Engine, method: Method) -> None:
    """Body and start read back as in the scene; its effects act, and nothing else."""
    if method.as_shipped:
        return
    for scene in _scenes(engine, method):
        run = engine.run(scene, method, TIMESTEP, np.arange(0, 101, 20))
        _require(run.outcome == "ok", engine, method, scene, f"it {run.outcome}: {run.reason}")
        _require(not run.reason, engine, method, scene, run.reason)


def begins_as_the_equations_of_motion_say(engine: Engine, method: Method) -> None:
    """The first steps obey Euler's and Newton's equations of the scene: effects, units, frames."""
    for scene in _scenes(engine, method):
        residuals = engine.equation_residuals(scene, method)
        _require(not residuals, engine, method, scene, residuals)


def is_of_the_declared_order(engine: Engine, method: Method) -> None:
    """ω and attitude converge with the declared order or better on all scenes, just it on one."""
    if method.as_shipped:
        return
    seen: list[tuple[float, float]] = []
    for scene in _scenes(engine, method):
        orders = _observed_orders(engine, method, scene)
        if orders is None:
            continue
        for what, observed, declared in zip(
            ("ω", "attitude"), orders, (method.order, method.attitude_order), strict=True
        ):
            words = f"{what} converges with order {observed:.2f}, declared is {declared}"
            _require(observed > declared - ORDER_SLACK, engine, method, scene, words)
        seen.append(orders)
    if seen:
        omega, attitude = np.min(seen, axis=0)
        words = f"orders are {omega:.2f} and {attitude:.2f} at least, declared are less"
        is_declared = omega < method.order + ORDER_SLACK
        is_declared &= attitude < method.attitude_order + ORDER_SLACK
        _require(bool(is_declared), engine, method, None, words)


def repeats_to_the_last_bit(engine: Engine, method: Method) -> None:
    """Two runs of a scene give the same motion, to the last bit."""
    for scene in _scenes(engine, method, FEW):
        with (
            engine.open(scene, method, TIMESTEP) as first,
            engine.open(scene, method, TIMESTEP) as second,
        ):
            first.advance(ODD_STEPS)
            second.advance(ODD_STEPS)
            _require(_same(first, second), engine, method, scene, "a second run is another motion")


def takes_many_steps_at_once_as_it_takes_them_one_by_one(engine: Engine, method: Method) -> None:
    """A call of k steps gives the same state as k calls of one step, to the last bit."""
    for scene in _scenes(engine, method, FEW):
        with (
            engine.open(scene, method, ODD_TIMESTEP) as at_once,
            engine.open(scene, method, ODD_TIMESTEP) as one_by_one,
        ):
            at_once.advance(ODD_STEPS)
            for _ in range(ODD_STEPS):
                one_by_one.advance(1)
            words = f"{ODD_STEPS} steps in a call are not as many calls"
            _require(_same(at_once, one_by_one), engine, method, scene, words)


def is_not_disturbed_by_being_read(engine: Engine, method: Method) -> None:
    """Reading and checking between steps changes nothing."""
    for scene in _scenes(engine, method, FEW):
        with (
            engine.open(scene, method, TIMESTEP) as watched,
            engine.open(scene, method, TIMESTEP) as alone,
        ):
            for _ in range(ODD_STEPS):
                watched.advance(1)
                watched.check()
                watched.snapshot()
                watched.read_state()
                watched.read_body()
                alone.advance(1)
            words = "reading between steps changes the motion"
            _require(_same(watched, alone), engine, method, scene, words)


def shares_no_memory_between_sessions(engine: Engine, method: Method) -> None:
    """Sessions stepped in turn move as each would alone; states that were read do not change."""
    scenes = list(_scenes(engine, method))
    chosen = [scenes[0], scenes[len(scenes) // 2], scenes[-1]]
    for one, other in pairwise([*chosen, chosen[0]]):
        with (
            engine.open(one, method, TIMESTEP) as first,
            engine.open(other, method, TIMESTEP) as second,
        ):
            before = first.read_state()
            kept = {name: np.array(column) for name, column in vars(before).items()}
            for _ in range(SAMPLES):
                first.advance(1)
                # More steps, so that the two differ on the same scene too.
                second.advance(2)
            is_kept = all(np.array_equal(getattr(before, name), kept[name]) for name in kept)
            _require(is_kept, engine, method, one, "a state that was read changes with later steps")
            interleaved = _numbers(first)
        with engine.open(one, method, TIMESTEP) as alone:
            for _ in range(SAMPLES):
                alone.advance(1)
            words = f"stepped in turn with '{other.name}' it moves in another way"
            _require(np.array_equal(_numbers(alone), interleaved), engine, method, one, words)


def records_what_it_reads(engine: Engine, method: Method) -> None:
    """The snapshots of a run equal the states that are read one by one."""
    for scene in _scenes(engine, method, FEW):
        snapshots: list[object] = []
        with (
            engine.open(scene, method, TIMESTEP) as recorded,
            engine.open(scene, method, TIMESTEP) as read,
        ):
            recorded.record([0, *[3] * SAMPLES], snapshots.append)
            states = recorded.states(snapshots)
            rows = [_numbers(read)]
            for _ in range(SAMPLES):
                read.advance(3)
                rows.append(_numbers(read))
            together = np.hstack([np.asarray(column) for column in vars(states).values()])
            size = np.abs(rows).max(axis=0)
            is_same = (np.abs(together - rows) <= 16 * np.finfo(float).eps * size).all()
            _require(bool(is_same), engine, method, scene, "snapshots are not what is read")


def restarts_as_it_opens(engine: Engine, method: Method) -> None:
    """After a run, a restart from the scene's start or another is a scene opened there.

    At another timestep, too; and the same restart again gives the same motion, to the last bit.
    """
    for scene in _scenes(engine, method, RESTARTED):
        with engine.open(scene, method, ODD_TIMESTEP) as session:
            if not session.can_restart:
                continue
            for start in (scene, from_elsewhere(scene)):
                session.advance(ODD_STEPS)
                session.restart(start_state(start), TIMESTEP)
                unlike = engine.differences(
                    start, method.name, session.read_body(), session.read_state()
                )
                words = f"restarted, {unlike[0].complaint}" if unlike else ""
                _require(not words or method.as_shipped, engine, method, scene, words)
                _moves_as_opened(engine, method, start, session)
                session.check()
                first = _numbers(session)
                session.restart(start_state(start))
                for steps in RESTART_STRIDES:
                    session.advance(steps)
                words = "restarted twice it moves in two ways"
                _require(np.array_equal(_numbers(session), first), engine, method, scene, words)


def differs_from_every_other_method(engine: Engine, method: Method) -> None:
    """Its motion differs on some scene; a method as shipped may equal another."""
    if method.as_shipped:
        return
    for other in engine.methods:
        if other == method or other.as_shipped:
            continue
        both = [s for s in _scenes(engine, method) if not engine.unsupported(s, other)]
        if both and not any(_moves_apart(engine, method, other, scene) for scene in both):
            _require(False, engine, method, None, f"it never differs from {other.name}")


CHECKS: tuple[Check, ...] = (
    holds_the_scene_and_only_its_effects_act,
    begins_as_the_equations_of_motion_say,
    is_of_the_declared_order,
    repeats_to_the_last_bit,
    takes_many_steps_at_once_as_it_takes_them_one_by_one,
    is_not_disturbed_by_being_read,
    shares_no_memory_between_sessions,
    records_what_it_reads,
    restarts_as_it_opens,
    differs_from_every_other_method,
)


def _scenes(engine: Engine, method: Method, names: Iterable[str] = SCENES) -> Iterator[Scenario]:
    """The scenes that the method can simulate; at least one, or the contract is broken."""
    able = [SCENES[name] for name in names if not engine.unsupported(SCENES[name], method)]
    _require(bool(able), engine, method, None, "it can simulate none of the contract's scenes")
    yield from able


def _moves_as_opened(engine: Engine, method: Method, scene: Scenario, session: Session) -> None:
    """Require that a restarted session steps like one that is opened."""
    with engine.open(scene, method, TIMESTEP) as opened:
        for steps in RESTART_STRIDES:
            opened.advance(steps)
            session.advance(steps)
            is_same = _same(session, opened)
            if not session.restarts_to_the_last_bit:
                is_same |= _apart(session, opened) <= engine.slack
            _require(is_same, engine, method, scene, "a restart is not a scene opened there")


def _apart(first: Session, second: Session) -> float:
    """The largest difference of two states: rad, of other quantities relative to their size."""
    one, other = first.read_state(), second.read_state()
    turn = rotation_vectors(one.q_world_body_wxyz[None], other.q_world_body_wxyz[None])
    pairs = list(zip(vars(one).values(), vars(other).values(), strict=True))[1:]
    apart = [float(np.linalg.norm(a - b) / (np.linalg.norm(b) or 1.0)) for a, b in pairs]
    return max(float(np.abs(turn).max()), *apart)


def _moves_apart(engine: Engine, method: Method, other: Method, scene: Scenario) -> bool:
    with (
        engine.open(scene, method, TIMESTEP) as first,
        engine.open(scene, other, TIMESTEP) as second,
    ):
        first.advance(SAMPLES)
        second.advance(SAMPLES)
        return not _same(first, second)


def _observed_orders(engine: Engine, method: Method, scene: Scenario) -> tuple[float, float] | None:
    """Signed orders of ω and attitude, from three runs; None where round-off hides them."""
    coarsest = COARSEST.get(method.order, SAMPLES)
    motions: list[Trajectory] = []
    for refinement in (1, 2, 4):
        steps = coarsest * refinement
        run = engine.run(scene, method, SPAN / steps, np.arange(SAMPLES + 1) * (steps // SAMPLES))
        _require(run.trajectory is not None, engine, method, scene, run.reason)
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


def _numbers(session: Session) -> FloatArray:
    """All numbers of a state, (13,)."""
    return np.concatenate([np.ravel(column) for column in vars(session.read_state()).values()])


def _same(first: Session, second: Session) -> bool:
    return np.array_equal(_numbers(first), _numbers(second))


def _require(
    holds: bool, engine: Engine, method: Method, scene: Scenario | None, words: str
) -> None:
    if not holds:
        where = f" on '{scene.name}'" if scene is not None else ""
        raise ContractBroken(f"{engine.name} {method.name}{where}: {words}.")
