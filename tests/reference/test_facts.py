"""Facts: each scene has those that apply to it, with the values worked out by hand."""

import math

import numpy as np
import pytest
from case_loops import each_case
from library_scenes import library
from spincheck.reference.facts import facts
from top_scenes import ASYMMETRIC, GRAVITY, HEAVY, TOP, scene

pytestmark = pytest.mark.slow

#: Facts are worked out in extended precision or by a handful of operations on doubles.
ROUNDED = 16 * np.finfo(float).eps

ALWAYS = {
    *("moment 1", "moment 2", "moment 3", "rotation", "angular momentum"),
    *("kinetic energy", "potential energy", "energy"),
}
TOP_AT_START = {
    *("I1", "I3", "M g l", "p_alpha", "p_gamma", "E'", "start angle"),
    *("sleeping threshold", "sleeping ratio"),
}
NUTATION = {
    *("nutation from", "nutation to", "nutation period", "bottom of V_eff", "small nutation"),
    *("precession rate", "steady precession, slow", "steady precession, fast"),
}
FREE_TOP = {"body cone rate", "body cone period", "body cone angle", "precession rate", "tilt"}
STEADY = "euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [2.0, 0.0, 6.0]"
SPUN = "euler_zyz_deg = [0, 0, 0]\nomega_body = [3.0, 0.0, 4.0]"
TABLE = "[effects.table]\nheight = 0.0\ntip = [0.0, 0.0, 0.0]\nradius = 0.01"
DRAG = "[effects.drag]\nrotational = 0.5"

SCENES = {
    "heavy top": (scene(TOP, STEADY), ALWAYS | TOP_AT_START | NUTATION),
    "heavy top with drag": (
        scene(TOP, STEADY, f"{HEAVY}\n{DRAG}"),
        ALWAYS | TOP_AT_START | {"spin-down time"},
    ),
    "top on a table": (
        scene(TOP, STEADY, f"{GRAVITY}\n{TABLE}"),
        ALWAYS | TOP_AT_START | NUTATION | {"table's force"},
    ),
    "free top": (scene(TOP, SPUN, ""), ALWAYS | FREE_TOP),
    "thrown top": (scene(TOP, SPUN, GRAVITY), ALWAYS | FREE_TOP),
    "top held at its com": (scene(TOP.replace("0.5]", "0.0]"), SPUN, HEAVY), ALWAYS | FREE_TOP),
    "free body": (
        scene(ASYMMETRIC, SPUN, ""),
        ALWAYS | {"wobble rate", "tumbling period", "separatrix distance"},
    ),
    "heavy body": (scene(ASYMMETRIC + "com = [0.1, 0.0, 0.0]", SPUN), ALWAYS),
    "sphere": (scene("mass = 1.0\ninertia = [1.0, 1.0, 1.0]", SPUN, ""), ALWAYS),
    "pushed body": (scene(ASYMMETRIC, SPUN, "[effects.torque]\nbody = [0.1, 0.0, 0.0]"), ALWAYS),
}


def values(scenario):
    return {fact.name: fact.value for fact in facts(scenario)}


@each_case(("scenario", "names"), SCENES)
def test_a_scene_has_the_facts_that_apply_each_once(scenario, names):
    assert sorted(fact.name for fact in facts(scenario)) == sorted(names)


def test_a_heavy_tops_facts_are_those_worked_out_by_hand():
    """I1 = 2, I3 = 1, κ = 10; Ω = 2, ω3 = 6 + 2 cos 60° = 7, so Ω² − 7 Ω + 10 = 0."""
    by_hand = {
        "I1": 2.0,
        "I3": 1.0,
        "M g l": 10.0,
        "sleeping threshold": math.sqrt(80),
        "p_gamma": 7.0,
        "p_alpha": 2 * 2 * 0.75 + 7 * 0.5,
        "energy": 2 * 4 * 0.75 / 2 + 49 / 2 + 5,
        "potential energy": 5.0,
        "E'": 3.0 + 5.0,
        "start angle": 60.0,
        "nutation from": 60.0,
        "nutation to": 60.0,
        "precession rate": 2.0,
        "steady precession, slow": 2.0,
        "steady precession, fast": 5.0,
        "sleeping ratio": 7 / math.sqrt(80),
        "small nutation": math.sqrt(5.25),
    }
    by_name = values(scene(TOP, STEADY))
    assert {name: by_name[name] for name in by_hand} == pytest.approx(by_hand, rel=ROUNDED)


def test_a_free_tops_facts_are_those_worked_out_by_hand():
    """About the com I1 = 1.5, I3 = 1; ω = (3, 0, 4), L = (4.5, 0, 4)."""
    size = math.hypot(4.5, 4)
    by_hand = {
        "angular momentum": size,
        "body cone rate": -4 / 3,
        "body cone period": math.tau * 3 / 4,
        "body cone angle": math.degrees(math.atan2(3, 4)),
        "precession rate": size / 1.5,
        "tilt": math.degrees(math.atan2(4.5, 4)),
    }
    by_name = values(scene(TOP, SPUN, ""))
    assert {name: by_name[name] for name in by_hand} == pytest.approx(by_hand, rel=ROUNDED)


def test_a_free_bodys_facts_are_those_worked_out_by_hand():
    """I = 3, 4, 6, ω = (3, 0, 4): L² = 81 + 576, 2 E = 27 + 96; wobble about axis 3."""
    by_hand = {
        "wobble rate": 4 * math.sqrt(3 * 2 / (3 * 4)),
        "separatrix distance": (657 - 4 * 123) / 657,
        "kinetic energy": 61.5,
    }
    by_name = values(scene(ASYMMETRIC, SPUN, ""))
    assert {name: by_name[name] for name in by_hand} == pytest.approx(by_hand, rel=ROUNDED)


def test_a_thrown_bodys_energy_has_its_flight_in_it():
    thrown = f"{SPUN}\nposition = [0.0, 0.0, 3.0]\nvelocity = [0.0, 2.0, 0.0]"
    by_name = values(scene(ASYMMETRIC, thrown, GRAVITY))
    assert by_name["kinetic energy"] == pytest.approx(61.5 + 2, rel=ROUNDED)
    assert by_name["potential energy"] == pytest.approx(30, rel=ROUNDED)


def test_about_the_middle_axis_a_growth_rate_is_shown():
    by_name = values(scene(ASYMMETRIC, SPUN.replace("[3.0, 0.0, 4.0]", "[0.1, 2.0, 0.1]"), ""))
    assert by_name["growth rate"] == pytest.approx(2 * math.sqrt(1 * 2 / (3 * 6)), rel=ROUNDED)


def test_the_spin_down_time_is_the_axial_moment_over_the_drag():
    assert values(scene(TOP, SPUN, DRAG))["spin-down time"] == 2.0


@each_case("scenario", library())
def test_every_scene_of_the_library_has_facts_without_nan(scenario):
    assert not any(math.isnan(fact.value) for fact in facts(scenario))
