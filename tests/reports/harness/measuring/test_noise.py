"""Every source of noise is what it is derived to be, and is none where it does not act."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from spincheck.engines import State
from spincheck.engines.checks.equations import Equations
from spincheck.reports.harness.measuring.noise import (
    NO_SIZE,
    NOISE,
    SOLVED,
    ULPS,
    noise_of,
    noise_of_steps,
    rounding_of_body,
    term_sizes,
    weakest_effects,
)
from spincheck.reports.harness.measuring.steps import Steps, flowed
from spincheck.scenarios import Scenario
from stepped import SteppedEngine
from top_scenes import GRAVITY, PIVOT, scene

EPS, EPS_SINGLE = (float(np.finfo(kind).eps) for kind in (np.float64, np.float32))
#: A sphere that spins about x: kg m², kg, rad/s and m/s.
MOMENT, MASS, SPEED, FLIGHT = 2.0, 0.5, 8.0, 4.0
#: m; of a free sphere the radius of gyration.
GYRATION, ARM = 2.0, 0.25
#: s.
TIMESTEPS = np.array([1e-2, 1e-4])
ATTITUDE, TORQUE, VELOCITY, PLACE = range(4)
#: Sums and products of a few numbers.
SURE = 32 * EPS


def sphere(effects: str = "", com: float = 0.0, flight: float = 0.0) -> Scenario:
    """With its com along z, the moments about it alike."""
    return scene(
        f"mass = {MASS}\ninertia = [{MOMENT}, {MOMENT}, {MOMENT}]\ncom = [0.0, 0.0, {com}]",
        f"quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]\nomega_body = [{SPEED}, 0.0, 0.0]"
        + (f"\nvelocity = [0.0, {flight}, 0.0]" if flight else ""),
        effects,
    )


def steps_of(scenario: Scenario) -> Steps:
    """One from the start with each timestep, which gains nothing."""
    start = scenario.start
    flight = start.position_world, start.velocity_world
    rows = start.q_world_body_wxyz, start.omega_body, *flight, scenario.start_spins
    states = State(*(np.tile(np.array(row, float), (len(TIMESTEPS), 1)) for row in rows))
    after = flowed(scenario, states, TIMESTEPS)
    return Steps(TIMESTEPS, TIMESTEPS, states, after, after)


def noise(scenario: Scenario, condition: float = 0.0, *, settled: bool = False, **as_if: object):
    """Of each timestep and quantity, (2, 4)."""
    engine = type("Made", (SteppedEngine,), {"slack": 0.0})(**as_if)
    steps = steps_of(scenario)
    return noise_of(Equations(scenario), steps, engine, condition, settled=settled)[:, 0]


def test_a_reading_is_off_by_some_ulp_of_each_number_over_the_timestep() -> None:
    found = noise(sphere())
    np.testing.assert_allclose(found[:, ATTITUDE], ULPS * EPS / TIMESTEPS, rtol=SURE)
    np.testing.assert_allclose(found[:, TORQUE], ULPS * EPS * MOMENT * SPEED / TIMESTEPS, rtol=SURE)
    fast = ULPS * EPS * GYRATION * SPEED / TIMESTEPS
    np.testing.assert_allclose(found[:, VELOCITY], fast, rtol=SURE)
    np.testing.assert_allclose(found[:, PLACE], ULPS * EPS * GYRATION / TIMESTEPS, rtol=SURE)


def test_of_a_body_on_a_pivot_place_and_velocity_are_no_rates() -> None:
    found = noise(sphere(PIVOT, ARM)) / (ULPS * EPS)
    # Of the arm, and of where and how fast the com is.
    assert ((found[:, VELOCITY] >= ARM * SPEED) & (found[:, VELOCITY] <= 2 * ARM * SPEED)).all()
    assert ((found[:, PLACE] >= ARM) & (found[:, PLACE] <= 2 * ARM)).all()


def test_in_single_precision_it_is_of_24_bits_and_less_in_the_mean_of_repeats() -> None:
    single, double = noise(sphere(), single_precision=True), noise(sphere())
    np.testing.assert_allclose(single / double, EPS_SINGLE / EPS, rtol=SURE)
    steps = steps_of(sphere())
    engine = SteppedEngine(single_precision=True)
    four = replace(
        steps,
        spans=np.repeat(TIMESTEPS, 4),
        before=steps.before.rows(np.repeat([0, 1], 4)),
        after=steps.after.rows(np.repeat([0, 1], 4)),
        repeats=4,
    )
    equations = Equations(sphere())
    of_one, of_four = (noise_of(equations, s, engine, 0.0, settled=False) for s in (steps, four))
    np.testing.assert_allclose(of_one / of_four, 2.0, rtol=SURE)


def test_a_body_that_is_held_to_a_slack_gains_as_much_of_the_largest_terms() -> None:
    engine = type("Slack", (SteppedEngine,), {"slack": 1e-6})()
    steps, equations = steps_of(sphere()), Equations(sphere())
    found = noise_of(equations, steps, engine, 0.0, settled=False)[:, 0]
    sizes = term_sizes(equations, steps)
    assert sizes[TORQUE] == pytest.approx(2 * MOMENT * SPEED**2, rel=0.5 + SURE)
    np.testing.assert_allclose(found, np.broadcast_to(1e-6 * sizes, found.shape), rtol=1e-6)


def test_moments_that_differ_round_by_the_condition_of_the_tensor() -> None:
    """As a torque, and by how far that turns the body in a step."""
    condition = 1e12
    rounding = rounding_of_body(condition)
    assert rounding == ULPS * EPS * condition
    found, sizes = (
        noise(sphere(), condition),
        term_sizes(Equations(sphere()), steps_of(sphere())),
    )
    # It is of the body as it is held, and of the solution.
    np.testing.assert_allclose(found[:, TORQUE], 2**0.5 * rounding * sizes[TORQUE], rtol=1e-6)
    turned = rounding * SPEED * np.hypot(1.0, np.minimum(1.0, TIMESTEPS * SPEED / 2))
    np.testing.assert_allclose(found[:, ATTITUDE], turned, rtol=1e-6)


def test_flight_is_a_torque_with_the_speed_of_what_engines_move() -> None:
    """The com's, and that of the body's origin around it."""
    fast = 1e9
    flying = noise(sphere(flight=fast))
    np.testing.assert_allclose(flying[:, TORQUE], ULPS * EPS * MASS * fast**2, rtol=1e-3)
    far = 1e6
    np.testing.assert_allclose(
        noise(sphere(com=far))[:, TORQUE], ULPS * EPS * MASS * (far * SPEED) ** 2, rtol=1e-3
    )


def test_a_place_that_is_held_is_corrected_by_its_rounding_in_a_step() -> None:
    held = library_scene("dental-top-on-glass")
    found = noise(held)[:, VELOCITY]
    far = np.linalg.norm(held.start.position_world) + Equations(held).reach
    # With the timestep so short nothing else is as large.
    corrected = ULPS * EPS * far / TIMESTEPS[1] ** 2
    assert found[1] == pytest.approx(corrected, rel=0.05)


def test_a_turn_that_a_solver_leaves_out_counts_where_a_constraint_settled() -> None:
    left_out = 1e-6
    settled, not_settled = (
        noise(sphere(), settled=is_settled, least_turn=left_out) for is_settled in (True, False)
    )
    np.testing.assert_allclose(settled[:, ATTITUDE], left_out / TIMESTEPS, rtol=1e-6)
    # A solver leaves something of every quantity.
    left = np.hypot(not_settled, SOLVED * term_sizes(Equations(sphere()), steps_of(sphere())))
    np.testing.assert_allclose(settled[:, TORQUE:], left[:, TORQUE:], rtol=1e-12)
    np.testing.assert_array_equal(not_settled, noise(sphere()))


def test_rotors_round_the_forces_that_cancel_between_them() -> None:
    fast = library_scene("wheel-in-a-box")
    steps, still = steps_of(fast), steps_of(fast)
    still = replace(still, before=replace(still.before, spins=0.0 * still.before.spins))
    equations, engine = Equations(fast), SteppedEngine()
    with_force, without = (
        noise_of(equations, one, engine, 0.0, settled=False)[:, 0] for one in (steps, still)
    )
    force, _ = fast.cancelling(np.abs(steps.before.spins))
    forced = ULPS * EPS * force / fast.body.mass
    gained = np.sqrt(with_force**2 - without**2)
    np.testing.assert_allclose(gained[:, VELOCITY], forced, rtol=1e-3, atol=forced.max() / 1e3)


def test_noise_that_is_no_fault_is_of_the_fastest_state() -> None:
    found = noise_of_steps(Equations(sphere()), steps_of(sphere()))[:, 0]
    np.testing.assert_allclose(found[:, ATTITUDE], NOISE / TIMESTEPS, rtol=SURE)


def test_nothing_is_divided_by_no_size() -> None:
    rest = sphere()
    still = steps_of(rest)
    still = replace(still, before=replace(still.before, omega_body=0.0 * still.before.omega_body))
    assert (term_sizes(Equations(rest), still) >= NO_SIZE).all()


def test_the_weakest_effect_is_the_least_that_is_not_absent() -> None:
    """Weight of a body that is held is a torque, of a free one an acceleration."""
    held, free = sphere(f"{PIVOT}\n{GRAVITY}", ARM), sphere(GRAVITY)
    least = weakest_effects(Equations(held), steps_of(held))
    assert least[TORQUE] == pytest.approx(MASS * 10.0 * ARM)
    assert np.isinf(np.delete(least, TORQUE)).all()
    least = weakest_effects(Equations(free), steps_of(free))
    assert least[VELOCITY] == pytest.approx(10.0)
    assert np.isinf(np.delete(least, VELOCITY)).all()
    pushed = sphere(f"{GRAVITY}\n[effects.drag]\nrotational = 1e-3")
    least = weakest_effects(Equations(pushed), steps_of(pushed))
    assert least[TORQUE] == pytest.approx(1e-3 * SPEED)
    # As good as none: a tenth of it could not be told from noise that is no fault.
    faint = sphere(f"{GRAVITY}\n[effects.drag]\nrotational = 1e-12")
    assert np.isinf(weakest_effects(Equations(faint), steps_of(faint))[TORQUE])
