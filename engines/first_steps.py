"""Whether an engine's first steps obey the scene's equations of motion: its model, felt.

A model can read back right and move like another: moments used in another order, gravity with its
sign turned, a damping nobody asked for, a clock that runs at another rate. At an ordinary timestep
that drowns in what a step is off by anyway; at one so small that rounding and truncation balance,
it stands out. So a scene is opened once more with such a step, and what its attitude, ω, com and
velocity gain is compared with Euler's equations and Newton's (Goldstein, Classical Mechanics,
eq. 5.39 and 1.23). A constraint takes some steps to settle; they are let pass.

It is a remark and no verdict. The verdict is the ladder's, which sees how a motion ends and not
only how it begins.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Scenario
from .read_back import State
from .session import Session

#: Steps that are let pass, and as many that are compared. Bullet takes back a fifth of a
#: constraint's error a step: 0.8^64 is 6e-7 of it.
STEPS = 64
#: Gains are right to a few times what the motion changes within these steps, relative.
TERMS = 16


@dataclass(frozen=True, eq=False)
class _Gain:
    """What a quantity gained a second, and what it should have; (3,) each.

    Attributes
    ----------
    what : in words, with its unit and axes
    scale : what either is made up of, or rounded with
    if_other : what it should have been if something about the engine were other than it says
    """

    what: str
    got: FloatArray
    wanted: FloatArray
    scale: float
    if_other: dict[str, FloatArray] = field(default_factory=dict)

    def departure(self, allowed: float) -> str:
        """In words, how it departs from what it should be; empty if it does not."""
        if _is_near(self.got, self.wanted, allowed * self.scale):
            return ""
        as_if = [
            f", as if {other}"
            for other, gain in self.if_other.items()
            if _is_near(self.got, gain, allowed * self.scale)
        ]
        said = f"{self.what} is {_numbers(self.got)} at the start, not {_numbers(self.wanted)}"
        return said + "".join(as_if[:1])


def equation_residuals(
    open_at: Callable[[float], Session], scenario: Scenario, epsilon: float
) -> list[str]:
    """In words, what an engine's first steps gain that the scene does not give.

    Parameters
    ----------
    open_at : opens the scene with a timestep, s
    epsilon : of the engine's floating-point numbers
    """
    rate = fastest_rate(scenario)
    # Truncation goes with h. Rounding goes with 1/h; but where a constraint holds the body, its
    # position is rounded and becomes an acceleration, with 1/h².
    balance = np.cbrt(epsilon) if scenario.has_pivot else np.sqrt(epsilon)
    # A power of two, so that times are exact.
    timestep = 2.0 ** np.floor(np.log2(balance / rate))
    with open_at(timestep) as session:
        start = session.read_state()
        session.advance(STEPS)
        before = session.read_state()
        session.advance(STEPS)
        after = session.read_state()
    gains = _gains(scenario, before, after, STEPS * timestep, rate)
    allowed = TERMS * STEPS * timestep * rate
    said = [_leap(start, before, allowed), *(gain.departure(allowed) for gain in gains)]
    return [words for words in said if words]


def fastest_rate(scenario: Scenario) -> float:
    """Of anything in the scene's start, 1/s: turning, wobbling, swinging, slowing, speeding up."""
    body = scenario.body
    inertia = body.inertia_origin if scenario.has_pivot else body.inertia_com
    moments = np.linalg.eigvalsh(inertia)
    least = float(moments[0])
    speed = float(np.linalg.norm(scenario.start.omega_body))
    weight = body.mass * float(np.linalg.norm(scenario.gravity_world)) if scenario.has_pivot else 0
    push = float(np.linalg.norm(scenario.torque_body) + np.linalg.norm(scenario.torque_world))
    return max(
        speed * float(moments[-1]) / least,
        scenario.drag / least,
        float(np.sqrt((weight * np.linalg.norm(body.com) + push) / least)),
        1 / scenario.window.duration,
    )


def _leap(start: State, soon: State, allowed: float) -> str:
    """Say so if ω is another one no time after the start."""
    size = float(np.linalg.norm(start.omega_body))
    # From rest anything is a leap; what ω gains there is compared below.
    if not size or _is_near(soon.omega_body, start.omega_body, allowed * size):
        return ""
    reads, soon_reads = _numbers(start.omega_body), _numbers(soon.omega_body)
    return f"ω, rad/s in body axes, reads {reads} at the start and leaps to {soon_reads}"


