"""What a recorded com and velocity are in place of those of the motion."""

import numpy as np
import pytest
from honest_library import arrays_of
from library_scenes import library_scene
from reported_faults import Arrays, judged
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.scenarios import Scenario, from_tables
from spincheck.scenarios.rotation import matrices, turned_back

pytestmark = pytest.mark.slow

COM, OMEGA = np.array([0.2, -0.15, 0.1]), np.array([1.5, -2.0, 1.0])
THROWN = from_tables(
    {
        "title": "Thrown",
        "source": "made up",
        "body": {"mass": 2.0, "inertia": np.diag([0.2, 0.25, 0.3]).tolist(), "com": COM.tolist()},
        "start": {
            "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0],
            "omega_body": OMEGA.tolist(),
            "position": [0.0, 0.0, 1.5],
            "velocity": [1.2, -0.7, 4.0],
        },
        "effects": {"gravity": {"acceleration": [0.0, 0.0, -9.81]}},
        "window": {"duration": 2.0, "samples": 101},
    },
    "thrown",
)
MOTION = solve(THROWN, THROWN.times).trajectory
R = matrices(MOTION.q_world_body_wxyz)
V, SWING = MOTION.velocity_world, np.einsum("nij,nj->ni", R, np.cross(MOTION.omega_body, COM))
RIGHT = {
    "t": MOTION.t,
    "q": MOTION.q_world_body_wxyz,
    "omega": MOTION.omega_body,
    "com": MOTION.com_world,
    "velocity": V,
}
#: North, east and down of axes that are east, north and up.
NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
PLANTED = {
    "velocity in body axes": (
        {"velocity": turned_back(R, V)},
        "the velocity is in body axes; it is to be in world axes",
    ),
    "velocity of the origin": (
        {"velocity": V - SWING},
        "the velocity is that of the body's origin; it is to be that of the com",
    ),
    "velocity of the origin in body axes": (
        {"velocity": turned_back(R, V - SWING)},
        "the velocity is that of the body's origin, in body axes; it is to be that of the com, in "
        "world axes",
    ),
    "the origin": (
        {"com": MOTION.com_world - R @ COM},
        "x y z are those of the body's origin; they are to be those of the com",
    ),
    "north, east and down": (
        {"com": MOTION.com_world @ NED.T, "velocity": V @ NED.T},
        "x y z are along the world's axes [y, x, -z]",
        "the velocity is along the world's axes [y, x, -z]",
    ),
    "downwards": (
        {"velocity": V * [1, 1, -1]},
        "the velocity is along the world's axes [x, y, -z]",
    ),
    "millimetres": (
        {"com": 1e3 * MOTION.com_world, "velocity": 1e3 * V},
        "x y z are in mm; x [mm] says so",
        "the velocity is in mm/s; vx [mm/s] says so",
    ),
    "half of the gravity": (
        {"com": MOTION.com_world + 0.5 * 9.81 / 2 * np.outer(MOTION.t**2, [0, 0, 1.0])},
        "the com is not that of the motion: it is off by up to 9.81 m, ",
    ),
    # Its numbers are round, so that few digits show them all.
    "without gravity": (
        {"com": MOTION.com_world[0] + np.outer(MOTION.t, V[0])},
        "the com is not that of the motion: it is off by up to 19.6 m, ",
    ),
    "another velocity at the start": (
        {
            "com": MOTION.com_world + np.outer(MOTION.t, [0.3, 0, 0]),
            "velocity": V + np.array([0.3, 0, 0]),
        },
        "the com started with another velocity: it is off by 0.3 m/s at t = 0 s",
    ),
    "half of the velocity": (
        {"velocity": V / 2},
        "the velocity is not that of the motion: it is off by up to ",
    ),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_a_translation_that_is_another_is_named(fault):
    arrays, *words = PLANTED[fault]
    found = judged(THROWN, RIGHT | arrays, 1e-3)
    assert len(found.explained_by) == len(words)
    for said, one in zip(found.explained_by, words, strict=True):
        assert said.startswith(one)
    assert found.is_another


HONEST = {
    "in full": {},
    "counted from elsewhere": {"com": MOTION.com_world + np.array([3.0, -1.0, 0.5])},
    "semi-implicit Euler": {
        "com": MOTION.com_world - 1e-3 * np.outer(MOTION.t, [0, 0, 9.81 / 2]),
        "velocity": V,
    },
    "half a step later": {"velocity": V - 0.5e-3 * np.array([0, 0, 9.81])},
    "noise": {"com": MOTION.com_world + np.random.default_rng(3).normal(0, 0.05, (101, 3))},
    "three digits": {
        name: np.vectorize(lambda x: float(f"{x:.3g}"))(RIGHT[name]) for name in ("com", "velocity")
    },
}


@pytest.mark.parametrize("how", HONEST)
def test_an_honest_translation_is_not_accused(how):
    assert judged(THROWN, RIGHT | HONEST[how], 1e-3).explained_by == ()


def exact_of(scene: str) -> tuple[Scenario, Arrays]:
    """A scene of the library, and its exact motion as it is recorded."""
    scenario = library_scene(scene)
    motion = solve(scenario, scenario.times).trajectory
    names = {"t": "t", "q": "q_world_body_wxyz", "omega": "omega_body", "com": "com_world"}
    return scenario, {name: np.array(getattr(motion, of)) for name, of in names.items()}


#: What a com in mm may be off by besides, mm: a step of semi-implicit Euler, rounding, noise.
BESIDES = {
    "a method's error": lambda com: com - 0.5 * np.outer(MOTION.t, [0, 0, 9.81]),
    "rounding to 1 mm": np.rint,
    "noise": lambda com: com + np.random.default_rng(3).normal(0, 1, com.shape),
    "another origin": lambda com: com + np.array([0.0, 0.0, 10.0]),
}


@pytest.mark.parametrize("besides", BESIDES)
def test_a_unit_is_named_beside_a_small_error(besides):
    arrays = {"com": BESIDES[besides](1e3 * MOTION.com_world)}
    assert judged(THROWN, RIGHT | arrays, 1e-3).explained_by == ("x y z are in mm; x [mm] says so",)


def test_a_com_that_hardly_moves_is_in_no_smaller_unit():
    """The velocity of the com is rounding alone, which any smaller unit would make smaller."""
    scene, arrays = exact_of("asleep-at-the-threshold")
    off = {"velocity": np.random.default_rng(2).normal(0, 1e-6, arrays["com"].shape)}
    assert not any("is in" in one for one in judged(scene, arrays | off, 1e-3).explained_by)


@pytest.mark.parametrize("off", [1e-17, np.array([1.0, 2.0, 3.0])])
def test_a_com_that_rests_at_the_origin_says_nothing_of_units(off):
    """It is zero in every unit."""
    scene, arrays = exact_of("tennis-racket")
    assert not judged(scene, arrays | {"com": arrays["com"] + off}, None).is_another


@pytest.mark.parametrize(
    ("scene", "com"),
    [
        ("fast-top", lambda com: np.repeat(com[:1], len(com), axis=0)),
        ("fast-top", lambda com: com + np.array([1.0, 2.0, 3.0])),
        ("gliding-top", lambda com: com - np.array([0, 0, 0.1])),
    ],
)
def test_where_a_constraint_holds_it_a_com_follows_from_the_attitude(scene, com):
    scenario, arrays = exact_of(scene)
    (words,) = judged(scenario, arrays | {"com": com(arrays["com"])}, None).explained_by
    assert words.startswith("the com is not that of the motion: it is off by up to ")
    assert not judged(scenario, arrays, None).is_another


def test_along_a_table_a_com_may_be_counted_from_elsewhere():
    scenario, arrays = exact_of("gliding-top")
    elsewhere = arrays | {"com": arrays["com"] + np.array([1.0, 2.0, 0.0])}
    assert not judged(scenario, elsewhere, None).is_another


@pytest.mark.parametrize(
    ("name", "method", "timestep", "steps"),
    [
        # The tip of a fast top on glass is pulled round the com, by 3 m/s² here.
        ("dental-top-on-glass", "implicit", 1e-5, 20_000),
        # Of a wheel at 10 000 rad/s forces of 1 000 N cancel.
        ("watch-wheel", "RK4", 2e-3, 10_000),
    ],
)
def test_an_engine_may_move_a_com_that_rests(name, method, timestep, steps):
    scenario, engine = library_scene(name), engines()["mujoco"]
    samples = np.arange(0, steps + 1, steps // 200)
    motion = engine.run(scenario, engine.method(method), timestep, samples).trajectory
    assert judged(scenario, arrays_of(motion), timestep).explained_by == ()


@pytest.mark.parametrize("timestep", [1e-4, 1e-3])
def test_a_tilted_table_is_told_of_a_fast_top(timestep):
    scenario, arrays = exact_of("gliding-top")
    com = arrays["com"] + [0.085, 0, 0] * arrays["t"][:, None] ** 2
    (words,) = judged(scenario, arrays | {"com": com}, timestep).explained_by
    assert words.startswith("the com is not that of the motion")
