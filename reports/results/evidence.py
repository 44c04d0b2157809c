"""What a ladder is judged by: a few numbers a rung. It can be judged again without a run."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import PlainValidator, TypeAdapter

from ...scenarios import EVERYWHERE, FloatArray, SignalName
from .records import MethodKey, Record

_NUMBERS = TypeAdapter(list[float])
_FLAGS = TypeAdapter(list[bool])


def _numbers(values: Any) -> FloatArray:
    return np.array(_NUMBERS.validate_python(values, strict=True))


def _flags(values: Any) -> NDArray[np.bool_]:
    return np.array(_FLAGS.validate_python(values, strict=True), dtype=bool)


#: (signals,), one entry a signal that the scene has.
Numbers = Annotated[FloatArray, PlainValidator(_numbers)]
Flags = Annotated[NDArray[np.bool_], PlainValidator(_flags)]


@dataclass(frozen=True)
class Deviation:
    """A limit that is wrong: where, over the samples in the asymptotic range, and by how much.

    Attributes
    ----------
    since, by : s, the first and the last sample by which its distance from the exact motion exceeds
        `DISTINCT` times its tolerance
    error, tolerance : that distance, and the largest that it may be, by the last of these samples
    """

    since: float
    by: float
    error: float
    tolerance: float


@dataclass(frozen=True, eq=False)
class Refinement:
    """What two neighbouring rungs, and the one before, show; arrays (signals,).

    Attributes
    ----------
    orders : used for the extrapolation
    limit_error : distance of their Richardson limit from the exact motion
    limit_change : distance of that limit from the limit of the two coarser rungs
    is_clean : whether differences and limits shrink as the order says
    rounding : the largest effect of rounding on the limit
    deviations : of the limit from the exact motion, None where it may be right
    """

    orders: Numbers
    limit_error: Numbers
    limit_change: Numbers
    is_clean: Flags
    rounding: Numbers
    deviations: tuple[Deviation | None, ...]


@dataclass(frozen=True, eq=False)
class JudgedRung:
    """A rung of a ladder, and what it shows beside the two coarser ones; arrays (signals,).

    Attributes
    ----------
    timestep : s
    errors : distance from the exact motion
    roundoff_bounds : the largest effect of rounding at every step
    differences : from the motion of the rung before; None of a first rung
    refinement : None of the first two rungs
    """

    timestep: float
    errors: Numbers
    roundoff_bounds: Numbers
    differences: Numbers | None = None
    refinement: Refinement | None = None


@dataclass(frozen=True, eq=False)
class LadderBasis:
    """What all rungs of a ladder are judged by; arrays (signals,).

    Attributes
    ----------
    declared_orders : of accuracy
    uncertainty : of the reference, plus that of start and body as the engine holds them
    duration : s, of the window
    rate : rad/s, the fastest of the motion
    signals : their names, in order; older files have those of every scene
    """

    declared_orders: Numbers
    uncertainty: Numbers
    duration: float
    rate: float
    signals: tuple[SignalName, ...] = EVERYWHERE

    def __post_init__(self) -> None:
        if len({*self.signals}) < len(self.signals) or not {*EVERYWHERE} <= {*self.signals}:
            raise ValueError("must have each signal of every scene once")


@dataclass(frozen=True, eq=False)
class JudgedLadder:
    """A ladder as it is judged; its rungs coarse to fine."""

    basis: LadderBasis
    rungs: tuple[JudgedRung, ...] = ()


@dataclass(frozen=True, eq=False)
class LocalEvidence:
    """What a method does from exact states along the motion.

    Attributes
    ----------
    finding : how its steps are inconsistent with the equations of motion, in words; empty if not
    excess : what is left of them in the limit of short steps, in tolerances
    tolerance : to which they are known to be consistent, relative to the largest terms
    is_open : whether steps leave something where next to nothing acts, which may add up
    states : number of states
    starts : of these, number of those that pieces start from
    pieces : the short runs from there; None where steps are inconsistent
    remark : what its steps do that vanishes with the timestep, in words; empty if nothing
    of_an_effect : as `tolerance`, relative to the weakest effect of the scene
    """

    finding: str
    excess: float
    tolerance: float
    is_open: bool
    states: int
    starts: int = 0
    pieces: JudgedLadder | None = None
    remark: str = ""
    of_an_effect: float = 0.0


@dataclass(frozen=True, eq=False)
class Evidence(Record):
    """What a method on a scene is judged by, besides its rows.

    Attributes
    ----------
    rungs : of its ladder, and of those that it began before a run failed
    basis : of all of them
    local : None where the method cannot be opened at exact states
    memory : by how many tolerances a run goes on otherwise than if restarted from its own states;
        None if that is not known
    """

    key: MethodKey
    rungs: tuple[JudgedRung, ...] = ()
    basis: LadderBasis | None = None
    local: LocalEvidence | None = None
    memory: float | None = None

    def __post_init__(self) -> None:
        pieces = self.local.pieces if self.local else None
        if any(len(set(_widths(of))) > 1 for of in ((self.basis, self.rungs), pieces)):
            raise ValueError("must have one value a signal throughout")


def _widths(part: Any) -> Iterator[int]:
    """How many values each field of a part of a ladder has that has one a signal."""
    if isinstance(part, tuple):
        for one in part:
            yield from _widths(one)
    elif is_dataclass(part):
        for field in fields(part):
            value = getattr(part, field.name)
            is_by_signal = isinstance(value, np.ndarray) or field.name in ("signals", "deviations")
            yield from (len(value),) if is_by_signal else _widths(value)
