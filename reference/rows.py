"""Rows of named numbers: scalars, vectors and matrices, of one object or of many at once.

All numbers of an object are one row of an array. So compiled code can take the array as it is, and
one expression of numpy computes a quantity for many objects.
"""

from collections.abc import Sequence
from math import prod
from typing import Any, Self, overload

import numpy as np

from ..scenarios import FloatArray


class Entry:
    """A scalar, vector or matrix that has fixed places in each row of a `Rows` class.

    It is read as an attribute of the rows.

    Attributes
    ----------
    shape : its shape; () for a scalar
    first, last : its numbers are those with the indices `first` to `last` − 1 of a row
    """

    def __init__(self, *shape: int) -> None:
        self.shape = shape
        self.first = self.last = 0

    def __set_name__(self, owner: type["Rows"], name: str) -> None:
        """Give the entry its places, after those of the entries declared before it in the class."""
        self.first, self.last = owner.count, owner.count + prod(self.shape)
        owner.count = self.last

    @overload
    def __get__(self, rows: None, owner: type["Rows"]) -> "Entry": ...

    @overload
    def __get__(self, rows: "Rows", owner: type["Rows"]) -> FloatArray: ...

    def __get__(self, rows: "Rows | None", owner: type["Rows"]) -> "Entry | FloatArray":
        """Return the entry's values: `shape` for one object, (H, *`shape`) for H objects.

        If the attribute is read from the class, without rows, the entry itself is returned.
        """
        if rows is None:
            return self
        numbers = rows.numbers[..., self.first : self.last]
        return numbers.reshape(numbers.shape[:-1] + self.shape)


class Rows:
    """The numbers of one object, or of H objects at once; a subclass declares each as an `Entry`.

    Attributes
    ----------
    count : how many numbers an object has
    numbers : all numbers of one object, (count,), or of H objects, (H, count)
    """

    count = 0

    def __init__(self, numbers: FloatArray) -> None:
        self.numbers = numbers

    def __len__(self) -> int:
        """Return the number of objects, H; raise `TypeError` for a single row, (count,)."""
        if self.numbers.ndim == 1:
            raise TypeError(f"one {type(self).__name__} has no length")
        return len(self.numbers)

    def __getitem__(self, which: Any) -> Self:
        """Return some of the H objects, or one of them, selected by any index of numpy's."""
        return type(self)(self.numbers[which])

    def of(self, **entries: Any) -> Self:
        """Return a copy of the objects in which some entries have new values.

        Parameters
        ----------
        entries : new values, by the entry's name: one value for all objects, with the shape of the
            entry, or one for each of H objects, (H, ...)

        Raises
        ------
        ValueError
            If a value has another shape.
        """
        numbers = self.numbers.copy()
        for name, value in entries.items():
            entry: Entry = getattr(type(self), name)
            value = np.asarray(value, dtype=float)
            if value.shape not in (entry.shape, numbers.shape[:-1] + entry.shape):
                raise ValueError(f"'{name}' must be {entry.shape} of each, got {value.shape}")
            before = value.shape[: value.ndim - len(entry.shape)]
            numbers[..., entry.first : entry.last] = value.reshape((*before, -1))
        return type(self)(numbers)

    def repeated(self, count: int) -> Self:
        """Return `count` copies of this one object, as that many rows."""
        return type(self)(np.tile(self.numbers, (count, 1)))

    @classmethod
    def joined(cls, every: Sequence[Self]) -> Self:
        """Return the objects of all given rows, one after another."""
        return cls(np.concatenate([one.numbers for one in every]))
