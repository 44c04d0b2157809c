"""What an adapter in Python states of its engine, checked before anything runs."""

import re
from dataclasses import asdict
from typing import Annotated

from pydantic import Field, ValidationError

from ..scenarios import printable
from .child.messages import (
    MOST_LEAST_TURN,
    MOST_NAMES,
    QUOTED,
    ChildAnswer,
    Effect,
    Name,
    Order,
    Positive,
    Words,
)
from .engine import Engine
from .method import Method

Effects = Annotated[frozenset[Effect], Field(strict=False)]


class _Method(ChildAnswer):
    """Types and ranges of the fields of a `Method`; that class documents the fields."""

    name: Name
    order: Order
    attitude_order: Order
    summary: str
    effects: Effects
    requires: Effects
    max_rotation_per_step: Annotated[float, Field(gt=0)]
    clamps_parts: bool
    as_shipped: bool
    reader: bool
    setup: str


class _Declaration(ChildAnswer):
    """Types and ranges of attributes of an `Engine`; that class documents the attributes."""

    name: Name
    version: Words
    methods: Annotated[
        tuple[_Method, ...], Field(min_length=1, max_length=MOST_NAMES, strict=False)
    ]
    single_precision: bool
    least_turn: Annotated[float, Field(ge=0, le=MOST_LEAST_TURN)]
    stock_timestep: Positive | None


def misdeclared(engine: Engine) -> str:
    """Return why the first invalid attribute of an adapter is invalid; empty if all are valid.

    The rules are those for an engine in another language (docs/reference/engine-protocol.md).
    """
    stated: dict[str, object] = {}
    for name in _Declaration.model_fields:
        try:
            stated[name] = getattr(engine, name)
        # An adapter may compute an attribute, and raise anything.
        except Exception as error:
            return f"its attribute '{name}' cannot be read: {type(error).__name__}: {error}"
    methods = stated["methods"]
    if not isinstance(methods, tuple | list) or not all(isinstance(m, Method) for m in methods):
        got = printable(repr(methods), QUOTED)
        return f"its attribute 'methods' must be a tuple of Method, got {got}"
    try:
        declared = _Declaration.model_validate(stated | {"methods": [asdict(m) for m in methods]})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        rule = re.sub(r"^(Value error, must|\w+ should)", "must", first["msg"])
        return f"its attribute '{where}' {rule}, got {printable(repr(first['input']), QUOTED)}"
    names = [method.name for method in declared.methods]
    return "" if len(set(names)) == len(names) else "its methods must have names of their own"
