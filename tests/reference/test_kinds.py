"""Kinds of motion, of scenes whose kind is in the books."""

import pytest
from library_scenes import library_scene
from spincheck.reference.kinds import KINDS, kind_of
from spincheck.scenarios.scatter import member

OF = {
    "feynman-plate": "free symmetric",
    "sphere": "free symmetric",
    "balanced-gyroscope": "free symmetric",
    "book-middle-axis": "free asymmetric",
    "book-in-skew-axes": "free asymmetric",
    "hammer": "free asymmetric",
    "fast-top": "heavy symmetric",
    "y-is-up": "heavy symmetric",
    "kovalevskaya": "heavy asymmetric",
    "lopsided-body": "heavy asymmetric",
    "motor-driven-top": "with other effects",
    "sphere-in-syrup": "with other effects",
    "wheel-in-a-box": "with other effects",
    "gliding-top": "with other effects",
}


@pytest.mark.parametrize("name", OF)
def test_a_scene_is_of_its_kind(name):
    assert kind_of(library_scene(name)) == OF[name]


def test_every_kind_has_a_scene_here():
    assert set(OF.values()) == set(KINDS)


@pytest.mark.parametrize("name", [name for name, kind in OF.items() if "symmetric" in kind])
def test_members_are_of_the_kind_of_their_scene(name):
    base = library_scene(name)
    assert {kind_of(member(base, 0, k)) for k in range(5)} == {OF[name]}
