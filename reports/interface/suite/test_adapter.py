"""Tests of an adapter: what every engine must do so that its runs can be trusted.

Each test is run on an engine and a method. Less is required of a method as shipped: it may hold
another body and apply other effects than those of the scene, if it does so in every run.
"""

from itertools import pairwise

import numpy as np
from spincheck.engines import Engine, Method
from spincheck.engines.checks.read_back import start_state
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.suite.comparisons import (
    ODD_STEPS,
    RESTART_STRIDES,
    SAMPLES,
    TIMESTEP,
    able_scenes,
    moves_apart,
    moves_as_opened,
    numbers,
    observed_orders,
    require,
    same,
)
from spincheck.suite.contract_scenes import from_elsewhere
from spincheck.suite.failure_means import failure_means

#: Timestep, s; not a power of two.
ODD_TIMESTEP = 1e-4
#: How far an observed order may be off the declared one; the verdict on a ladder allows the same.
ORDER_SLACK = 0.25
#: Scenes for requirements that do not depend on the scene. Bodies are free, on a pivot or on a
#: table, and some torques change with time.
FEW = ("free", "free-torque-body", "heavy-tilted", "table-torque-body", "everything")
#: Scenes for restarts: those of `FEW`, a free body whose com is not its origin, drag, and rotors.
RESTARTED = (*FEW, "free-falling", "pivot-drag", "free-rotors", "pivot-rotors")


@failure_means(
    "Mass, tensor, com or start are not what was set, or something acts that the scene has not.",
    "google-deepmind/mujoco#3559",
    "google-deepmind/mujoco#2982",
    "google-deepmind/mujoco#243",
    "o3de/o3de#20016",
    "isaac-sim/IsaacLab#4161",
    "bulletphysics/bullet3#4689",
)
def test_holds_the_scene_and_only_its_effects_act(engine: Engine, method: Method) -> None:
    """Body and start read back as in the scene; its effects act, and nothing else."""
    if method.as_shipped:
        return
    for scene in able_scenes(engine, method):
        run = engine.run(scene, method, TIMESTEP, np.arange(0, 101, 20))
        require(run.outcome == "ok", engine, method, scene, f"it {run.outcome}: {run.reason}")
        require(not run.reason, engine, method, scene, run.reason)


@failure_means(
    "A term of the equations of motion is missing, wrong, or in other axes or units.",
    "DanielChappuis/reactphysics3d#422",
    "siconos/siconos#163",
    "ArduPilot/ardupilot#26972",
)
def test_begins_as_the_equations_of_motion_say(engine: Engine, method: Method) -> None:
    """The first steps obey Euler's and Newton's equations of the scene: effects, units, frames.

    They are single steps from states of the exact motion.
    """
    for scene in able_scenes(engine, method):
        residuals = physics_in_words(engine, scene, method)
        require(not residuals, engine, method, scene, residuals)


@failure_means(
    "The integrator is not of the order that it is said to be: a stage or a factor is wrong.",
    "RobotLocomotion/drake#18816",
    "DanielChappuis/reactphysics3d#198",
    "sofa-framework/sofa#172",
)
def test_order_of_accuracy(engine: Engine, method: Method) -> None:
    """ω and attitude converge on all scenes with at least the declared orders.

    On at least one scene, each converges with no more than its declared order. `ORDER_SLACK` is
    allowed for.
    """
    if method.as_shipped:
        return
    seen: list[tuple[float, float]] = []
    for scene in able_scenes(engine, method):
        orders = observed_orders(engine, method, scene)
        if orders is None:
            continue
        for what, observed, declared in zip(
            ("ω", "attitude"), orders, (method.order, method.attitude_order), strict=True
        ):
            words = f"{what} converges with order {observed:.2f}, declared is {declared}"
            require(observed > declared - ORDER_SLACK, engine, method, scene, words)
        seen.append(orders)
    if seen:
        omega, attitude = np.min(seen, axis=0)
        words = f"orders are {omega:.2f} and {attitude:.2f} at least, declared are less"
        is_declared = omega < method.order + ORDER_SLACK
        is_declared &= attitude < method.attitude_order + ORDER_SLACK
        require(bool(is_declared), engine, method, None, words)


@failure_means("A run depends on what ran before, on time or on chance.")
def test_repeats_to_the_last_bit(engine: Engine, method: Method) -> None:
    """Two runs of a scene give the same motion, to the last bit."""
    for scene in able_scenes(engine, method, FEW):
        with (
            engine.open(scene, method, TIMESTEP) as first,
            engine.open(scene, method, TIMESTEP) as second,
        ):
            first.advance(ODD_STEPS)
            second.advance(ODD_STEPS)
            require(same(first, second), engine, method, scene, "a second run is another motion")


