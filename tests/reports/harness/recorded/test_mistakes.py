"""Usual mistakes in recording a motion, planted in an exact one, are named, and no others."""

from pathlib import Path

import numpy as np
import pytest
from library_scenes import library_scene
from planted_motions import case, exactly, product, rates_of
from spincheck.reference import solve
from spincheck.reports.harness.recorded.files.recording import Recording, RecordingError
from spincheck.reports.harness.recorded.fits.read_omega import OMEGA
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.samples import mistakes
from spincheck.scenarios import from_tables

pytestmark = pytest.mark.slow

TO_WORLD = "the quaternion takes world to body components"


TOP = library_scene("fast-top")
#: Of a recording: a mistake shows in the first of them, and times in ms are followed to the last.
SAMPLES = 81


def exact_at(scene, delay=0.0):
    """Arrays of a recording: states of a time `delay` in samples after the times beside them."""
    times = scene.times[:SAMPLES]
    motion = solve(scene, times + delay * times[1]).trajectory
    return {
        "t": times,
        "q": motion.q_world_body_wxyz,
        "omega": motion.omega_body,
        "omega_world": motion.to_world(motion.omega_body),
    }


def judged(scene, arrays):
    recorded = {name: arrays[name] for name in ("t", "q", "omega")}
    return judged_motion(scene, Recording(Path("motion.csv"), recorded))


def rolled(q_wxyz):
    return np.roll(q_wxyz, -1, axis=1)


CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
XYZW = "the quaternion's order is x y z w (state 'quaternion = xyzw')"
WORLD = "ω is in world axes (state 'omega = world')"
PLANTED = {
    "none": (lambda a, later: {}, []),
    "order": (lambda a, later: {"q": rolled(a["q"])}, [XYZW]),
    "conjugate": (lambda a, later: {"q": a["q"] * CONJUGATE}, [f"{TO_WORLD} (it is conjugated)"]),
    "both": (
        lambda a, later: {"q": rolled(a["q"] * CONJUGATE)},
        ["the quaternion's order is x y z w, and it takes world to body components"],
    ),
    "world": (lambda a, later: {"omega": a["omega_world"]}, [WORLD]),
    "sign": (lambda a, later: {"omega": -a["omega"]}, ["ω has the opposite sign"]),
    "degrees": (
        lambda a, later: {"omega": np.degrees(a["omega"])},
        ["ω is in degrees a second; wx [deg/s] says so"],
    ),
    "degrees that are none": (
        lambda a, later: {"omega": a["omega"] * np.pi / 180},
        ["ω is in rad/s already, and was converted from deg/s"],
    ),
    "turns": (lambda a, later: {"omega": a["omega"] / 2 / np.pi}, ["ω is in turns a second"]),
    "late": (
        lambda a, later: {"q": later(1)["q"], "omega": later(1)["omega"]},
        ["each state is that of one sample after its time"],
    ),
    "later": (
        lambda a, later: {"q": later(2)["q"], "omega": later(2)["omega"]},
        ["each state is that of 2 samples after its time"],
    ),
    "half a sample": (
        lambda a, later: {"q": later(0.5)["q"], "omega": later(0.5)["omega"]},
        ["each state is that of half a sample after its time"],
    ),
    "stale": (
        lambda a, later: {"q": later(1)["q"], "omega": a["omega"], "t": a["t"] + a["t"][1]},
        ["ω is one sample older than the attitude"],
    ),
    "ms": (lambda a, later: {"t": 1e3 * a["t"]}, ["the times are in ms; t [ms] says so"]),
    "min": (lambda a, later: {"t": a["t"] / 60}, ["the times are in min; t [min] says so"]),
    "columns in another order": (
        lambda a, later: {"omega": a["omega"][:, [2, 0, 1]]},
        ["ω is [wy, wz, wx] of its columns"],
    ),
    "a column with the other sign": (
        lambda a, later: {"omega": a["omega"] * [1, 1, -1]},
        ["ω is [wx, wy, -wz] of its columns"],
    ),
    "left-handed axes": (
        lambda a, later: {"q": a["q"] * [1, -1, 1, -1], "omega": a["omega"] * [-1, 1, -1]},
        ["its axes are left-handed, with y reversed"],
    ),
    "left-handed axes with y up": (
        lambda a, later: {
            "q": a["q"][:, [0, 1, 3, 2]] * [1, -1, -1, -1],
            "omega": -a["omega"][:, [0, 2, 1]],
        },
        ["its axes are left-handed, with y and z exchanged"],
    ),
    "two at once": (
        lambda a, later: {"q": rolled(a["q"]), "omega": a["omega_world"]},
        [XYZW, WORLD],
    ),
}


@pytest.mark.parametrize("name", ["fast-top", "book-middle-axis"])
@pytest.mark.parametrize("mistake", PLANTED)
def test_a_planted_mistake_is_named_and_no_other(name, mistake):
    scene = library_scene(name)
    plant, words = PLANTED[mistake]
    arrays = exact_at(scene)
    found = judged(scene, arrays | plant(arrays, lambda delay: exact_at(scene, delay)))
    assert list(found.explained_by) == words
    assert (found.exceeds_1deg_at is None) or words


TUMBLING = [case(7), case(8, is_pivoted=True)]
OF_TIMES = {
    "one state in ten": (
        lambda a: {name: a[name][::10] for name in ("q", "omega")} | {"t": a["t"][:21]},
        ["the times are 10 times too short, as where one state in so many is kept"],
    ),
    "half the timestep": (
        lambda a: {"t": 2 * a["t"]},
        ["the times are 2 times too long, as of another timestep than that of the steps"],
    ),
}


