"""The signals that motions are judged by, each with its error's norm, as data.

Everything that computes, bounds, stores or shows errors iterates over `SIGNALS`: another signal is
an entry there and a field of `Errors`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from .float_array import FloatArray
from .mechanics import angular_momentum_world, energy, energy_base
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .scenario import Scenario

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Errors:
    """One number a signal: the largest distance over the samples of a motion, or a bound on it.

    Iterates over pairs of name and number, in the order of `SIGNALS`.
    """

    omega: float
    attitude: float
    angular_momentum: float
    energy: float
    com: float
    velocity: float

    def __iter__(self) -> Iterator[tuple[str, float]]:
        return ((signal.name, self[signal.name]) for signal in SIGNALS)

    def __getitem__(self, name: str) -> float:
        return float(getattr(self, name))


@dataclass(frozen=True, eq=False)
class Sizes:
    """Sizes of an exact motion, which distances from it are relative to."""

    scene: "Scenario"
    exact: Trajectory

    @cached_property
    def speed(self) -> float:
        """max |ω|, rad/s."""
        return _longest(self.exact.omega_body)

    @cached_property
    def gyration(self) -> float:
        """The radius of gyration, m, for a com that stays where it is."""
        return radius_of_gyration(self.scene)

    @property
    def angular_momentum(self) -> float:
        """max |L|, kg m²/s."""
        return _longest(angular_momentum_world(self.scene, self.exact))

    @property
    def way(self) -> float:
        """The longest way of the com from its start, m, at least the radius of gyration."""
        return max(_longest(self.exact.com_world - self.exact.com_world[0]), self.gyration)

    @property
    def com_speed(self) -> float:
        """max |v|, m/s, at least max |ω| times the radius of gyration."""
        return max(_longest(self.exact.velocity_world), self.gyration * self.speed)


@dataclass(frozen=True, eq=False)
class Flight:
    """What one ulp in each number of a free body's state, and in its arm, does by the end.

    Engines may integrate the flight for an origin other than the com.

    Attributes
    ----------
    conditioning : what it does to the rotation
    """

    scene: "Scenario"
    exact: Trajectory
    conditioning: Errors

    @cached_property
    def fast(self) -> float:
        """max |v|, m/s."""
        return _largest_norm(self.exact.velocity_world)

    @cached_property
    def speed(self) -> float:
        """max |ω|, rad/s."""
        return _largest_norm(self.exact.omega_body)

    @cached_property
    def metres(self) -> float:
        """Change of the com's place, m."""
        arm, exact = float(np.linalg.norm(self.scene.body.com)), self.exact
        lengths = _largest_norm(exact.com_world) + arm + self.fast * float(exact.t[-1])
        return EPS * lengths + self.conditioning.attitude * arm

    @cached_property
    def metres_a_second(self) -> float:
        """Change of the com's velocity, m/s."""
        arm, growth = float(np.linalg.norm(self.scene.body.com)), self.conditioning
        return EPS * self.fast + (growth.attitude + growth.omega) * arm * self.speed

    @property
    def energy(self) -> float:
        """Change of the energy, relative."""
        mass, g = self.scene.body.mass, float(np.linalg.norm(self.scene.gravity_world))
        joules = mass * self.fast * self.metres_a_second + mass * g * self.metres
        relative = _relative(joules, energy_base(self.scene, self.exact))
        return max(self.conditioning.energy, relative)

    @property
    def com(self) -> float:
        """Change of the com's place, relative."""
        way = _largest_norm(self.exact.com_world - self.exact.com_world[0])
        return _relative(self.metres, max(way, radius_of_gyration(self.scene)))

    @property
    def velocity(self) -> float:
        """Change of the com's velocity, relative."""
        base = max(self.fast, radius_of_gyration(self.scene) * self.speed)
        return max(EPS, _relative(self.metres_a_second, base))


