"""A table by joints: two slides without mass under a spherical joint; planted faults are told.

That it is held, stepped, restarted and audited as a scene says is verified by the contract
(`table`, `table-torque-body`, `table-rotors`).
"""

from collections.abc import Callable

import numpy as np
import pybullet as p
from case_loops import each_case
from library_scenes import library_scene
from pybullet_planted import ENGINE, opened
from spincheck.engines.adapters.pybullet.session import PyBulletSession
from spincheck.reference import solve
from spincheck.scenarios import errors_between
from spincheck.scenarios.fastest_rate import fastest_rate
from spincheck.suite.contract_scenes import SCENES

BY_JOINTS = ENGINE.method("multibody")
#: The fastest rate times the step of the coarser of two runs, and its steps; order 1 shows.
TURN, STEPS = 0.05, 128
ORDER_SLACK = 0.25


@each_case("name", ["gliding-top", "lopsided-egg", "top-with-drag-on-the-table"])
def test_it_converges_with_the_declared_order(name: str) -> None:
    scene = library_scene(name)
    rate, errors = fastest_rate(scene, scene.start.omega_body), []
    for finer in (1, 2):
        timestep, steps = TURN / rate / finer, np.arange(0, STEPS * finer + 1, 16 * finer)
        run = ENGINE.run(scene, BY_JOINTS, timestep, steps)
        assert (run.outcome, run.reason, run.active) == ("ok", "", scene.called_for)
        assert run.trajectory is not None
        found = errors_between(scene, run.trajectory, solve(scene, steps * timestep).trajectory)
        errors.append([found.omega, found.attitude, found.com])
    assert (np.log2(np.divide(*errors)) > BY_JOINTS.order - ORDER_SLACK).all(), errors


def damped(session: PyBulletSession) -> None:
    p.changeDynamics(session.world.body, 0, jointDamping=1e-6, physicsClientId=session.client)


def braked(session: PyBulletSession) -> None:
    session.world.drive(1, 0.0, 1e-6)


def pushed(session: PyBulletSession) -> None:
    session.world.pushes.append(
        lambda: p.applyExternalForce(
            session.world.body, 1, (1e-6, 0, 0), (0, 0, 0), p.WORLD_FRAME, session.client
        )
    )


def turned(session: PyBulletSession) -> None:
    torque = [0.0, 1e-7, 0.0]
    push = session.world.push
    session.world.pushes.append(lambda: push(torque, p.WORLD_FRAME))


FAULTS: dict[Callable[[PyBulletSession], None], str] = {
    damped: "a force of",
    braked: "a force of",
    pushed: "a force of",
    turned: "N m at rest",
}


@each_case(("plant", "words"), list(FAULTS.items()))
def test_the_audit_feels_what_else_acts(
    plant: Callable[[PyBulletSession], None], words: str
) -> None:
    scene = SCENES["table"]
    with opened(scene, BY_JOINTS) as session:
        session.advance(1)
        plant(session)
        extra = session.active() - scene.called_for
        assert any(words in one for one in extra), extra
