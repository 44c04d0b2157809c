"""The answers that a child process may give, and the checks of their sizes, types and ranges.

docs/reference/engine-protocol.md describes the protocol.
"""

import json
import math
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator
from spincheck.engine import FloatArray, Method

from ...scenarios import EFFECTS
from ...scenarios.document import MAX_ROTORS
from ...scenarios.rotation import matrix
from ...scenarios.scales import LARGEST
from ..interface import misfit

#: Largest number of characters that a message quotes of an answer.
QUOTED = 80
#: Largest number of methods of an engine, and of names in its list of what acts on the body.
MOST_NAMES = 32


#: Newest and oldest version of the protocol that a child may speak.
NEWEST = OLDEST = 1


def _protocol(stated: int) -> int:
    """Return a version of the protocol unchanged; raise ValueError if it is not supported."""
    if reason := misfit("protocol", stated, OLDEST, NEWEST):
        raise ValueError(reason)
    return stated


def _printable(text: str) -> str:
    """Return a text unchanged; raise ValueError if it has characters that cannot be printed."""
    if not text.isprintable():
        raise ValueError("must be printable")
    return text


def _effect(name: str) -> str:
    """Return `name` unchanged; raise ValueError if it is not the name of an effect."""
    if name not in EFFECTS:
        raise ValueError(f"must be one of {', '.join(EFFECTS)}")
    return name


Protocol = Annotated[int, AfterValidator(_protocol)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,39}$")]
Words = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_printable)]
Effect = Annotated[str, AfterValidator(_effect)]
Effects = Annotated[list[Effect], Field(max_length=len(EFFECTS))]
Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=float(LARGEST))]
Known = Number | None
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
Order = Annotated[int, Field(ge=1, le=12)]
#: The largest `least_turn` that an engine may state, rad.
MOST_LEAST_TURN = 1e-4
#: Tolerance of a quaternion's norm, wide enough for single precision.
UNIT_SLACK = 1e-3


def _unit(q_wxyz: Quaternion) -> Quaternion:
    """Return a quaternion unchanged; raise ValueError unless its norm is 1 within `UNIT_SLACK`."""
    if not abs(math.hypot(*q_wxyz) - 1) <= UNIT_SLACK:
        raise ValueError("must be a unit quaternion")
    return q_wxyz


Rotation = Annotated[Quaternion, AfterValidator(_unit)]


class ChildAnswer(BaseModel):
    """Base of all answers: unknown keys are refused, and types are strict."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class ChildMethod(ChildAnswer):
    """A method as the child describes it; `Method` documents the fields of the same names."""

    name: Name
    order: Order
    attitude_order: Order
    summary: Words
    effects: Effects
    requires: Effects = []
    max_rotation_per_step: Positive | None = None
    clamps_parts: bool = False
    as_shipped: bool = False

    def method(self) -> Method:
        """Return the method as a `Method`."""
        sets = {"effects": frozenset(self.effects), "requires": frozenset(self.requires)}
        return Method(**self.model_dump(exclude_none=True) | sets)


class Hello(ChildAnswer):
    """An engine's description of itself; docs/reference/engine-protocol.md explains the keys."""

    protocol: Protocol
    name: Name
    version: Words
    precision: Literal["double", "single"]
    stock_timestep: Positive | None
    methods: Annotated[list[ChildMethod], Field(min_length=1, max_length=MOST_NAMES)]
    restart: bool = False
    least_turn: Annotated[float, Field(ge=0, le=MOST_LEAST_TURN)] = 0.0

    @model_validator(mode="after")
    def _named_once(self) -> Self:
        """Return the object itself; raise ValueError if two of its methods have the same name."""
        names = [method.name for method in self.methods]
        if len(set(names)) < len(names):
            raise ValueError("'methods' must have names of their own")
        return self


class ChildRigid(ChildAnswer):
    """A rigid body as the engine holds it, in the axes and from the origin of the engine's body.

    Attributes
    ----------
    mass : mass, kg
    com : position of the com, m
    moments : principal moments of inertia about the com, kg m²
    frame : attitude of the principal axes, w x y z, relative to the axes of the engine's body
    """

    mass: Number
    com: Vector
    moments: Vector
    frame: Rotation

    @property
    def inertia_com(self) -> FloatArray:
        """The tensor of inertia about the com, kg m², in the axes of the engine's body, (3, 3)."""
        axes = matrix(np.array(self.frame))
        return axes @ np.diag(self.moments) @ axes.T