@pytest.mark.parametrize("body", TUMBLING)
@pytest.mark.parametrize("mistake", OF_TIMES)
def test_times_of_other_steps_are_told(body, mistake):
    plant, words = OF_TIMES[mistake]
    arrays = exactly(body, rates_of(body))
    assert list(judged(body.scenario, arrays | plant(arrays)).explained_by) == words


@pytest.mark.parametrize("factor", [2.0, np.pi / 180])
@pytest.mark.parametrize("body", TUMBLING)
def test_an_attitude_that_does_not_follow_omega_has_no_other_times(body, factor):
    """Of times so short that nothing moves, or of an ω that hardly changes, both might be said."""

    def turning(q, omega):
        return product(q, factor * np.array([0, *omega])) / 2

    words = judged(body.scenario, exactly(body, rates_of(body, turning=turning))).explained_by
    assert words[0].startswith("ω obeys Euler's equations, but the attitude does not follow ω: ")


@pytest.mark.parametrize("how", ["held", "interpolated linearly"])
@pytest.mark.parametrize("body", TUMBLING)
@pytest.mark.parametrize("count", [2, 10])
def test_an_omega_that_is_new_at_one_sample_in_some_is_told(body, how, count):
    arrays = exactly(body, rates_of(body))
    t, new = arrays["t"], arrays["t"][::count]
    if how == "held":
        omega = np.repeat(arrays["omega"][::count], count, axis=0)[: len(t)]
    else:
        omega = np.transpose([np.interp(t, new, rates[::count]) for rates in arrays["omega"].T])
    (words,) = judged(body.scenario, arrays | {"omega": omega}).explained_by
    assert words == f"ω is {how}: it is new at one sample in {count} only; record those alone"


def test_a_start_that_is_not_the_scenes_is_told_with_its_size():
    arrays = exact_at(TOP)
    arrays |= {"q": np.tile([1.0, 0, 0, 0], (len(arrays["t"]), 1)), "omega": 0 * arrays["omega"]}
    (words,) = judged(TOP, arrays).explained_by
    assert words == "it started elsewhere: at t = 0 s the attitude is off by 30° and ω by 40 rad/s"


@pytest.mark.parametrize("left_out", [(), ("omega",)])
def test_two_samples_have_mistakes_too(left_out):
    arrays = {name: rows[:2] for name, rows in exact_at(TOP).items() if name not in left_out}
    arrays["q"] = arrays["q"] * CONJUGATE
    found = judged_motion(TOP, Recording(Path("motion.csv"), arrays))
    assert list(found.explained_by) == PLANTED["conjugate"][1]


def sphere(tilt):
    """About an axis that stays, started so far from upright, rad: ω is nearly alike in all axes."""
    tables = {
        "title": "Sphere",
        "source": "made up",
        "body": {"mass": 1.0, "inertia": np.eye(3).tolist()},
        "start": {
            "quaternion_wxyz": [np.cos(tilt / 2), np.sin(tilt / 2), 0.0, 0.0],
            "omega_body": [0.0, 0.0, 2.0],
        },
        "window": {"duration": 1.0, "samples": 21},
    }
    return from_tables(tables, "sphere")


def test_of_two_samples_none_is_dropped_to_make_a_mistake_fit():
    """Of the last alone any ω would be as it should be: here it is the same at both."""
    scene = sphere(0.0)
    arrays = {name: rows[:2].copy() for name, rows in exact_at(scene).items()}
    arrays["q"][0] = np.cos(0.05), np.sin(0.05), 0.0, 0.0
    (words,) = judged(scene, arrays).explained_by
    assert words.startswith("it started elsewhere")


@pytest.mark.parametrize(("tilt", "words"), [(0.5e-9, []), (2e-9, [WORLD])])
def test_an_error_below_a_billionth_needs_no_explanation(tilt, words):
    scene = sphere(tilt)
    arrays = exact_at(scene)
    found = judged(scene, arrays | {"omega": arrays["omega_world"]}).explained_by
    assert list(found) == words


def test_no_motion_is_followed_for_hours_to_see_whether_its_times_are_minutes(monkeypatch):
    followed = []

    def follow(equations, states, spans):
        followed.append(float(spans.sum()))
        return mistakes_follow(equations, states, spans)

    mistakes_follow = mistakes.follow
    monkeypatch.setattr(mistakes, "follow", follow)
    times = np.array([0.0, 5.0, 10.0, 15.0])
    motion = solve(TOP, times).trajectory
    arrays = {"t": times, "q": motion.q_world_body_wxyz, "omega": -motion.omega_body}
    assert judged(TOP, arrays).explained_by == ("ω has the opposite sign",)
    fastest = np.linalg.norm(motion.omega_body, axis=1).max()
    assert (
        times[-1] * fastest < max(followed) * fastest < mistakes.FURTHEST < 60 * times[-1] * fastest
    )


def test_no_unit_is_named_that_only_makes_a_wrong_omega_small():
    """Of an ω that is nothing like the exact one, one of zero is nearer to it."""
    arrays = exact_at(TOP)
    words = judged(TOP, arrays | {"omega": 30 * np.roll(arrays["omega"], 1, axis=1)}).explained_by
    assert not any("degrees" in one or "turns" in one for one in words)


def test_an_error_that_no_mistake_explains_has_none_and_times_far_off_are_of_another_unit():
    arrays = exact_at(TOP)
    drifting = 1 + 0.01 * arrays["t"][:, None]
    assert judged(TOP, arrays | {"omega": arrays["omega"] * drifting}).explained_by == (OMEGA,)
    with pytest.raises(RecordingError, match=r"reach 1e\+06 s, .* from its start, .* t \[us\]"):
        judged(TOP, arrays | {"t": 1e6 * arrays["t"]})
