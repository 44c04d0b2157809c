"""Changes (`Change`) of effects and rotors that are tried with recorded motions only.

Single steps of engines are explained without them.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .....reference.other_equations import OtherEquations, equations_of
from .....scenarios import FloatArray, Scenario
from .....scenarios.rotation import matrix
from .....scenarios.scenario import with_tables
from ...explaining.effect_changes import mean_moment, usual_rate, usual_torque
from ...explaining.hypothesis import Change, Hypothesis, fitted, scaled, set_to
from ...explaining.other_tensors import tensors_of_entries


def tilt(e: OtherEquations) -> Iterator[Change]:
    """Yield the change of gravity's direction by two angles, rad; none if gravity has no torque.

    Parameters
    ----------
    e : the scene's own equations
    """
    if e.pull.any() and e.gravity_world.any():
        perpendicular = np.linalg.svd(e.gravity_world[None])[2][1:]

        def tilted(n: FloatArray) -> FloatArray:
            return Rotation.from_rotvec(n @ perpendicular).apply(e.gravity_world)

        yield Change(
            "tilt",
            lambda h, n: h.of(gravity_world=tilted(n)),
            np.ones(2),
            lambda n: np.array([np.degrees(np.linalg.norm(n)), *tilted(n)]),
        )


def of_attitude(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that add a torque which depends on the attitude, or a rate of turning.

    The rate is constant: one with which the body turns besides ω, or with which the world turns.
    Only long motions show the effects of these changes.

    Parameters
    ----------
    e : the scene's own equations
    """
    rate = usual_rate(scenario, e)
    size, gravity = usual_torque(scenario, e), e.gravity_world
    up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.eye(3)[2]
    yield Change(
        "gravity gradient",
        lambda h, n: h.of(gravity_gradient=scaled(n, np.outer(up, up))),
        np.array([rate**2]),
        lambda n: np.array([n[0], *up]),
    )
    yield fitted("turning besides", np.zeros(3), rate, lambda h, n: h.of(body_turns=n))
    yield world_turning(rate)
    yield fitted("gravity gradient along other axes", np.zeros(5), rate**2, _gravity_gradient)
    yield by_attitude(size)
    yield from (_spring(q, size) for q in (np.eye(4)[0], scenario.start.q_world_body_wxyz))


def by_attitude(size: float) -> Change:
    """Return the change that adds the torque Σᵢ P eᵢ × Rᵀ eᵢ, body axes, to the equations.

    R is the attitude, body to world, and eᵢ are the unit vectors. The matrix P, (3, 3), is fitted.

    Parameters
    ----------
    size : scale of the entries of P, N m
    """
    return fitted(
        "torque by attitude",
        *(np.zeros(9), size),
        lambda h, n: h.of(attitude_torque=n.reshape(-1, 3, 3)),
    )


def dipole(P: FloatArray) -> Change:
    """Return the change that adds the torque of a dipole in the body, in a field of the world.

    The change has five parameters, which are deviations from the dipole whose torque is nearest to
    that of P. Three of them are components of the dipole times the field strength, N m. Two are
    angles of the field's direction, rad.

    Parameters
    ----------
    P : the matrix of a torque that was fitted with `by_attitude`, N m, (3, 3)
    """
    of_body, scales, of_world = np.linalg.svd(P)

    def dipole_torque(n: FloatArray) -> FloatArray:
        field = Rotation.from_rotvec(n[..., 3:] @ of_world[1:]).apply(of_world[0])
        of_dipole = scales[0] * of_body[:, 0] + n[..., :3]
        return np.asarray(of_dipole[..., None] * field[..., None, :])

    return Change(
        "torque by attitude",
        lambda h, n: h.of(attitude_torque=dipole_torque(n)),
        np.array([scales[0]] * 3 + [1.0] * 2),
        lambda n: dipole_torque(n).ravel(),
    )


def _spring(q_rest_wxyz: FloatArray, size: float) -> Change:
    """Return the change that adds the torque of a spring, which turns the body to a rest attitude.

    Parameters
    ----------
    q_rest_wxyz : the rest attitude, scalar first, (4,)
    size : scale of the stiffness, N m/rad
    """
    R_rest = matrix(q_rest_wxyz)
    return Change(
        "spring",
        lambda h, n: h.of(spring=scaled(n, R_rest)),
        np.array([size]),
        lambda n: [n[0], *q_rest_wxyz],
    )


def world_turning(rate: float) -> Change:
    """Return the change in which the world turns at a fitted angular velocity, rad/s, world axes.

    Parameters
    ----------
    rate : scale of the angular velocity, rad/s
    """
    return fitted("world turning", np.zeros(3), rate, lambda h, n: h.of(world_turns=n))


def _gravity_gradient(h: Hypothesis, n: FloatArray) -> Hypothesis:
    """Return H hypotheses `h` with gravity gradients that are set to given matrices.

    The entry zz of a matrix is 0: a multiple of the identity would have no torque.

    Parameters
    ----------
    n : the entries xx, yy, xy, xz and yz, 1/s², (H, 5)
    """
    return h.of(gravity_gradient=tensors_of_entries(np.insert(n, 2, 0.0, axis=1)))


def of_rotors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes of the rotors' hinges, of the signs of their spins, and of their momentum.

    Each change of hinges or signs is made for all rotors, and for one rotor at a time.

    Parameters
    ----------
    e : the scene's own equations
    """
    tables = scenario.document.rotors or ()
    for kind in "free", "driven", "locked", "reversed":
        for which in range(len(tables) + 1):
            changed = []
            for k, one in enumerate(tables):
                hinge, reversed_ = {"hinge": kind}, {"spin": -one.spin}
                update: dict[str, Any] = reversed_ if kind == "reversed" else hinge
                changed.append(one.model_copy(update=update) if which in (0, k + 1) else one)
            if changed != list(tables):
                other = equations_of(with_tables(scenario, rotors=tuple(changed)))
                terms = ("inertia", "inverse", "gyroscopic", "kept")
                yield set_to(
                    f"{kind} rotors", (which,), **{name: getattr(other, name) for name in terms}
                )
    yield momentum(scenario, e)


def momentum(scenario: Scenario, e: OtherEquations) -> Change:
    """Return the change of the constant angular momentum of rotors, N m s.

    If the scene has no such momentum, the change adds one, as that of a wheel in the body.

    Parameters
    ----------
    e : the scene's own equations
    """
    size = float(np.linalg.norm(e.kept)) or mean_moment(e) * usual_rate(scenario, e)
    kind = "rotors' momentum" if e.kept.any() else "momentum besides"
    return fitted(kind, e.kept, size, lambda h, n: h.of(kept=n))
