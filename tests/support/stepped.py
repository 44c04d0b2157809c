"""An honest engine of all effects, by three methods, whose steps faults can be planted in.

It is stepped in compiled code: a ladder of it takes a second. A fault is a subclass of `Stepped`.
"""

from dataclasses import replace

import numpy as np
from numba import njit
from quiet_session import QuietSession
from spincheck.engines import BodyReading, Engine, Method, Session, State
from spincheck.scenarios import EFFECTS, Scenario

Vector = np.ndarray

METHODS = (
    Method("Euler", 1, 1, "symplectic Euler", frozenset(EFFECTS)),
    Method("Heun", 2, 2, "Heun's method", frozenset(EFFECTS)),
    Method("RK4", 4, 4, "the classical Runge-Kutta method", frozenset(EFFECTS)),
)

# Rows of the table of constants.
TENSOR, INVERSE, LEVER, GRAVITY, FALL, PUSH_BODY, PUSH_WORLD, DRAG = 0, 3, 6, 7, 8, 9, 10, 11

NO_TORQUE = np.zeros(3)


@njit(cache=True)
def _rotation(y):
    w, x, y_, z = y[0], y[1], y[2], y[3]
    n = w * w + x * x + y_ * y_ + z * z
    return (
        np.array(
            [
                [w * w + x * x - y_ * y_ - z * z, 2 * (x * y_ - w * z), 2 * (x * z + w * y_)],
                [2 * (x * y_ + w * z), w * w - x * x + y_ * y_ - z * z, 2 * (y_ * z - w * x)],
                [2 * (x * z - w * y_), 2 * (y_ * z + w * x), w * w - x * x - y_ * y_ + z * z],
            ]
        )
        / n
    )


@njit(cache=True)
def _cross(a, b):
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@njit(cache=True)
def _rate(y, constants, push):
    """d/dt of attitude, ω, place and velocity (Goldstein §5.5), with a torque besides."""
    rate = np.empty(13)
    q, omega = y[:4], y[4:7]
    L = constants[TENSOR : TENSOR + 3] @ omega
    to_body = _rotation(y).T
    torque = (
        _cross(constants[LEVER], to_body @ constants[GRAVITY])
        + constants[PUSH_BODY]
        + to_body @ constants[PUSH_WORLD]
        - constants[DRAG, 0] * omega
        - _cross(omega, L)
        + push
    )
    rate[4:7] = constants[INVERSE : INVERSE + 3] @ torque
    rate[0] = -0.5 * (q[1] * omega[0] + q[2] * omega[1] + q[3] * omega[2])
    rate[1:4] = 0.5 * (q[0] * omega + _cross(q[1:4], omega))
    rate[7:10], rate[10:13] = y[10:13], constants[FALL]
    return rate


@njit(cache=True)
def _take_steps(y, steps, h, order, constants, push):
    for _ in range(steps):
        first = _rate(y, constants, push)
        if order == 1:
            y[4:7] += h * first[4:7]
            y[10:13] += h * first[10:13]
            second = _rate(y, constants, push)
            y[:4] += h * second[:4]
            y[7:10] += h * second[7:10]
        elif order == 2:
            y += h / 2 * (first + _rate(y + h * first, constants, push))
        else:
            second = _rate(y + h / 2 * first, constants, push)
            third = _rate(y + h / 2 * second, constants, push)
            fourth = _rate(y + h * third, constants, push)
            y += h / 6 * (first + 2 * second + 2 * third + fourth)
        y[:4] /= np.sqrt((y[:4] ** 2).sum())


