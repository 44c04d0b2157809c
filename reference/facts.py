"""Derived numbers of a scene that classify its motion.

All are computed from the exact motion. A quantity that changes along the motion is given at t = 0,
and its description says so.
"""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from mpmath import mp

from ..scenarios import (
    Scenario,
    Trajectory,
    angular_momentum_world,
    kinetic_energy,
    potential_energy,
)
from ..scenarios.exact import DIGITS, dot
from ..scenarios.mechanics import RECENT
from . import heavy_symmetric_top as lagrangian
from . import stability
from .conservation_laws import LAWS, InvariantScales
from .effect_terms import TERMS, is_free, nutates
from .fact import Fact
from .heavy_symmetric_top import HeavySymmetricTop, heavy_symmetric_top
from .motion import motion
from .problem import Problem
from .rotational_problem import rotational_problem
from .symmetry import (
    across,
    angular_momentum_axes,
    moments_across_and_along,
    norm,
    symmetry_axis,
)


@lru_cache(maxsize=RECENT)
def facts(scenario: Scenario) -> list[Fact]:
    """Return all derived numbers that apply to a scene, in the order in which they are shown."""
    problem = rotational_problem(scenario)
    start = _start(scenario, problem)
    scene_facts = list(_of_any_body(scenario, problem, start))
    axis = symmetry_axis(problem)
    top = heavy_symmetric_top(problem)
    if top is not None:
        scene_facts += _of_a_heavy_top(top)
        if nutates(problem):
            scene_facts += _of_nutation(top)
    elif is_free(problem):
        scene_facts += _of_a_free_body(problem) if axis is None else _of_a_free_top(problem)
    scales = InvariantScales(scenario, problem)
    for law in LAWS:
        if law.title and law.holds(scales):
            value = float(law.values(scales, start)[0])
            scene_facts.append(Fact(law.title, value, law.unit, f"{law.formula}, conserved"))
    for terms in TERMS.values():
        scene_facts += terms.facts(scenario, problem)
    return scene_facts


def _start(scenario: Scenario, problem: Problem) -> Trajectory:
    """Return a trajectory of one sample, the exact state at t = 0."""
    states = np.array([problem.q_world_axes], float), np.array([problem.omega_axes], float)
    return motion(scenario, problem, np.zeros(1), states)


def _of_any_body(scenario: Scenario, problem: Problem, start: Trajectory) -> Iterator[Fact]:
    """Yield facts of any scene: moments, angular momentum, energies and forces.

    `start` is a trajectory of one sample, the state at t = 0.
    """
    point = "pivot" if scenario.constraint.is_pivot else "centre of mass"
    less = ", less what parts that turn freely have about their axles" if problem.kept else ""
    for k, moment in enumerate(problem.moments, start=1):
        yield Fact(f"moment {k}", float(moment), "kg m²", f"principal, about the {point}{less}")
    kinetic = float(kinetic_energy(scenario, start)[0])
    potential = float(potential_energy(scenario, start)[0]) + 0.0  # never −0
    L = float(np.linalg.norm(angular_momentum_world(scenario, start)[0]))
    yield Fact("rotation", float(norm(problem.omega_axes)), "rad/s", "‖ω‖ at t = 0")
    yield Fact("angular momentum", L, "kg m²/s", f"‖L‖ about the {point} at t = 0")
    yield Fact("kinetic energy", kinetic, "J", "T at t = 0")
    yield Fact("potential energy", potential, "J", "V = −m g·r at t = 0, zero at the origin")
    yield Fact("energy", kinetic + potential, "J", "T + V at t = 0")
    for effect in scenario.acting:
        if effect.force is not None:
            force, name = float(effect.force_along(scenario, start)[0]), effect.name
            yield Fact(f"{name}'s force", force, "N", f"N at t = 0, upward: a {name} cannot pull")


