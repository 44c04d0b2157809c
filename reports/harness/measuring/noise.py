"""The noise of the gains of steps, from every source, and the sizes that gains are compared with.

The sources, with their standard deviations, are:

- Rounding of the state: `ULPS` ulp of each component, as a step of an engine rounds a few times. It
  is smaller in a mean of repeats, unless the rounding is biased (`examine.py`).
- The body that the engine holds: the difference from the scene's that its read-back allows
  (`Engine.slack`); in single precision, the effect of rounding its moments of inertia.
- Rounding of moments of inertia: `ULPS` ulp times the condition number of their tensor, or of the
  mass matrix where the com is far from the body's origin, as an error of I dω/dt; and the angle by
  which that error turns the body (Higham, Accuracy and Stability of Numerical Algorithms, §7.1).
- Flight: `ULPS` ulp of m v², as a torque, because engines may solve for rotation and translation
  together (measured in MuJoCo 4.0). v is the velocity of the body's origin, as engines step the
  position of the origin and not that of the com.
- Rotors: `ULPS` ulp of the forces that cancel between the rotors, and of the torques that cancel
  about their axes (`Scenario.cancelling`). Noise of I dω/dt turns the rotors, too.
- Contact: `ULPS` ulp of the com's position, which the constraint corrects within a step.
- The largest turn in a step that the engine ignores, as its adapter declares
  (`Engine.least_turn`).
- The solver of a constraint: `SOLVED` of the largest terms. In addition it is measured, by letting
  the constraint settle further, up to `CONSISTENT` of the largest terms (`examine.py`).
- Other noise of the engine: it is measured, and is no fault up to `NOISE` a step (`examine.py`).
"""

import numpy as np

from ....engines import Engine
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import State
from ....scenarios import FloatArray, push
from ....scenarios.rotation import norms
from ...results.evidence import SEEN
from ...results.records import LARGEST
from .steps import Steps

#: Rounding of a step, in ulp of each component of a state.
ULPS = 4.0
#: Largest relative noise of a state after a step that is no fault: iterative solvers stop there.
NOISE = 1e-12
#: Residual of an iterative solver of a constraint, relative to the largest terms, however long the
#: constraint settles: up to 5e-10 was measured in MuJoCo 4.0.
SOLVED = 1e-9
#: A difference is significant if it exceeds this number of standard deviations of noise.
SURE = 8.0
#: Smallest size used as a divisor: the square of its inverse is finite.
NO_SIZE = 1 / LARGEST


def rounding_of_body(condition: float, ulp: float = float(np.finfo(float).eps)) -> float:
    """Return the relative change of an angular acceleration by rounding of moments of inertia.

    Parameters
    ----------
    condition : factor by which a relative error of the moments grows: `Places.condition`
    ulp : relative spacing of the numbers that the moments are rounded to
    """
    return ULPS * ulp * condition


def noise_of(
    equations: Equations, steps: Steps, engine: Engine, condition: float, *, settled: bool
) -> FloatArray:
    """Return the standard deviation of the noise of gains, except for noise that is measured.

    Each gain is a mean over repeated steps. The noise comes from rounding, from the difference that
    is allowed between the engine's body and the scene's, from turns so small that the engine
    ignores them, and from residuals of its solver: the docstring of this module lists all sources.

    Parameters
    ----------
    condition : factor by which a relative error of moments of inertia grows: `Places.condition`
    settled : whether a constraint settled before the steps

    Returns
    -------
    The standard deviation of each component, in the units of the gains, for J timesteps, K states
    and Q quantities, (J, K, Q)
    """
    scenario, rounding = equations.scenario, ULPS * engine.ulp
    spans, sizes = steps.timesteps[:, None], term_sizes(equations, steps)
    of_body = rounding * condition
    of_reading = of_body if engine.single_precision else max(engine.slack, of_body)
    variance = (rounding * roundings(equations, steps)) ** 2 / steps.repeats
    variance += (of_reading * sizes) ** 2
    variance[..., 1] += (of_body * sizes[1]) ** 2
    if settled:
        variance += (SOLVED * sizes) ** 2
        variance[..., 0] += (engine.least_turn / spans) ** 2
    if not scenario.constraint.is_pivot:
        before = steps.before
        linear_speed = norms(before.velocity_world) + equations.arm * norms(before.omega_body)
        torques = rounding * scenario.body.mass * steps.by_timestep(linear_speed).max(axis=1) ** 2
        variance[..., 1] += torques**2
        # By a step's end, an error of dω/dt has turned the body by half of the added ω times h.
        variance[..., 0] += (torques * np.linalg.norm(equations.inverse, 2) * spans / 2) ** 2
        if not scenario.constraint.is_free:
            distance = steps.by_timestep(norms(before.com_world) + equations.reach).max(axis=1)
            variance[..., 2] += (rounding * distance / spans**2) ** 2
    variance[..., 0] += (of_body * sizes[0] * np.minimum(1.0, spans * sizes[0] / 2)) ** 2
    if steps.before.spins.size:
        force, torque = scenario.cancelling(np.abs(steps.before.spins))
        turned = equations.scenario.largest_part * float(np.linalg.norm(equations.inverse, 2))
        variance[..., 4] += variance[..., 1] * turned**2
        variance[..., 4] += (rounding * steps.by_timestep(torque).max(axis=1)) ** 2
        if scenario.constraint.is_free:
            forced = rounding * steps.by_timestep(force).max(axis=1) / scenario.body.mass
            variance[..., 2] += forced**2
            variance[..., 3] += (forced * spans) ** 2
    return np.asarray(np.maximum(np.sqrt(variance), NO_SIZE))


