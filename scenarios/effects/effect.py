"""What the rest of the program has to know of an effect, and an effect of its scene."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol, TypeVar

from mpmath import mp, mpf

from ..body import Body
from ..constraint import Constraint
from ..float_array import FloatArray
from ..gyrostat import Rotors
from ..start import Start, StartTable
from ..trajectory import Trajectory
from ..values import Table

T = TypeVar("T", bound="EffectTable")

#: The group of scenes with a torque that a machine, or the air, exerts.
DRIVEN = "Driven or damped"
#: Where a quantity is written in a file, what it is, its size and its unit.
Size = tuple[tuple[str | int, ...], str, mpf, str]
#: Where a rate is written, what it is, and 1/s.
Rate = tuple[tuple[str | int, ...], str, mpf]


class EffectTable(Table):
    """Base of the tables in `[effects]`, and of those that add parts to the body.

    Attributes
    ----------
    EXAMPLE : its keys in a scene, with their units
    """

    EXAMPLE: ClassVar[str] = ""


class Scene(Protocol):
    """What effects and signals see of a `Scenario`, which is made of their tables."""

    @property
    def body(self) -> Body:
        """The body, with its rotors as if they did not turn in it."""

    @property
    def start(self) -> Start:
        """The state at t = 0."""

    @property
    def rotors(self) -> Rotors:
        """The parts of the body that turn in it."""

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """The angular momentum that each part keeps as it turns, kg m²/s, (n, parts)."""

    @property
    def kept_at_start(self) -> FloatArray:
        """What each part keeps at t = 0, kg m²/s, (parts,)."""

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """The sum of what parts keep, body axes, (n, 3)."""

    @property
    def constraint(self) -> Constraint:
        """What holds the body."""

    @property
    def inertia(self) -> FloatArray:
        """About the pivot, or the com where there is none, kg m², (3, 3)."""

    @property
    def gravity_world(self) -> FloatArray:
        """Gravitational acceleration, m/s², (3,)."""

    @property
    def pushed(self) -> dict[str, Any]:
        """The numbers that `push` takes."""

    @property
    def acting(self) -> "tuple[Effect, ...]":
        """The effects to simulate."""

    def table_of(self, model: type[T]) -> T | None:
        """The table of an effect, None where the scene has none."""

    def __hash__(self) -> int: ...


#: Something of a scene's body along a motion, SI, one row a sample.
Along = Callable[[Scene, Trajectory], FloatArray]
#: A force, N, (n,), at rotation matrices (n, 3, 3), angular velocities, body axes, rad/s, (n, 3),
#: and what parts keep then, kg m²/s, (n, 3).
Force = Callable[[Scene, FloatArray, FloatArray, FloatArray], FloatArray]
#: Torque, N m, body axes, and acceleration of the com, m/s², world axes, with what a constraint
#: does about them: given ẑ and ω in body axes, and both without it, (3,) each.
Answer = Callable[
    [Scene, FloatArray, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]
]


@dataclass(frozen=True, eq=False)
class Extent:
    """A scene over a time, as checks of size and of rate see it: mpmath numbers, SI.

    Attributes
    ----------
    span : s
    moments : principal, about the fixed point, ascending, kg m²
    decay : 1/s, at which effects slow the body
    """

    scenario: Scene
    span: mpf
    moments: tuple[mpf, mpf, mpf]
    decay: mpf

    @cached_property
    def arm(self) -> mpf:
        """m, from the body's origin to the com."""
        return length(self.scenario.body.com_exact)

    @cached_property
    def speed(self) -> mpf:
        """m/s, the greatest of a free body's com."""
        start, pull = self.scenario.start, length(self.scenario.gravity_world)
        return length(start.velocity_world) + pull * self.span

    @cached_property
    def distance(self) -> mpf:
        """m, the greatest of the com from the world's origin."""
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
    """An effect, by what differs from one to the next; scenes without it are not asked about it.

    Attributes
    ----------
    name : as engines claim it and results show it
    table, model : its table in `[effects]`, by name and format
    is_part : whether it adds parts to the body, in an array of tables beside `[effects]`
    key : what that table must hold; empty if it need not hold anything
    constraint : how its table holds the body, if it does: without it the scene would be another one
    pushed : of a torque that `push` includes, its number in SI; of the table, None where it is not
    check : raises `Misfit` for a scene whose start, with its table, it does not go with
    sizes, rates : its numbers that must be computable, each with where it is written
    rate : 1/s, the fastest at which it changes a state; `rate_formula` is that in words
    decay : 1/s, the fastest at which it slows the body
    potential : energy, J, (n,); None if it has none
    momentum_body, kinetic : of parts, what they add to L, kg m²/s, (n, 3), and to T, J, (n,)
    work : of parts, J, (n,): its change is the work of their drives, which E gains; None without
    wrong_momentum : of parts, the words for another angular momentum than theirs, by its factor
    force : of a constraint that cannot pull, upward, N
    answer : of such a constraint, what it does about a torque and an acceleration
    place_formula : of a constraint, of the place that it keeps
    group : of the scenes with it, where they are listed by effects; the last of a scene's counts
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
        """The force along a motion, N, (n,), of a constraint that has one."""
        assert self.force is not None
        kept_body = scenario.kept_body(scenario.kept(motion.omega_body, motion.spins))
        R_world_body = motion.R_world_body.as_matrix()
        return self.force(scenario, R_world_body, motion.omega_body, kept_body)

    @property
    def heading(self) -> str:
        """What its table begins with in a scene."""
        return f"[[{self.table}]]" if self.is_part else f"[effects.{self.table}]"

    def table_in(self, document: Any) -> Any:
        """Its table, or of parts their tables, if a scene's document has one."""
        return getattr(document if self.is_part else document.effects, self.table, None)

    def is_called_for(self, document: Any) -> bool:
        """Whether a scene's document calls for it."""
        table = self.table_in(document)
        if self.is_part:
            return bool(table)
        return table is not None and (not self.key or getattr(table, self.key) is not None)


def length(vector: Iterable[Any]) -> mpf:
    """Euclidean length, at the caller's precision."""
    return mp.sqrt(mp.fsum(mpf(component) ** 2 for component in vector))