@dataclass(frozen=True)
class Signal:
    """A signal, and the norm of errors in it.

    Attributes
    ----------
    name : how files, options and results refer to it
    label, quantity : how tables and texts do
    formula : of the error
    unit : of the error; empty where it is relative
    kind : which distance two values have: the norm of their difference, of a scalar its size, of
        quaternions the angle of the turn from one to the other
    values : along a motion, SI, (n, columns), of a scalar (n,)
    base : what distances are relative to, in the signal's unit
    depends_on : of rotation, "omega" and "attitude": whose orders of accuracy bound its own
    in_flight : growth of one ulp where a body is free, if not what its rotation's is, relative
    """

    name: str
    label: str
    quantity: str
    formula: str
    kind: Literal["vector", "quaternion", "scalar"]
    values: Callable[["Scenario", Trajectory], FloatArray]
    base: Callable[[Sizes], float]
    unit: str = ""
    depends_on: tuple[str, ...] = ("omega", "attitude")
    in_flight: Callable[[Flight], float] | None = None

    @property
    def columns(self) -> int:
        """Numbers a sample."""
        return {"vector": 3, "quaternion": 4, "scalar": 1}[self.kind]

    @property
    def key(self) -> str:
        """The name of its error in JSON and CSV."""
        return f"{self.name}_error"

    def __str__(self) -> str:
        """Label and unit: `ω, relative`."""
        return f"{self.label}, {self.unit or 'relative'}"

    @property
    def error_title(self) -> str:
        """The same of its error: `ω error, relative`."""
        return f"{self.label} error, {self.unit or 'relative'}"

    def declared_order(self, order: int, attitude_order: int) -> int:
        """The order of accuracy of a method that declares those of ω and of the attitude."""
        orders = {"omega": order, "attitude": attitude_order}
        return min(orders[name] for name in self.depends_on)

    def growth(self, flight: Flight) -> float:
        """What one ulp in each number of a free body's state changes it by, relative."""
        return self.in_flight(flight) if self.in_flight else flight.conditioning[self.name]


def radius_of_gyration(scene: "Scenario") -> float:
    """√(tr I / 2m), m; I about the pivot, or the com where there is none."""
    body = scene.body
    inertia = body.inertia_origin if scene.has_pivot else body.inertia_com
    return float(np.sqrt(np.trace(inertia) / (2 * body.mass)))


def _longest(vectors: FloatArray) -> float:
    return float(np.sqrt(np.einsum("ni,ni->n", vectors, vectors).max()))


def _largest_norm(vectors: FloatArray) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


def _relative(change: float, base: float) -> float:
    return change / base if base else EPS


SIGNALS = (
    Signal(
        name="omega",
        label="ω",
        quantity="angular velocity",
        formula="max |ω_e − ω_r| / max |ω_r|, body axes",
        kind="vector",
        values=lambda _, motion: motion.omega_body,
        base=lambda sizes: sizes.speed,
        depends_on=("omega",),
    ),
    Signal(
        name="attitude",
        label="attitude",
        quantity="attitude",
        formula="max angle of R_eᵀ R_r, rad",
        unit="rad",
        kind="quaternion",
        values=lambda _, motion: motion.q_world_body_wxyz,
        base=lambda _: 1.0,
        depends_on=("attitude",),
    ),
    Signal(
        name="angular_momentum",
        label="L",
        quantity="angular momentum",
        formula="max |L_e − L_r| / max |L_r|, world axes",
        kind="vector",
        values=angular_momentum_world,
        base=lambda sizes: sizes.angular_momentum,
    ),
    Signal(
        name="energy",
        label="energy",
        quantity="energy",
        formula="max |E_e − E_r| / (max T_r + m |g| max |r_com|)",
        kind="scalar",
        values=energy,
        base=lambda sizes: energy_base(sizes.scene, sizes.exact),
        in_flight=lambda flight: flight.energy,
    ),
    Signal(
        name="com",
        label="com",
        quantity="centre of mass",
        formula="max |r_e − r_r| / max(the longest way of r_r from its start, k), world axes",
        kind="vector",
        values=lambda _, motion: motion.com_world,
        base=lambda sizes: sizes.way,
        in_flight=lambda flight: flight.com,
    ),
    Signal(
        name="velocity",
        label="velocity",
        quantity="velocity of the centre of mass",
        formula="max |v_e − v_r| / max(max |v_r|, k max |ω_r|), world axes, of the com",
        kind="vector",
        values=lambda _, motion: motion.velocity_world,
        base=lambda sizes: sizes.com_speed,
        in_flight=lambda flight: flight.velocity,
    ),
)


def errors_by_key(errors: Errors | None) -> dict[str, float | None]:
    """The errors with their names in JSON and CSV; all None where a run has none."""
    return {signal.key: errors[signal.name] if errors else None for signal in SIGNALS}


#: The signals by their names.
SIGNAL = {signal.name: signal for signal in SIGNALS}
assert tuple(SIGNAL) == tuple(field.name for field in fields(Errors)), "one field a signal"

if TYPE_CHECKING:
    SignalName = str
else:
    #: The name of a signal, checked where it is read from a file.
    SignalName = Literal[tuple(SIGNAL)]
