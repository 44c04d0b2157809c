"""The reference has terms for every effect, and solves no scene with one that it has none for."""

import pytest
from scene_texts import FAST_TOP
from spincheck.reference import solve
from spincheck.reference.conservation_laws import LAWS, InvariantScales
from spincheck.reference.effect_terms import TERMS, EffectTerms
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.scenarios import EFFECTS, loads
from spincheck.scenarios.effects import Effect, EffectTable
from top_scenes import GRAVITY, scene

#: An effect of every scene with gravity, of which nothing says that it is no force.
PULL = Effect("pull of nothing", table="gravity", model=EffectTable)
TURNS_NOTHING = EffectTerms("constant", lambda *_: {}, lambda _: False, lambda *_: {})


def test_every_effect_but_the_pivot_has_terms() -> None:
    assert list(TERMS) == [name for name in EFFECTS if name != "pivot"]


def test_a_scene_with_an_effect_that_has_none_is_not_solved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(EFFECTS, PULL.name, PULL)
    top = loads(FAST_TOP, "top")
    assert top.called_for == {"gravity", "pivot", PULL.name}
    with pytest.raises(NotImplementedError, match=f"exact motion with {PULL.name}"):
        solve(top, top.times)


def test_a_force_that_the_flight_is_without_is_not_left_out_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(EFFECTS, PULL.name, PULL)
    monkeypatch.setitem(TERMS, PULL.name, TURNS_NOTHING)
    thrown = scene(effects=GRAVITY)
    with pytest.raises(NotImplementedError, match=f"exact motion with {PULL.name}"):
        solve(thrown, thrown.times)


def test_laws_of_a_thrown_body_hold_with_no_force_but_gravity(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    laws = [law for law in LAWS if law.name in ("momentum_less_impulse", "com_parabola")]
    scales = InvariantScales(thrown := scene(effects=GRAVITY), rotational_problem(thrown))
    assert [law.holds(scales) for law in laws] == [True, True]
    monkeypatch.setitem(EFFECTS, PULL.name, PULL)
    pulled = InvariantScales(scene(effects=GRAVITY), scales.problem)
    assert [law.holds(pulled) for law in laws] == [False, False]


def test_forces_are_told_from_torques_constraints_and_parts() -> None:
    assert {name for name, effect in EFFECTS.items() if effect.is_force} == {"gravity"}
