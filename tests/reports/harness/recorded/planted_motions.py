"""Motions of bodies of many shapes, computed with faults that are planted, or by honest methods.

They are computed here, by scipy and plain steps, with nothing of what explains them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from spincheck.scenarios import Scenario, from_tables

Rates = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class Case:
    """A scene, and the numbers that a fault is made of.

    Attributes
    ----------
    inertia : about the com, or the pivot, kg m², (3, 3)
    """

    scenario: Scenario
    inertia: np.ndarray
    com: np.ndarray
    gravity: np.ndarray

    def torque(self, R: np.ndarray) -> np.ndarray:
        """Gravity's about a pivot, body axes, N m."""
        mass = self.scenario.body.mass
        return cross(self.com, mass * (R.T @ self.gravity)) if self.gravity.any() else np.zeros(3)


def case(seed: int, is_pivoted: bool = False, duration: float = 4.0, samples: int = 201) -> Case:
    """A body of any shape in skew axes, turning at some rad/s."""
    chance = np.random.default_rng(seed)
    sides = chance.uniform(0.3, 1.5, 3) ** 2
    moments = sides.sum() - sides
    axes = Rotation.random(random_state=seed).as_matrix()
    tensor = (axes * moments) @ axes.T
    tensor = (tensor + tensor.T) / 2
    com = chance.uniform(0.1, 0.4, 3) * chance.choice([-1, 1], 3)
    omega = chance.normal(size=3)
    omega *= chance.uniform(1.5, 4.0) / np.linalg.norm(omega)
    q = Rotation.random(random_state=seed + 1).as_quat(scalar_first=True)
    tables = {
        "title": "Planted",
        "source": "made up",
        "body": {"mass": 1.5, "inertia": tensor.tolist(), "com": com.tolist()},
        "start": {"quaternion_wxyz": q.tolist(), "omega_body": omega.tolist()},
        "window": {"duration": duration, "samples": samples},
    }
    gravity = np.zeros(3)
    if is_pivoted:
        gravity = np.array([0.0, 0.0, -9.81])
        tables["effects"] = {"gravity": {"acceleration": gravity.tolist()}, "pivot": {}}
        tensor = tensor + 1.5 * (com @ com * np.eye(3) - np.outer(com, com))
    return Case(from_tables(tables, "planted"), tensor, com, gravity)


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Of two vectors, (3,): in a tenth of the time that numpy takes for so few numbers."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Of two quaternions, scalar first."""
    (a, u), (b, v) = (p[0], p[1:]), (q[0], q[1:])
    return np.array([a * b - u @ v, *(a * v + b * u + cross(u, v))])


def rates_of(one: Case, **other: object) -> Rates:
    """The rates of q and ω, with what is named changed.

    Parameters
    ----------
    other : `inertia`, `gyroscopic` (3, 3), `turning` of (q, ω), `torque` of ω, `scale` of gravity
    """
    inertia = np.asarray(other.get("inertia", one.inertia))
    G = np.asarray(other.get("gyroscopic", inertia))
    inverse = np.asarray(other.get("inverse", np.linalg.inv(inertia)))
    turning = other.get("turning", lambda q, omega: product(q, np.array([0, *omega])) / 2)
    more = other.get("torque", lambda omega: 0.0)
    scale = other.get("scale", 1.0)

    def rates(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        torque = scale * one.torque(R) - cross(omega, G @ omega) + more(omega)
        return turning(q, omega), inverse @ torque

    return rates


def exactly(one: Case, rates: Rates) -> dict[str, np.ndarray]:
    """The arrays of a recording, to rounding."""
    start, times = one.scenario.start, one.scenario.times
    y = np.concatenate([start.q_world_body_wxyz, start.omega_body])
    found = solve_ivp(
        lambda _, y: np.concatenate(rates(y[:4], y[4:])),
        (0, times[-1]),
        y,
        "DOP853",
        times,
        rtol=1e-13,
        atol=1e-13,
    ).y.T
    q = found[:, :4] / np.linalg.norm(found[:, :4], axis=1)[:, None]
    return {"t": times.copy(), "q": q, "omega": found[:, 4:]}


def stepped(
    scene: Scenario, rates: Rates, order: int, timestep: float, chance: np.random.Generator
) -> dict[str, np.ndarray]:
    """The same by an explicit Runge–Kutta method of order 1 to 4, drawn at random where it may be.

    Of order 1 a step is Euler's with each rate taken a random part of a step later, of order 2
    one of Ralston's family, of order 3 Kutta's, of order 4 his 3/8 rule (J. C. Butcher, Numerical
    Methods for Ordinary Differential Equations, §23): none of them is known by name.
    """
    c, d = chance.uniform(0.1, 0.9), chance.uniform(0.55, 0.95)
    a, b = {
        1: ([[0, 0], [c, 0]], [0, 1]) if abs(c - 0.5) > 0.1 else ([[0, 0], [1, 0]], [0.2, 0.8]),
        2: ([[0, 0], [d, 0]], [1 - 1 / (2 * d), 1 / (2 * d)]),
        3: ([[0, 0, 0], [0.5, 0, 0], [-1, 2, 0]], [1 / 6, 2 / 3, 1 / 6]),
        4: (
            [[0, 0, 0, 0], [1 / 3, 0, 0, 0], [-1 / 3, 1, 0, 0], [1, -1, 1, 0]],
            [1 / 8, 3 / 8, 3 / 8, 1 / 8],
        ),
    }[order]
    y = np.concatenate([scene.start.q_world_body_wxyz, scene.start.omega_body])
    times, states = scene.times, [y]
    every = round(times[1] / timestep)
    for _ in times[1:]:
        for _ in range(every):
            k: list[np.ndarray] = []
            for row in a:
                at = y + timestep * sum((w * s for w, s in zip(row, k, strict=False)), np.zeros(7))
                k.append(np.concatenate(rates(at[:4], at[4:])))
            y = y + timestep * sum(w * s for w, s in zip(b, k, strict=True))
            y[:4] /= np.linalg.norm(y[:4])
        states.append(y)
    table = np.array(states)
    return {"t": times.copy(), "q": table[:, :4], "omega": table[:, 4:]}