def noise_of_steps(equations: Equations, steps: Steps) -> FloatArray:
    """Return the noise of gains if each step has a relative error of `NOISE`.

    It is the largest noise of all states, in the units of the gains, for J timesteps and Q
    quantities, (J, 1, Q).
    """
    return np.asarray(NOISE * roundings(equations, steps).max(axis=1, keepdims=True))


def term_sizes(equations: Equations, steps: Steps) -> FloatArray:
    """Return the size of the rate of change of each of Q quantities, to compare gains with, (Q,).

    It is the sum of the sizes of the rate's terms, however they cancel. The largest sum of all
    states is taken, in the units of gains. On a pivot, the sizes of velocity and position are those
    of velocity and com themselves.
    """
    scenario, reach, states = equations.scenario, equations.reach, steps.before
    speeds = norms(states.omega_body)
    g = float(np.linalg.norm(scenario.gravity_world))
    if scenario.constraint.is_pivot:
        velocity, position = speeds * reach, np.full_like(speeds, reach)
    else:
        velocity, position = g + reach * speeds**2, norms(states.velocity_world) + reach * speeds
    torque = _largest_moment(equations) * speeds**2 + norms(equations.kept_body(states)) * speeds
    torque += _torques(equations, states).sum(axis=1)
    sizes = [speeds, torque, velocity, position]
    if states.spins.size:
        turned = float(np.linalg.norm(equations.inverse, 2)) * torque
        sizes.append(
            _largest_rotor_momentum(equations, states) * speeds
            + equations.scenario.largest_part * turned
        )
    return np.maximum([size.max() for size in sizes], NO_SIZE)


def weakest_effects(equations: Equations, steps: Steps) -> FloatArray:
    """Return the size of the weakest effect in each of Q quantities, (Q,); infinite if none acts.

    The size of an effect is the largest size of its term in any state, in the units of gains.
    Torques of the same kind count as one effect. An effect is ignored if `SEEN` times its size is
    less than `NOISE` times `term_sizes`, as its loss could not be told from noise.
    """
    negligible = NOISE / SEEN * term_sizes(equations, steps)
    torques = _torques(equations, steps.before).max(axis=0)
    least = np.full_like(negligible, np.inf)
    least[1] = torques[torques > negligible[1]].min(initial=np.inf)
    g = float(np.linalg.norm(equations.scenario.gravity_world))
    if g > negligible[2] and not equations.scenario.constraint.is_pivot:
        least[2] = g
    return least


def _torques(equations: Equations, states: State) -> FloatArray:
    """Return the sizes of three torques in n states, N m, (n, 3): constant, of drag, and of weight.

    The size of the torque of weight is the largest at any attitude, m g times the arm. It is zero
    for a free body.
    """
    scenario = equations.scenario
    still, pushed = (
        push(scenario.pushed, np.eye(3), omega)
        for omega in (np.zeros(3), np.array(states.omega_body))
    )
    g = 0.0 if scenario.constraint.is_free else float(np.linalg.norm(scenario.gravity_world))
    weight = scenario.body.mass * g * equations.arm
    sizes = np.linalg.norm(still), norms(pushed - still), weight
    return np.stack(np.broadcast_arrays(*sizes), axis=1)


def roundings(equations: Equations, steps: Steps) -> FloatArray:
    """Return how much a relative error of the state after a step changes each gain.

    It is the largest change, in the units of the gains, divided by the relative error, for J
    timesteps, K states and Q quantities, (J, K, Q).
    """
    states, spans = steps.before, steps.spans
    speeds = np.maximum(norms(states.omega_body), norms(steps.after.omega_body))
    linear_speed = norms(states.velocity_world) + equations.reach * speeds
    distance = norms(states.com_world) + equations.reach
    momentum = _largest_moment(equations) * speeds
    if states.spins.size:
        # If an engine has rotors as bodies of their own, their angular momentum is rounded, too.
        momentum = momentum + _largest_rotor_momentum(equations, states)
    sizes = [1 / spans, momentum / spans, linear_speed, distance]
    if not equations.scenario.constraint.is_pivot:
        sizes[2:] = linear_speed / spans, distance / spans
    if states.spins.size:
        sizes.append(_largest_rotor_momentum(equations, states) / spans)
    each = steps.by_timestep(np.stack(np.broadcast_arrays(*sizes), axis=1))
    return np.asarray(each.max(axis=1))


def _largest_rotor_momentum(equations: Equations, states: State) -> FloatArray:
    """Return the largest momentum of any rotor about its axle in n states, kg m²/s, (n,)."""
    fastest = norms(states.omega_body) + np.abs(states.spins).max(axis=1)
    return np.asarray(equations.scenario.largest_part * fastest)


def _largest_moment(equations: Equations) -> float:
    """Return the largest principal moment of inertia about the fixed point, kg m²."""
    return float(np.linalg.norm(equations.scenario.inertia, 2))
