"""Every conservation law holds on the scenes it applies to, and detects motions that break it."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from spincheck.reference.conservation_laws import LAWS
from spincheck.reference.cross_check import RELATIVE_TOLERANCE, cross_check
from spincheck.reference.invariants import drifts, invariants
from spincheck.scenarios import LIBRARY, load
from top_scenes import ASYMMETRIC, GRAVITY, HEAVY, PIVOT, TOP, scene

SPUN = "rotation_vector_deg = [20.0, -50.0, 35.0]\nomega_body = [1.0, -2.0, 3.0]"
THROWN = f"{SPUN}\nposition = [0.3, -0.1, 0.5]\nvelocity = [0.2, 1.0, -0.4]"
SKEW = """
mass = 1.3
inertia = [[1.4, 0.2, -0.1], [0.2, 1.1, 0.3], [-0.1, 0.3, 0.9]]
com = [0.1, -0.2, 0.3]
"""
#: Equal moments 2, the third half of them, com in the plane of the equal ones but on no axis.
KOVALEVSKAYA = """
mass = 1.0
inertia = [2.0, 2.0, 1.0]
inertia_about = "origin"
com = [0.3, 0.4, 0.0]
"""
KOVALEVSKAYA_ABOUT_X = """
mass = 1.0
inertia = [1.0, 2.0, 2.0]
inertia_about = "origin"
com = [0.0, 0.3, 0.4]
"""
GORYACHEV_CHAPLYGIN = """
mass = 1.0
inertia = [2.0, 2.0, 0.5]
inertia_about = "origin"
com = [0.1, 0.0, 0.0]
"""
#: Gravity along the body's own x: there L·ĝ = I1 ω1 = 0.
LEVEL = "rotation_vector_deg = [0.0, 90.0, 0.0]\nomega_body = [0.0, 1.0, 3.0]"
SKEW_GRAVITY = "[effects.gravity]\nacceleration = [1.0, -2.0, -9.0]"
DRAG = "[effects.drag]\nrotational = 1e-2"

ROTORS = """
[[rotors]]
axis = [1.0, 2.0, -1.0]
position = [0.1, 0.0, 0.2]
mass = 0.5
inertia = [0.1, 0.15]
spin = 9.0
hinge = "free"
[[rotors]]
axis = [0.0, 1.0, 1.0]
position = [0.0, 0.2, -0.1]
mass = 0.3
inertia = [0.1, 0.12]
spin = -5.0
hinge = "driven"
"""
WITH_ROTORS = {"rotors_momentum"}

FREE = {"energy", "L_world", "L_norm", "momentum_less_impulse", "com_parabola"}
TOPS = {"energy", "L_vertical", "pivot"}
#: Scenes by name, with the laws that hold for each.
CASES = {
    "free": (scene(ASYMMETRIC, THROWN, ""), FREE),
    "free, skew": (scene(SKEW, THROWN, SKEW_GRAVITY), FREE),
    "free, symmetric": (scene(TOP, THROWN, ""), FREE | {"L_axial"}),
    "pivot": (scene(SKEW, SPUN, PIVOT), {"energy", "L_world", "L_norm", "pivot"}),
    "heavy": (scene(SKEW, SPUN, f"{PIVOT}\n{SKEW_GRAVITY}"), TOPS),
    "heavy, symmetric": (scene(TOP, SPUN, f"{PIVOT}\n{SKEW_GRAVITY}"), TOPS | {"L_axial"}),
    "Kovalevskaya": (scene(KOVALEVSKAYA, SPUN), TOPS | {"kovalevskaya"}),
    "Kovalevskaya about x": (scene(KOVALEVSKAYA_ABOUT_X, SPUN), TOPS | {"kovalevskaya"}),
    "Goryachev-Chaplygin": (scene(GORYACHEV_CHAPLYGIN, LEVEL), TOPS | {"goryachev_chaplygin"}),
    "world torque": (
        scene(SKEW, SPUN, "[effects.torque]\nworld = [0.4, -0.3, 0.2]"),
        {"L_world", "momentum_less_impulse", "com_parabola"},
    ),
    "world torque on a heavy body": (
        scene(SKEW, SPUN, f"{HEAVY}\n[effects.torque]\nworld = [0.4, -0.3, 0.2]"),
        {"L_vertical", "pivot"},
    ),
    "body torque on a heavy top": (
        scene(TOP, SPUN, f"{HEAVY}\n[effects.torque]\nbody = [0.4, -0.3, 0.2]"),
        {"L_axial", "pivot"},
    ),
    "free, with rotors": (scene(SKEW, THROWN, f"{SKEW_GRAVITY}\n{ROTORS}"), FREE | WITH_ROTORS),
    "heavy, with rotors": (scene(TOP, SPUN, f"{HEAVY}\n{ROTORS}"), TOPS | WITH_ROTORS),
    "on a table": (
        load(LIBRARY / "table/falling-stick.toml"),
        {"energy", "L_vertical", "table", "momentum_less_impulse", "com_parabola"},
    ),
    "drag": (
        scene(SKEW, THROWN, f"{GRAVITY}\n{DRAG}"),
        {"momentum_less_impulse", "com_parabola"},
    ),
}


@cache
def solved(name):
    """A scene's motion, by an integrator that knows of no law."""
    scenario, _ = CASES[name]
    return cross_check(scenario, scenario.times)


def bound(name):
    """The integrator commits its tolerance at every step, a root mean square of 13 numbers."""
    return solved(name).steps * RELATIVE_TOLERANCE * 13**0.5


@pytest.mark.parametrize("name", CASES)
def test_the_laws_of_a_scene_are_those_that_hold(name):
    scenario, laws = CASES[name]
    assert {invariant.name for invariant in invariants(scenario)} == laws


