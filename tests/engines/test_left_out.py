"""Only what a scene does not call for is left out: leaving it in does not change the motion.

That what a scene calls for acts, and nothing else, is verified by the contract and by the items of
the library's scenes.
"""

import numpy as np
import pybullet as p
import pytest
from kinds_of_engines import required_engines
from spincheck.engines import Engine, Method, Session
from spincheck.engines.adapters.pybullet.engine import PyBullet
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

TIMESTEP = 1e-3
STEPS = 100
METHODS = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine in required_engines()
    for method in engine.methods
    if not method.as_shipped
    # PyBullet's contacts need all that is there.
    and (engine.name, method.requires) != ("pybullet", {"table"})
]


def numbers(session: Session | None, steps: int = STEPS) -> np.ndarray:
    """All of the state after some steps."""
    assert session is not None
    with session:
        session.advance(steps)
        session.check()
        return np.concatenate(list(vars(session.read_state()).values()))


@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_left_in_it_changes_no_bit_of_the_motion(engine: Engine, method: Method) -> None:
    """But the audit sees it."""
    scenes = [scene for scene in SCENES.values() if not engine.unsupported(scene, method)]
    for scene in scenes:
        left_out = engine.left_out(scene, method)
        assert left_out
        pruned = numbers(engine.open(scene, method, TIMESTEP))
        unpruned = numbers(engine.open_with(scene, method, TIMESTEP, left_in=left_out))
        assert np.array_equal(pruned, unpruned), scene.name
        assert not np.array_equal(pruned, numbers(engine.open(scene, method, TIMESTEP), STEPS + 1))
    scene = scenes[0]
    for left_in in ((), *((name,) for name in engine.left_out(scene, method))):
        with engine.open_with(scene, method, TIMESTEP, left_in=left_in) as session:
            session.advance(1)
            extra = session.active() - scene.called_for
        # A motor without force has no effect, nor has zero gravity.
        assert bool(extra) == bool(left_in) or left_in[0] in ("idle joint motor", "gravity")


def test_of_an_engine_as_shipped_nothing_is_left_out() -> None:
    methods = [(engine, method) for engine in required_engines() for method in engine.methods]
    shipped = [(engine, method) for engine, method in methods if method.as_shipped]
    assert shipped
    assert {engine.left_out(SCENES["free"], method) for engine, method in shipped} == {()}


def test_a_motor_that_is_left_in_is_solved_for() -> None:
    """With a force it holds the joint: it was there all the time."""
    engine = PyBullet()
    scene, method = SCENES["pivot"], engine.method("multibody")

    def slowed(left_in: list[str]) -> bool:
        with engine.open_with(scene, method, TIMESTEP, left_in=left_in) as session:
            p.setJointMotorControlMultiDof(
                session.world.body,  # type: ignore[attr-defined]
                0,
                p.POSITION_CONTROL,
                targetPosition=(0, 0, 0, 1),
                positionGain=(0, 0, 0),
                velocityGain=(1, 1, 1),
                force=[100, 100, 100],
                physicsClientId=session.client,  # type: ignore[attr-defined]
            )
            session.advance(10)
            return bool(np.linalg.norm(session.read_state().omega_body) < 0.5)

    assert slowed(["idle joint motor"])
    assert not slowed([])
