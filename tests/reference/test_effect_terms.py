"""The reference has terms for every effect, and solves no scene with one that it has none for."""

import pytest
from scene_texts import FAST_TOP
from spincheck.reference import solve
from spincheck.reference.effect_terms import TERMS
from spincheck.scenarios import EFFECTS, loads
from spincheck.scenarios.effects import Effect, EffectTable


def test_every_effect_but_the_pivot_has_terms() -> None:
    assert list(TERMS) == [name for name in EFFECTS if name != "pivot"]


def test_a_scene_with_an_effect_that_has_none_is_not_solved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    planted = Effect("spring", table="gravity", model=EffectTable)
    monkeypatch.setitem(EFFECTS, planted.name, planted)
    top = loads(FAST_TOP, "top")
    assert top.called_for == {"gravity", "pivot", "spring"}
    with pytest.raises(NotImplementedError, match="exact motion with spring"):
        solve(top, top.times)