class ChildPart(ChildRigid):
    """A rotor as the engine holds it at the start, in the axes of the engine's body.

    Attributes
    ----------
    axis : axis of the hinge, a unit vector; zeros if the hinge is locked
    """

    axis: Vector


class ChildBody(ChildRigid):
    """A body as the engine holds it; mass, com and moments are those without the rotors.

    Attributes
    ----------
    arm : the point where the body is held, m, from the origin of the engine's body; None if the
        body is free
    parts : the rotors, in the scene's order
    """

    arm: Vector | None
    parts: Annotated[list[ChildPart], Field(max_length=MAX_ROTORS)] = []


class StateRow(ChildAnswer):
    """A state of the body and its rotors, in world axes.

    Attributes
    ----------
    q : attitude of the axes of the scene record, w x y z, to world
    omega : angular velocity, rad/s
    com : position of the com of the body without its rotors, m
    velocity : velocity of that com, m/s
    spins : angular velocities of the rotors about their axes, relative to the body, rad/s
    """

    q: Rotation
    omega: Vector
    com: Vector
    velocity: Vector
    spins: Annotated[list[Number], Field(max_length=MAX_ROTORS)] = []


class Stepped(ChildAnswer):
    """The state after some steps, with the keys, axes and units of `StateRow`.

    Numbers that are not finite, which JSON cannot write, are None.
    """

    q: tuple[Known, Known, Known, Known]
    omega: tuple[Known, Known, Known]
    com: tuple[Known, Known, Known]
    velocity: tuple[Known, Known, Known]
    spins: Annotated[list[Known], Field(max_length=MAX_ROTORS)] = []


class Opened(ChildAnswer):
    """The body and the state as the engine holds them before the first step."""

    body: ChildBody
    state: StateRow


class Seconds(ChildAnswer):
    """The time that some steps took, s, as the child measures it around the steps alone."""

    seconds: Positive


class Active(ChildAnswer):
    """The names of what acts on the body, as `Session.active` returns them."""

    active: Annotated[list[Words], Field(max_length=MOST_NAMES)]


class Done(ChildAnswer):
    """The answer to a call that returns nothing."""


class Refusal(ChildAnswer):
    """The answer to a call that failed: the reason in words."""

    error: Annotated[str, Field(min_length=1, max_length=2000)]


A = TypeVar("A", bound=ChildAnswer)


class Misanswer(ValueError):
    """An answer breaks the protocol; the message completes a sentence "its answer …"."""


def parse(line: bytes, number: int, expected: type[A]) -> A | Refusal:
    """Return the answer in a line: of the expected class, or a refusal.

    Parameters
    ----------
    line : the line, as received
    number : number of the call, which the answer must repeat as its `id`
    expected : class of the answer to this call

    Raises
    ------
    Misanswer
        If the line is not an answer that the protocol allows.
    """
    try:
        answer: Any = json.loads(line, parse_constant=_no_number, object_pairs_hook=_with_keys_once)
    except (ValueError, RecursionError) as error:
        fault = str(error) if isinstance(error, Misanswer) else f"is not JSON: {_quoted(line)}"
        raise Misanswer(fault) from None
    if not isinstance(answer, dict):
        raise Misanswer(f"is not a JSON object: {_quoted(line)}")
    its_id = answer.pop("id", None)
    # `True`, which equals 1 in Python, is not accepted as a number.
    if type(its_id) is not int or its_id != number:
        raise Misanswer(f"must have the call's 'id', {number}: {_quoted(line)}")
    kind: type[A] | type[Refusal] = Refusal if "error" in answer else expected
    try:
        return kind.model_validate_json(json.dumps(answer))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise Misanswer(
            f"breaks the protocol{f' at {where!r}' if where else ''}: {first['msg']}"
        ) from None


def _with_keys_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the object of a JSON text; raise `Misanswer` if it has a key twice.

    Parameters
    ----------
    pairs : its keys and values, in the order of the text
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise Misanswer(f"has the key {_quoted(twice.encode(errors='replace'))} twice")
    return found


def _no_number(name: str) -> float:
    """Raise `Misanswer` for a number that JSON does not have: `name` is NaN or an infinity."""
    raise Misanswer(f"holds {name}, which is not JSON; null says that a number is not finite")


def _quoted(line: bytes) -> str:
    """Return the first `QUOTED` characters of a line in quotes; control characters are escaped."""
    text = line.decode(errors="replace").strip()
    return repr(text if len(text) <= QUOTED else text[:QUOTED] + "…")
