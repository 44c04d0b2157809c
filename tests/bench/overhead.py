"""What the harness adds to bare stepping, where it times and where it records.

Every engine's steps are taken in turn by the harness and by the calls that a user would write, in
one process; ratios are of CPU seconds, their median over the rounds, with the distance of the
quartiles.
"""

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from bench_timing import in_turn, ratio
from rich.console import Console
from rich.table import Table
from spincheck.engines import Engine, Method, Session, engines
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.engines.checks.faults import Bounds
from spincheck.engines.native_output import native_output
from spincheck.engines.sampling import sample
from spincheck.reports.harness.costs.step_cost import timed_timestep
from spincheck.scenarios import find, load

with native_output():
    # It prints when it was built.
    import pybullet as p
    from spincheck.engines.adapters.pybullet.session import PyBulletSession

ROUNDS = 20
#: Steps a stretch: a multiple of `PER_SAMPLE`, and what PyBullet is given in one call.
STEPS = 10 * 2**10
PER_SAMPLE = 10
#: Goals: what the timing of steps, and the recording of runs, may take of bare stepping.
TIMING_GOAL, RECORDING_GOAL = 1.05, 1.3
CASES = [
    ("mujoco", "Euler", "tennis-racket"),
    ("mujoco", "Euler", "fast-top"),
    ("mujoco", "RK4", "tennis-racket"),
    ("mujoco", "RK4", "fast-top"),
    ("pybullet", "multibody", "tennis-racket"),
    ("pybullet", "maximal", "tennis-racket"),
    ("pybullet", "multibody", "fast-top"),
    ("pybullet", "multibody-p2p", "fast-top"),
    ("pybullet", "maximal", "fast-top"),
]


#: CPU time over that of bare stepping: the median, and the distance of the quartiles.
Ratio = tuple[float, float]


@dataclass(frozen=True)
class Overhead:
    """One engine, method and scene.

    Attributes
    ----------
    bare_us : µs a step, bare, the least over the rounds
    timing : what the harness does to time steps
    recording : what it does in an accuracy run, a sample every ten steps, all states checked, and
        some read once more a single step later
    reading : `Session.record` alone, a sample every ten steps
    by_hand : the shortest loop that reads the same numbers as often and keeps them
    """

    engine: str
    method: str
    scene: str
    bare_us: float
    timing: Ratio
    recording: Ratio
    reading: Ratio
    by_hand: Ratio


def overhead(engine: Engine, method: Method, scene: str) -> Overhead:
    """Measure one case."""
    scenario = load(find([scene])[0])
    timestep = timed_timestep(scenario)
    counts = np.arange(0, STEPS + 1, PER_SAMPLE)
    arm = np.array(scenario.body.com) if scenario.constraint.is_pivot else None
    bounds = Bounds(timestep, method.max_rotation_per_step, arm)
    with (
        engine.open(scenario, method, timestep) as bare,
        engine.open(scenario, method, timestep) as timed,
        engine.open(scenario, method, timestep) as recorded,
        engine.open(scenario, method, timestep) as read,
        engine.open(scenario, method, timestep) as by_hand,
    ):
        actions = [
            bare_stepping(bare, timestep),
            lambda: timed.advance(STEPS),
            lambda: sample(recorded, counts, bounds),
            lambda: read.record([PER_SAMPLE] * (STEPS // PER_SAMPLE), [].append),
            recording_by_hand(by_hand, timestep),
        ]
        seconds = in_turn(ROUNDS, actions)
    ratios = [ratio(seconds[:, k] / seconds[:, 0]) for k in (1, 2, 3, 4)]
    least = float(seconds[:, 0].min())
    return Overhead(engine.name, method.name, scene, 1e6 * least / STEPS, *ratios)


def bare_stepping(session: Session, timestep: float) -> Callable[[], object]:
    """`STEPS` steps in one native call."""
    if isinstance(session, MuJoCoSession):
        model, data = session.model, session.data
        return lambda: mujoco.mj_step(model, data, STEPS)
    assert isinstance(session, PyBulletSession)
    client = session.client
    set_substeps(client, STEPS, timestep)
    return lambda: p.stepSimulation(client)


def recording_by_hand(session: Session, timestep: float) -> Callable[[], object]:
    """The same, `PER_SAMPLE` a call, with the state read after each."""
    if isinstance(session, MuJoCoSession):
        model, data = session.model, session.data

        def record_mujoco() -> None:
            rows = []
            for _ in range(STEPS // PER_SAMPLE):
                mujoco.mj_step(model, data, PER_SAMPLE)
                rows.append((data.qpos.copy(), data.qvel.copy()))

        return record_mujoco
    assert isinstance(session, PyBulletSession)
    client, body, link = session.client, session.world.body, session.world.link
    set_substeps(client, PER_SAMPLE, timestep)

    def read() -> object:
        if link >= 0:
            return p.getLinkState(body, link, 1, 1, client)
        return p.getBasePositionAndOrientation(body, client), p.getBaseVelocity(body, client)

    def record_pybullet() -> None:
        rows = []
        for _ in range(STEPS // PER_SAMPLE):
            p.stepSimulation(client)
            rows.append(read())

    return record_pybullet


def set_substeps(client: int, substeps: int, timestep: float) -> None:
    p.setPhysicsEngineParameter(
        fixedTimeStep=substeps * timestep, numSubSteps=substeps, physicsClientId=client
    )


def shown(ratio: Ratio, goal: float = np.inf) -> str:
    median, spread = ratio
    missed = " !" if median > goal else ""
    return f"{median:.2f} ± {spread:.2f}{missed}"


def main() -> None:
    """Measure, and print a table."""
    done = [overhead(engines()[e], engines()[e].method(m), scene) for e, m, scene in CASES]
    grid = Table(
        "engine",
        "method",
        "scene",
        "bare, µs a step",
        f"timing (goal {TIMING_GOAL})",
        f"recording (goal {RECORDING_GOAL})",
        "reading",
        "reading by hand",
        title="CPU time over that of bare stepping; a sample every ten steps where recorded",
    )
    for one in done:
        grid.add_row(
            one.engine,
            one.method,
            one.scene,
            f"{one.bare_us:.2f}",
            shown(one.timing, TIMING_GOAL),
            shown(one.recording, RECORDING_GOAL),
            shown(one.reading),
            shown(one.by_hand),
        )
    Console(width=120).print(grid)


if __name__ == "__main__":
    main()
