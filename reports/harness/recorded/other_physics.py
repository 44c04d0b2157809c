"""Other physics that explain a recorded motion: a clamp, or one change of the equations.

The exact flow is followed from each sample to the next one, and what the recording gains beyond it
is compared with what such changes would make: so it shows at any time, however far the motion is
from the exact one by then.
"""

from collections.abc import Iterator

import numpy as np

from ....engines.checks.equations import Equations
from ....reference import IntegrationError
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.rotation import norms
from ...results.reasons import explained
from ..measuring.explanations import explanation, gains_of
from ..measuring.noise import term_sizes
from ..measuring.places import states_of
from ..measuring.steps import Steps, flowed, step_gains

#: rad between two samples, so that what acts meanwhile is nearly constant; intervals looked at.
NEAR, FEWEST_INTERVALS, MOST_INTERVALS = 0.5, 8, 200
#: A change explains the motion if no more than this fraction is left.
LEFT = 0.1
#: Samples at which a clamp is looked for, and how well it has to fit, relative.
FIRST, CLAMPED = 3, 1e-2
#: The quantities of a gain that are about rotation: attitude and I ω.
ROTATION = slice(0, 2)


def other_physics(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, timestep: float | None
) -> list[str]:
    """Return the change that explains a motion, in words; empty if there is none.

    What an integrator of first order may do at that timestep is no change.

    Parameters
    ----------
    exact : the exact motion at the same times
    timestep : s, that the motion was made with; None if that is unknown
    """
    clamps = _clamps(motion, exact) if len(motion.t) > FIRST else ()
    return [*clamps][:1] or _change(scenario, motion, timestep)


def _clamps(motion: Trajectory, exact: Trajectory) -> Iterator[str]:
    """Clamps of ω that make of the first exact samples what was recorded."""
    # The first may be the start as it was set.
    recorded, right = (one.until(FIRST + 1).at(np.arange(1, FIRST + 1)) for one in (motion, exact))
    frames = (
        ("each component of ω in world axes", recorded.to_world, right.to_world),
        ("each component of ω in body axes", np.asarray, np.asarray),
    )
    for words, of_recorded, of_right in frames:
        omega, wanted = of_recorded(recorded.omega_body), of_right(right.omega_body)
        bound = float(np.abs(omega).max())
        if _fits(omega, np.clip(wanted, -bound, bound), wanted):
            yield f"{words} is clamped to {bound:.4g} rad/s"
    speeds = norms(right.omega_body)[:, None]
    bound = float(norms(recorded.omega_body).max())
    clamped = right.omega_body * np.minimum(1.0, bound / np.maximum(speeds, bound))
    if _fits(recorded.omega_body, clamped, right.omega_body):
        yield f"‖ω‖ is clamped to {bound:.4g} rad/s"


def _fits(omega: FloatArray, clamped: FloatArray, wanted: FloatArray) -> bool:
    """Whether ω is what a clamp makes of what it should be, and it makes something else of it."""
    size = float(norms(wanted).max())
    off, changed = (float(norms(one - clamped).max()) for one in (omega, wanted))
    is_moving = bool(clamped.any())
    return is_moving and off <= CLAMPED * size and changed > off / LEFT and changed > CLAMPED * size


def _change(scenario: Scenario, motion: Trajectory, timestep: float | None) -> list[str]:
    spans = np.diff(motion.t)
    rate = fastest_rate(scenario, motion.omega_body)
    near = np.flatnonzero(spans * rate <= NEAR)
    if len(near) < FEWEST_INTERVALS or not motion.omega_body.any():
        return []
    kept = near[np.unique(np.linspace(0, len(near) - 1, MOST_INTERVALS).astype(int))]
    before, after = (states_of(motion.at(at)) for at in (kept, kept + 1))
    try:
        right = flowed(scenario, before, spans[kept])
    except IntegrationError:
        return []
    equations = Equations(scenario)
    excess = step_gains(equations, Steps(spans[kept], spans[kept], before, after, right))[:, 0, 0]
    sizes = term_sizes(equations, before).max(axis=0)
    share = float((np.abs(excess).max(axis=2) / sizes)[:, ROTATION].max())
    if not share > rate * (timestep or float(spans[kept].max())):
        return []
    gains = gains_of(equations, before, right, spans[kept], excess)
    noise = np.tile(LEFT * share * sizes, (len(kept), 1))
    of_rotation = noise.copy()
    of_rotation[:, ROTATION.stop :] = np.inf
    found = explanation(equations, gains, noise) or explanation(equations, gains, of_rotation)
    return [f"it moves as if {explained(found)}"] if found else []
