"""Every derivative, against central differences of a second derivation in forty digits."""

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest
from differenced import NUDGE, derivatives
from library_scenes import library_scene
from scene_texts import scene
from spincheck.reference import ExactMotion, Sensitivity, sensitivity
from spincheck.reference import taylor_coefficients as terms
from spincheck.reference.solve import ROUNDING
from spincheck.scenarios import EFFECTS, FloatArray, Scenario

pytestmark = pytest.mark.slow

TIMES = (0.15,)
#: 1/s, at the most.
RATE = 8.0
#: Both are rounded, and differences leave out the square of the nudge.
BOUND = 2 * ROUNDING + float(NUDGE) ** 2

SKEW = (
    "inertia = [1.0, 2.0, 2.5]",
    "inertia = [[2.0, 0.3, 0.1], [0.3, 2.5, 0.2], [0.1, 0.2, 3.0]]",
)
ROTOR = """
[[rotors]]
axis = [0.6, 0.0, 0.8]
position = [0.1, -0.2, 0.3]
mass = 0.5
inertia = [0.02, 0.03]
spin = 20.0
hinge = "free"
"""
DRIVEN = ROTOR.replace("free", "driven").replace("[0.6, 0.0, 0.8]", "[0.0, 1.0, 0.0]")
LOCKED = ROTOR.replace("free", "locked").replace("spin = 20.0\n", "")
GRAVITY = "[effects.gravity]\nacceleration = [1.0, -0.5, -9.0]\n"
DRAG = "[effects.drag]\nrotational = 0.25\n"
TABLE = "[effects.table]\nheight = 0.5\ntip = [0.0, 0.1, -0.2]\nradius = 0.05\n"
SCENES = {
    "on a pivot, with rotors": scene(
        SKEW,
        more=f"[effects.pivot]\n{GRAVITY}{DRAG}[effects.torque]\nbody = [0.5, 1.0, -2.0]\n"
        + ROTOR
        + DRIVEN
        + LOCKED,
    ),
    "on a table, with a rotor": scene(SKEW, more=GRAVITY + TABLE + DRAG + ROTOR),
    "free, with a rotor": scene(SKEW, more="[effects.torque]\nworld = [0.5, 1.0, -2.0]\n" + ROTOR),
    "balanced on its pivot": scene(
        SKEW, ("com = [0.1, 0.2, 0.3]", "com = [0.0, 0.0, 0.0]"), more=f"[effects.pivot]\n{GRAVITY}"
    ),
    "symmetric": library_scene("falling-stick"),
}


def found(scenario: Scenario) -> Sensitivity:
    return sensitivity(scenario, ExactMotion(scenario).outline(np.array(TIMES)))


@cache
def differences(label: str, name: str, columns: int) -> tuple[FloatArray, FloatArray]:
    """A direction in the columns of an array, and the array times that."""
    scenario, direction = SCENES[label], np.random.default_rng(1).choice([-1.0, 1.0], columns)
    if name == "spins":
        direction *= [rotor.hinge != "locked" for rotor in scenario.rotors.each]
    return direction, derivatives(scenario, name, direction, TIMES, RATE)


def apart(label: str, one: Sensitivity, name: str) -> float:
    """How far an array is from the differences along a direction, relative, ω per rate."""
    scenario, array = SCENES[label], getattr(one, name).reshape(len(TIMES), 6, -1)
    direction, right = differences(label, name, array.shape[-1])
    by_array = array @ direction
    if scenario.effects.table:
        flight = one.translation[name].reshape(len(TIMES), 6, -1)[:, 2::3, : len(direction)]
        by_array = np.hstack([by_array, flight @ direction])
    unit = np.repeat([1.0, one.rate, 1.0, one.rate], [3, 3, 1, 1])[: right.shape[1]]
    difference, size = np.abs((by_array - right) / unit).max(), np.abs(right / unit).max()
    return float(difference / size) if size else float(difference)


@pytest.mark.parametrize("label", SCENES)
def test_every_array_is_the_limit_of_differences(label: str) -> None:
    one = found(SCENES[label])
    off = {name: apart(label, one, name) for name in one.uncertainty if name != "moments"}
    assert max(off.values()) < BOUND, off


def test_every_effect_is_among_the_scenes() -> None:
    assert set().union(*(one.called_for for one in SCENES.values())) == set(EFFECTS)


@pytest.mark.parametrize("row", ["EULER", "MOMENTUM", "LEVER_NEXT", "LINEAR", "MASS_OVER_MOMENT"])
def test_a_term_that_is_dropped_shows(row: str, monkeypatch: pytest.MonkeyPatch) -> None:
    module = import_module(sensitivity.__module__)
    complete = module.constants_of

    def without(problem):
        parts = complete(problem)
        for part in parts:
            part[getattr(terms, row)] = 0.0
        return parts

    monkeypatch.setattr(module, "constants_of", without)
    name = "on a table, with a rotor" if row == "MASS_OVER_MOMENT" else "on a pivot, with rotors"
    assert apart(name, found(SCENES[name]), "state_transition") > 1e3 * BOUND


def test_a_transposed_transition_shows() -> None:
    one = found(SCENES[label := "free, with a rotor"])
    transposed = replace(one, state_transition=one.state_transition.swapaxes(1, 2))
    assert apart(label, transposed, "state_transition") > 1e3 * BOUND