class Stepped(QuietSession):
    """A scene, stepped honestly; `size` is that of the fault of a subclass.

    Attributes
    ----------
    y : attitude wxyz, ω in body axes, place and velocity of the com, (13,)
    taken : steps since it was opened or restarted
    """

    def __init__(self, scenario: Scenario, order: int, timestep: float, size: float) -> None:
        self.scenario, self.order, self.timestep, self.size = scenario, order, timestep, size
        self.inertia = np.array(scenario.inertia)
        self.rate = max(
            float(np.linalg.norm(scenario.start.omega_body)), 1 / scenario.window.duration
        )
        #: N m, which turns the body by a radian's worth of its spin in a radian.
        self.unit_torque = float(np.trace(self.inertia)) / 3 * self.rate**2
        self.constants = self.constants_with(self.inertia)
        start = scenario.start
        self.set(
            State(
                start.q_world_body_wxyz,
                start.omega_body,
                start.position_world,
                start.velocity_world,
            )
        )

    def constants_with(self, inertia: Vector) -> Vector:
        """The table of constants of `_rate`."""
        scenario, free = self.scenario, not self.scenario.constraint.is_pivot
        g, lever = scenario.gravity_world, scenario.body.mass * scenario.body.com
        drag = np.full(3, scenario.pushed["drag"])
        zero = np.zeros(3)
        rows = [zero if free else lever, g, g if free else zero]
        rows += [scenario.pushed["torque_body"], scenario.pushed["torque_world"], drag]
        return np.vstack([inertia, np.linalg.inv(inertia), *rows])

    def set(self, state: State) -> None:
        self.y = np.concatenate([np.array(column, float) for column in vars(state).values()])
        self.taken = 0

    @property
    def can_restart(self) -> bool:
        return True

    def restart(self, state: State, timestep: float | None = None) -> None:
        self.timestep = timestep or self.timestep
        self.set(state)

    @property
    def time(self) -> float:
        return self.taken * self.timestep

    @property
    def omega(self) -> Vector:
        return self.y[4:7]

    def read_body(self) -> BodyReading:
        body = self.scenario.body
        return BodyReading(body.mass, np.array(body.com), np.array(body.inertia_com))

    def read_state(self) -> State:
        y = self.y.copy()
        if self.scenario.constraint.is_pivot:
            R_world_body, com = _rotation(y), np.array(self.scenario.body.com)
            y[7:10], y[10:13] = R_world_body @ com, R_world_body @ _cross(y[4:7], com)
        state = State(y[:4], y[4:7], y[7:10], y[10:13])
        return self.reading(state) if self.taken else state

    def active(self) -> frozenset[str]:
        return self.scenario.called_for

    def advance(self, steps: int) -> None:
        kind = type(self)
        if kind.torque is Stepped.torque and kind.after_step is Stepped.after_step:
            # In a compiled loop.
            self.take(steps)
            return
        for _ in range(steps):
            push = self.torque()
            self.take(1, NO_TORQUE if push is None else push)
            self.after_step()

    def take(self, steps: int, push: Vector = NO_TORQUE) -> None:
        """Take honest steps, with a torque in body axes besides, N m."""
        _take_steps(self.y, steps, self.timestep, self.order, self.constants, push)
        self.taken += steps

    def turn(self, turn_body: Vector) -> None:
        """Turn the body by a little, rad."""
        w, v, half = self.y[0], self.y[1:4].copy(), turn_body / 2
        self.y[0] -= v @ half
        self.y[1:4] += w * half + _cross(v, half)
        self.y[:4] /= np.linalg.norm(self.y[:4])

    # What a subclass may plant.

    def torque(self) -> Vector | None:
        """A torque that acts during the next step, N m in body axes."""
        return None

    def after_step(self) -> None:
        """Change the state after a step."""

    def reading(self, state: State) -> State:
        """Read another state than the body is in."""
        return state


class SteppedEngine(Engine):
    """The engine of a kind of session, with a fault of a size."""

    interface = 1
    version = "1"
    methods = METHODS

    def __init__(self, kind: type[Stepped] = Stepped, size: float = 0.0, **as_if: object) -> None:
        self.kind, self.size = kind, size
        # What is known of an engine's first steps is known by its name.
        self.name = f"{kind.__name__} of {size:g}"
        vars(self).update(as_if)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        return self.kind(scenario, method.order, timestep, self.size)


def with_omega(state: State, omega: Vector) -> State:
    """A state that spins otherwise."""
    return replace(state, omega_body=omega)
