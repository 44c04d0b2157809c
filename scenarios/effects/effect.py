"""The class of effects, and the part of a scene that effects' functions may use."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, TypeVar

from mpmath import mp, mpf

from ..body import Body
from ..constraint import Constraint
from ..float_array import FloatArray
from ..gyrostat import Rotors
from ..start import Start, StartTable
from ..trajectory import Trajectory
from ..values import Table

T = TypeVar("T", bound="EffectTable")

#: Name of the group of scenes with a torque that a machine or the air exerts.
DRIVEN = "Driven or damped"
#: A quantity of a scene: path of keys to it in the scene file, name, size and unit.
Size = tuple[tuple[str | int, ...], str, mpf, str]
#: A rate of a scene: path of keys to its cause in the scene file, name, and size, 1/s.
Rate = tuple[tuple[str | int, ...], str, mpf]


class Unit(NamedTuple):
    """The unit of a key's number or vector, kg^mass m^length s^time, and how the key transforms.

    Attributes
    ----------
    kind : scalar, vector v, or axial vector; a mirror image M takes a vector v to M v, and an axial
        one to −M v
    axes : the axes along which a vector's components are given
    """

    mass: int = 0
    length: int = 0
    time: int = 0
    kind: Literal["scalar", "vector", "axial"] = "scalar"
    axes: Literal["world", "body"] = "world"


class EffectTable(Table):
    """Base of the tables in `[effects]`, and of those that add parts to the body.

    Attributes
    ----------
    EXAMPLE : its keys in a scene, with their units
    UNITS : the unit of each key of a table in `[effects]`, by which other descriptions of a scene
        convert it
    """

    EXAMPLE: ClassVar[str] = ""
    UNITS: ClassVar[dict[str, Unit]] = {}


class Scene(Protocol):
    """The part of a `Scenario` that effects and signals use.

    It is a protocol because `Scenario` itself imports the effects.
    """

    @property
    def body(self) -> Body:
        """The body, with its rotors counted as fixed parts of it."""

    @property
    def start(self) -> Start:
        """The state at t = 0."""

    @property
    def rotors(self) -> Rotors:
        """All rotors of the scene's body, the parts that turn in it; often none."""

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return each rotor's constant angular momentum about its axle, kg m²/s, (n, rotors).

        It is C (u·ω + s) on a free hinge and C s on any other, with u the unit vector of the axle
        and C the rotor's moment about it.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        spins : spins s of the rotors in these states, rad/s, (n, rotors)
        """

    @property
    def kept_at_start(self) -> FloatArray:
        """The constant angular momenta of the rotors about their axles, kg m²/s, (rotors,)."""

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """Return the vector sum of the rotors' angular momenta, kg m²/s, body axes, (n, 3) or (3,).

        Parameters
        ----------
        kept : constant angular momentum of each rotor about its axle, kg m²/s, in n states,
            (n, rotors), or in one, (rotors,)
        """

    @property
    def constraint(self) -> Constraint:
        """The constraint that holds the body; a free body has one that holds along no axis."""

    @property
    def inertia(self) -> FloatArray:
        """Inertia tensor about the pivot, or the com if there is none, kg m², body axes, (3, 3).

        The moments of rotors on free hinges about their axles are left out.
        """

    @property
    def gravity_world(self) -> FloatArray:
        """Gravitational acceleration, m/s², world axes, (3,)."""

    @property
    def pushed(self) -> dict[str, Any]:
        """The numbers that `push.push` computes the torque of effects from, by name.

        They are `torque_body` and `torque_world`, N m, (3,), and `drag`, N m s.
        """

    @property
    def acting(self) -> "tuple[Effect, ...]":
        """The effects to simulate, in the order of `EFFECTS`."""

    def table_of(self, model: type[T]) -> T | None:
        """Return an effect's parsed table in the scene's `[effects]`; None if it is not there.

        Parameters
        ----------
        model : class of the parsed table
        """

    def __hash__(self) -> int: ...


#: A quantity of a scene's body along a motion, SI, one row for each sample.
Along = Callable[[Scene, Trajectory], FloatArray]
#: A force, N, (n,), as a function of rotation matrices (n, 3, 3), angular velocities, body axes,
#: rad/s, (n, 3), and the sum of the rotors' constant angular momenta, body axes, kg m²/s, (n, 3).
Force = Callable[[Scene, FloatArray, FloatArray, FloatArray], FloatArray]
#: Torque, N m, body axes, and acceleration of the com, m/s², world axes, including the force of a
#: constraint; as a function of ẑ and ω in body axes, and of torque and acceleration without the
#: constraint, (3,) each.
Answer = Callable[
    [Scene, FloatArray, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]
]


@dataclass(frozen=True, eq=False)
class Extent:
    """A scene over a time span, for checks of its sizes and rates; SI, in extended precision.

    Attributes
    ----------
    scenario : the scene
    span : length of the time span, s
    moments : principal moments of `Scene.inertia`, ascending, kg m²
    decay : rate at which effects slow the body, 1/s
    """

    scenario: Scene
    span: mpf
    moments: tuple[mpf, mpf, mpf]
    decay: mpf

    @cached_property
    def arm(self) -> mpf:
        """Distance of the com from the body's origin, m."""
        return length(self.scenario.body.com_exact)

    @cached_property
    def speed(self) -> mpf:
        """Greatest speed that a free body's com can reach, m/s."""
        start, pull = self.scenario.start, length(self.scenario.gravity_world)
        return length(start.velocity_world) + pull * self.span

    @cached_property
    def distance(self) -> mpf:
        """Greatest distance that the com can have from the world's origin, m."""
        if self.scenario.constraint.is_pivot:
            return self.arm
        start, pull = self.scenario.start, length(self.scenario.gravity_world)
        flown = length(start.velocity_world) * self.span + pull * self.span**2 / 2
        return length(start.position_world) + flown


