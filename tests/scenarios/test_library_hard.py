"""What makes the hard scenes hard, where numbers of the file can tell."""

import re
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from case_loops import each_case
from library_scenes import library
from mpmath import mp
from spincheck.scenarios import LIBRARY, Scenario
from spincheck.scenarios.exact import DIGITS

EPS = float(np.finfo(float).eps)
HARD = [scene for scene in library() if scene.path.is_relative_to(LIBRARY / "hard")]
KINDS = ("free", "thrown", "heavy", "driven")
FEWEST_SCENES = 40
#: Words too few to say what is hard, and for which method.
FEWEST_WORDS = 8
#: Doubles round a distance of 1e-14 by some hundredths of it.
ROUNDED = 0.05
#: A scene of another distance, spin or size must fail: it is off by this factor at the least.
FAULT = 10.0
#: Rods, by the moment about them over those across.
RODS = {"rod-1e-6": 1e-6, "rod-1e-12": 1e-12, "needle-in-skew-axes": 1e-8}
#: rad: six rungs of a ladder from 0.2 rad a step take fewer than 2^20 steps.
LADDER_TURN_RAD = 6500.0
#: A number of a scene.
Quantity = Callable[[Scenario], float | Fraction]


def scene(name: str) -> Scenario:
    (named,) = (scenario for scenario in HARD if scenario.name == name)
    return named


def fractions(values) -> list[Fraction]:
    return [Fraction(float(x)) for x in values]


def moments(scenario: Scenario) -> list[Fraction]:
    """Moments about the com of a body given by its moments, exactly as typed."""
    return fractions(scenario.body.inertia_com.diagonal())


def near(computed: float | Fraction, stated: float, within: float) -> bool:
    """Equal but for a share."""
    return abs(computed - stated) <= within * abs(stated)


every_hard_scene = each_case("scenario", HARD)


@each_case("kind", KINDS)
def test_there_are_enough_hard_scenes_and_of_every_kind(kind: str) -> None:
    assert len(HARD) >= FEWEST_SCENES
    assert any(kind in scenario.document.tags for scenario in HARD)


@every_hard_scene
def test_a_hard_scene_says_that_it_is_and_in_its_first_sentence_what_is_hard(
    scenario: Scenario,
) -> None:
    assert scenario.document.tags[0] == "hard"
    first = re.split(r"[.?!]\s", scenario.document.description.strip())[0]
    assert len(first.split()) >= FEWEST_WORDS
    assert first.split() != scenario.document.title.split()


@every_hard_scene
def test_a_full_ladder_of_timesteps_fits(scenario: Scenario) -> None:
    """A million turns are for the reference, not for an engine."""
    if scenario.name == "million-turns":
        return
    turn = np.linalg.norm(scenario.start.omega_body) * scenario.window.duration
    assert turn <= LADDER_TURN_RAD


def beyond_separatrix(scenario: Scenario) -> Fraction:
    """(L² − 2T I₂)/2T I₂ of a body in principal axes, exactly; the sign tells the side."""
    inertia, omega = moments(scenario), fractions(scenario.start.omega_body)
    L_squared = sum((i * w) ** 2 for i, w in zip(inertia, omega, strict=True))
    twice_energy = sum(i * w**2 for i, w in zip(inertia, omega, strict=True))
    return L_squared / (twice_energy * sorted(inertia)[1]) - 1


def excess(low: int, high: int) -> Quantity:
    """By which part of itself one of the ascending moments exceeds another."""
    return lambda scenario: sorted(moments(scenario))[high] / sorted(moments(scenario))[low] - 1


def about_the_rod(scenario: Scenario) -> float:
    least, _, most = scenario.body.principal_moments
    return least / most


def across_the_rod(scenario: Scenario) -> float:
    """The difference of the moments across it, over that about it."""
    least, middle, most = scenario.body.principal_moments
    return (most - middle) / least


