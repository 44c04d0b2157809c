"""L and energy of a body are those of six masses that it is as good as."""

from dataclasses import replace

import numpy as np
import pytest
from case_loops import each_case
from scene_texts import scene
from scipy.spatial.transform import Rotation
from spincheck.scenarios import (
    Scenario,
    Trajectory,
    angular_momentum_world,
    energy,
    energy_base,
    kinetic_energy,
    potential_energy,
)

EPS = np.finfo(float).eps
#: Some tens of products and sums, relative to the largest.
ROUNDED = 64 * EPS
PIVOT = "[effects.pivot]\n"
GRAVITY = "[effects.gravity]\nacceleration = [3.0, 0.0, -10.0]\n"
RANDOM = np.random.default_rng(5)
SAMPLES = 20
#: Places and velocities that have nothing to do with each other.
ANYHOW = Trajectory(
    np.arange(SAMPLES),
    Rotation.random(SAMPLES, rng=RANDOM).as_quat(scalar_first=True),
    *RANDOM.uniform(-5, 5, (3, SAMPLES, 3)),
)


def by_masses(scenario: Scenario, motion: Trajectory) -> dict[str, np.ndarray]:
    """L about pivot or com, and the energies, of masses in pairs on the body's three axes."""
    body, g = scenario.body, np.array(scenario.gravity_world)
    # Of each pair ∫ x² dm is what the moments leave: half their sum less the one about its axis.
    along = np.trace(body.inertia_com) / 2 - np.diag(body.inertia_com)
    arms = np.vstack([np.diag(s * np.sqrt(3 * along / body.mass)) for s in (1, -1)])
    pairs = [*zip(motion.R_world_body, motion.omega_body, strict=True)]
    turned = [R.apply(arms) for R, _ in pairs]
    swings = [R.apply(np.cross(w, arms)) for R, w in pairs]
    x, v = turned + motion.com_world[:, None], swings + motion.velocity_world[:, None]
    at = x if scenario.constraint.is_pivot else turned
    kinetic, potential = (v**2).sum(axis=(1, 2)) / 2, -(x @ g).sum(axis=1)
    found = {"L": np.cross(at, v).sum(axis=1), "kinetic": kinetic, "potential": potential}
    return {name: body.mass / 6 * of_all for name, of_all in found.items()}


@each_case("effects", ["", PIVOT, GRAVITY, PIVOT + GRAVITY])
def test_they_are_those_of_six_masses(effects: str) -> None:
    scenario = scene(more=effects)
    masses = by_masses(scenario, ANYHOW)
    ours = {"L": angular_momentum_world, "kinetic": kinetic_energy, "potential": potential_energy}
    faster = by_masses(scenario, replace(ANYHOW, velocity_world=1.01 * ANYHOW.velocity_world))
    for name, found in ((name, of(scenario, ANYHOW)) for name, of in ours.items()):
        slack = ROUNDED * np.abs(masses[name]).max()
        np.testing.assert_allclose(found, masses[name], rtol=0, atol=slack)
        counts = name == "kinetic" or (name == "L" and scenario.constraint.is_pivot)
        assert (np.abs(found - faster[name]).max() > slack) == counts
    both = masses["kinetic"] + masses["potential"]
    np.testing.assert_allclose(energy(scenario, ANYHOW), both, rtol=ROUNDED * 10)


def test_the_base_is_of_the_fastest_and_the_farthest() -> None:
    """Two samples: T = 2.5·16/2 and at rest; |r| = 0 and 5, weight 20."""
    q, still = [1, 0, 0, 0], [0, 0, 0]
    path = Trajectory([0, 1], [q, q], [[0, 0, 4], still], [still, [3, 0, 4]], [still, still])
    down = "[effects.gravity]\nacceleration = [0.0, 0.0, -10.0]\n"
    assert energy_base(scene(more=down), path) == pytest.approx(20 + 100, rel=ROUNDED)


def test_motions_that_blow_up_have_no_finite_energy_and_make_no_warning() -> None:
    scenario = scene(more=PIVOT + GRAVITY)
    fast = replace(ANYHOW, omega_body=np.full((SAMPLES, 3), np.finfo(float).max))
    assert not np.isfinite(angular_momentum_world(scenario, fast)).all()
    assert not np.isfinite(energy(scenario, fast)).any()