def _of_a_heavy_top(top: HeavySymmetricTop) -> Iterator[Fact]:
    """Yield facts of a heavy symmetric top that follow from its start."""
    threshold = lagrangian.sleeping_threshold(top)
    point, about = ("tip", "com") if top.heave else ("pivot", "pivot")
    yield Fact("I1", float(top.I1), "kg m²", f"moment across the axis, about the {about}")
    yield Fact("I3", float(top.I3), "kg m²", f"moment about the axis, from the {point} to the com")
    yield Fact(
        "M g l", float(top.kappa), "N m", f"weight times the com's distance from the {point}"
    )
    yield Fact("p_alpha", float(top.p_alpha), "kg m²/s", "L along the upward vertical at t = 0")
    yield Fact("p_gamma", float(top.p_gamma), "kg m²/s", "L along the axis at t = 0: I3 ω3")
    yield Fact("E'", float(top.E_prime), "J", "E − p_gamma²/2 I3 at t = 0")
    yield Fact("start angle", _deg(top.cos_beta), "deg", "of the axis from the upward vertical")
    yield Fact("sleeping threshold", threshold, "kg m²/s", "√(4 M g l I1): |p_gamma| to stay up")
    ratio = abs(float(top.p_gamma)) / threshold
    yield Fact("sleeping ratio", ratio, "", "|p_gamma| over the threshold: 1 or more stays up")


def _of_nutation(top: HeavySymmetricTop) -> Iterator[Fact]:
    """Yield facts of a top's nutation.

    They hold if L along the vertical, L along the top's axis, and the energy are conserved.
    """
    low, high = (math.degrees(beta) for beta in lagrangian.nutation_bounds(top))
    bottom = math.degrees(lagrangian.steady_angle(top))
    small = lagrangian.small_nutation_frequency(top)
    mean = lagrangian.mean_precession_rate(top)
    rates = lagrangian.steady_precession_rates(top, top.cos_beta)
    yield Fact("nutation from", low, "deg", "smallest angle: V_eff = E'")
    yield Fact("nutation to", high, "deg", "largest angle: V_eff = E'")
    yield Fact("nutation period", lagrangian.nutation_period(top), "s", "of cos β")
    yield Fact("bottom of V_eff", bottom, "deg", "where this p_alpha, p_gamma precess steadily")
    yield Fact("small nutation", small, "rad/s", "of β about the bottom of V_eff")
    if mean is not None:
        yield Fact("precession rate", mean, "rad/s", "α̇, mean over a nutation")
    for name, rate in zip(("slow", "fast"), rates, strict=False):
        meaning = "steady at the start angle: I1 cos β Ω² − p_gamma Ω + M g l = 0"
        yield Fact(f"steady precession, {name}", rate, "rad/s", meaning)


def _of_a_free_top(problem: Problem) -> Iterator[Fact]:
    """Yield facts of the regular precession of a free symmetric body (Goldstein §5.6)."""
    axis = symmetry_axis(problem)
    assert axis is not None
    with mp.workdps(DIGITS):
        I1, I3 = moments_across_and_along(problem, axis)
        omega, L = problem.omega_axes, angular_momentum_axes(problem)
        omega3, size = dot(omega, axis), norm(L)
        aside = norm([dot(omega, e) for e in across(axis)])
        tilt, half_angle = mp.atan2(I1 * aside, I3 * omega3), mp.atan2(aside, omega3)
        precession = size / I1
    cone = stability.body_cone_rate(I1, I3, omega3)
    yield Fact("body cone rate", cone, "rad/s", "(I3 − I1)/I1 ω3: ω round the axis, in the body")
    if cone:
        yield Fact("body cone period", 2 * math.pi / abs(cone), "s", "2π over it")
    yield Fact("body cone angle", math.degrees(half_angle), "deg", "from the axis to ω")
    yield Fact("precession rate", float(precession), "rad/s", "‖L‖/I1: the axis round L")
    yield Fact("tilt", math.degrees(tilt), "deg", "from the axis to L")


def _of_a_free_body(problem: Problem) -> Iterator[Fact]:
    """Yield facts of a free asymmetric body (Landau & Lifshitz §37).

    There are none for a body at rest, and none for one with three equal moments.
    """
    moments, omega = problem.moments, problem.omega_axes
    period = stability.tumbling_period(moments, omega)
    if period is None:
        return
    k = max(range(3), key=lambda axis: abs(omega[axis]))
    square = stability.perturbation_rate_squared(moments, k, float(omega[k]))
    meaning = f"of small deviations from rotation about axis {k + 1} at ω{k + 1}"
    name = "growth rate" if square > 0 else "wobble rate"
    distance = stability.separatrix_distance(moments, omega)
    yield Fact(name, math.sqrt(abs(square)), "rad/s", meaning)
    yield Fact("tumbling period", period, "s", "4K/p, of ω in the body: two flips")
    yield Fact("separatrix distance", distance, "", "(L² − 2 E I_mid)/L²; > 0: about the largest I")


def _deg(cosine: object) -> float:
    """Return the angle with a given cosine, degrees."""
    with mp.workdps(DIGITS):
        return float(mp.degrees(mp.acos(cosine)))
