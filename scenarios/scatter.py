"""Members of an ensemble: a scene with its start and its body scattered at random.

The distribution, in which each n is another standard normal number:

- attitude: uniform on SO(3) where no direction of the world is special; where gravity or a torque
  fixed in the world acts, the scene's, turned about the body axes by the rotation vector
  SCATTER · (n, n, n) rad;
- angular velocity, in body axes: the scene's, turned by the rotation vector SCATTER · (n, n, n)
  rad and made longer by the factor exp(SCATTER · n); a body at rest stays at rest;
- second moments of mass ∫ x² dm, ∫ y² dm, ∫ z² dm along the principal axes: each times
  exp(SCATTER · n), those that are equal by the same factor. They add up in pairs to the moments of
  inertia, so that the triangle inequality holds and a symmetric top stays one;
- mass, and the arm from the pivot to the com: each times exp(SCATTER · n).
"""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .body import Body
from .float_array import FloatArray
from .scenario import Scenario
from .vary import own_tables, rewritten

#: Size of the scatter, rad or relative: a tenth, so that a member resembles its scene and no two
#: are alike.
SCATTER = 0.1
#: Number of standard normals that a member takes, drawn in one call.
_NUMBERS = 13
#: Effects that distinguish a direction of the world, so that attitudes are not equivalent.
_MAKE_A_DIRECTION_SPECIAL = {"gravity", "torque_world"}
#: Second moments of mass that agree this far, relative to the largest, are equal.
_EQUAL = 16 * np.finfo(float).eps
#: Keys of a body that a member states in another way, or that name a file with other numbers.
_BODY_KEYS = ("particles", "inertia_about", "model", "link", "welded", "sha256")
#: Alternative keys of attitude and ω: removed, since a member states each in one way.
_ATTITUDES = ("euler_zyz_deg", "rotation_vector_deg")
_OMEGAS = ("omega_world", "euler_zyz_rates")


def member(scenario: Scenario, seed: int, number: int) -> Scenario:
    """Return a member of a scene's ensemble, by seed and number.

    It does not depend on how many members there are.

    Parameters
    ----------
    seed : seed of the ensemble, 0 or more
    number : number of the member, 0 or more
    """
    sequence = np.random.SeedSequence(seed, spawn_key=(number,))
    n = np.random.Generator(np.random.PCG64(sequence)).standard_normal(_NUMBERS)
    attitude, turn, longer, shape, mass, arm = n[:4], n[4:7], n[7], n[8:11], n[11], n[12]
    tables = own_tables(scenario)
    start, body = dict(tables["start"]), dict(tables["body"])
    for key in (*_ATTITUDES, *_OMEGAS, *_BODY_KEYS):
        (body if key in _BODY_KEYS else start).pop(key, None)
    start["quaternion_wxyz"] = _attitude(scenario, attitude).as_quat(scalar_first=True).tolist()
    turned = Rotation.from_rotvec(SCATTER * turn).apply(np.array(scenario.start.omega_body))
    start["omega_body"] = (turned * _factor(longer)).tolist()
    body["mass"] = float(scenario.carrier.mass * _factor(mass))
    body["inertia"] = _inertia(scenario.carrier, shape)
    if scenario.constraint.is_pivot:
        body["com"] = (scenario.carrier.com * _factor(arm)).tolist()
    changed = tables | {"start": start, "body": body}
    return rewritten(scenario, changed, f"member {number} of seed {seed}")


def _attitude(scenario: Scenario, n: FloatArray) -> Rotation:
    """Return an attitude near the scene's, given four standard normals, `n`.

    It is uniformly distributed if no effect of the scene makes a direction special.
    """
    if not scenario.called_for & _MAKE_A_DIRECTION_SPECIAL:
        # The direction of four normals is uniform on the sphere of unit quaternions.
        return Rotation.from_quat(n)
    base = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
    return base * Rotation.from_rotvec(SCATTER * n[:3])


def _inertia(body: Body, n: FloatArray) -> list[Any]:
    """Return a scattered inertia about the com, kg m², as a scene file states it.

    It is a list of moments if the body's tensor is diagonal, else a matrix as nested lists.

    Parameters
    ----------
    n : three standard normals, by which the second moments of mass are scattered
    """
    tensor = body.inertia_com
    # ∫ r rᵀ dm: the inertia is its trace times the unit matrix, less the matrix itself.
    second = np.trace(tensor) / 2 * np.eye(3) - tensor
    diagonal = not np.any(tensor - np.diag(np.diag(tensor)))
    sizes, axes = (np.diag(second), np.eye(3)) if diagonal else np.linalg.eigh(second)
    # For a flat body one of them is zero up to rounding, which may be negative.
    sizes = np.maximum(sizes, 0.0) * [_factor(n[k]) for k in _alike(sizes)]
    if diagonal:
        x, y, z = sizes.tolist()
        return [y + z, z + x, x + y]
    scattered = np.sum(sizes) * np.eye(3) - axes @ np.diag(sizes) @ axes.T
    entries: list[Any] = ((scattered + scattered.T) / 2).tolist()
    return entries


def _alike(sizes: FloatArray) -> list[int]:
    """Return for each size the index of the first size that is equal to it up to rounding."""
    slack = _EQUAL * float(np.abs(sizes).max())
    return [int(np.flatnonzero(np.abs(sizes - size) <= slack)[0]) for size in sizes]


def _factor(n: float) -> float:
    """Return exp(`SCATTER` · n), a random factor near 1."""
    return float(np.exp(SCATTER * n))
