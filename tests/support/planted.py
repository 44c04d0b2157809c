"""Engines with a planted fault each: what they do wrong, a study must tell by name.

They step a rigid body honestly, in the way of `spincheck.reference.cross_check`, but for the
fault, so that a study of the faultless one converges.
"""

import ctypes
import math
import os
import time
from dataclasses import replace
from functools import cache

import numpy as np
from quiet_session import QuietSession
from scipy.spatial.transform import Rotation
from spincheck.engines import BodyReading, Engine, EngineError, Method, Session, State
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.checks.equation_residuals import starting_with
from spincheck.scenarios import EFFECTS, Scenario, loads
from spincheck.scenarios.rotation import cross, times

METHOD = Method("Heun", 2, 2, "Heun's method on rotation vectors", frozenset(EFFECTS) - {"pivot"})


class HeunSession(QuietSession):
    """A free body in its own frame, stepped by Heun's method in ω and attitude."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        self.scenario, self.timestep = scenario, timestep
        self.inertia = np.array(scenario.body.inertia_com)
        self.inverse = np.linalg.inv(self.inertia)
        self.omega = np.array(scenario.start.omega_body)
        self.q_world_body_wxyz = np.array(scenario.start.q_world_body_wxyz)
        self.steps = 0

    def read_body(self) -> BodyReading:
        body = self.scenario.body
        return BodyReading(body.mass, np.array(body.com), self.inertia)

    def read_state(self) -> State:
        return State(self.q_world_body_wxyz, self.omega.copy(), np.zeros(3), np.zeros(3))

    def rate(self, omega):
        return self.inverse @ cross(self.inertia @ omega, omega)

    def advance(self, steps: int) -> None:
        h = self.timestep
        for _ in range(steps):
            first = self.rate(self.omega)
            second = self.rate(self.omega + h * first)
            middle = self.omega + h / 4 * (first + second)
            self.omega = self.omega + h / 2 * (first + second)
            self.turn(h * middle)
        self.steps += steps

    @property
    def attitude(self) -> Rotation:
        return Rotation.from_quat(self.q_world_body_wxyz, scalar_first=True)

    @attitude.setter
    def attitude(self, other: Rotation) -> None:
        self.q_world_body_wxyz = other.as_quat(scalar_first=True)

    def turn(self, rotation_vector_body):
        """Turn the body, rad."""
        angle = math.sqrt(rotation_vector_body @ rotation_vector_body)
        sine = 0.5 * np.sinc(angle / (2 * np.pi)) * rotation_vector_body
        self.q_world_body_wxyz = self.q_world_body_wxyz @ times([math.cos(angle / 2), *sine])


class Planted(Engine):
    """The faultless one."""

    name = "faultless"
    version = "1"
    methods = (METHOD,)
    session = HeunSession

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        return self.session(scenario, timestep)


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
        if not self.steps:
            os.write(1, b"stepping\n")
        super().advance(steps)


class HangSession(HeunSession):
    def advance(self, steps: int) -> None:
        time.sleep(600)


class NotANumberSession(HeunSession):
    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.steps * self.timestep > 0.5:
            self.omega = self.omega * np.nan


class ResetSession(HeunSession):
    def check(self) -> None:
        if self.steps * self.timestep > 0.5:
            raise EngineError("the clock went back: the engine has reset itself")


class ExplodingSession(HeunSession):
    """Kicks the body once, to a finite but absurd spin."""

    kicked = False

    def advance(self, steps: int) -> None:
        super().advance(steps)
        if self.steps * self.timestep > 0.5 and not self.kicked:
            self.omega, self.kicked = self.omega * 10, True


class LyingAboutBodySession(HeunSession):
    def read_body(self) -> BodyReading:
        return replace(super().read_body(), mass=1.01 * self.scenario.body.mass)


class LyingAboutStartSession(HeunSession):
    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.omega = 1.01 * self.omega


class DampedInSecretSession(HeunSession):
    """Damps the spin and does not say so: only a comparison with the exact motion shows it."""

    def rate(self, omega):
        return super().rate(omega) - 1e-3 * omega


class DampedOpenlySession(DampedInSecretSession):
    def active(self) -> frozenset[str]:
        return frozenset({"damping"})


class SwappedMomentsSession(HeunSession):
    """Steps with the first and the last moment swapped, and reads back the right ones."""

    def rate(self, omega):
        swapped = self.inertia[::-1, ::-1]
        return np.linalg.inv(swapped) @ cross(swapped @ omega, omega)


class XyzwSession(HeunSession):
    """Reads its attitude out scalar last, after a start that was right."""

    def read_state(self) -> State:
        state = super().read_state()
        if not self.steps:
            return state
        return replace(state, q_world_body_wxyz=np.roll(state.q_world_body_wxyz, -1))


class RaisingSession(HeunSession):
    def advance(self, steps: int) -> None:
        raise ZeroDivisionError("a bug in an adapter")


@cache
def planted(kind: type[HeunSession]) -> Engine:
    """An engine of one session class, picklable by name."""
    return _ENGINES[kind]


def _engine(kind: type[HeunSession]) -> Engine:
    name = kind.__name__.removesuffix("Session")
    cls = type(f"{name}Engine", (Planted,), {"name": name, "session": kind})
    cls.__module__ = __name__
    globals()[cls.__name__] = cls
    return cls()


_ENGINES = {kind: _engine(kind) for kind in [HeunSession, *HeunSession.__subclasses__()]}
_ENGINES[DampedOpenlySession] = _engine(DampedOpenlySession)


class UpsideDown(MuJoCo):
    """MuJoCo, told of a scene whose gravity points the other way, and honest about that one."""

    name = "upside-down"
    methods = tuple(method for method in MuJoCo.methods if method.name == "RK4")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        flipped = scenario.text.replace("-9.81]", "9.81]")
        assert flipped != scenario.text
        other = starting_with(loads(flipped, scenario.name), scenario.start.omega_body)
        return super().open(other, method, timestep)