def speed(scenario: Scenario) -> float:
    return float(np.linalg.norm(scenario.start.omega_body))


def flatness(scenario: Scenario) -> float:
    low, middle, high = scenario.body.principal_moments
    return high / (low + middle)


def driven_over_braked(scenario: Scenario) -> float:
    braking = scenario.pushed["drag"] * scenario.start.omega_body[2]
    return scenario.pushed["torque_body"][2] / braking


def tilt_of_the_axle(scenario: Scenario) -> float:
    inertia = scenario.body.inertia_com
    return inertia[0, 2] / (inertia[2, 2] - inertia[0, 0])


#: By scene: a quantity of its numbers, what it is said to be, and the part that it may be off.
STATED: list[tuple[str, Quantity, float, float]] = [
    ("separatrix-within-1e-3", beyond_separatrix, 1e-3, ROUNDED),
    ("separatrix-within-1e-6", beyond_separatrix, 1e-6, ROUNDED),
    ("separatrix-below-by-1e-6", beyond_separatrix, -1e-6, ROUNDED),
    ("separatrix-within-1e-10", beyond_separatrix, 1e-10, ROUNDED),
    ("separatrix-below-by-1e-14", beyond_separatrix, -1e-14, ROUNDED),
    (
        "middle-axis-off-by-1e-8",
        lambda scenario: abs(scenario.start.omega_body[0] / scenario.start.omega_body[1]),
        *(1e-8, 8 * EPS),
    ),
    ("moments-equal-to-1e-14-prolate", excess(1, 2), 1e-14, ROUNDED),
    ("moments-equal-to-1e-14-end-over-end", excess(1, 2), 1e-14, ROUNDED),
    ("moments-equal-to-1e-14-oblate", excess(0, 1), 1e-14, ROUNDED),
    ("moments-all-equal-to-1e-14", excess(0, 1), 1e-14, ROUNDED),
    ("moments-all-equal-to-1e-14", excess(1, 2), 1e-14, ROUNDED),
    # Where rounding of the large ones leaves some digits.
    *((name, about_the_rod, part, EPS / part + 1e-6) for name, part in RODS.items()),
    *((name, across_the_rod, 0.5, 4 * EPS / RODS[name]) for name in [*RODS][1:]),
    ("spin-of-1e-6", speed, 1e-6, ROUNDED),
    ("steel-ball-at-40-million-rpm", speed, 40e6 * 2 * np.pi / 60, ROUNDED),
    (
        "million-turns",
        lambda scenario: speed(scenario) * scenario.window.duration / (2 * np.pi),
        *(1e6, ROUNDED),
    ),
    ("tennis-racket-thrown", flatness, 1.0, 8 * EPS),
    ("reaction-wheel", driven_over_braked, 1.0, 8 * EPS),
    ("reaction-wheel", tilt_of_the_axle, 4e-5, 0.2),
]


@each_case(("name", "quantity", "stated", "within"), STATED)
def test_a_number_is_the_one_stated_on_its_side_and_no_ten_times_as_large(
    name: str, quantity: Quantity, stated: float, within: float
) -> None:
    computed = quantity(scene(name))
    assert near(computed, stated, within)
    assert not near(computed, FAULT * stated, within)
    assert not near(computed, -stated, within)


def test_one_starts_on_the_separatrix_to_the_last_bit() -> None:
    assert beyond_separatrix(scene("separatrix-exactly")) == 0
    assert beyond_separatrix(scene("separatrix-below-by-1e-14")) != 0


def test_a_steady_spin_about_the_middle_axis_has_no_other_component() -> None:
    scenario = scene("middle-axis-exactly")
    middle = int(np.argsort(scenario.body.inertia_com.diagonal())[1])
    assert [k for k in range(3) if scenario.start.omega_body[k]] == [middle]


