"""Chooses the methods that are also timed with no pass left out, and compares their motions.

A pass is a part of a step, such as the search for contacts. An adapter leaves out the passes that a
scene does not call for (`Engine.left_out`).
"""

import math
from collections.abc import Sequence

import numpy as np

from ....engines import EngineError, Method, Session
from ....engines.fault import ENVIRONMENTAL
from ....engines.varied_engine import VariedEngine
from ....scenarios import FloatArray, Scenario
from ..choice import EngineMethod

#: Angle turned in the first step, rad, when motions are compared: small for any method.
COMPARED_TURN = 0.05
#: Largest number of steps in the comparison of motions.
MOST_STEPS = 1 << 13
#: Number of times at which the two motions are compared.
COMPARED = 16


def with_all_left_in(
    scenario: Scenario, pairs: Sequence[EngineMethod]
) -> list[tuple[VariedEngine, Method]]:
    """Return the methods that are timed a second time on a scene, with no part of a step left out.

    An engine's methods are grouped by the parts of a step that they leave out, as the scene does
    not call for them. Methods that leave out none are not timed again. Of each group the first
    method is returned, and the first of the highest order of accuracy, as reports recommend that.
    Each comes with a variant of its engine that leaves nothing out.

    Parameters
    ----------
    pairs : the methods that are timed, with their engines
    """
    alike: dict[tuple[str, tuple[str, ...]], list[EngineMethod]] = {}
    for engine, method in pairs:
        if names := engine.left_out(scenario, method):
            alike.setdefault((engine.name, names), []).append((engine, method))
    chosen = {
        (engine.name, method.name): (VariedEngine(engine, "left_in", names), method)
        for (_, names), group in alike.items()
        for engine, method in (group[0], max(group, key=lambda pair: pair[1].order))
    }
    return list(chosen.values())


def motions_apart(
    scenario: Scenario, engine: VariedEngine, name: str
) -> tuple[float, float] | None:
    """Return how far an engine's motion is from its motion with no part of a step left out.

    The states are compared at `COMPARED` times.

    Parameters
    ----------
    engine : the variant of the engine that leaves nothing out
    name : name of the method

    Returns
    -------
    The time of the last comparison, s, and the largest difference at any comparison of any
    component of the states, SI; None if the engine failed before the first comparison

    Raises
    ------
    EngineError
        If the engine fails and the machine is to blame. Any other failure ends the comparison.
    """
    method, steps = engine.method(name), _number_of_steps(scenario)
    timestep, largest = scenario.window.duration / steps, 0.0
    compared = None
    try:
        with (
            engine.base.open(scenario, method, timestep) as pruned,
            engine.open(scenario, method, timestep) as whole,
        ):
            for sample in range(1, COMPARED + 1):
                states = [_state_after(session, steps // COMPARED) for session in (pruned, whole)]
                largest = max(largest, float(np.abs(states[0] - states[1]).max()))
                compared = sample * steps // COMPARED * timestep, largest
    except EngineError as error:
        if error.cause in ENVIRONMENTAL:
            raise
    return compared


def _number_of_steps(scenario: Scenario) -> int:
    """Return the number of steps over the window, a multiple of `COMPARED`.

    A step turns the body by `COMPARED_TURN` at the start, unless more than about `MOST_STEPS` steps
    would be needed.
    """
    turned = float(np.linalg.norm(scenario.start.omega_body)) * scenario.window.duration
    wanted = min(turned / COMPARED_TURN, MOST_STEPS)
    return COMPARED * max(1, math.ceil(wanted / COMPARED))


def _state_after(session: Session, steps: int) -> FloatArray:
    """Advance a session by some steps; return all components of its state, SI, (13 + rotors,)."""
    session.advance(steps)
    session.check()
    return np.concatenate(list(vars(session.read_state()).values()))
