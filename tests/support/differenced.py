"""Derivatives of a scene's motion by central differences of a second derivation in forty digits."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from mpmath import mp, mpf
from second_derivation import DIGITS, Array, CoupledBodies, exact, of_scene, rotation
from spincheck.reference.parameter_changes import ENTRIES
from spincheck.scenarios import Scenario
from spincheck.scenarios.body import Body
from spincheck.scenarios.exact import product

#: Of a parameter's size: what is left out is its square, and 1e-26 over it is rounding.
NUDGE = mpf("1e-9")
UNITS = exact(np.eye(3))


def nudged(scene: Scenario, name: str, column: int, by: mpf) -> CoupledBodies:
    """The bodies of a scene, one of their numbers changed, by its name in a `Sensitivity`."""
    bodies = of_scene(scene)
    if name == "state_transition" and column < 3:
        turn = (mpf(1), *(by / 2 * UNITS[column]))
        q = product(scene.start.q_exact, turn)
        return replace(bodies, R=rotation(np.array(q) / mp.norm(mp.matrix(turn))))
    if name == "state_transition":
        return replace(bodies, omega=bodies.omega + by * UNITS[column - 3])
    if name == "spins":
        rotors = list(bodies.rotors)
        rotors[column] = rotors[column]._replace(spin=rotors[column].spin + by)
        return replace(bodies, rotors=rotors)
    if name == "drag":
        return replace(bodies, drag=bodies.drag + by)
    if name in ("inertia", "mass", "com"):
        return of_scene(with_body(scene, name, column, by))
    key = {"gravity": "gravity_world"}.get(name, name)
    return replace(bodies, **{key: getattr(bodies, key) + by * UNITS[column]})


def with_body(scene: Scenario, name: str, column: int, by: mpf) -> Scenario:
    """The scene with one number of its body changed; it cannot be written as a file."""
    body = scene.carrier
    mass, com = body.mass_exact, list(body.com_exact)
    inertia = [list(row) for row in body.inertia_com_exact]
    if name == "mass":
        mass += by
    elif name == "com":
        com[column] += by
    else:
        for i, j in {ENTRIES[column], ENTRIES[column][::-1]}:
            inertia[i][j] += by
    return replace(scene, carrier=Body(mass, tuple(com), tuple(map(tuple, inertia))))


def size_of(scene: Scenario, name: str) -> mpf:
    """A size that a number of this kind may have in the scene."""
    body = scene.body
    arm = float(np.sqrt(np.trace(body.inertia_com) / body.mass))
    speed = float(np.abs([*scene.start.omega_body, *scene.start_spins]).max()) or 1.0
    moment = float(body.principal_moments[0])
    sizes = {
        "inertia": moment,
        "mass": body.mass,
        "com": arm,
        "gravity": float(np.linalg.norm(scene.gravity_world)) or 1.0,
        "drag": moment * speed,
        "spins": speed,
    }
    return mpf(sizes.get(name, moment * speed**2 if "torque" in name else 1.0))


def derivative(
    scene: Scenario, name: str, column: int, times: list[float], rate: float
) -> Iterator[Array]:
    """At each time the derivative of attitude and ω, (6,), body axes; of `column` of an array."""
    with mp.workdps(DIGITS):
        by = NUDGE * size_of(scene, name)
        states = [nudged(scene, name, column, sign * by).motion(times, rate) for sign in (-1, 0, 1)]
        for before, middle, after in zip(*states, strict=True):
            turned = middle.R.T @ (after.R - before.R) / (2 * by)
            turn = [(turned[j, i] - turned[i, j]) / 2 for i, j in ((1, 2), (2, 0), (0, 1))]
            yield np.concatenate([turn, (after.omega - before.omega) / (2 * by)])
