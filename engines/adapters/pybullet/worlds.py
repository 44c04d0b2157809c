"""Reuses PyBullet worlds, because connecting to a new one takes as long as thousands of steps.

In a world that was emptied, bodies move as in a new one, to the last bit.
"""

import pybullet as p
from spincheck.engine import EngineError

#: Parameters of a new world: timestep, s, and number of steps in a call (0 stands for one step).
DEFAULT_TIMESTEP, DEFAULT_SUBSTEPS = 1 / 240, 0

_empty: list[int] = []


def take_world() -> int:
    """Return PyBullet's number of an empty world.

    Raises
    ------
    EngineError
        If PyBullet cannot open another world.
    """
    if _empty:
        return _empty.pop()
    client: int = p.connect(p.DIRECT)
    if client < 0:
        raise EngineError("PyBullet cannot open another world")
    return client


def give_back(client: int) -> None:
    """Empty the world with PyBullet's number `client`, and keep it for reuse.

    Constraints and bodies are removed one by one: a reset alone leaves them in PyBullet's lists.
    """
    for index in reversed(range(p.getNumConstraints(client))):
        p.removeConstraint(p.getConstraintUniqueId(index, client), client)
    for index in reversed(range(p.getNumBodies(client))):
        p.removeBody(p.getBodyUniqueId(index, client), client)
    # By keyword, because the first positional argument is not the client: passed by position, world
    # 0 would be emptied instead.
    p.resetSimulation(physicsClientId=client)
    p.setPhysicsEngineParameter(
        fixedTimeStep=DEFAULT_TIMESTEP, numSubSteps=DEFAULT_SUBSTEPS, physicsClientId=client
    )
    _empty.append(client)