def test_told_in_skew_axes_the_spin_is_about_the_middle_axis_exactly() -> None:
    scenario = scene("middle-axis-in-skew-axes")
    tensor = [fractions(row) for row in scenario.body.inertia_com]
    omega = fractions(scenario.start.omega_body)
    L = [sum(a * w for a, w in zip(row, omega, strict=True)) for row in tensor]
    ratio = L[0] / omega[0]
    assert [ratio * w for w in omega] == L
    assert near(ratio, scenario.body.principal_moments[1], 8 * EPS)
    assert all(omega)


def test_the_plate_has_no_thickness_in_exact_numbers() -> None:
    scenario = scene("plate-of-particles")
    tensor = scenario.body.inertia_com_exact
    assert tensor[0][2] == tensor[1][2] == 0
    with mp.workdps(DIGITS):
        excess = tensor[0][0] + tensor[1][1] - tensor[2][2]
        assert abs(excess) <= EPS**2 * tensor[2][2]


@each_case(
    ("name", "mass", "length"),
    [
        ("dust-grain", 1e-15, 1e-6),
        ("grain-of-sand", 1e-6, 1e-3),
        ("haumea-wobbling", 1e21, 1e6),
        ("toutatis", 1e13, 1e3),
        ("earth-polar-motion", 1e25, 1e6),
    ],
)
def test_body_is_of_the_size_stated(name: str, mass: float, length: float) -> None:
    """Radius of gyration √(I/m) and mass, within a factor of ten."""
    body = scene(name).body
    gyration = np.sqrt(body.principal_moments[2] / body.mass)
    assert 1 / FAULT < body.mass / mass < FAULT
    assert 1 / FAULT < gyration / length < FAULT


@each_case(
    ("name", "cosine"),
    [
        ("wobble-through-the-pole", 1),
        ("end-over-end-through-both-poles", 1),
        ("tumbling-from-the-lower-pole", -1),
    ],
)
def test_the_body_starts_with_its_axis_on_the_vertical_exactly(name: str, cosine: int) -> None:
    w, x, y, z = scene(name).start.q_exact
    assert ((x, y) if cosine == 1 else (w, z)) == (0, 0)


def test_end_over_end_the_axis_passes_through_both_poles() -> None:
    """It turns about a level axis across its own."""
    scenario = scene("end-over-end-through-both-poles")
    omega = scenario.start.omega_body
    assert omega[0] == omega[2] == 0
    assert np.array_equal(scenario.start.q_world_body_wxyz, [1.0, 0.0, 0.0, 0.0])


def test_the_wobble_brings_the_axis_back_to_the_pole() -> None:
    """The axis goes round L, and begins on the vertical, which is not along L."""
    scenario = scene("wobble-through-the-pole")
    L = scenario.body.inertia_com @ scenario.start.omega_body
    assert L[0] != 0
    precession = np.linalg.norm(L) / scenario.body.inertia_com[0, 0]
    assert precession * scenario.window.duration > 2 * np.pi


def test_drag_lasts_for_many_e_foldings() -> None:
    scenario = scene("drag-until-rest")
    slowest = scenario.pushed["drag"] / scenario.body.principal_moments[2]
    assert np.exp(-slowest * scenario.window.duration) < 1e-13


def test_stiff_drag_has_rates_ten_thousand_times_apart() -> None:
    scenario = scene("stiff-drag")
    least, middle, _ = scenario.body.principal_moments
    assert middle / least >= 1e4
    assert scenario.pushed["drag"] / least * scenario.window.duration >= 1e4


@each_case("name", ["torque-to-high-spin", "torque-about-the-middle-axis", "pushed-from-rest"])
def test_driven_from_exactly_zero(name: str) -> None:
    assert not scene(name).start.omega_body.any()


def test_far_from_the_origin_is_far_for_single_precision() -> None:
    start = scene("far-from-the-origin").start
    assert np.finfo(np.float32).eps * np.abs(start.position_world).max() > 1.0  # m
