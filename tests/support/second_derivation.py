"""Motions by a second derivation, in forty digits: that of coupled bodies.

The other way round in all: the rates of ω, of the spins and the force of a table are solved for
together, from the tensors of all parts,

    I ω' + Σ C u s' = τ − ω × (I ω + Σ C s u),    u·ω' + s' = 0 on a free hinge,  s' = 0 elsewhere,

with no momentum taken for constant and no principal axes; a rotation matrix for the quaternion; and
Gragg's rule extrapolated (Hairer, Nørsett & Wanner I, §II.9) for a series.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios import Scenario
from spincheck.scenarios.exact import rotate

DIGITS = 40
#: rad at the fastest, of a step; columns of its extrapolation, which then errs by some 1e-26.
STEP_TURN, COLUMNS = 0.5, 10

#: Of mpf.
Array = np.ndarray


class State(NamedTuple):
    """ω in body axes, (3,), the spin of each rotor, and R_world_body, (3, 3)."""

    omega: Array
    spins: Array
    R: Array


class Rotor(NamedTuple):
    """A rotor: its axis and moment about that, its spin, and whether its hinge is free."""

    axis: Array
    along: mpf
    spin: mpf
    is_free: bool


def exact(values: Sequence[object]) -> Array:
    """Numbers as an array of mpf."""
    return np.vectorize(mpf, otypes=[object])(np.array(values, dtype=object))


def rotation(q: Sequence[mpf]) -> Array:
    """R of a unit quaternion."""
    return np.array([rotate(tuple(q), axis) for axis in np.eye(3, dtype=int).tolist()]).T


@dataclass
class CoupledBodies:
    """Bodies and what acts on them, in axes of the body that need not be principal ones.

    Attributes
    ----------
    inertia : about the point that is held, else about the com
    lever : mass times the com from a pivot
    table_lever : the com from a tip on a table; None without a table
    """

    inertia: Array
    omega: Array
    R: Array
    lever: Array
    gravity_world: Array
    torque_body: Array
    torque_world: Array
    drag: mpf
    rotors: Sequence[Rotor] = ()
    mass: mpf = field(default_factory=lambda: mpf(1))
    table_lever: Array | None = None

    def __post_init__(self) -> None:
        count = len(self.rotors)
        self.axes = exact([one.axis for one in self.rotors]).reshape(count, 3)
        self.along = exact([one.along for one in self.rotors])
        # What the rates of ω and spins are multiplied by.
        matrix = mp.eye(3 + count)
        matrix[:3, :3] = mp.matrix(self.inertia.tolist())
        for k, one in enumerate(self.rotors):
            for i in range(3):
                matrix[i, 3 + k] = one.along * one.axis[i]
                matrix[3 + k, i] = one.axis[i] if one.is_free else 0
        self.solver = np.array((matrix**-1).tolist(), dtype=object)

    def rates(self, y: Array) -> Array:
        """Of ω, the spins and the rows of R."""
        count = len(self.rotors)
        omega, spins, R = y[:3], y[3 : 3 + count], y[3 + count :].reshape(3, 3)
        momentum = self.inertia @ omega + (self.along * spins) @ self.axes
        torque = self.torque_body - self.drag * omega - np.cross(omega, momentum)
        torque = torque + np.cross(self.lever, self.gravity_world @ R) + self.torque_world @ R
        gained = self.solver[:, :3] @ torque
        if self.table_lever is not None:
            # By the force N the com rises at N/m + g, as the tip does not.
            up, lever = R[2], self.table_lever
            per_newton = self.solver[:, :3] @ np.cross(up, lever)
            bend = np.cross(omega, np.cross(omega, lever))
            without = up @ (np.cross(gained[:3], lever) + bend) - self.gravity_world[2]
            force = without / (1 / self.mass - up @ np.cross(per_newton[:3], lever))
            gained = gained + force * per_newton
        return np.concatenate([gained, np.cross(R, omega).ravel()])

    def motion(self, times: Sequence[float], rate: float) -> Iterator[State]:
        """States at times after 0, of a motion whose fastest rate is that, 1/s."""
        spins = exact([one.spin for one in self.rotors])
        y, now = np.concatenate([self.omega, spins, self.R.ravel()]), mpf(0)
        for time in map(mpf, times):
            steps = max(1, round(float((time - now) * rate) / STEP_TURN))
            for _ in range(steps):
                y = extrapolated(self.rates, y, (time - now) / steps)
            now = time
            yield State(y[:3], y[3 : 3 + len(spins)], y[3 + len(spins) :].reshape(3, 3))


def extrapolated(rates: Callable[[Array], Array], y: Array, span: mpf) -> Array:
    """The state a step later: the midpoint rule with 2, 4, 6, … substeps, h² → 0."""
    first, table = rates(y), []
    for n in range(2, 2 * COLUMNS + 2, 2):
        h = span / n
        before, now = y, y + h * first
        for _ in range(n - 1):
            before, now = now, before + 2 * h * rates(now)
        row = [(before + now + h * rates(now)) / 2]
        for k, coarser in enumerate(table, start=1):
            row.append(row[-1] + (row[-1] - coarser) / ((mpf(n) / (n - 2 * k)) ** 2 - 1))
        table = row
    return table[-1]


def of_problem(p: Problem) -> CoupledBodies:
    """The body of a problem; momenta that it keeps as rotors that are driven."""
    rotors = [
        Rotor(exact(axis), kept, mpf(1), False)
        for kept, axis in zip(p.kept, p.kept_axes, strict=True)
    ]
    forces = (p.lever_axes, p.gravity_world, p.torque_axes, p.torque_world)
    inertia, R = np.diag(exact(p.moments)), rotation(p.q_world_axes)
    return CoupledBodies(inertia, exact(p.omega_axes), R, *map(exact, forces), p.drag, rotors)


def of_scene(scenario: Scenario) -> CoupledBodies:
    """The bodies of a scene, from the tables of its file."""
    tables, constraint, pushed = (
        scenario.document.rotors or (),
        scenario.constraint,
        scenario.pushed,
    )
    axes = [exact(one.axis) / mp.norm(mp.matrix(one.axis)) for one in tables]
    parts = [(scenario.carrier.mass_exact, exact(scenario.carrier.com_exact))]
    parts += [(mpf(one.mass), exact(one.position)) for one in tables]
    mass = sum(mass for mass, _ in parts)
    com = sum(mass * place for mass, place in parts) / mass
    fixed = exact((0, 0, 0)) if constraint.is_pivot else com
    unit, inertia = exact(np.eye(3)), exact(scenario.carrier.inertia_com_exact)
    for one, axis in zip(tables, axes, strict=True):
        across, along = map(mpf, one.inertia)
        inertia = inertia + across * unit + (along - across) * np.outer(axis, axis)
    for part_mass, place in parts:
        arm = place - fixed
        inertia = inertia + part_mass * (arm @ arm * unit - np.outer(arm, arm))
    return CoupledBodies(
        inertia,
        exact(scenario.start.omega_body_exact),
        rotation(scenario.start.q_exact),
        mass * (com - fixed),
        exact(scenario.gravity_world),
        exact(pushed["torque_body"]),
        exact(pushed["torque_world"]),
        mpf(pushed["drag"]),
        [
            Rotor(axis, mpf(one.inertia[1]), mpf(spin), one.hinge == "free")
            for one, axis, spin in zip(tables, axes, scenario.rotors.start_spins, strict=True)
        ],
        mass,
        exact(constraint.lever_exact) if scenario.effects.table else None,
    )
