"""Bodies on a smooth table, against a second derivation integrated with forty digits.

The other way round in all: L about the com and the rotation matrix instead of ω and a quaternion,
the force from the tip's acceleration along the world's axes, and Gragg's rule extrapolated (Hairer,
Nørsett & Wanner I, §II.9) instead of a series. Symmetric tops have a quadrature besides, to
thirty digits, by which the motion's turning points are told. Not verified here: that engines agree.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from case_loops import each_case
from mpmath import mp, mpf
from spincheck.reference import solve
from spincheck.reference.cross_check import cross_check, times_within_reach
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
from spincheck.scenarios import LIBRARY, Scenario, errors_between, load
from spincheck.scenarios.effects.table import EFFECT, force
from spincheck.scenarios.fastest_rate import parts_rate
from spincheck.scenarios.rotation import matrices
from spincheck.scenarios.vary import varied
from spincheck.suite.contract_scenes import SCENES as CONTRACT

pytestmark = pytest.mark.slow

DIGITS = 40
#: rad at the fastest, of a step; columns of its extrapolation: (STEP_TURN / 2)^(2 COLUMNS) = 1e-34.
STEP_TURN, COLUMNS, STEPS = 0.5, 14, 6
AGREES = mpf("1e-15")
EPS = float(np.finfo(float).eps)
#: Relative, of the tip's place: a fault that must show.
PLANTED = 1e-12
#: rad, of an angle near a turning point that is read off its cosine.
BY_COSINE = float(np.sqrt(EPS))
SCENES = [load(path) for path in sorted(LIBRARY.glob("table/*.toml"))]
SCENES += [load(LIBRARY / "hard/dental-top-on-glass.toml"), CONTRACT["table-rotors"]]
SCENES += [load(LIBRARY / "rotors/gyroscope-on-glass.toml")]
each_scene = each_case("scene", SCENES)
UP = mp.matrix([0, 0, 1])
#: Of a quadrature: half of them are left where the phase of a start at a turning point is a root.
#: Turning points that a motion is followed for.
QUADRATURE_DIGITS, TURNING_POINTS = 60, 12


def cross(a, b):
    return mp.matrix(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def mobile(scene: Scenario):
    """What I ω is multiplied by to be ω, and the momentum that rotors keep, both in body axes.

    The moment of a free rotor about its hinge is no part of I: it keeps what it has.
    """
    inertia, kept = mp.matrix(scene.body.inertia_com_exact), mp.zeros(3, 1)
    for rotor in scene.rotors.each:
        axis, spin = mp.matrix(rotor.axis), rotor.spin
        if rotor.hinge == "free":
            inertia -= rotor.along * axis * axis.T
            spin += (axis.T * mp.matrix(scene.start.omega_body_exact))[0]
        kept += rotor.along * spin * axis
    return inertia**-1, kept


def rates(scene: Scenario):
    """dy/dt of y = (L about the com, the columns of R), world axes."""
    inverse, kept = mobile(scene)
    mass, tip = scene.body.mass_exact, -mp.matrix(scene.constraint.lever_exact)
    down, drag = mpf(float(scene.gravity_world[2])), mpf(scene.pushed["drag"])

    def rate(y):
        L, R = y[0:3, 0], mp.matrix([[y[3 + 3 * k + i] for k in range(3)] for i in range(3)])
        mobility, arm = R * inverse * R.T, R * tip
        omega = mobility * (L - R * kept)
        per_newton = mobility * cross(arm, UP)
        without = mobility * (-drag * omega - cross(omega, L))
        bend = cross(omega, cross(omega, arm))
        needed = -down - (cross(without, arm) + bend)[2]
        pressed = mass * needed / (1 + mass * cross(per_newton, arm)[2])
        gained = pressed * cross(arm, UP) - drag * omega
        columns = [cross(omega, R[:, k]) for k in range(3)]
        return mp.matrix([*gained, *(x for column in columns for x in column)])

    return rate


def extrapolated(rate, y, span):
    """The state a step later: the midpoint rule with 2, 4, 6, … substeps, h² → 0."""
    table = []
    for column in range(1, COLUMNS + 1):
        n = 2 * column
        h, first = span / n, rate(y)
        before, now = y, y + h * first
        for _ in range(n - 1):
            before, now = now, before + 2 * h * rate(now)
        row = [(before + now + h * rate(now)) / 2]
        for k, coarser in enumerate(table[-1] if table else [], start=1):
            ratio = (mpf(n) / (n - 2 * k)) ** 2
            row.append(row[-1] + (row[-1] - coarser) / (ratio - 1))
        table.append(row)
    return table[-1][-1]


def start_of(scene: Scenario):
    """L and R at t = 0."""
    w, x, y, z = scene.start.q_exact
    R = mp.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    inverse, kept = mobile(scene)
    L = R * (inverse**-1 * mp.matrix(scene.start.omega_body_exact) + kept)
    return mp.matrix([*L, *(R[i, k] for k in range(3) for i in range(3))])


def largest_error(scene: Scenario, told: Scenario) -> mpf:
    """Of the exact motion of one scene from that of another by the second derivation, relative."""
    speed = float(np.linalg.norm(scene.start.omega_body))
    swing = float(np.sqrt(9.81 / (np.linalg.norm(scene.constraint.lever) + 1e-3)))
    fastest = max(speed, swing, parts_rate(scene))
    span = min(STEP_TURN / fastest, scene.window.duration / STEPS)
    times = span * np.arange(STEPS + 1)
    solution = solve(scene, times)
    motion = solution.trajectory
    largest = mpf(0)
    with mp.workdps(DIGITS):
        rate, y = rates(told), start_of(told)
        inverse, kept = mobile(told)
        height = mpf(0) + told.constraint.place_exact[2]
        for k in range(1, STEPS + 1):
            y = extrapolated(rate, y, mpf(times[k]) - mpf(times[k - 1]))
            R = mp.matrix([[y[3 + 3 * c + i] for c in range(3)] for i in range(3)])
            omega = inverse * (R.T * y[0:3, 0] - kept)
            w, q1, q2, q3 = map(mpf, motion.q_world_body_wxyz[k].tolist())
            got = start_of(replace_attitude(told, (w, q1, q2, q3)))[3:, 0]
            largest = max(largest, mp.norm(got - y[3:, 0]))
            off = mp.matrix(motion.omega_body[k].tolist()) - omega
            largest = max(largest, mp.norm(off) / max(mp.norm(omega), speed))
            lever = R * mp.matrix(told.constraint.lever_exact)
            z = height + lever[2]
            largest = max(largest, abs(mpf(float(motion.com_world[k, 2])) - z) / abs(z))
    assert largest <= max(value for _, value in solution.uncertainty) or told is not scene
    return largest


def replace_attitude(scene: Scenario, q) -> Scenario:
    norm = mp.sqrt(sum(c * c for c in q))
    return replace(scene, start=replace(scene.start, q_exact=tuple(c / norm for c in q)))


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
def test_a_second_integrator_finds_it_over_the_whole_window(scene: Scenario) -> None:
    exact = solve(scene, scene.times)
    times = times_within_reach(scene, exact.trajectory)
    other = cross_check(scene, times)
    count = len(times)
    apart = errors_between(scene, other.trajectory, solve(scene, times).trajectory)
    bound = 64 * other.steps * other.tolerance * exact.conditioning.attitude / EPS
    assert count > 2
    assert max(apart.omega, apart.attitude, apart.com) < bound


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
        up, omega = start_of(scene)[5::3, 0], mp.matrix(scene.start.omega_body_exact)
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
