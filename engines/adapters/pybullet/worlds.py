"""Empty PyBullet worlds, used again: to connect to a new one takes as long as thousands of steps.

A world that is emptied moves what is loaded into it next as a new one does, to the last bit.
"""

import pybullet as p

from ...read_back import EngineError

#: s, and steps a call, of a world that nobody has set otherwise.
DEFAULT_TIMESTEP, DEFAULT_SUBSTEPS = 1 / 240, 0

_empty: list[int] = []


def take_world() -> int:
    """An empty world, by PyBullet's number of it.

    Raises
    ------
    EngineError
        If PyBullet opens no more.
    """
    if _empty:
        return _empty.pop()
    client: int = p.connect(p.DIRECT)
    if client < 0:
        raise EngineError("PyBullet cannot open another world")
    return client


def give_back(client: int) -> None:
    """Empty a world, for whoever takes one next.

    Constraints and bodies are removed one by one: a reset alone leaves them in PyBullet's lists.
    """
    for index in reversed(range(p.getNumConstraints(client))):
        p.removeConstraint(p.getConstraintUniqueId(index, client), client)
    for index in reversed(range(p.getNumBodies(client))):
        p.removeBody(p.getBodyUniqueId(index, client), client)
    # By name: its first argument is another, and world 0 would be emptied instead.
    p.resetSimulation(physicsClientId=client)
    p.setPhysicsEngineParameter(
        fixedTimeStep=DEFAULT_TIMESTEP, numSubSteps=DEFAULT_SUBSTEPS, physicsClientId=client
    )
    _empty.append(client)
