"""Rows of named numbers hold one object or many, and an entry of each."""

import numpy as np
import pytest
from spincheck.reference.rows import Entry, Rows


class Base(Rows):
    mass = Entry()
    place = Entry(3)


class Derived(Base):
    tensor = Entry(2, 2)


ONE = Derived(np.arange(8.0))
MANY = ONE.repeated(3).of(mass=[1.0, 2.0, 3.0])


def test_entries_follow_on_each_other_and_on_those_of_the_base():
    assert (Base.count, Derived.count) == (4, 8)
    assert (Derived.mass.first, Derived.place.first, Derived.tensor.first) == (0, 1, 4)


def test_an_entry_of_one_has_its_shape_and_of_many_one_more_axis():
    assert ONE.mass.shape == ()
    assert ONE.tensor.tolist() == [[4, 5], [6, 7]]
    assert MANY.mass.tolist() == [1, 2, 3]
    assert MANY.tensor.shape == (3, 2, 2)
    assert (MANY.tensor == ONE.tensor).all()


@pytest.mark.parametrize("value", [np.eye(2), np.stack([np.eye(2)] * 3)])
def test_other_entries_are_those_of_all_or_of_each(value):
    other = MANY.of(tensor=value)
    assert (other.tensor == np.eye(2)).all()
    assert (other.place == MANY.place).all()
    assert (MANY.tensor == ONE.tensor).all()


def test_what_has_no_such_name_or_shape_is_refused():
    with pytest.raises(AttributeError, match="weight"):
        ONE.of(weight=1.0)
    for value in (1.0, np.ones(2), np.ones((3, 1)), np.ones((2, 3)), np.ones((1, 3))):
        with pytest.raises(ValueError, match="'place' must be"):
            MANY.of(place=value)
    with pytest.raises(ValueError, match="'place' must be"):
        ONE.of(place=np.ones((1, 3)))


def test_one_has_no_length():
    assert len(MANY) == 3
    with pytest.raises(TypeError, match="no length"):
        len(ONE)


def test_some_and_one_of_many_and_all_joined():
    assert MANY[[0, 2]].mass.tolist() == [1, 3]
    assert MANY[1].mass == 2
    assert (Derived.joined([MANY[:1], MANY[1:]]).numbers == MANY.numbers).all()
    assert len(ONE[None]) == 1
