"""A body held on its pivot by impulses, as game engines hold it: by six coordinates and a solver.

Each step puts back a fifth of the com's drift, as Bullet does.
"""

from dataclasses import replace

import numpy as np
from numba import njit
from spincheck.engines import State
from stepped import Stepped, _cross, _rotation

PUT_BACK = 0.2


@njit(cache=True)
def _take_steps(y, steps, h, mass, com, inertia, inverse, gravity):
    """Symplectic Euler of a free body, with an impulse at the pivot (Catto, GDC 2005)."""
    for _ in range(steps):
        R = _rotation(y)
        omega = y[4:7] + h * inverse @ _cross(inertia @ y[4:7], y[4:7])
        velocity = R.T @ (y[10:13] + h * gravity)
        off = R.T @ y[7:10] - com
        moves = velocity - _cross(omega, com) + PUT_BACK / h * off
        yields = np.empty((3, 3))
        for axis in range(3):
            impulse = np.zeros(3)
            impulse[axis] = 1.0
            yields[:, axis] = impulse / mass + _cross(inverse @ _cross(com, impulse), com)
        impulse = -np.linalg.solve(yields, moves)
        omega -= inverse @ _cross(com, impulse)
        y[10:13] = R @ (velocity + impulse / mass)
        y[7:10] += h * y[10:13]
        y[4:7] = omega
        w, v = y[0], y[1:4].copy()
        y[0] -= h / 2 * v @ omega
        y[1:4] += h / 2 * (w * omega + _cross(v, omega))
        y[:4] /= np.sqrt((y[:4] ** 2).sum())


class HeldByImpulses(Stepped):
    """Honest, of first order."""

    def take(self, steps, *push):
        body = self.scenario.body
        inertia = np.array(body.inertia_com)
        rows = body.mass, np.array(body.com), inertia, np.linalg.inv(inertia)
        _take_steps(self.y, steps, self.timestep, *rows, np.array(self.scenario.gravity_world))
        self.taken += steps

    def read_state(self):
        state = State(*map(np.copy, (self.y[:4], self.y[4:7], self.y[7:10], self.y[10:13])))
        return self.reading(state) if self.taken else state


class ReadsOmegaOffWhereHeld(HeldByImpulses):
    """What is read of ω is off by its size."""

    def reading(self, state):
        return replace(state, omega_body=(1 + self.size) * state.omega_body)


class HeldAtRandom(HeldByImpulses):
    """Each step ends with a random torque, relative to ω²: what a poor solver leaves."""

    def take(self, steps, *push):
        chance = np.random.default_rng([*self.y.tobytes()])
        for _ in range(steps):
            super().take(1)
            speed = float(np.linalg.norm(self.y[4:7]))
            self.y[4:7] += self.size * self.timestep * speed**2 * chance.standard_normal(3)
