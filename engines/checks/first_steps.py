"""Checks that an engine's first steps obey the scene's equations of motion.

A model can read back correctly and still move wrongly: moments in another order, gravity with the
opposite sign, an additional damping, no gyroscopic torque, a clock at another rate. At ordinary
timesteps such faults are hidden by the method's own error; at very small ones they are not. So the
scene is opened with a very small timestep, and the gains of attitude, ω, com and velocity over the
first steps are compared with the exact gains. This is repeated with a half and a quarter of the
timestep: the method's error is extrapolated away, and the difference of two extrapolations is the
noise. What then exceeds the noise is confirmed with four timesteps: an error that is no smooth
function of the timestep shows in one of the differences. Jolt, for one, drops what its pivot puts
back as soon as that is less than 1e-6 rad a step.

A body that turns about a principal axis has no gyroscopic torque. So the same is done from two
other starts with ω askew to the body's axes. Together they determine which change of the model
explains all gains. A constraint needs some steps to settle; these are skipped.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ...scenarios import FloatArray, Scenario
from ...scenarios.scenario import started_at
from ..session import Session
from .equations import Equations, Gain, gain_between, gain_sizes, rounded
from .explanations import NO_GYROSCOPIC_TORQUE, explanation
from .read_back import State

#: Number of the longest steps that are skipped, and of those compared. Bullet removes a fifth of a
#: constraint's error in a step: 0.8^64 = 6e-7 of it is left.
STEPS = 64
#: How many steps a longest one is divided into; and again, where these show an excess.
HALVINGS, CONFIRMING = (1, 2, 4), (1, 2, 4, 8)
#: An excess counts if it exceeds so many times its noise.
ABOVE_NOISE = 8.0
#: Fraction of a gain's size that a constraint's solver may leave as an error.
NEGLIGIBLE = 2e-6
#: Directions of ω in the body, beside the scene's own: askew to every axis of a body that is drawn
#: along its axes.
ASKEW = ((0.62, 0.55, 0.56), (-0.48, 0.71, 0.52))
#: Scenes whose other starts are kept, for their next methods.
KEPT = 4
#: ω has jumped at the start if it changed by more than this fraction, beyond what the rotation of
#: the body explains.
LEAP = 1e-3
#: Digits printed of a number; more if they are needed to show a difference.
DIGITS = 3

Open = Callable[[Scenario, float], Session]


@dataclass(frozen=True, eq=False)
class _FirstStates:
    """The states read from one start: at the start, in the middle and at the end, by timestep.

    Attributes
    ----------
    span : s, from the start to the middle, and from there to the end
    """

    states: list[tuple[State, State, State]]
    span: float


@dataclass(frozen=True, eq=False)
class _NoisyGain:
    """Result from one start: the gain with the shortest steps, and its extrapolated excess.

    Attributes
    ----------
    noise : of the excess, (4,)
    is_held : whether there is a pivot
    """

    gain: Gain
    noise: FloatArray
    is_held: bool


def equation_residuals(
    open_at: Open, scenario: Scenario, epsilon: float, negligible: float = NEGLIGIBLE
) -> list[str]:
    """What an engine's first steps gain beyond the scene's equations of motion, in words.

    Parameters
    ----------
    open_at : opens a scene with a timestep, s
    epsilon : relative rounding of the engine's floating-point numbers
    negligible : fraction of a gain's size below which nothing is reported
    """
    if not _residuals_of(open_at, scenario, epsilon, negligible, HALVINGS):
        return []
    return _residuals_of(open_at, scenario, epsilon, negligible, CONFIRMING)


def _residuals_of(
    open_at: Open,
    scenario: Scenario,
    epsilon: float,
    negligible: float,
    halvings: tuple[int, ...],
) -> list[str]:
    """As `equation_residuals`, with these timesteps."""
    equations = Equations(scenario)
    starts = [_first_states(open_at, scenario, equations, epsilon, halvings)]
    if leap := _leap(starts[0], equations):
        return [leap]
    starts += [
        _first_states(open_at, start, equations, epsilon, halvings)
        for start in _askew(scenario, equations.rate)
    ]
    gains = [_noisy_gain(one, equations, epsilon, negligible) for one in starts]
    residuals = list(_residuals([gains[0]])) or list(_residuals(gains[1:]))[:1]
    if not residuals:
        return []
    without = Equations(scenario, gyroscopic=False)
    if any(_residuals([_noisy_gain(one, without, epsilon, negligible) for one in starts])):
        noise = np.array([one.noise for one in gains])
        as_if = explanation(equations, [one.gain for one in gains], noise)
    else:
        as_if = NO_GYROSCOPIC_TORQUE
    return [f"behaves as if {as_if}: {residuals[0]}", *residuals[1:]] if as_if else residuals


def starting_with(scenario: Scenario, omega_body: FloatArray) -> Scenario:
    """The scene with another ω at its start, rad/s, body axes."""
    start = scenario.start
    flight = start.position_world, start.velocity_world
    return started_at(scenario, start.q_world_body_wxyz, omega_body, *flight)


@lru_cache(maxsize=KEPT)
def _askew(scenario: Scenario, rate: float) -> tuple[Scenario, ...]:
    speed = float(np.linalg.norm(scenario.start.omega_body)) or rate
    return tuple(starting_with(scenario, speed * np.array(direction)) for direction in ASKEW)


def _first_states(
    open_at: Open,
    start: Scenario,
    equations: Equations,
    epsilon: float,
    halvings: tuple[int, ...],
) -> _FirstStates:
    """Take the first steps from one start, with each of the timesteps."""
    longest = halvings[-1] * _shortest_step(start, equations.rate, epsilon)
    states = []
    for halving in halvings:
        with open_at(start, longest / halving) as session:
            first = session.read_state()
            session.advance(STEPS * halving)
            before = session.read_state()
            session.advance(STEPS * halving)
            states.append((first, before, session.read_state()))
    return _FirstStates(states, STEPS * longest)


def _noisy_gain(
    start: _FirstStates, equations: Equations, epsilon: float, negligible: float
) -> _NoisyGain:
    """The gains of states in excess of these equations."""
    gains = [
        gain_between(equations, before, after, start.span) for _, before, after in start.states
    ]
    extrapolated = [2 * fine.excess - coarse.excess for coarse, fine in pairwise(gains)]
    apart = np.zeros(len(extrapolated[0]))
    for coarse, fine in pairwise(extrapolated):
        # What is left by extrapolation is of second order: of the coarser steps' a quarter.
        apart = np.maximum(apart / 4, np.abs(fine - coarse).max(axis=1))
    # One rounding for each of the shortest steps, as all may have the same sign.
    roundings = STEPS * 2 ** (len(gains) - 1)
    noise = ABOVE_NOISE * apart + roundings * rounded(equations, gains[-1], epsilon)
    noise += negligible * gain_sizes(equations, gains[-1])
    is_held = equations.scenario.constraint.is_pivot
    return _NoisyGain(replace(gains[-1], excess=extrapolated[-1]), noise, is_held)


def _shortest_step(scenario: Scenario, rate: float, epsilon: float) -> float:
    """A power of two, s, so that times are exact.

    The rounding error of a gain is proportional to 1/h, the error left by extrapolation to h². If a
    constraint holds the body, the rounding of its position causes an acceleration proportional to
    1/h².
    """
    balance = np.cbrt(epsilon) if scenario.constraint.is_pivot else np.cbrt(12 * epsilon) / STEPS
    return float(2.0 ** np.floor(np.log2(balance / rate)))


def _leap(first: _FirstStates, equations: Equations) -> str:
    """The message if ω jumps at the start, before any time has passed; else empty."""
    for start, soon, _ in first.states:
        size = float(np.linalg.norm(start.omega_body))
        exact = equations.after(start, first.span)
        # From rest any ω would be a jump; its gain is compared below.
        apart = [np.linalg.norm(soon.omega_body - other.omega_body) for other in (start, exact)]
        if size and min(apart) > (LEAP + equations.rate * first.span) * size:
            reads, soon_reads = _numbers(start.omega_body), _numbers(soon.omega_body)
            return f"ω, rad/s in body axes, reads {reads} at the start and leaps to {soon_reads}"
    return ""


_WHAT = ("dR/dt, rad/s in body axes,", "I dω/dt, N m in body axes,")
_WHAT_FREE = ("dv/dt, m/s² in world axes,", "dr/dt, m/s in world axes,")
_WHAT_HELD = ("the com's velocity, m/s,", "the com, m,")


def _residuals(gains: list[_NoisyGain]) -> Iterator[str]:
    """The residuals that exceed their noise, one sentence each."""
    for one in gains:
        for k in range(len(one.noise)):
            if np.abs(one.gain.excess[k]).max() > one.noise[k]:
                yield residual_words(one.gain, k, one.is_held, "at the start")


def residual_words(gain: Gain, quantity: int, is_held: bool, when: str) -> str:
    """What one of the four quantities of a gain is, and what it should be."""
    what = (*_WHAT, *(_WHAT_HELD if is_held else _WHAT_FREE))[quantity]
    excess, wanted = gain.excess[quantity], gain.wanted[quantity]
    digits = _digits_that_differ(wanted, excess)
    got, should = _numbers(wanted + excess, digits), _numbers(wanted, digits)
    return f"{what} is {got} {when}, not {should}"


def _digits_that_differ(wanted: FloatArray, excess: FloatArray) -> int:
    part = float(np.abs(excess).max()) / (float(np.abs(wanted).max()) or 1.0)
    return DIGITS + max(0, math.ceil(-math.log10(part)) - 1)


def _numbers(vector: FloatArray, digits: int = DIGITS) -> str:
    return f"[{', '.join(f'{value:.{digits}g}' for value in vector)}]"
