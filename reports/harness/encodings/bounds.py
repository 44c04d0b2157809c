"""What rounding may do to a motion that is described otherwise, signal by signal."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ....engines import Engine
from ....engines.checks.read_back import State
from ....engines.encodings import KEPT, SAME_BODY, Encoding
from ....engines.models.description import away_from
from ....reference import Solution
from ....scenarios import SIGNAL, Scenario, Trajectory
from ..measuring.rounding import roundings_in_flight

#: The signals that make up a state; the others follow from them.
JUDGED = ("omega", "attitude", "com", "velocity")
#: Both motions are rounded.
BOTH = 2
#: Numbers that a motion follows from, each of which rounding may change: of ω and attitude three
#: each, of the tensor six. The conditioning is of changes of length one, together.
NUMBERS = 12
EPS = float(np.finfo(float).eps)


def rounding_bounds(
    scenario: Scenario, encoding: Encoding, solution: Solution, steps: int, engine: Engine
) -> dict[str, float]:
    """The largest distance that rounding explains, of each of `JUDGED`, in the norm of errors.

    To first order two motions are apart by the conditioning, per ulp, times the ulp by which their
    bodies and states are apart, with √n for n numbers that each change by as much (Higham, §1.6).

    - The body: one that reads back within `SAME_BODY` ulp of I₃ + m r², r from the frame's origin
      to the com, is as many times (I₃ + m r²) / I₁ off in its least moment.
    - A step: ω̇ = I⁻¹ (ω × I ω) is rounded relative to ‖I⁻¹‖ ‖I‖ ω² = (I₃ + m r²) / I₁ ω², and
      gains ω dt of that, an ulp of ω for the 20 operations of a component at 0.05 rad a step; the
      state is rounded once. Steps add up as if all had one sign.
    - The flight, for place and velocity of a free body: an ulp of the changed scene's own numbers.
    """
    change = encoding.change(scenario)
    changed, exact = _farthest(encoding.scene(scenario), encoding), solution.trajectory
    state = State(exact.q_world_body_wxyz, exact.omega_body, exact.com_world, exact.velocity_world)
    place, velocity = change.motion(state, exact.t)
    moved = Trajectory(
        t=exact.t * change.time,
        q_world_body_wxyz=exact.q_world_body_wxyz,
        omega_body=exact.omega_body / change.time,
        com_world=place,
        velocity_world=velocity,
    )
    flight = roundings_in_flight(changed, replace(solution, trajectory=moved), steps)
    ulps = (steps + flight + SAME_BODY) * _condition(changed) * BOTH * np.sqrt(NUMBERS)
    ulps *= engine.ulp / EPS
    units = {"com": change.length, "velocity": change.length / change.time}
    # A place turns with the body: what it is rounded by makes a velocity.
    metres = SIGNAL["com"].growth(changed, moved, solution.conditioning)
    metres *= SIGNAL["com"].base(changed, moved)
    swing = metres * float(np.linalg.norm(moved.omega_body, axis=1).max())
    bounds = {}
    for name in JUDGED:
        signal, ulp = SIGNAL[name], solution.conditioning[name]
        if name in units and not scenario.constraint.is_pivot:
            absolute = signal.growth(changed, moved, solution.conditioning)
            absolute *= signal.base(changed, moved)
            absolute += swing if name == "velocity" else 0.0
            ulp = absolute / units[name] / signal.base(scenario, exact)
        bounds[name] = ulp * ulps
    return bounds


@lru_cache(maxsize=KEPT)
def _farthest(scenario: Scenario, encoding: Encoding) -> Scenario:
    """The scene with its com where the farthest frame of the model has it."""
    if encoding.description.parts == "one":
        return scenario
    return replace(scenario, body=replace(scenario.body, com_exact=away_from(scenario.body)))


def _condition(scenario: Scenario) -> float:
    """(I₃ + m r²) / I₁, r the distance of the com from the frame's origin."""
    body = scenario.body
    moments, far = body.principal_moments, float(np.linalg.norm(body.com))
    return float((moments[-1] + body.mass * far**2) / moments[0])
