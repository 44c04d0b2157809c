"""The types of tables in a scenario file and of their values: numbers, vectors, texts."""

import math
from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
)

from .errors import Misfit, is_control

#: Tolerance of a typed quaternion's norm: typed digits rarely give 1 exactly.
QUATERNION_NORM_SLACK = 1e-3


class Table(BaseModel):
    """A table of the file: immutable, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _line(text: str) -> str:
    if not text.strip():
        raise ValueError(f"must not be empty, got {text!r}")
    if any(is_control(c) for c in text):
        raise ValueError(f"must be one line without control characters, got {text!r}")
    return text


def _prose(text: str) -> str:
    if any(is_control(c) and c not in "\n\t" for c in text):
        raise ValueError(f"must have no control characters, got {text!r}")
    return text


def _whole_number(value: Any) -> Any:
    """Return a value that is an integer; raise `ValueError` for any other, also true and 1.0."""
    if type(value) is not int:
        raise ValueError(f"must be a whole number, got {value!r}")
    return value


def _inertia_form(value: Any) -> str:
    nested = isinstance(value, list | tuple) and value and isinstance(value[0], list | tuple)
    return "matrix" if nested else "moments"


Version = Annotated[Literal[1], BeforeValidator(_whole_number)]
#: TOML integers are numbers too; strings and booleans are not, nor are inf and nan.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]
Matrix = tuple[Vector, Vector, Vector]
Inertia = Annotated[
    Annotated[Vector, Tag("moments")] | Annotated[Matrix, Tag("matrix")],
    Discriminator(_inertia_form),
]
#: One line of text that a terminal shows as it stands: no escape sequences, no line break.
Text = Annotated[str, Field(strict=True, min_length=1), AfterValidator(_line)]
Digest = Annotated[str, Field(strict=True, pattern="^[0-9a-fA-F]{64}$"), AfterValidator(str.lower)]
#: Text of any number of lines, without escape sequences.
Prose = Annotated[str, Field(strict=True), AfterValidator(_prose)]


def check_unit(q: Quaternion) -> None:
    """Check that a quaternion in a scene file is of norm 1.

    Raises
    ------
    Misfit
        If its norm differs from 1 by more than `QUATERNION_NORM_SLACK`.
    """
    norm = math.hypot(*q)
    if abs(norm - 1) > QUATERNION_NORM_SLACK:
        raise Misfit(f"must have norm 1, got norm {norm:.6g}", "quaternion_wxyz")


def names(keys: Iterable[str]) -> str:
    """Return keys of a TOML table as messages list them: in quotes, sorted."""
    return ", ".join(f"'{key}'" for key in sorted(keys))
