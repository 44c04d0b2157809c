"""Engines with a planted fault: their start reads back right, and they report nothing unusual.

Stepped like the faultless engine of `planted`, except for the fault.
"""

from dataclasses import replace

import numpy as np
from planted import HeunSession, Planted
from scipy.spatial.transform import Rotation
from spincheck.engines import Engine, Method, Session, State
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.scenarios import Scenario

#: s, when some faults begin.
HALFWAY = 0.5


class ResetInSecretSession(HeunSession):
    """Goes back to its start once, its clock going on."""

    was_reset = False

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            super().advance(1)
            if self.steps * self.timestep > HALFWAY and not self.was_reset:
                start = self.scenario.start
                self.omega = np.array(start.omega_body)
                self.attitude = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
                self.was_reset = True


class FrozenSession(HeunSession):
    """Stands still from halfway on, its ω as it was."""

    def advance(self, steps: int) -> None:
        if self.steps * self.timestep < HALFWAY:
            super().advance(steps)


class WorldOmegaSession(HeunSession):
    """Gives ω along the world's axes for that along the body's."""

    def read_state(self) -> State:
        state = super().read_state()
        return replace(state, omega_body=self.attitude.apply(self.omega)) if self.steps else state


class NegatedSession(HeunSession):
    """Gives its quaternion with one component negated."""

    def read_state(self) -> State:
        state = super().read_state()
        mirror = np.array([1.0, -1.0, 1.0, 1.0])
        q = state.q_world_body_wxyz * mirror
        return replace(state, q_world_body_wxyz=q) if self.steps else state


class SlowClockSession(HeunSession):
    """Takes steps of another length than it is told."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, 0.99 * timestep)


class SpunUpInSecretSession(HeunSession):
    """Gains energy, slowly."""

    def rate(self, omega):
        return super().rate(omega) + 1e-3 * omega


class SpunUpFromHalfwaySession(HeunSession):
    """Gains energy only later on."""

    def rate(self, omega):
        late = self.steps * self.timestep >= HALFWAY
        return super().rate(omega) + (1e-2 * omega if late else 0)

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            super().advance(1)


class BarelyDampedSession(HeunSession):
    """Loses energy, a billionth a second."""

    def rate(self, omega):
        return super().rate(omega) - 1e-9 * omega


class LaggingSession(HeunSession):
    """Turns its attitude by no more than so much a step, its ω going on."""

    #: rad.
    MOST = 0.01

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            before = self.attitude
            super().advance(1)
            turn = (before.inv() * self.attitude).as_rotvec()
            short = min(1.0, self.MOST / float(np.linalg.norm(turn)))
            self.attitude = before * Rotation.from_rotvec(short * turn)


class LateSession(HeunSession):
    """Reads what it was a step ago."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.last = self.read_state()

    def read_state(self) -> State:
        return getattr(self, "last", super().read_state())

    def advance(self, steps: int) -> None:
        super().advance(steps - 1)
        self.last = super().read_state()
        super().advance(1)


class UngyroscopicSession(HeunSession):
    """Leaves the gyroscopic torque out, as engines for games do."""

    def rate(self, omega):
        return 0 * omega


class SingleSession(HeunSession):
    """Holds its state in 24 bits."""

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            super().advance(1)
            self.omega = self.omega.astype(np.float32).astype(float)
            q = self.attitude.as_quat().astype(np.float32).astype(float)
            self.attitude = Rotation.from_quat(q)


class SingleUngyroscopicSession(SingleSession):
    """Both."""

    def rate(self, omega):
        return 0 * omega


class AnotherStartSession(HeunSession):
    """Reads back its start, and starts from another."""

    def __init__(self, scenario: Scenario, timestep: float) -> None:
        super().__init__(scenario, timestep)
        self.omega = 1.01 * self.omega

    def read_state(self) -> State:
        state = super().read_state()
        right = np.array(self.scenario.start.omega_body)
        return state if self.steps else replace(state, omega_body=right)


class TwiceTheMassSession(HeunSession):
    """Doubles mass and moments once they were read back: of a free body that changes nothing."""

    def advance(self, steps: int) -> None:
        self.inertia, self.inverse = 2 * self.inertia, self.inverse / 2
        super().advance(steps)
        self.inertia, self.inverse = self.inertia / 2, 2 * self.inverse


def engine_of(kind: type[HeunSession]) -> Engine:
    """An engine of a session class of this file, picklable by name."""
    name = kind.__name__.removesuffix("Session")
    cls = type(name, (Planted,), {"name": name, "session": kind})
    cls.__module__ = __name__
    return globals().setdefault(name, cls)()


for _kind in HeunSession.__subclasses__():
    if _kind.__module__ == __name__:
        engine_of(_kind)


class HeavierOnceLoaded(MuJoCo):
    """MuJoCo, with the body's mass doubled after loading."""

    name = "heavier"
    methods = tuple(method for method in MuJoCo.methods if method.name == "RK4")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        session = super().open(scenario, method, timestep)
        held = session.read_body()
        session.read_body = lambda: held
        session.model.body_mass[-1] *= 2
        return session
