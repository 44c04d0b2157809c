"""A mistake of recording beside another, or beside other physics: both are said."""

from collections.abc import Callable

import numpy as np
import pytest
from library_scenes import library_scene
from planted_motions import case, exactly, rates_of
from reported_faults import Arrays, judged, named
from scipy.spatial.transform import Rotation
from spincheck.reference.other_equations import equations_of
from test_other_torques import made

pytestmark = pytest.mark.slow

ONE = case(151)
BIAS = np.array([0.04, 0.03, -0.05])
OTHER = ONE.inertia * (2 * np.eye(3) - 1)
#: The body's axes forward, right and down for forward, left and up.
DOWN = np.array([1.0, -1.0, -1.0])
WHEEL = library_scene("wheel-in-a-box")


def frd_in_degrees(a: Arrays) -> Arrays:
    q = a["q"] * [1.0, *DOWN]
    turn = Rotation.from_matrix(np.diag(DOWN))
    q = (Rotation.from_quat(a["q"], scalar_first=True) * turn).as_quat(scalar_first=True)
    return a | {"q": q, "omega": np.degrees(a["omega"] * DOWN)}


#: What is recorded of the right motion, or of one with other products of inertia; and words.
PAIRS: dict[str, tuple[Callable[[Arrays], Arrays], bool, list[str]]] = {
    "scalar last, and a bias": (
        lambda a: a | {"q": np.roll(a["q"], -1, axis=1), "omega": a["omega"] + BIAS},
        False,
        ["order is x y z w", "a bias of [0.04, 0.03, -0.05] rad/s"],
    ),
    "world axes, and other products": (
        lambda a: (
            a
            | {
                "omega": Rotation.from_quat(a["q"], scalar_first=True).apply(a["omega"]),
            }
        ),
        True,
        ["ω is in world axes", "the products of inertia had the other sign"],
    ),
    "a sample older, and other products": (
        lambda a: {"t": a["t"][1:], "q": a["q"][1:], "omega": a["omega"][:-1]},
        True,
        ["ω is one sample older", "the products of inertia had the other sign"],
    ),
    "axes and degrees": (frd_in_degrees, False, ["in degrees a second", "axes"]),
}


@pytest.mark.parametrize("name", PAIRS)
def test_two_mistakes_are_both_named(name: str) -> None:
    change, is_other, words = PAIRS[name]
    of_tensor = {"inertia": OTHER} if is_other else {}
    motion = change(exactly(ONE, rates_of(ONE, **of_tensor)))
    said = named(judged(ONE.scenario, motion, 1e-5))
    assert len(said) == len(words)
    for one, wanted in zip(said, words, strict=True):
        assert wanted in one


def test_a_gyroscope_beside_a_rotor_of_the_other_sign() -> None:
    kept = -equations_of(WHEEL).kept
    motion = made(WHEEL, lambda t, R, omega: np.zeros(3), kept=kept)
    motion["omega"] = motion["omega"] * [1.05, 1.0, 1.0]
    said = named(judged(WHEEL, motion, 1e-5))
    assert "the rotors' torque ω × h had the other sign" in said[0]
    assert said[1:] == ["the gyroscope's axes read [1.05, 1, 1] times ω"]


def test_a_low_pass_filter_beside_drag_is_told_within_a_methods_error() -> None:
    """Few parameters explain the attitudes exactly, which no method's error does."""
    one = case(301, samples=201)
    arrays = exactly(one, rates_of(one, torque=lambda omega: -0.02 * omega))
    omega = arrays["omega"].copy()
    for k in range(1, len(omega)):
        omega[k] = omega[k - 1] + (1 - np.exp(-1 / 3)) * (omega[k] - omega[k - 1])
    drag, filtered = judged(one.scenario, arrays | {"omega": omega}, None).explained_by
    assert drag == "it moves as if it were slowed by 0.02 N m s"
    assert filtered.startswith("ω is filtered, which delays it by 0.0")
