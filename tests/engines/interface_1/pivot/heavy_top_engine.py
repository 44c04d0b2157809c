"""A body on a pivot, with gravity and drag, by Heun's method: an engine in a package of its own."""

import numpy as np
from spincheck.engine import BodyReading, Engine, EngineError, Method, Session, State


def matrix(q):
    """Body to world, of w x y z."""
    w, v = q[0], q[1:]
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * skew + 2 * skew @ skew


class HeavyTopSession(Session):
    can_restart = True

    def __init__(self, scenario, timestep):
        body, start = scenario.body, scenario.start
        self.mass, self.com = body.mass, np.array(body.com)
        arm = self.com @ self.com * np.eye(3) - np.outer(self.com, self.com)
        self.inertia = body.inertia_com + self.mass * arm  # about the pivot
        self.arm = arm
        self.gravity = np.array(scenario.gravity_world)
        self.drag = scenario.pushed["drag"]
        self.timestep = timestep
        self.restart(State(start.q_world_body_wxyz, start.omega_body, np.zeros(3), np.zeros(3)))

    def restart(self, state, timestep=None):
        self.q, self.omega = np.array(state.q_world_body_wxyz), np.array(state.omega_body)
        self.timestep = timestep or self.timestep

    def rates(self, q, omega):
        w, v = q[0], q[1:]
        turning = np.concatenate([[-v @ omega], w * omega + np.cross(v, omega)]) / 2
        weight = np.cross(self.com, self.mass * matrix(q).T @ self.gravity)
        torque = weight - self.drag * omega - np.cross(omega, self.inertia @ omega)
        return turning, np.linalg.solve(self.inertia, torque)

    def advance(self, steps):
        for h in [self.timestep] * steps:
            turning, speeding = self.rates(self.q, self.omega)
            last = self.rates(self.q + h * turning, self.omega + h * speeding)
            self.q = self.q + h / 2 * (turning + last[0])
            self.omega = self.omega + h / 2 * (speeding + last[1])
            self.q /= np.linalg.norm(self.q)

    def read_body(self):
        return BodyReading(self.mass, self.com, self.inertia - self.mass * self.arm)

    def read_state(self):
        R = matrix(self.q)
        velocity = R @ np.cross(self.omega, self.com)
        return State(self.q.copy(), self.omega.copy(), R @ self.com, velocity)

    def check(self):
        if not np.isfinite(self.omega).all():
            raise EngineError("the angular velocity is not finite")

    def active(self):
        acting = {"gravity": self.gravity.any(), "drag": self.drag, "pivot": True}
        return frozenset(name for name, acts in acting.items() if acts)

    def close(self):
        """There is nothing to free."""


class HeavyTop(Engine):
    interface = 1
    name = "heavy-top"
    version = "1.0"
    methods = (
        Method(
            "Heun",
            order=2,
            attitude_order=2,
            summary="Heun's method, about the pivot",
            effects=frozenset({"gravity", "pivot", "drag"}),
            requires=frozenset({"pivot"}),
        ),
    )

    def open(self, scenario, method, timestep):
        return HeavyTopSession(scenario, timestep)
