"""Engines with a planted fault each: what they do wrong, a study must tell by name.

They are stepped honestly, by Heun's method (`stepped`), but for the fault, so that a study of the
faultless one converges. Faults that single steps and replays show are in `stepped_faults`.
"""

import ctypes
import os
import time
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engine import Derivative
from spincheck.engines import BodyReading, Engine, EngineError, Method, Session, State
from spincheck.scenarios import EFFECTS, FloatArray, Scenario
from stepped import Stepped, with_omega

METHOD = Method("Heun", 2, 2, "Heun's method on quaternions", frozenset(EFFECTS) - {"pivot"})
#: s, when some faults begin.
HALFWAY = 0.5


class HeunSession(Stepped):
    """The faultless one; it cannot be restarted."""

    can_restart = False

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, METHOD.order, timestep, 0.0)

    @property
    def is_late(self) -> bool:
        return self.time > HALFWAY


class Planted(Engine):
    """The engine of a session class, picklable by name."""

    name = "faultless"
    version = "1"
    methods = (METHOD,)
    session = HeunSession

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        return self.session(scenario, timestep)


# What ends a process or a run.


class SegfaultSession(HeunSession):
    def advance(self, steps: int) -> None:
        ctypes.string_at(0)


class AbortSession(HeunSession):
    """Says why, where no Python can catch it, and aborts."""

    def advance(self, steps: int) -> None:
        os.write(2, b"solver.cpp:42\nassertion failed: norm(q) > 0\n")
        os.abort()


class ChattySession(HeunSession):
    def advance(self, steps: int) -> None:
        if not self.taken:
            os.write(1, b"stepping\n")
        super().advance(steps)


class HangSession(HeunSession):
    def advance(self, steps: int) -> None:
        time.sleep(600)


def _without_end() -> FloatArray:
    while True:
        pass


def _at_address_zero() -> FloatArray:
    ctypes.string_at(0)
    raise AssertionError


class DerivativesSession(HeunSession):
    """Two of its derivatives end what asks for them; one is wrong, but it is there."""

    def derivatives(self) -> dict[str, Derivative]:
        return {
            "without end": Derivative(_without_end),
            "crash": Derivative(_at_address_zero),
            "identity": Derivative(lambda: np.eye(6)),
        }


class RaisingSession(HeunSession):
    def advance(self, steps: int) -> None:
        raise ZeroDivisionError("a bug in an adapter")


class NotANumberSession(HeunSession):
    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.is_late:
            self.omega[:] = np.nan


class ResetSession(HeunSession):
    def check(self) -> None:
        if self.is_late:
            raise EngineError("the clock went back: the engine has reset itself")


class ExplodingSession(HeunSession):
    """Kicks the body once, to a finite but absurd spin."""

    kicked = False

    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.is_late and not self.kicked:
            self.omega[:] *= 10
            self.kicked = True


# What is held, or read, is not what is there.


class LyingAboutBodySession(HeunSession):
    def read_body(self) -> BodyReading:
        return replace(super().read_body(), mass=1.01 * self.scenario.body.mass)


class LyingAboutStartSession(HeunSession):
    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.omega[:] *= 1.01


class AnotherStartSession(LyingAboutStartSession):
    """Reads back its start, and starts from another."""

    def read_state(self) -> State:
        state = super().read_state()
        return state if self.taken else replace(state, omega_body=self.scenario.start.omega_body)


class XyzwSession(HeunSession):
    """Reads its attitude out scalar last, after a start that was right."""

    def reading(self, state: State) -> State:
        return replace(state, q_world_body_wxyz=np.roll(state.q_world_body_wxyz, -1))


class NegatedSession(HeunSession):
    """Gives its quaternion with one component negated."""

    def reading(self, state: State) -> State:
        return replace(state, q_world_body_wxyz=state.q_world_body_wxyz * [1, -1, 1, 1])


class WorldOmegaSession(HeunSession):
    """Gives ω along the world's axes for that along the body's."""

    def reading(self, state: State) -> State:
        attitude = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        return with_omega(state, attitude.apply(state.omega_body))


class LateSession(HeunSession):
    """Reads what it was a step ago."""

    def advance(self, steps: int) -> None:
        super().advance(steps - 1)
        self.last = State(*np.split(self.y.copy(), (4, 7, 10)))
        super().advance(1)

    def reading(self, state: State) -> State:
        return self.last


# What acts, or is solved, is something else.


class DampedInSecretSession(HeunSession):
    """Damps the spin and does not say so: only a comparison with the exact motion shows it."""

    #: 1/s
    gain = -1e-3

    def torque(self):
        return self.gain * (self.inertia @ self.omega)


class DampedOpenlySession(DampedInSecretSession):
    def active(self) -> frozenset[str]:
        return frozenset({"damping"})


class BarelyDampedSession(DampedInSecretSession):
    """Loses energy, a billionth a second."""

    gain = -1e-9


class SpunUpInSecretSession(DampedInSecretSession):
    """Gains energy, slowly."""

    gain = 1e-3


class SpunUpFromHalfwaySession(DampedInSecretSession):
    """Gains energy only later on."""

    gain = 1e-2

    def torque(self):
        return super().torque() if self.time >= HALFWAY else None


class SwappedMomentsSession(HeunSession):
    """Steps with the first and the last moment swapped, and reads back the right ones."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.constants = self.constants_with(self.inertia[::-1, ::-1])


class TwiceTheMassSession(HeunSession):
    """Doubles mass and moments once they were read back: of a free body that changes nothing."""

    def advance(self, steps: int) -> None:
        self.constants = self.constants_with(2 * self.inertia)
        super().advance(steps)


class SlowClockSession(HeunSession):
    """Takes steps of another length than it is told."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, 0.99 * timestep)


class FrozenSession(HeunSession):
    """Stands still from halfway on, its ω as it was."""

    def advance(self, steps: int) -> None:
        if self.time < HALFWAY:
            super().advance(steps)


class ResetInSecretSession(HeunSession):
    """Goes back to its start once, its clock going on."""

    was_reset = False

    def after_step(self) -> None:
        if self.is_late and not self.was_reset:
            start, self.was_reset = self.scenario.start, True
            self.y[:7] = *start.q_world_body_wxyz, *start.omega_body


class LaggingSession(HeunSession):
    """Turns its attitude by no more than so much a step, its ω going on."""

    #: rad.
    MOST = 0.01

    def after_step(self) -> None:
        turn = float(np.linalg.norm(self.omega)) * self.timestep
        self.turn((min(1.0, self.MOST / turn) - 1) * self.timestep * self.omega)


@cache
def planted(kind: type[HeunSession]) -> Engine:
    """The engine of a session class of this module."""
    name = kind.__name__.removesuffix("Session")
    cls = type(f"{name}Engine", (Planted,), {"name": name, "session": kind})
    cls.__module__ = __name__
    globals()[cls.__name__] = cls
    return cls()


for _kind in [*globals().values()]:
    if isinstance(_kind, type) and issubclass(_kind, HeunSession):
        planted(_kind)
