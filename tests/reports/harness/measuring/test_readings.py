"""Mistakes in reading that are named from n states that are read and what they should be."""

import numpy as np
import pytest
from spincheck.engines import State
from spincheck.reports.harness.explaining.readings import MISTAKES, misreading

CHANCE = np.random.default_rng(5)
TURNS = CHANCE.standard_normal((7, 4))
EXACT = State(
    TURNS / np.linalg.norm(TURNS, axis=1)[:, None],
    *CHANCE.standard_normal((3, 7, 3)),
    np.empty((7, 0)),
)


def in_24_bits(state: State) -> State:
    return State(*(column.astype(np.float32).astype(float) for column in state.columns))


@pytest.mark.parametrize("kind", MISTAKES)
def test_each_mistake_is_named(kind: str) -> None:
    (found,) = misreading(MISTAKES[kind](EXACT), EXACT, is_single=False)
    assert found.kind == kind


def test_single_precision_is_named_of_an_engine_that_does_not_declare_it() -> None:
    (found,) = misreading(in_24_bits(EXACT), EXACT, is_single=False)
    assert found.kind == "24 bits"
    assert not misreading(in_24_bits(EXACT), EXACT, is_single=True)


def test_what_no_mistake_explains_is_not_named() -> None:
    turned = State(np.roll(EXACT.q_world_body_wxyz, 1, axis=0), *EXACT.columns[1:])
    assert not misreading(turned, EXACT, is_single=False)
