"""Bodies on a smooth table, against the second derivation.

Symmetric tops have a quadrature besides, to thirty digits, by which the motion's turning points are
told. Not verified here: that engines agree; that a second integrator finds the same over the whole
window, which the scenes' own items verify.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from case_loops import each_case
from mpmath import mp, mpf
from second_derivation import DIGITS, STEP_TURN, exact, of_scene, rotation
from spincheck.reference import solve
from spincheck.reference.heavy_symmetric_top import (
    HeavySymmetricTop,
    heavy_symmetric_top,
    mean_precession_rate,
    nutation_bounds,
    nutation_period,
    small_nutation_frequency,
    steady_precession_rates,
)
from spincheck.reference.invariants import drifts
from spincheck.reference.rotational_problem import rotational_problem
from spincheck.scenarios import LIBRARY, Scenario, load
from spincheck.scenarios.effects.table import EFFECT, force
from spincheck.scenarios.rotation import matrices
from spincheck.suite.contract_scenes import SCENES as CONTRACT
from varied_scenes import varied

pytestmark = pytest.mark.slow

#: Samples that are compared.
STEPS = 6
AGREES = 1e-15
EPS = float(np.finfo(float).eps)
#: Relative, of the tip's place: a fault that must show.
PLANTED = 1e-12
#: rad, turned between the states of a central difference.
NARROW = 1e-4
#: rad, of an angle near a turning point that is read off its cosine.
BY_COSINE = float(np.sqrt(EPS))
SCENES = [load(path) for path in sorted(LIBRARY.glob("table/*.toml"))]
SCENES += [load(LIBRARY / "hard/dental-top-on-glass.toml"), CONTRACT["table-rotors"]]
SCENES += [load(LIBRARY / "rotors/gyroscope-on-glass.toml")]
each_scene = each_case("scene", SCENES)
#: Of a quadrature: half of them are left where the phase of a start at a turning point is a root.
#: Turning points that a motion is followed for.
QUADRATURE_DIGITS, TURNING_POINTS = 60, 12


def fastest(scene: Scenario) -> float:
    """rad/s, of spin, of swings, and of what rotors do."""
    speed = float(np.linalg.norm(scene.start.omega_body))
    swing = float(np.sqrt(9.81 / (np.linalg.norm(scene.constraint.lever) + 1e-3)))
    of_parts = sum(effect.rate(scene) for effect in scene.acting if effect.is_part)
    return max(speed, swing, of_parts)


def largest_error(scene: Scenario, told: Scenario) -> float:
    """Of the exact motion of one scene from that of another by the second derivation, relative."""
    speed, rate = float(np.linalg.norm(scene.start.omega_body)), fastest(scene)
    span = min(STEP_TURN / rate, scene.window.duration / STEPS)
    solution = solve(scene, span * np.arange(STEPS + 1))
    motion, errors = solution.trajectory, [0.0]
    with mp.workdps(DIGITS):
        for k, state in enumerate(of_scene(told).motion(motion.t[1:], rate), start=1):
            q = [mpf(x) for x in motion.q_world_body_wxyz[k].tolist()]
            norm = mp.sqrt(sum(x * x for x in q))
            turned = rotation([x / norm for x in q]) - state.R
            off = (motion.omega_body[k] - state.omega) / max(mp.norm(state.omega.tolist()), speed)
            lever_world = state.R @ exact(told.constraint.lever_exact)
            z = told.constraint.place_exact[2] + lever_world[2]
            rise = motion.com_world[k, 2] / z - 1
            errors += [mp.norm(turned.ravel().tolist()), mp.norm(off.tolist()), abs(rise)]
    assert max(errors) <= max(value for _, value in solution.uncertainty) or told is not scene
    return float(max(errors))


@each_scene
def test_the_motion_is_that_of_a_second_derivation(scene: Scenario) -> None:
    assert largest_error(scene, scene) <= AGREES


def test_a_tip_a_trillionth_off_would_show() -> None:
    scene = next(scene for scene in SCENES if scene.name == "gliding-top")
    moved = varied(scene, {"effects.table.tip[2]": PLANTED})
    assert largest_error(moved, scene) > 10 * AGREES


def test_a_spin_a_trillionth_off_would_show() -> None:
    moved = varied(CONTRACT["table-rotors"], {"rotors[0].spin": PLANTED})
    assert largest_error(moved, CONTRACT["table-rotors"]) > 10 * AGREES


@each_scene
def test_the_table_pushes_all_along_and_what_is_kept_is_kept(scene: Scenario) -> None:
    solution = solve(scene, scene.times)
    motion = solution.trajectory
    assert solution.horizon is None
    assert (EFFECT.force_along(scene, motion) > 0).all()
    kept = drifts(scene, motion)
    assert {"table", "momentum_less_impulse", "com_parabola"} <= kept.keys()
    assert ("energy" in kept) == (scene.pushed["drag"] == 0)
    assert max(kept.values()) < 8 * EPS


@each_scene
def test_the_table_s_force_is_what_the_com_is_accelerated_by(scene: Scenario) -> None:
    """Besides gravity; by a central difference, whose error is of second order in the turn."""
    size = float(np.linalg.norm(scene.constraint.lever)) * fastest(scene) ** 2
    h = NARROW / fastest(scene)
    times = np.array([0.0, h, 2 * h])
    motion = solve(scene, times).trajectory
    gained = np.diff(motion.velocity_world[::2, 2])[0] / (2 * h)
    force_of = scene.body.mass * (gained - scene.gravity_world[2])
    allowed = scene.body.mass * NARROW**2 * size
    assert EFFECT.force_along(scene, motion)[1] == pytest.approx(force_of, rel=0, abs=allowed)


@each_case(
    ("spin", "leaves"),
    [((3.0, 0.0, 5.0), 0.150344), ((12.0, 0.0, 5.0), 0.117303), ((0.0, 0.0, 80.0), None)],
)
def test_the_motion_ends_where_the_table_would_have_to_pull(spin, leaves) -> None:
    """By bisection of the force along the motion of a body that is held by a joint."""
    scene = next(scene for scene in SCENES if scene.name == "gliding-top")
    start = {f"start.omega_body[{k}]": value for k, value in enumerate(spin)}
    scene = varied(scene, start)
    solution = solve(scene, scene.times)
    assert solution.lifts_off == (leaves is not None)
    if leaves is None:
        return
    assert solution.horizon == pytest.approx(leaves, rel=1e-5)
    assert "leaves the table, or falls flat on it, at t = 0.1" in solution.ending
    times = solution.horizon * np.array([0.0, 1 - 1e-9])
    last = solve(scene, times).trajectory
    R_world_body = matrices(last.q_world_body_wxyz)
    pressed = force(
        scene,
        R_world_body,
        last.omega_body,
        scene.kept_body(scene.kept(last.omega_body, last.spins)),
    )
    height = last.com_world[:, 2] - scene.effects.table.height
    weight = 9.81 * scene.body.mass
    assert min(pressed[1] / weight, height[1] / height[0]) < 1e-6
    assert (pressed > 0).all()
    assert (height > 0).all()


def test_a_symmetric_tops_quadrature_is_that_of_the_integrated_motion() -> None:
    """It starts at a turning point: it is back after a period, and at the other one after half."""
    scene = next(scene for scene in SCENES if scene.name == "gliding-top")
    top = heavy_symmetric_top(rotational_problem(scene))
    assert top is not None

    def axes(top: HeavySymmetricTop) -> np.ndarray:
        times = nutation_period(top) * np.array([0.0, 0.5, 1.0])
        return solve(scene, times).trajectory.R_world_body.as_matrix()[:, :, 2]

    axis = axes(top)
    low, high = nutation_bounds(top)
    assert np.arccos(axis[:, 2]) == pytest.approx([low, high, low], abs=BY_COSINE)
    azimuth = np.arctan2(axis[2, 1], axis[2, 0]) - np.arctan2(axis[0, 1], axis[0, 0])
    turned = mean_precession_rate(top) * nutation_period(top)
    assert np.exp(1j * (turned - azimuth)) == pytest.approx(1.0, abs=BY_COSINE)
    on_a_pivot = replace(top, heave=mpf(0))
    assert abs(np.arccos(axes(on_a_pivot)[2, 2]) - low) > 1000 * BY_COSINE


@dataclass(frozen=True)
class TurningPoints:
    """Of u = cos β of a symmetric top: the first time, s, half a period, s, and the two bounds."""

    first: mpf
    half_period: mpf
    bounds: tuple[mpf, mpf]
    #: u'' at each of the bounds, 1/s².
    rates: tuple[mpf, mpf]


def turning_points(scene: Scenario) -> TurningPoints:
    """By what the motion keeps: E, L_z, and L_3 along the axis; z is the body's axis.

    With I for the moment across, about the com, and l from the tip to it,

        (I + m l² (1 − u²)) u'² = (E₂ − k u) (1 − u²) − (L_z − L₃ u)² / I,    k = 2 m g l,

    E₂ being twice the energy but for what the spin about the axis has of it. Of three roots two are
    turning points; with u = (a + b) / 2 + (b − a) / 2 sin s the time's integrand is smooth.
    """
    with mp.workdps(QUADRATURE_DIGITS):
        across, along = (scene.body.inertia_com_exact[i][i] for i in (0, 2))
        m, (_, _, lever) = scene.body.mass_exact, scene.constraint.lever_exact
        up, omega = rotation(scene.start.q_exact)[2], scene.start.omega_body_exact
        L_3 = along * omega[2] + sum(rotor.along * rotor.spin for rotor in scene.rotors.each)
        L_z = across * (omega[0] * up[0] + omega[1] * up[1]) + L_3 * up[2]
        rising, k = up[0] * omega[1] - up[1] * omega[0], -2 * m * lever * scene.gravity_world[2]
        E_2 = across * (omega[0] ** 2 + omega[1] ** 2) + m * (lever * rising) ** 2 + k * up[2]
        cubic = [k, -E_2 - L_3**2 / across, 2 * L_z * L_3 / across - k, E_2 - L_z**2 / across]
        near = np.roots([float(x) for x in cubic]).real.tolist()

        def right(u: mpf) -> mpf:
            return (E_2 - k * u) * (1 - u**2) - (L_z - L_3 * u) ** 2 / across

        roots = sorted((mp.findroot(right, u) for u in near), key=abs)
        a, b, c = (*sorted(roots[:2]), roots[2])

        def weight(u: mpf) -> mpf:
            return across + m * lever**2 * (1 - u**2)

        def seconds(s: mpf) -> mpf:
            u = (a + b + (b - a) * mp.sin(s)) / 2
            return mp.sqrt(weight(u) / abs(k * (u - c)))

        sine = min(max((2 * up[2] - a - b) / (b - a), mpf(-1)), mpf(1))
        ahead = mp.asin(sine), mp.pi / 2 if rising >= 0 else -mp.pi / 2
        rates = tuple(k * (u - v) * (u - c) / weight(u) / 2 for u, v in ((a, b), (b, a)))
        half_period = mp.quad(seconds, [-mp.pi / 2, 0, mp.pi / 2])
        return TurningPoints(abs(mp.quad(seconds, ahead)), half_period, (a, b), rates)


def off_turning_points(scene: Scenario, told: TurningPoints) -> float:
    """By how much u' and u are off 0 and the bounds there, in what the exact motion may be off.

    u' is an ulp of the time times u'' off, too.
    """
    ahead = (told.first + k * told.half_period for k in range(1, TURNING_POINTS))
    times = np.array([0.0, *map(float, ahead)])
    solution = solve(scene, times)
    motion, own = solution.trajectory, solution.uncertainty
    assert solution.horizon is None
    up, omega = matrices(motion.q_world_body_wxyz)[1:, 2, :], motion.omega_body[1:]
    speed = float(np.linalg.norm(motion.omega_body, axis=1).max())
    rising = np.abs(up[:, 0] * omega[:, 1] - up[:, 1] * omega[:, 0])
    bounds = np.array(told.bounds, dtype=float)
    which = np.abs(up[:, 2, None] - bounds).argmin(axis=1)
    assert (np.diff(which) != 0).all()
    rate = np.abs(np.array(told.rates, dtype=float))[which]
    allowed = (own.omega + own.attitude) * speed + EPS * times[1:] * rate
    place = np.abs(up[:, 2] - bounds[which]) / (own.attitude + EPS)
    return float(max((rising / allowed).max(), place.max()))


def keeps_its_axial_momentum(scene: Scenario) -> bool:
    """Of a symmetric top on a level table, whose axis is z; its rotors are about that too."""
    inertia, (x, y, _) = scene.body.inertia_com, scene.gravity_world
    is_symmetric = np.array_equal(inertia, np.diag(inertia[[0, 0, 2], [0, 0, 2]]))
    return is_symmetric and not (x or y or scene.pushed["drag"])


SYMMETRIC = [scene for scene in SCENES if keeps_its_axial_momentum(scene)]
GLIDING = next(scene for scene in SCENES if scene.name == "gliding-top")
SYMMETRIC += [varied(GLIDING, {"start.omega_body[0]": 2.0, "start.omega_body[1]": 1.0})]


@each_case("scene", SYMMETRIC)
def test_a_symmetric_top_turns_back_when_its_quadrature_says(scene: Scenario) -> None:
    assert off_turning_points(scene, turning_points(scene)) <= 1
    moved = varied(scene, {"effects.table.tip[2]": PLANTED})
    assert off_turning_points(scene, turning_points(moved)) > 1


def test_a_tops_small_nutation_is_that_of_its_period() -> None:
    """Beside steady precession: a period of 2π over the frequency at the bottom of V_eff."""
    scene = next(scene for scene in SCENES if scene.name == "gliding-top")
    top = heavy_symmetric_top(rotational_problem(scene))
    rate = steady_precession_rates(top, top.cos_beta)[0]
    p_alpha = top.I1 * rate * (1 - top.cos_beta**2) + top.p_gamma * top.cos_beta
    energy = top.energy + top.I1 * rate**2 * (1 - top.cos_beta**2) / 2
    steady = replace(top, p_alpha=p_alpha, energy=energy)
    period = 2 * np.pi / small_nutation_frequency(steady)
    assert nutation_period(steady) == pytest.approx(period, rel=BY_COSINE)
