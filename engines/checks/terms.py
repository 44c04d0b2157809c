"""The sizes of the terms of a scene's equations of motion, and what rounding may make of a gain."""

import numpy as np

from ...scenarios import FloatArray, push
from ...scenarios.rotation import norms
from .equations import Equations
from .read_back import State


def term_sizes(equations: Equations, states: State) -> FloatArray:
    """Sizes of the terms that gains are sums of, (n, 4)."""
    scenario, reach = equations.scenario, equations.reach
    speeds = norms(states.omega_body)
    g = float(np.linalg.norm(scenario.gravity_world))
    if scenario.constraint.is_pivot:
        velocity, place = speeds * reach, np.full_like(speeds, reach)
    else:
        velocity, place = g + reach * speeds**2, norms(states.velocity_world) + reach * speeds
    torque = _largest_moment(equations) * speeds**2 + norms(equations.kept_body(states)) * speeds
    torque += _torques(equations, states).sum(axis=1)
    return np.stack([speeds, torque, velocity, place], axis=1)


def _torques(equations: Equations, states: State) -> FloatArray:
    """Sizes of the torques of what always pushes, of what ω adds, and of weight, N m, (n, 3)."""
    scenario = equations.scenario
    still, pushed = (
        push(scenario.pushed, np.eye(3), omega)
        for omega in (np.zeros(3), np.array(states.omega_body))
    )
    g = 0.0 if scenario.constraint.is_free else float(np.linalg.norm(scenario.gravity_world))
    weight = scenario.body.mass * g * equations.arm
    sizes = np.linalg.norm(still), norms(pushed - still), weight
    return np.stack(np.broadcast_arrays(*sizes), axis=1)


def weakest_effects(equations: Equations, states: State, nothing: FloatArray) -> FloatArray:
    """The least that an effect adds at most to each term that gains are sums of, (4,).

    Infinite where no effect adds any. Effects that hold or push alike count as one.

    Parameters
    ----------
    nothing : what is as good as nothing, (4,)
    """
    torques = _torques(equations, states).max(axis=0)
    least = np.full(4, np.inf)
    least[1] = torques[torques > nothing[1]].min(initial=np.inf)
    g = float(np.linalg.norm(equations.scenario.gravity_world))
    if g > nothing[2] and not equations.scenario.constraint.is_pivot:
        least[2] = g
    return least


def roundings(equations: Equations, states: State, after: State, spans: FloatArray) -> FloatArray:
    """The change of a gain by one rounding of the states read, in ulp, (n, 4)."""
    speeds = np.maximum(norms(states.omega_body), norms(after.omega_body))
    fast = norms(states.velocity_world) + equations.reach * speeds
    far = norms(states.com_world) + equations.reach
    sizes = [1 / spans, _largest_moment(equations) * speeds / spans, fast, far]
    table = np.stack(np.broadcast_arrays(*sizes), axis=1)
    if not equations.scenario.constraint.is_pivot:
        table[:, 2:] /= spans[:, None]
    return table


def rates(equations: Equations, sizes: FloatArray) -> FloatArray:
    """Sizes of what the gains are gains of, which are read: rad, N m s, and m/s and m, (4,)."""
    speed, reach = float(sizes[0]), equations.reach
    if equations.scenario.constraint.is_pivot:
        return np.array([1.0, _largest_moment(equations) * speed, 0.0, 0.0])
    return np.array([1.0, _largest_moment(equations) * speed, float(sizes[3]), reach])


def _largest_moment(equations: Equations) -> float:
    return float(np.linalg.norm(equations.inertia, 2))
