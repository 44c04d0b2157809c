"""The signals that motions are judged by, each with its error's norm, as data.

Everything that computes, bounds, stores or shows errors iterates over `SIGNALS`. To add a signal,
add an entry at its end, and a field at the end of `Errors`. The default of the field must be None,
because results stored earlier lack the signal.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import MISSING, dataclass, fields
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from .effects.effect import Scene
from .float_array import FloatArray
from .mechanics import angular_momentum_world, energy, energy_base
from .rotation import norms
from .trajectory import Trajectory

#: A number that is neither negative nor NaN; checked where it is read from a file.
Distance = Annotated[float, Field(ge=0)]


@dataclass(frozen=True)
class Errors:
    """One number for each signal: the largest distance over a motion's samples, or a bound on it.

    Iteration yields pairs of name and number for the signals that the scene has, in the order of
    `SIGNALS`. Of any other signal ``errors[name]`` is NaN.
    """

    omega: Distance
    attitude: Distance
    angular_momentum: Distance
    energy: Distance
    com: Distance
    velocity: Distance
    spins: Distance | None = None

    def __iter__(self) -> Iterator[tuple[str, float]]:
        return ((name, self[name]) for name in SIGNAL if getattr(self, name) is not None)

    def __getitem__(self, name: str) -> float:
        value = getattr(self, name)
        return math.nan if value is None else float(value)


@dataclass(frozen=True)
class Signal:
    """A signal, and the norm of errors in it.

    Attributes
    ----------
    name : how files, options and results refer to it
    label : its name in columns of reports
    quantity : its name in sentences
    formula : formula of the error
    unit : unit of the error; empty where the error is relative
    kind : how the distance of two values is defined: for vectors and scalars as the norm of their
        difference, for quaternions as the angle of the rotation from one to the other
    values : returns the values at a motion's n samples, SI, (n, columns), or (n,) for a scalar
    base : returns the number that distances are relative to, in the signal's unit
    depends_on : those of the signals "omega" and "attitude" whose orders of accuracy limit this
        signal's order
    exists : returns whether a scene has the signal
    """

    name: str
    label: str
    quantity: str
    formula: str
    kind: Literal["vector", "quaternion", "scalar"]
    values: Callable[[Scene, Trajectory], FloatArray]
    base: Callable[[Scene, Trajectory], float]
    unit: str = ""
    depends_on: tuple[str, ...] = ("omega", "attitude")
    exists: Callable[[Scene], bool] = lambda _: True

    @property
    def key(self) -> str:
        """The name of the signal's error in JSON and CSV."""
        return f"{self.name}_error"

    def __str__(self) -> str:
        """Label and unit: `ω, relative`."""
        return f"{self.label}, {self.unit or 'relative'}"

    @property
    def shown(self) -> float:
        """The factor by which errors are multiplied for display: 180/π if in rad, else 1."""
        return math.degrees(1.0) if self.unit == "rad" else 1.0

    @property
    def shown_unit(self) -> str:
        """The unit of the signal's errors as people read them: "°", or "relative"."""
        return "°" if self.unit == "rad" else "relative"

    def words(self, error: float) -> str:
        """Return an error as text for people, in degrees if it is an angle in rad."""
        return f"{error * self.shown:.2g}°" if self.unit == "rad" else f"{error:.1e}"

    @property
    def error_title(self) -> str:
        """The heading of the signal's errors in reports: `ω error, relative`."""
        return f"{self.label} error, {self.shown_unit}"

    def declared_order(self, order: int, attitude_order: int) -> int:
        """Return the signal's order of accuracy, given a method's orders in ω and attitude."""
        orders = {"omega": order, "attitude": attitude_order}
        return min(orders[name] for name in self.depends_on)


def radius_of_gyration(scene: Scene) -> float:
    """Return the radius of gyration √(tr I / 2m), m, with I the tensor `Scenario.inertia`."""
    return float(np.sqrt(np.trace(scene.inertia) / (2 * scene.body.mass)))


