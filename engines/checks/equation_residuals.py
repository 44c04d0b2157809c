"""Whether an engine's single steps obey the scene's equations of motion, and how not, in words.

A model can read back correctly and still move wrongly: moments in another order, gravity with the
opposite sign, an additional damping, no gyroscopic torque, a clock at another rate. At ordinary
timesteps such faults are hidden by the method's own error; in the limit of short steps they are
not (`consistency`).

A body that turns about a principal axis has no gyroscopic torque. So steps are taken from two other
states too, with ω askew to the body's axes. Together they determine which change of the model
explains what the steps gain (`explanations`). A constraint needs some steps to settle; these are
skipped.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...scenarios import FloatArray, Scenario
from ...scenarios.scenario import started_at
from .consistency import NEGLIGIBLE, Excess, excess
from .equations import Equations, Gain, gains_of
from .explanations import explanation
from .extrapolation import ABOVE, COARSER
from .precision import single_precision
from .read_back import State, stacked, start_state
from .steps import After, Open, Steps, single_steps

#: Steps until a constraint has settled. Bullet removes a fifth of its error in a step: 0.8^128 =
#: 4e-13 of it is left, and 6e-7 after half of them, which is enough in single precision.
SETTLING = 128
#: Directions of ω in the body, beside the scene's own: askew to every axis of a body that is drawn
#: along its axes, so that no torque vanishes by symmetry.
ASKEW = ((0.62, 0.55, 0.56), (-0.48, 0.71, 0.52))
#: rad at the scene's fastest rate, in the longest step; and the timesteps, each half of the one
#: before.
LONGEST_TURN, HALVINGS = 0.1, 10
#: rad in the shortest step in single precision. Where a constraint holds a body, its place's
#: rounding is an acceleration as 1/h².
LEAST_TURN_SINGLE = float(np.cbrt(np.finfo(np.float32).eps))
#: Four times the repeats halve what chance leaves. Where more than this is left, it is no chance.
STILL_GAINING = 0.75
#: So many of the shortest steps have to show that an error does not depend on their length.
LEAPS = 4
#: rad at the fastest rate, in a step that an explanation is looked for of.
FOLLOWED = 30.0
#: Digits printed of a number; more if they are needed to show a difference.
DIGITS = 3


def equation_residuals(
    open_at: Open,
    scenario: Scenario,
    slack: float = 0.0,
    *,
    is_single: bool = False,
    least_turn: float = 0.0,
) -> str:
    """What an engine's steps from the start gain beyond the scene's equations of motion, in words.

    Parameters
    ----------
    open_at : opens a scene with a timestep, s
    slack : relative to the largest terms, what a body that an engine holds so exactly leaves
    is_single : whether it declares single precision
    least_turn : rad, below which its solver leaves out how a constraint turns a body in a step

    Returns
    -------
    The words; empty if there is nothing.
    """
    equations = Equations(scenario)
    speed = float(np.linalg.norm(scenario.start.omega_body)) or equations.rate
    starts = [scenario, *(starting_with(scenario, speed * np.array(way)) for way in ASKEW)]
    states = stacked([start_state(start) for start in starts])
    states = states.rows(equations.bears(states))
    turns = LONGEST_TURN / 2.0 ** np.arange(HALVINGS)
    if is_single:
        turns = turns[turns >= LEAST_TURN_SINGLE]
    timesteps = np.asarray(turns / equations.rate)
    others = np.asarray(timesteps[COARSER : COARSER + 1] / 2**0.5)
    steps, found = settled(
        open_at,
        scenario,
        lambda _: states,
        (timesteps, others),
        equations.after_each,
        max(slack, NEGLIGIBLE / ABOVE),
        is_single=is_single,
        least_turn=least_turn,
    )
    askew = "at the start with ω along a skew axis"
    when = ["at the start", *[askew] * (len(states.omega_body) - 1)]
    return leap(found, steps) or differing(equations, steps, found, when)


def starting_with(scenario: Scenario, omega_body: FloatArray) -> Scenario:
    """The scene with another ω at its start, rad/s, body axes."""
    start = scenario.start
    flight = start.position_world, start.velocity_world
    return started_at(scenario, start.q_world_body_wxyz, omega_body, *flight)


def settled(
    open_at: Open,
    scenario: Scenario,
    repeated: Callable[[int], State],
    timesteps: tuple[FloatArray, FloatArray],
    after: After,
    slack: float,
    *,
    is_single: bool,
    least_turn: float = 0.0,
    repeats: Sequence[int] = (1,),
    is_enough: Callable[[float, float], bool] = lambda *_: True,
) -> tuple[Steps, Excess]:
    """Steps from exact states, and what they gain; once settled where a constraint holds them.

    Parameters
    ----------
    repeated : the states so many times over, each time a little otherwise
    timesteps : s, each half of the one before; and others, which these are to predict
    after : the exact motion
    slack, is_single, least_turn : as of `equation_residuals`
    repeats : of each state; where there are several, the first shows whether a constraint holds the
        body, and the next ones are taken until steps are known well enough, or to be wrong
    is_enough : whether steps are known well enough: relative to the largest terms, and to the
        weakest effect
    """
    equations, together = Equations(scenario), np.concatenate(timesteps)
    settling = 0

    def found_with(count: int) -> tuple[Steps, Excess]:
        states = repeated(count)
        steps = single_steps(open_at, scenario, states, together, after, settling, count)
        halved = len(timesteps[0])
        steps, others = steps.part(0, halved), steps.part(halved, len(together))
        epsilon = rounding_of(steps.before, is_single)
        return steps, excess(equations, steps, others, epsilon, slack, least_turn * bool(settling))

    first = steps, found = found_with(repeats[0])
    is_wrong = bool(found.by_tolerance.max() > 1)
    # An impulse begins as that of the step before, of which an exact state has none. In single
    # precision rounding hides that the com is off then.
    is_constrained = found.is_constrained or (is_wrong and is_single and scenario.is_jointed)
    if is_constrained:
        settling, slack = SETTLING // (1 + is_single), max(slack, NEGLIGIBLE / ABOVE)
    elif is_wrong:
        return steps, found
    known_to = math.inf
    for count in repeats[1:] or repeats[: int(is_constrained)]:
        steps, found = found_with(count)
        if is_enough(found.at_most, found.of_an_effect) or found.by_tolerance.max() > 1:
            break
        if found.at_most > STILL_GAINING * known_to:
            break
        known_to = found.at_most
    # Settled steps must be known better than the first are off to acquit them, but for the torque
    # of the impulse that is missing in a constraint's first step.
    k, quantity = np.unravel_index(int(np.argmax(first[1].by_tolerance)), first[1].off.shape)
    is_missing = first[1].is_constrained and quantity == TORQUE
    is_known = is_missing or found.most[k, quantity] < first[1].off[k, quantity]
    if is_wrong and found.by_tolerance.max() <= 1 and not is_known:
        return first
    return steps, replace(found, is_constrained=is_constrained)


def rounding_of(states: State, is_single: bool) -> float:
    """The relative rounding of states as an engine holds them, whether it declares it or not."""
    return float(np.finfo(np.float32 if is_single or single_precision(states) else float).eps)


#: Which quantity of a gain is I dω/dt.
TORQUE = 1
#: Name and unit of what leaps, and how much of it an SI unit is.
_LEAPING = (
    ("attitude", "°", math.degrees(1.0)),
    ("I ω", " N m s", 1.0),
    ("the com's velocity", " m/s", 1.0),
    ("com", " m", 1.0),
)


def leap(found: Excess, steps: Steps) -> str:
    """The message if a step changes the state by as much however short it is; else empty."""
    gains = found.by_timestep[-LEAPS:] * steps.timesteps[-LEAPS:, None]
    leaps = (np.ptp(gains, axis=0) < gains.min(axis=0) / 2) & (found.unsmooth.max(axis=0) > 1)
    if not leaps.any():
        return ""
    quantity = int(np.argmax(leaps * gains.max(axis=0)))
    what, unit, factor = _LEAPING[quantity]
    off = factor * gains[-1, quantity] * found.sizes[quantity]
    return (
        f"{what} is off by {off:.2g}{unit} after a step, however short it is, down to "
        f"{steps.timesteps[-1]:.2g} s"
    )


_WHAT = ("dR/dt, rad/s in body axes,", "I dω/dt, N m in body axes,")
_WHAT_FREE = ("dv/dt, m/s² in world axes,", "dr/dt, m/s in world axes,")
_WHAT_HELD = ("the com's velocity, m/s,", "the com, m,")


def differing(equations: Equations, steps: Steps, found: Excess, when: Sequence[str]) -> str:
    """How steps differ from the equations of motion, and which change of them explains it.

    Parameters
    ----------
    when : words for each of the states

    Returns
    -------
    The words; empty if steps differ by no more than their tolerance.
    """
    off = found.by_tolerance
    if off.max() <= 1:
        return ""
    gains = gains_of(equations, steps.before, steps.exact, steps.spans, found.limit)
    # A rod whose least moment is a 10⁻¹²th is not followed, even for a step.
    is_followed = equations.rate * max(gain.span for gain in gains) <= FOLLOWED
    as_if = explanation(equations, gains, found.tolerance) if is_followed else ""
    worst, quantity = divmod(int(np.argmax(off)), off.shape[1])
    what = _residual(gains[worst], quantity, equations.scenario.constraint.is_pivot, when[worst])
    return f"behaves as if {as_if}: {what}" if as_if else what


def _residual(gain: Gain, quantity: int, is_held: bool, when: str) -> str:
    """What one of the four quantities of a gain is, and what it should be."""
    what = (*_WHAT, *(_WHAT_HELD if is_held else _WHAT_FREE))[quantity]
    excess, wanted = gain.excess[quantity], gain.wanted[quantity]
    digits = _digits_that_differ(wanted, excess)
    got, should = _numbers(wanted + excess, digits), _numbers(wanted, digits)
    return f"{what} is {got} {when}, not {should}"


def _digits_that_differ(wanted: FloatArray, excess: FloatArray) -> int:
    part = float(np.abs(excess).max()) / (float(np.abs(wanted).max()) or 1.0)
    return DIGITS + max(0, math.ceil(-math.log10(part)) - 1)


def _numbers(vector: FloatArray, digits: int) -> str:
    return f"[{', '.join(f'{value:.{digits}g}' for value in vector)}]"
