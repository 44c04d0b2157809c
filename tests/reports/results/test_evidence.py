"""Evidence from a file may be anybody's: it has each signal once, and a value for each."""

import numpy as np
import pytest
from spincheck.reports.results.evidence import Evidence, JudgedRung, LadderBasis
from spincheck.reports.results.records import Key
from spincheck.scenarios import EVERYWHERE

KEY = Key("made-up-top", "mujoco", "Euler")


def basis(signals: tuple[str, ...]) -> LadderBasis:
    values = np.ones(len(signals))
    return LadderBasis(values, values, duration=1.0, rate=1.0, signals=signals)


@pytest.mark.parametrize(
    "signals",
    [(), EVERYWHERE[1:], (*EVERYWHERE, EVERYWHERE[0]), (*EVERYWHERE[1:], "spins")],
    ids=["none", "one less", "one twice", "another for one"],
)
def test_no_signal_of_every_scene_is_missing_or_there_twice(signals: tuple[str, ...]) -> None:
    """A fault in a signal that is left out would not be judged."""
    with pytest.raises(ValueError, match="must have each signal of every scene once"):
        basis(signals)


@pytest.mark.parametrize("more", [-1, 1])
def test_every_rung_has_one_value_a_signal(more: int) -> None:
    values = np.ones(len(EVERYWHERE) + more)
    rung = JudgedRung(1e-3, values, values)
    with pytest.raises(ValueError, match="must have one value a signal throughout"):
        Evidence(KEY, (rung,), basis(EVERYWHERE))


def test_spins_are_a_signal_of_some_scenes() -> None:
    signals = (*EVERYWHERE, "spins")
    values = np.ones(len(signals))
    rungs = (JudgedRung(1e-3, values, values),)
    assert Evidence(KEY, rungs, basis(signals)).rungs == rungs
