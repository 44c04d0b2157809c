"""A free rigid body, by the classical Runge-Kutta method: an engine in a package of its own."""

import numpy as np
from spincheck.engine import BodyReading, Engine, Method, Session, State


class ToySession(Session):
    can_restart = True

    def __init__(self, scenario, timestep):
        body, start = scenario.body, scenario.start
        self.held = BodyReading(body.mass, np.array(body.com), np.array(body.inertia_com))
        self.inverse, self.timestep = np.linalg.inv(self.held.inertia_com), timestep
        self.gravity = np.array(scenario.gravity_world)
        motion = start.position_world, start.velocity_world
        self.restart(State(start.q_world_body_wxyz, start.omega_body, *motion))

    def restart(self, state, timestep=None):
        self.y = np.concatenate(list(vars(state).values()))
        self.timestep = timestep or self.timestep

    def rates(self, y):
        w, v, omega, velocity = y[0], y[1:4], y[4:7], y[10:]
        turning = np.concatenate([[-v @ omega], w * omega + np.cross(v, omega)]) / 2
        spinning = self.inverse @ np.cross(self.held.inertia_com @ omega, omega)
        return np.concatenate([turning, spinning, velocity, self.gravity])

    def advance(self, steps):
        for h in [self.timestep] * steps:
            k1 = self.rates(self.y)
            k2 = self.rates(self.y + h / 2 * k1)
            k3 = self.rates(self.y + h / 2 * k2)
            k4 = self.rates(self.y + h * k3)
            self.y = self.y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            self.y[:4] /= np.linalg.norm(self.y[:4])

    def read_body(self):
        return self.held

    def read_state(self):
        return State(*np.split(self.y.copy(), (4, 7, 10)))

    def check(self):
        """Nothing here goes wrong by itself: what is not finite is found by whoever reads it."""

    def active(self):
        return frozenset({"gravity"} if self.gravity.any() else ())

    def close(self):
        """There is nothing to free."""


class Toy(Engine):
    interface = 1
    name = "toy"
    version = "1.0"
    methods = (Method("RK4", 4, 4, "classical Runge-Kutta, free bodies", frozenset({"gravity"})),)

    def open(self, scenario, method, timestep):
        return ToySession(scenario, timestep)
