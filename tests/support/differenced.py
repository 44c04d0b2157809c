"""Derivatives of a scene's motion by central differences of a second derivation in forty digits.

Nothing is shared with `reference/sensitivity.py`: another arithmetic, other equations, and bodies
that are changed themselves.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from mpmath import mp, mpf
from second_derivation import DIGITS, Array, CoupledBodies, exact, of_scene, rotation
from spincheck.scenarios import Scenario
from spincheck.scenarios.body import Body
from spincheck.scenarios.exact import product

#: Of a parameter's size. Its square is left out; 1e-26 over it is what the motions are rounded to.
NUDGE = mpf("1e-9")
#: By the name of an array: the attribute of `CoupledBodies` that its columns change.
ATTRIBUTES = {"gravity": "gravity_world", "torque_body": "torque_body", "drag": "drag"}
ATTRIBUTES |= {"torque_world": "torque_world"}


class Unchecked(Body):
    """A body that may break the triangle inequality: a plate is at its bound."""

    def __post_init__(self) -> None:
        pass


def changed(scene: Scenario, name: str, by: Array) -> CoupledBodies:
    """The bodies of a scene, numbers of them changed: columns of an array of a `Sensitivity`."""
    if name in ("inertia", "mass", "com"):
        return of_scene(with_body(scene, **{name: by}))
    bodies = of_scene(scene)
    if name == "state_transition":
        turn = (mpf(1), *(by[:3] / 2))
        q = np.array(product(scene.start.q_exact, turn)) / mp.norm(mp.matrix(turn))
        return replace(bodies, R=rotation(q), omega=bodies.omega + by[3:])
    if name == "spins":
        pairs = zip(bodies.rotors, by, strict=True)
        return replace(bodies, rotors=[one._replace(spin=one.spin + x) for one, x in pairs])
    attribute = ATTRIBUTES[name]
    before = getattr(bodies, attribute)
    return replace(bodies, **{attribute: before + (by[0] if name == "drag" else by)})


def with_body(
    scene: Scenario, inertia: Array | None = None, mass: Array = (0,), com: Array | int = 0
) -> Scenario:
    """The scene with another body, so much off, which cannot be written as a file."""
    body = scene.carrier
    xx, yy, zz, xy, xz, yz = np.zeros(6) if inertia is None else inertia
    tensor = exact(body.inertia_com_exact) + np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    place = tuple(exact(body.com_exact) + com)
    carrier = Unchecked(body.mass_exact + mass[0], place, tuple(map(tuple, tensor)))
    return replace(scene, carrier=carrier)


def size_of(scene: Scenario, name: str) -> mpf:
    """What a number of this kind may come to in the scene, roughly."""
    moment, speed = (
        float(scene.body.principal_moments[0]),
        float(np.abs(scene.start.omega_body).max()),
    )
    pull = float(np.abs(scene.gravity_world).max())
    sizes = {
        "inertia": moment,
        "mass": scene.body.mass,
        "com": np.sqrt(moment / scene.body.mass),
        "gravity": pull,
        "drag": moment * speed,
        "torque_body": moment * speed**2,
        "torque_world": moment * speed**2,
        "spins": speed,
    }
    return mpf(float(sizes.get(name, 1)) or 1.0)


def derivatives(
    scene: Scenario, name: str, direction: Sequence[float], times: Sequence[float], rate: float
) -> np.ndarray:
    """An array of a `Sensitivity` times a direction, (n, 6), and on a table com z and its rate."""
    with mp.workdps(DIGITS):
        by = NUDGE * size_of(scene, name)
        one, other = (changed(scene, name, sign * by * exact(direction)) for sign in (-1, 1))
        motions = (bodies.motion(times, rate) for bodies in (one, other))
        rows = []
        for before, after in zip(*motions, strict=True):
            # The mean of both is the motion itself but for the square of the nudge.
            turned = (before.R + after.R).T / 2 @ (after.R - before.R)
            turn = [(turned[j, i] - turned[i, j]) / 2 for i, j in ((1, 2), (2, 0), (0, 1))]
            heights = _height(other, after) - _height(one, before)
            rows.append([*turn, *(after.omega - before.omega), *heights])
        return np.array(exact(rows) / (2 * by), dtype=float)


def _height(bodies: CoupledBodies, state: object) -> Array:
    """The com above the tip, m, and its rate, m/s; nothing without a table."""
    if bodies.table_lever is None:
        return exact([])
    up, lever = state.R[2], bodies.table_lever
    return np.array([up @ lever, up @ np.cross(state.omega, lever)])