@failure_means("Steps are lost or added in calls of many steps.")
def test_many_steps_at_once_equal_single_steps(engine: Engine, method: Method) -> None:
    """A call of k steps gives the same state as k calls of one step, to the last bit."""
    for scene in able_scenes(engine, method, FEW):
        with (
            engine.open(scene, method, ODD_TIMESTEP) as at_once,
            engine.open(scene, method, ODD_TIMESTEP) as one_by_one,
        ):
            at_once.advance(ODD_STEPS)
            for _ in range(ODD_STEPS):
                one_by_one.advance(1)
            words = f"{ODD_STEPS} steps in a call are not as many calls"
            require(same(at_once, one_by_one), engine, method, scene, words)


@failure_means("Reading a state writes to it.")
def test_reading_does_not_disturb(engine: Engine, method: Method) -> None:
    """Reading and checking between steps changes nothing."""
    for scene in able_scenes(engine, method, FEW):
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
            require(same(watched, alone), engine, method, scene, words)


@failure_means("Two worlds share state, or what is read is a view of what is written.")
def test_shares_no_memory_between_sessions(engine: Engine, method: Method) -> None:
    """Sessions stepped in turn move as each would alone; states that were read do not change."""
    scenes = list(able_scenes(engine, method))
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
                # Another number of steps, so that the two sessions differ even on the same scene.
                second.advance(2)
            # Read before the comparison: an engine may read every state into the same arrays.
            interleaved = numbers(first)
            is_kept = all(np.array_equal(getattr(before, name), kept[name]) for name in kept)
            words = "a state that was read changes with later steps or readings"
            require(is_kept, engine, method, one, words)
        with engine.open(one, method, TIMESTEP) as alone:
            for _ in range(SAMPLES):
                alone.advance(1)
            words = f"stepped in turn with '{other.name}' it moves in another way"
            require(np.array_equal(numbers(alone), interleaved), engine, method, one, words)


@failure_means("States that are recorded are of another time than those that are read.")
def test_records_what_it_reads(engine: Engine, method: Method) -> None:
    """The snapshots of a run equal the states that are read one by one.

    They may differ by rounding.
    """
    for scene in able_scenes(engine, method, FEW):
        snapshots: list[object] = []
        with (
            engine.open(scene, method, TIMESTEP) as recorded,
            engine.open(scene, method, TIMESTEP) as read,
        ):
            recorded.record([0, *[3] * SAMPLES], snapshots.append)
            states = recorded.states(snapshots)
            rows = [numbers(read)]
            for _ in range(SAMPLES):
                read.advance(3)
                rows.append(numbers(read))
            together = np.hstack([np.asarray(column) for column in vars(states).values()])
            size = np.abs(rows).max(axis=0)
            is_same = (np.abs(together - rows) <= 16 * np.finfo(float).eps * size).all()
            require(bool(is_same), engine, method, scene, "snapshots are not what is read")


@failure_means("A reset leaves something behind: a clock, a warm start, a cached tensor.")
def test_restarts_as_it_opens(engine: Engine, method: Method) -> None:
    """After a run, a restarted session steps like a session that is opened at the same state.

    The session is restarted from the scene's start and from another state, and at another timestep
    than before. A second restart from the same state gives the same motion, to the last bit.
    """
    for scene in able_scenes(engine, method, RESTARTED):
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
                require(not words or method.as_shipped, engine, method, scene, words)
                moves_as_opened(engine, method, start, session)
                session.check()
                first = numbers(session)
                session.restart(start_state(start))
                for steps in RESTART_STRIDES:
                    session.advance(steps)
                words = "restarted twice it moves in two ways"
                require(np.array_equal(numbers(session), first), engine, method, scene, words)


@failure_means("The switch that selects the integrator has no effect.")
def test_differs_from_every_other_method(engine: Engine, method: Method) -> None:
    """A method's motion differs from that of each other method on some scene.

    Methods as shipped are left out, as their steps may be those of a clean method.
    """
    if method.as_shipped:
        return
    for other in engine.methods:
        if other == method or other.as_shipped:
            continue
        both = [s for s in able_scenes(engine, method) if not engine.unsupported(s, other)]
        if both and not any(moves_apart(engine, method, other, scene) for scene in both):
            require(False, engine, method, None, f"it never differs from {other.name}")
