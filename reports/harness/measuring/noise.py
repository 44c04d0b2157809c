"""The noise of what steps gain: every source, with its standard deviation, and the sizes beside it.

- Reading: `ULPS` ulp of each number of a state; a step of an engine rounds a few times. It is less
  in a mean of repeats, unless it goes one way (`examine.py`).
- The body as it is held: what it may differ by when it is read back (`Engine.slack`); in single
  precision what rounding of its moments makes.
- Moments that differ: `ULPS` ulp times the condition number of the tensor, or of the mass matrix
  where the com is far off, of I dω/dt, and by how far that turns the body (Higham, Accuracy and
  Stability of Numerical Algorithms, §7.1).
- Flight: `ULPS` ulp of m v², a torque, as engines may solve for rotation and flight together
  (measured in MuJoCo 4.0), with v that of the body's origin, which engines move.
- Parts that turn: `ULPS` ulp of the forces that cancel between them, and of the torques that cancel
  about their axes (`Scenario.cancelling`); noise of I dω/dt turns them, too.
- Places that are held: `ULPS` ulp of the com's place, which a constraint corrects within a step.
- A turn that a solver leaves out in a step, as the adapter declares (`Engine.least_turn`).
- A constraint's solver: `SOLVED` of the largest terms; and measured, by settling further, up to
  `CONSISTENT` of them (`examine.py`).
- Noise of the engine that is no fault: measured, and `NOISE` a step at most (`examine.py`).
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

#: Rounding of a step, in ulp of each number of a state.
ULPS = 4.0
#: Relative noise of a state after a step up to which it is no fault: iterative solvers stop there.
NOISE = 1e-12
#: What an iterative solver of a constraint leaves of the largest terms, however long it settles:
#: MuJoCo 4.0 was measured to leave up to 5e-10.
SOLVED = 1e-9
#: A difference is significant beyond so many standard deviations of noise.
SURE = 8.0
#: Smallest size that anything is divided by: the square of its inverse is finite.
NO_SIZE = 1 / LARGEST


def rounding_of_body(condition: float, ulp: float = float(np.finfo(float).eps)) -> float:
    """The relative change of a body's angular acceleration by rounding of its moments."""
    return ULPS * ulp * condition


def noise_of(
    equations: Equations, steps: Steps, engine: Engine, condition: float, *, settled: bool
) -> FloatArray:
    """The noise of gains from all sources that are derived: the standard deviation of their mean.

    The mean is that of the repeats of a state.

    Returns
    -------
    In the units of the gains, (J, K, Q).
    """
    scenario, rounding = equations.scenario, ULPS * engine.ulp
    spans, sizes = steps.timesteps[:, None], largest_terms(equations, steps)
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
        fast = norms(before.velocity_world) + equations.arm * norms(before.omega_body)
        torques = rounding * scenario.body.mass * steps.by_timestep(fast).max(axis=1) ** 2
        variance[..., 1] += torques**2
        # An angular acceleration that is off turns the body by half of what it adds to ω.
        variance[..., 0] += (torques * np.linalg.norm(equations.inverse, 2) * spans / 2) ** 2
        if not scenario.constraint.is_free:
            far = steps.by_timestep(norms(before.com_world) + equations.reach).max(axis=1)
            variance[..., 2] += (rounding * far / spans**2) ** 2
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
    """The noise of gains if each step changes the fastest state by `NOISE`, (J, 1, Q)."""
    return np.asarray(NOISE * roundings(equations, steps).max(axis=1, keepdims=True))


def largest_terms(equations: Equations, steps: Steps) -> FloatArray:
    """The largest of the terms that the gains of all steps are sums of, (Q,)."""
    scenario, reach, states = equations.scenario, equations.reach, steps.before
    speeds = norms(states.omega_body)
    g = float(np.linalg.norm(scenario.gravity_world))
    if scenario.constraint.is_pivot:
        velocity, place = speeds * reach, np.full_like(speeds, reach)
    else:
        velocity, place = g + reach * speeds**2, norms(states.velocity_world) + reach * speeds
    torque = _largest_moment(equations) * speeds**2 + norms(equations.kept_body(states)) * speeds
    torque += _torques(equations, states).sum(axis=1)
    sizes = [speeds, torque, velocity, place]
    if states.spins.size:
        turned = float(np.linalg.norm(equations.inverse, 2)) * torque
        sizes.append(_kept(equations, states) * speeds + equations.scenario.largest_part * turned)
    return np.maximum([size.max() for size in sizes], NO_SIZE)


def weakest_effects(equations: Equations, steps: Steps) -> FloatArray:
    """The size of the weakest effect in each quantity, (Q,): infinite where no effect acts.

    The size of an effect is the largest that its term has in any state. Torques of the same kind
    count as one effect. An effect is ignored if `SEEN` of it is less than `NOISE` of the largest
    terms, as it could not be told from noise that is no fault.
    """
    nothing = NOISE / SEEN * largest_terms(equations, steps)
    torques = _torques(equations, steps.before).max(axis=0)
    least = np.full_like(nothing, np.inf)
    least[1] = torques[torques > nothing[1]].min(initial=np.inf)
    g = float(np.linalg.norm(equations.scenario.gravity_world))
    if g > nothing[2] and not equations.scenario.constraint.is_pivot:
        least[2] = g
    return least


def _torques(equations: Equations, states: State) -> FloatArray:
    """Sizes of the constant torques, of those that depend on ω, and of weight's, N m, (n, 3)."""
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
    """The largest derivative of gains by relative changes of the states read, (J, K, Q)."""
    states, spans = steps.before, steps.spans
    speeds = np.maximum(norms(states.omega_body), norms(steps.after.omega_body))
    fast = norms(states.velocity_world) + equations.reach * speeds
    far = norms(states.com_world) + equations.reach
    momentum = _largest_moment(equations) * speeds
    if states.spins.size:
        # Where parts are bodies of their own, their angular momentum is rounded, too.
        momentum = momentum + _kept(equations, states)
    sizes = [1 / spans, momentum / spans, fast, far]
    if not equations.scenario.constraint.is_pivot:
        sizes[2:] = fast / spans, far / spans
    if states.spins.size:
        sizes.append(_kept(equations, states) / spans)
    each = steps.by_timestep(np.stack(np.broadcast_arrays(*sizes), axis=1))
    return np.asarray(each.max(axis=1))


def _kept(equations: Equations, states: State) -> FloatArray:
    """The largest size of the angular momentum that a part keeps, kg m²/s, (n,)."""
    fastest = norms(states.omega_body) + np.abs(states.spins).max(axis=1)
    return np.asarray(equations.scenario.largest_part * fastest)


def _largest_moment(equations: Equations) -> float:
    return float(np.linalg.norm(equations.scenario.inertia, 2))
