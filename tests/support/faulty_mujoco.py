"""MuJoCo with a fault of a given size in it: a model that is another, or readings that are.

What it reads back before the first step is what the scene says.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engines import BodyReading, Method, Session, State
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.scenarios import Scenario, loads, radius_of_gyration
from spincheck.scenarios.scenario import started_at, with_tables

#: About this axis what is turned is turned.
AXIS = np.array([2.0, -1.0, 2.0]) / 3

Read = Callable[[State, float], State]


@dataclass(frozen=True)
class PlantedFault:
    """A kind out of `KINDS`, and its size, relative or in rad."""

    kind: str
    size: float


def _changed(scenario: Scenario, **tables: dict[str, object]) -> Scenario:
    changed = {
        name: getattr(scenario.document, name).model_copy(update=update)
        for name, update in tables.items()
    }
    return with_tables(scenario, **changed)


def _moments(scenario: Scenario, size: float) -> Scenario:
    tensor = np.array(scenario.body.inertia_com)
    tensor[0, 0] *= 1 + size
    matrix = tuple(tuple(float(value) for value in row) for row in tensor)
    return _changed(scenario, body={"inertia": matrix, "inertia_about": "com"})


def _com(scenario: Scenario, size: float) -> Scenario:
    com = np.array(scenario.body.com) + size * radius_of_gyration(scenario) * AXIS
    about_com = tuple(map(tuple, np.array(scenario.body.inertia_com).tolist()))
    body = {"com": tuple(com.tolist()), "inertia": about_com, "inertia_about": "com"}
    return _changed(scenario, body=body)


def _gravity(scenario: Scenario, acceleration: np.ndarray) -> Scenario:
    assert scenario.effects.gravity is not None
    table = scenario.effects.gravity.model_copy(
        update={"acceleration": tuple(acceleration.tolist())}
    )
    return _changed(scenario, effects={"gravity": table})


def _tilted(scenario: Scenario, size: float) -> Scenario:
    turn = Rotation.from_rotvec(size * np.array([1.0, 0.0, 0.0]))
    return _gravity(scenario, turn.apply(np.array(scenario.gravity_world)))


def _late(state: State, by: float) -> State:
    """The attitude, and the com, of a while ago, s."""
    late = _turned(state, -by * state.omega_body)
    return replace(late, com_world=state.com_world - by * state.velocity_world)


def _turned(state: State, turn_body: np.ndarray) -> State:
    attitude = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
    q = (attitude * Rotation.from_rotvec(turn_body)).as_quat(scalar_first=True)
    return replace(state, q_world_body_wxyz=q)


def _sagged(state: State, by: float) -> State:
    return replace(state, com_world=state.com_world - [0.0, 0.0, by])


def _drifted(state: State, t: float, speed: float) -> State:
    drift = np.array([speed, 0.0, 0.0])
    velocity = state.velocity_world + drift
    return replace(state, com_world=state.com_world + t * drift, velocity_world=velocity)


def _rounded(state: State) -> State:
    return State(*(column.astype(np.float32).astype(float) for column in vars(state).values()))


#: What a fault does to the scene that is simulated.
MODELS: dict[str, Callable[[Scenario, float], Scenario]] = {
    "moment": _moments,
    "com": _com,
    "gravity": lambda s, size: _gravity(s, (1 + size) * np.array(s.gravity_world)),
    "gravity's tilt": _tilted,
}
#: What it does to a state read after the first step, given the time, s, and the scene.
READINGS: dict[str, Callable[[State, float, Scenario, float], State]] = {
    "reading of ω": lambda s, _t, _c, size: replace(s, omega_body=(1 + size) * s.omega_body),
    "reading of the attitude": lambda s, _t, _c, size: _turned(s, size * AXIS),
    "reading of the velocity": lambda s, _t, _c, size: replace(
        s, velocity_world=(1 + size) * s.velocity_world
    ),
    "reading of the com": lambda s, _t, c, size: _sagged(s, size * radius_of_gyration(c)),
    "reading of the spins": lambda s, _t, _c, size: replace(s, spins=(1 + size) * s.spins),
    "drift": lambda s, t, c, size: _drifted(s, t, size * radius_of_gyration(c) / c.window.duration),
    "sample late": lambda s, _t, c, size: _late(
        s, size / max(float(np.linalg.norm(c.start.omega_body)), 1 / c.window.duration)
    ),
    "float32": lambda s, _t, _c, _size: _rounded(s),
}
CLOCK = "clock"
KINDS = (*MODELS, CLOCK, *READINGS)


def applies(fault: PlantedFault, scenario: Scenario) -> bool:
    """Whether it makes a difference to a scene: com, gravity and velocity where there are any."""
    if fault.kind in ("gravity", "gravity's tilt"):
        return scenario.effects.gravity is not None
    if fault.kind == "com":
        return scenario.constraint.is_pivot and scenario.effects.gravity is not None
    if fault.kind == "reading of the velocity":
        return bool(scenario.called_for or scenario.start.velocity_world.any())
    if fault.kind == "reading of the spins":
        return bool(scenario.rotors)
    return fault.kind != "moment" or bool(np.ptp(scenario.body.principal_moments) > 0)


class FaultySession(Session):
    """A session that reads back correctly before the first step."""

    can_restart = True

    def __init__(
        self, honest: Session, faulty: Session, scenario: Scenario, read: Read, clock: float
    ) -> None:
        self.start, self.body = honest.read_state(), honest.read_body()
        honest.close()
        self.faulty, self.scenario, self.read, self.time = faulty, scenario, read, 0.0
        self.clock = clock

    def restart(self, state: State, timestep: float | None = None) -> None:
        self.start, self.time = state, 0.0
        self.timestep = timestep or self.timestep
        self.faulty.restart(state, self.timestep * self.clock)

    def read_body(self) -> BodyReading:
        return self.body

    def read_state(self) -> State:
        return self.read(self.faulty.read_state(), self.time) if self.time else self.start

    def advance(self, steps: int) -> None:
        self.faulty.advance(steps)
        self.time += steps * self.timestep

    def check(self) -> None:
        self.faulty.check()

    def active(self) -> frozenset[str]:
        return self.scenario.called_for

    def close(self) -> None:
        self.faulty.close()


class FaultyMuJoCo(MuJoCo):
    """Its methods of first and of fourth order, with a fault in them."""

    methods = tuple(method for method in MuJoCo.methods if method.name in ("Euler", "RK4"))

    def __init__(self, fault: PlantedFault | None = None) -> None:
        self.fault = fault
        # What is known of an engine's first steps is known by its name.
        self.name = f"faulty in its {fault.kind} by {fault.size:g}" if fault else "honest"

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        honest = super().open(scenario, method, timestep)
        if self.fault is None:
            return honest
        kind, size = self.fault.kind, self.fault.size
        model = MODELS.get(kind, lambda same, _: same)(scenario, size)
        clock = 1 + size if kind == CLOCK else 1.0
        reading = READINGS.get(kind, lambda state, *_: state)
        session = FaultySession(
            honest,
            super().open(model, method, timestep * clock),
            scenario,
            lambda state, time: reading(state, time, scenario, size),
            clock,
        )
        session.timestep = timestep
        return session


class UpsideDown(MuJoCo):
    """MuJoCo, told of a scene whose gravity points the other way, and honest about that one."""

    name = "upside-down"
    methods = tuple(method for method in MuJoCo.methods if method.name == "RK4")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        flipped = scenario.text.replace("-9.81]", "9.81]")
        assert flipped != scenario.text
        start = scenario.start
        flight = start.position_world, start.velocity_world
        q, omega_body = start.q_world_body_wxyz, start.omega_body
        other = started_at(loads(flipped, scenario.name), q, omega_body, *flight)
        return super().open(other, method, timestep)


class HeavierOnceLoaded(MuJoCo):
    """MuJoCo, with the body's mass doubled after loading."""

    name = "heavier"
    methods = UpsideDown.methods

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        session = super().open(scenario, method, timestep)
        held = session.read_body()
        session.read_body = lambda: held
        session.model.body_mass[-1] *= 2
        return session