def _way(scene: Scene, exact: Trajectory) -> float:
    """Return the com's largest distance from its start or, if larger, the radius of gyration, m.

    The distance is that in the exact motion, `exact`.
    """
    return max(_longest(exact.com_world - exact.com_world[0]), radius_of_gyration(scene))


def _speed(scene: Scene, exact: Trajectory) -> float:
    """Return the com's largest speed or, if larger, largest |ω| times radius of gyration, m/s.

    Both are those of the exact motion, `exact`.
    """
    turning = radius_of_gyration(scene) * _longest(exact.omega_body)
    return max(_longest(exact.velocity_world), turning)


def _fastest(_: Scene, exact: Trajectory) -> float:
    """Return the larger of two maxima over the exact motion, rad/s: |ω| and the norm of spins.

    The scene, which is the first argument, is not used.
    """
    return max(_longest(exact.spins), _longest(exact.omega_body))


def _longest(vectors: FloatArray) -> float:
    """Return the largest norm of n vectors of k components, (n, k)."""
    return float(norms(vectors).max())


SIGNALS = (
    Signal(
        name="omega",
        label="ω",
        quantity="angular velocity",
        formula="max |ω_e − ω_r| / max |ω_r|, body axes",
        kind="vector",
        values=lambda _, motion: motion.omega_body,
        base=lambda _, exact: _longest(exact.omega_body),
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
        base=lambda *_: 1.0,
        depends_on=("attitude",),
    ),
    Signal(
        name="angular_momentum",
        label="L",
        quantity="angular momentum",
        formula="max |L_e − L_r| / max |L_r|, world axes",
        kind="vector",
        values=angular_momentum_world,
        base=lambda scene, exact: _longest(angular_momentum_world(scene, exact)),
    ),
    Signal(
        name="energy",
        label="energy",
        quantity="energy",
        formula="max |E_e − E_r| / (max T_r + m |g| max |r_com|)",
        kind="scalar",
        values=energy,
        base=energy_base,
    ),
    Signal(
        name="com",
        label="com",
        quantity="centre of mass",
        formula="max |r_e − r_r| / max(the longest way of r_r from its start, k), world axes",
        kind="vector",
        values=lambda _, motion: motion.com_world,
        base=_way,
    ),
    Signal(
        name="velocity",
        label="velocity",
        quantity="velocity of the centre of mass",
        formula="max |v_e − v_r| / max(max |v_r|, k max |ω_r|), world axes, of the com",
        kind="vector",
        values=lambda _, motion: motion.velocity_world,
        base=_speed,
    ),
    Signal(
        name="spins",
        label="spins",
        quantity="spins of the rotors",
        formula="max |s_e − s_r| / max(max |s_r|, max |ω_r|), relative to the body",
        kind="vector",
        values=lambda _, motion: motion.spins,
        base=_fastest,
        depends_on=("omega",),
        exists=lambda scene: bool(scene.rotors),
    ),
)


def errors_by_key(errors: Errors | None) -> dict[str, float | None]:
    """Return the error in each signal by its name in JSON and CSV.

    It is None for a signal that the scene does not have. If `errors` is None, as for a run that has
    none, it is None for every signal.
    """
    known = dict(errors or ())
    return {signal.key: known.get(signal.name) for signal in SIGNALS}


def signals_of(scene: Scene) -> tuple[Signal, ...]:
    """Return the signals that a scene has, in the order of `SIGNALS`."""
    return tuple(signal for signal in SIGNALS if signal.exists(scene))


#: The signals by their names.
SIGNAL = {signal.name: signal for signal in SIGNALS}
assert tuple(SIGNAL) == tuple(field.name for field in fields(Errors)), "one field a signal"
#: The names of the signals that every scene has, and every stored result.
EVERYWHERE = tuple(field.name for field in fields(Errors) if field.default is MISSING)

if TYPE_CHECKING:
    SignalName = str
else:
    #: The name of a signal, checked where it is read from a file.
    SignalName = Literal[tuple(SIGNAL)]