@pytest.mark.parametrize("name", CASES)
def test_what_is_conserved_does_not_drift(name):
    scenario, _ = CASES[name]
    for law, drift in drifts(scenario, solved(name).trajectory).items():
        assert drift < bound(name), law


def test_every_law_is_tried():
    tried = set().union(*(laws for _, laws in CASES.values()))
    assert tried == {law.name for law in LAWS}


def test_the_page_on_physics_has_every_law():
    text = (Path(__file__).parents[2] / "docs/explanation/physics.md").read_text(encoding="utf-8")
    table = text.split("## What is conserved")[1]
    assert re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE) == [law.name for law in LAWS]


#: What is done to a motion to break a law: more than a bound, less than anyone would see.
FAULT = 1e-6


def pushed(motion):
    """ω and v off by a millionth more every second, along no axis."""
    extra = FAULT * motion.t[:, None] * np.array([0.6, -0.5, 0.7])
    return replace(
        motion,
        omega_body=motion.omega_body + extra,
        velocity_world=motion.velocity_world + extra,
    )


def slipping(motion):
    """The com a micrometre a second off its path."""
    return replace(motion, com_world=motion.com_world + FAULT * motion.t[:, None])


@pytest.mark.parametrize("name", CASES)
def test_a_law_notices_a_planted_fault(name):
    scenario, _ = CASES[name]
    motion = solved(name).trajectory
    of_place = {"pivot", "table", "com_parabola"}
    for invariant in invariants(scenario):
        broken = slipping(motion) if invariant.name in of_place else pushed(motion)
        assert invariant.drift(broken) > 100 * bound(name), invariant.name


@pytest.mark.parametrize(
    ("law", "body", "old", "new"),
    [
        ("kovalevskaya", KOVALEVSKAYA, "2.0, 2.0, 1.0", "2.0, 2.0, 1.0000000000000002"),
        ("kovalevskaya", KOVALEVSKAYA, "0.4, 0.0]", "0.4, 1e-20]"),
        ("kovalevskaya", KOVALEVSKAYA, "2.0, 2.0, 1.0", "2.0, 2.0000000000000004, 1.0"),
        ("goryachev_chaplygin", GORYACHEV_CHAPLYGIN, "body = [0.0", "body = [1e-20"),
    ],
    ids=["ratio", "com", "equal moments", "L along gravity"],
)
def test_a_body_one_ulp_off_an_integrable_case_is_just_heavy(law, body, old, new):
    start = SPUN if body is KOVALEVSKAYA else LEVEL
    as_is, off = (
        {invariant.name for invariant in invariants(scene(*texts))}
        for texts in ((body, start), (body.replace(old, new), start.replace(old, new)))
    )
    assert as_is - off == {law}


#: A fifth of a turn or so about x that puts the vertical along the body's (0, 0.8, 0.6).
TILTED = f"quaternion_wxyz = [{2 / 5**0.5!r}, {1 / 5**0.5!r}, 0.0, 0.0]"


@pytest.mark.parametrize(
    ("law", "body", "start", "by_hand"),
    [
        # e1 = (0.6, 0.8, 0), γ = −x = −0.6 e1 + 0.8 e2, ω = e1, c/I3 = 5: |1 − (−3 + 4i)|².
        (
            "kovalevskaya",
            KOVALEVSKAYA,
            "rotation_vector_deg = [0.0, 90.0, 0.0]\nomega_body = [0.6, 0.8, 5.0]",
            32.0,
        ),
        # c/I3 = 2: 16 (2² + 3²) − 2 · 2 · 0.6; L·γ = −2 · 3 · 0.8 + 0.5 · 16 · 0.6 = 0.
        (
            "goryachev_chaplygin",
            GORYACHEV_CHAPLYGIN,
            f"{TILTED}\nomega_body = [2.0, -3.0, 16.0]",
            205.6,
        ),
    ],
    ids=["Kovalevskaya", "Goryachev-Chaplygin"],
)
def test_an_integrable_case_has_the_value_worked_out_by_hand(law, body, start, by_hand):
    scenario = scene(body, start)
    (invariant,) = [one for one in invariants(scenario) if one.name == law]
    motion = cross_check(scenario, scenario.times).trajectory
    assert invariant.values(motion)[0] == pytest.approx(by_hand, rel=1e-14)


def test_a_body_let_go_from_rest_has_scales():
    """L and T are zero at the start; a drift relative to them would be infinite."""
    scenario = scene(TOP, "euler_zyz_deg = [0, 50, 0]\nomega_body = [0.0, 0.0, 0.0]")
    assert all(one.law.scale(one.scene) > 0 for one in invariants(scenario))


def test_what_moves_though_nothing_should_drifts_infinitely_far():
    still = scene(ASYMMETRIC, "euler_zyz_deg = [0, 50, 0]\nomega_body = [0.0, 0.0, 0.0]", "")
    assert set(drifts(still, cross_check(still, still.times).trajectory).values()) == {0.0}
    moving = scene(ASYMMETRIC, "euler_zyz_deg = [0, 50, 0]\nomega_body = [0.0, 1.0, 0.0]", DRAG)
    motion = cross_check(moving, still.times).trajectory
    assert drifts(still, motion)["energy"] == np.inf


@pytest.mark.filterwarnings("error")
def test_what_has_blown_up_beyond_doubles_drifts_infinitely_far():
    """Result files with a drift that is no number are refused."""
    skew = scene(SKEW, SPUN)
    motion = cross_check(skew, skew.times).trajectory
    omega = motion.omega_body.copy()
    for size in (1e200, 1e308):
        omega[1:] = [size, -size, size]
        assert drifts(skew, replace(motion, omega_body=omega))["energy"] == np.inf