def _gains(
    scenario: Scenario, before: State, after: State, span: float, rate: float
) -> Iterator[_Gain]:
    yield _turning(before, after, span, rate)
    yield _spinning(scenario, before, after, span, rate)
    if not scenario.has_pivot:
        yield from _flying(scenario, before, after, span, rate)


def _turning(before: State, after: State, span: float, rate: float) -> _Gain:
    attitude = _rotation(before)
    got_body = (attitude.inv() * _rotation(after)).as_rotvec() / span
    omega_body = (before.omega_body + after.omega_body) / 2
    speed = float(np.linalg.norm(omega_body))
    length = float(got_body @ omega_body) / speed**2 if speed else 0.0
    if_other = {
        "ω were along the world's axes": attitude.inv().apply(omega_body),
        "the attitude were that of the world in the body": -attitude.apply(omega_body),
        f"a step were {length:.6g} of a timestep": length * omega_body,
    }
    what = "dR/dt, rad/s in body axes,"
    return _Gain(what, got_body, omega_body, speed + rate, if_other)


def _spinning(scenario: Scenario, before: State, after: State, span: float, rate: float) -> _Gain:
    """Euler's equations about the pivot, or the com where there is none."""
    to_body = _rotation(before).inv()
    inertia = scenario.body.inertia_origin if scenario.has_pivot else scenario.body.inertia_com
    omega_body = (before.omega_body + after.omega_body) / 2
    got_body = inertia @ (after.omega_body - before.omega_body) / span
    weight_body = to_body.apply(scenario.body.mass * scenario.gravity_world)
    fall_body = np.cross(scenario.body.com, weight_body) if scenario.has_pivot else np.zeros(3)
    push_body = scenario.torque_body + to_body.apply(np.array(scenario.torque_world))
    torque_body = fall_body + push_body - scenario.drag * omega_body
    L_body = inertia @ omega_body
    wanted_body = torque_body - np.cross(omega_body, L_body)
    left = got_body - wanted_body
    resistance = -float(left @ omega_body) / float(omega_body @ omega_body or 1.0)
    decay = -float(left @ L_body) / float(L_body @ L_body or 1.0)
    word = "slowed" if resistance > 0 else "sped up"
    if_other = {
        "gravity were turned round": wanted_body - 2 * fall_body,
        "there were no gravity": wanted_body - fall_body,
        "there were no gyroscopic torque": wanted_body + np.cross(omega_body, L_body),
        f"it were {word} by {abs(resistance):.3g} N m s": wanted_body - resistance * omega_body,
        f"L were {word} by {abs(decay):.3g} /s": wanted_body - decay * L_body,
    }
    speed = float(np.linalg.norm(omega_body))
    size = float(np.linalg.norm(L_body)) * (speed + rate) + float(np.linalg.norm(torque_body))
    return _Gain("I dω/dt, N m in body axes,", got_body, wanted_body, size, if_other)


def _flying(
    scenario: Scenario, before: State, after: State, span: float, rate: float
) -> Iterator[_Gain]:
    gravity = scenario.gravity_world
    # The com of an engine may be rounded with the body's origin, and with what turns about it.
    arm = float(np.linalg.norm(scenario.body.com))
    velocity = (before.velocity_world + after.velocity_world) / 2
    fast = float(np.linalg.norm(velocity)) + arm * rate
    far = float(np.linalg.norm(before.com_world)) + arm
    got = (after.velocity_world - before.velocity_world) / span
    if_other = {"gravity were turned round": -gravity, "there were no gravity": 0 * gravity}
    size = float(np.linalg.norm(gravity)) + fast * rate
    yield _Gain("dv/dt, m/s² in world axes,", got, gravity, size, if_other)
    got = (after.com_world - before.com_world) / span
    yield _Gain("dr/dt, m/s in world axes,", got, velocity, size / rate + far * rate)


def _rotation(state: State) -> Rotation:
    return Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)


def _is_near(got: FloatArray, wanted: FloatArray, slack: float) -> bool:
    return bool(np.linalg.norm(got - wanted) <= slack)


def _numbers(vector: FloatArray) -> str:
    return f"[{', '.join(f'{value:.3g}' for value in vector)}]"
