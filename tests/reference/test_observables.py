"""Observables equal the exact values to the spline's accuracy, or are left out."""

import math
from functools import cache

import numpy as np
import pytest
from spincheck.reference.cross_check import cross_check
from spincheck.reference.facts import facts
from spincheck.reference.observables import SAMPLES_PER_PERIOD, axis_motion, observables
from spincheck.scenarios import Trajectory
from top_scenes import ASYMMETRIC, HEAVY, TOP, scene

WINDOW = "duration = 10.0\nsamples = 4001"
LOOPS = "euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [-1.0, 0.0, 20.0]"
STEADY = "euler_zyz_deg = [0, 60, 0]\neuler_zyz_rates = [2.0, 0.0, 6.0]"
PENDULUM = "euler_zyz_deg = [0, 100, 0]\nomega_body = [0.0, 0.0, 0.0]"
SPUN = "euler_zyz_deg = [20, 30, 0]\nomega_body = [3.0, 0.0, 4.0]"
FLIPPING = "euler_zyz_deg = [0, 0, 0]\nomega_body = [0.02, 15.0, 0.02]"

TOP_SIGHTS = {"nutation from", "nutation to", "nutation period", "precession rate"}
SCENES = {
    "loops": (scene(TOP, LOOPS, HEAVY, WINDOW), TOP_SIGHTS),
    "steady": (scene(TOP, STEADY, HEAVY, WINDOW), TOP_SIGHTS - {"nutation period"}),
    "pendulum": (scene(TOP, PENDULUM, HEAVY, WINDOW), TOP_SIGHTS - {"precession rate"}),
    "free top": (scene(TOP, SPUN, "", WINDOW), {"body cone rate", "precession rate"}),
    "flips": (scene(ASYMMETRIC, FLIPPING, "", WINDOW), {"tumbling period"}),
    "free body": (scene(ASYMMETRIC, SPUN, "", WINDOW), {"tumbling period"}),
    "heavy body": (scene(ASYMMETRIC + "com = [0.1, 0.0, 0.0]", SPUN, HEAVY, WINDOW), set()),
    "drag": (scene(TOP, LOOPS, f"{HEAVY}\n[effects.drag]\nrotational = 0.1", WINDOW), set()),
}


@cache
def motion_of(name):
    scenario, _ = SCENES[name]
    return cross_check(scenario, scenario.times).trajectory


def sights(name, motion=None):
    scenario, _ = SCENES[name]
    return {
        observable.name: observable
        for observable in observables(scenario, motion or motion_of(name))
    }


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_shows_what_its_scene_has(name):
    assert set(sights(name)) == SCENES[name][1]


@pytest.mark.parametrize("name", SCENES)
def test_the_exact_value_is_the_fact_of_that_name(name):
    by_fact = {fact.name: (fact.value, fact.unit) for fact in facts(SCENES[name][0])}
    for observable in sights(name).values():
        assert by_fact[observable.name] == (observable.exact, observable.unit)


#: 2.5 ms between samples; nothing here turns faster than 25 rad/s, and a cubic spline's times are
#: right to the third power of what turns between two samples.
SPLINE = (25 * 0.0025) ** 3


@pytest.mark.parametrize("name", SCENES)
def test_what_is_seen_is_the_exact_value(name):
    for observable in sights(name).values():
        assert observable.value == pytest.approx(observable.exact, rel=SPLINE, abs=SPLINE), (
            observable
        )


@pytest.mark.parametrize("name", [name for name, (_, observable) in SCENES.items() if observable])
def test_a_motion_a_hundredth_too_fast_is_seen_to_be(name):
    slow = motion_of(name)
    fast = Trajectory(
        slow.t / 1.01,
        slow.q_world_body_wxyz,
        slow.omega_body * 1.01,
        slow.com_world,
        slow.velocity_world * 1.01,
    )
    of_time = {"s", "rad/s"}
    for observable in sights(name, fast).values():
        if observable.unit in of_time:
            assert observable.value != pytest.approx(observable.exact, rel=10 * SPLINE), observable


def thinned(motion, every):
    return Trajectory(**{name: values[::every] for name, values in vars(motion).items()})


@pytest.mark.parametrize("name", [name for name, (_, observable) in SCENES.items() if observable])
def test_samples_too_far_apart_show_nothing(name):
    fastest = max(
        math.tau / abs(observable.exact) if observable.unit == "rad/s" else observable.exact
        for observable in sights(name).values()
        if observable.unit != "deg"
    )
    every = int(fastest / SAMPLES_PER_PERIOD / 0.0025) + 1
    assert set(sights(name, thinned(motion_of(name), every))) <= {"nutation from", "nutation to"}


def test_a_window_too_short_for_a_period_shows_nothing():
    assert sights("loops", motion_of("loops").until(20)) == {}


def test_a_body_that_stays_on_its_axis_shows_no_flips():
    """Whatever rounding makes of the two other components of ω."""
    scenario = scene(ASYMMETRIC, FLIPPING.replace("0.02, 15.0, 0.02", "0.0, 0.0, 5.0"), "", WINDOW)
    assert observables(scenario, cross_check(scenario, scenario.times).trajectory) == []


def test_azimuth_and_angle_are_those_of_a_uniform_precession():
    """An axis 0.3 rad from x goes round it at 2 rad/s."""
    times = np.linspace(0, 5, 501)
    spin = np.tile([2.0, 0.0, 0.0], (501, 1))
    zero = np.zeros((501, 3))
    half = times[:, None] * [1.0]
    q = np.column_stack([np.cos(half), np.sin(half), zero[:, :2]])
    motion = Trajectory(times, q, spin, zero, zero)
    axis = np.array([math.cos(0.3), math.sin(0.3), 0.0])
    moving = axis_motion(motion, axis, np.array([1.0, 0.0, 0.0]))
    rounding = 1e3 * np.finfo(float).eps
    assert moving.angle(times) == pytest.approx(np.full(501, 0.3), abs=rounding)
    assert np.ptp(moving.azimuth()(times) - 2 * times) < rounding