def _nothing(extent: Extent) -> Iterator[Any]:  # noqa: ARG001
    yield from ()


def _goes_with_all(scenario: Scene, stated: StartTable) -> None:
    pass


def _no_rate(scenario: Scene) -> float:  # noqa: ARG001
    return 0.0


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect: all that distinguishes it from other effects.

    Most attributes are functions, which are called only for scenes that have the effect, except
    `pushed`. "Table" is here the effect's TOML table in a scene file, and n the number of samples
    of a motion, or of states.

    Attributes
    ----------
    name : name of the effect in engines' lists and in results
    table, model : name and class of the effect's table in `[effects]`
    key : the key that the table must have for this effect; empty if it need not have any
    is_part : whether the effect adds rotors to the body, in an array of tables beside `[effects]`
    constraint : returns how the effect holds the body, given its table and the body; None if it
        does not hold the body
    pushed : returns the parameter, SI, of the effect's torque in `push`, given the effect's table,
        or None in its place if the scene has no such table; `pushed` itself is None if `push` does
        not include the effect
    check : raises `Misfit` if the scene's start, or another effect, does not go with the table
    sizes, rates : yield the quantities and the rates that the effect adds to a scene, each with the
        keys to it in the file; `check_scales` refuses a scene in which one is too large
    rate : returns the fastest rate at which the effect changes a state, 1/s; `rate_formula` is its
        formula in words
    decay : returns the fastest rate at which the effect slows the body, 1/s
    potential : returns the potential energy, J, (n,); None if the effect has none
    momentum_body, kinetic : return what rotors add to L, kg m²/s, (n, 3), and to T, J, (n,)
    work : returns an energy of rotors, J, (n,). Its change along a motion is the work that their
        drives do, and the change of E that follows; None for an effect without drives
    wrong_momentum : words for an engine that counts the rotors' angular momentum wrongly, with {}
        where the factor stands
    force : returns the upward force of a constraint that cannot pull, N, (n,)
    answer : returns torque and acceleration that include the force of such a constraint
    place_formula : formula of the place that a constraint holds constant
    group : heading of scenes with the effect in lists of scenes; the last effect of a scene decides
    """

    name: str
    table: str
    model: type[EffectTable]
    key: str = ""
    is_part: bool = False
    constraint: Callable[[Any, Body], Constraint] | None = None
    pushed: Callable[[Any], float | FloatArray] | None = None
    check: Callable[[Scene, StartTable], None] = _goes_with_all
    sizes: Callable[[Extent], Iterator[Size]] = _nothing
    rates: Callable[[Extent], Iterator[Rate]] = _nothing
    rate: Callable[[Scene], float] = _no_rate
    rate_formula: str = ""
    decay: Callable[[Scene], float] = _no_rate
    potential: Along | None = None
    momentum_body: Along | None = None
    kinetic: Along | None = None
    work: Along | None = None
    wrong_momentum: str = ""
    force: Force | None = None
    answer: Answer | None = None
    place_formula: str = ""
    group: str = ""

    def force_along(self, scenario: Scene, motion: Trajectory) -> FloatArray:
        """Return a constraint's upward force at a motion's n samples, N, (n,).

        The effect's `force` must not be None.
        """
        assert self.force is not None
        kept_body = scenario.kept_body(scenario.kept(motion.omega_body, motion.spins))
        R_world_body = motion.R_world_body.as_matrix()
        return self.force(scenario, R_world_body, motion.omega_body, kept_body)

    @property
    def is_force(self) -> bool:
        """Whether the effect is a force that accelerates a free body's com, as gravity is.

        These are all effects that are neither torques, nor constraints, nor rotors.
        """
        return not (self.pushed or self.constraint or self.is_part)

    @property
    def heading(self) -> str:
        """The heading of the effect's table in a scene file: "[effects.drag]" or "[[rotors]]"."""
        return f"[[{self.table}]]" if self.is_part else f"[effects.{self.table}]"

    def table_in(self, document: Any) -> Any:
        """Return the effect's table in a scene's parsed document, or the tables of all rotors.

        It is None if the document has none.
        """
        return getattr(document if self.is_part else document.effects, self.table, None)

    def is_called_for(self, document: Any) -> bool:
        """Whether a scene's parsed document calls for the effect."""
        table = self.table_in(document)
        if self.is_part:
            return bool(table)
        return table is not None and (not self.key or getattr(table, self.key) is not None)


def length(vector: Iterable[Any]) -> mpf:
    """Return the Euclidean length of a vector, in the caller's precision of mpmath."""
    return mp.sqrt(mp.fsum(mpf(component) ** 2 for component in vector))
