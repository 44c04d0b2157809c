"""Torques by the attitude, turns besides, and what is said of a torque that nothing makes."""

from collections.abc import Callable

import numpy as np
import pytest
from planted_motions import case, exactly, product, rates_of
from reported_faults import judged, named
from scipy.spatial.transform import Rotation
from test_other_torques import made

pytestmark = pytest.mark.slow

ONE = case(151)
SCENE, INERTIA = ONE.scenario, ONE.inertia
DIPOLE, FIELD = np.array([0.4, -0.25, 0.3]), np.array([0.8, 0.3, -0.6])
TO = Rotation.from_rotvec([0.3, -0.5, 0.2])
KAPPA, STIFFNESS, DAMPING, TURNS = 0.3, 0.6, 0.1, np.array([0.0, 0.0, 0.08])


def gradient(R: np.ndarray, up: np.ndarray) -> np.ndarray:
    u = R.T @ up
    return KAPPA * np.cross(u, INERTIA @ u)


def spring(R: np.ndarray) -> np.ndarray:
    """N m, body axes: the gradient of −k/2 tr(R₀ᵀ R), written out."""
    turned = TO.as_matrix().T @ R
    return (
        -STIFFNESS
        / 2
        * (
            np.array(
                [
                    turned[2, 1] - turned[1, 2],
                    turned[0, 2] - turned[2, 0],
                    turned[1, 0] - turned[0, 1],
                ]
            )
        )
    )


ASIDE = np.array([0.6, 0.0, 0.8])
#: What is planted, of R and ω, and what is said, in order.
TORQUES: dict[str, tuple[Callable[[np.ndarray, np.ndarray], np.ndarray], list[str]]] = {
    "gravity gradient": (
        lambda R, omega: gradient(R, np.eye(3)[2]),
        ["a gravity gradient of 0.3 /s² along [0, 0, 1]"],
    ),
    "gravity gradient aside": (
        lambda R, omega: gradient(R, ASIDE),
        ["a gravity gradient of 0.3 /s² along [0.6, "],
    ),
    "dipole": (
        lambda R, omega: np.cross(DIPOLE, R.T @ FIELD),
        [f"{np.linalg.norm(DIPOLE) * np.linalg.norm(FIELD):.4g} N m times m × b acted"],
    ),
    "spring and damping": (
        lambda R, omega: spring(R) - DAMPING * omega,
        ["slowed by 0.1 N m s", "a spring of 0.6 N m a radian turned it to the attitude [0.95"],
    ),
}


@pytest.mark.parametrize("name", TORQUES)
def test_a_torque_by_the_attitude_is_named_and_no_other(name: str) -> None:
    torque, words = TORQUES[name]
    motion = made(SCENE, lambda t, R, omega: torque(R, omega))
    said = named(judged(SCENE, motion, 1e-5))
    assert len(said) == len(words)
    for one, wanted in zip(said, words, strict=True):
        assert wanted in one


@pytest.mark.parametrize("along", ["world", "body"])
def test_what_turns_besides_is_named(along: str) -> None:
    motion = exactly(ONE, rates_of(ONE))
    if along == "world":
        turned = Rotation.from_rotvec(-np.outer(motion["t"], TURNS))
        q = Rotation.from_quat(motion["q"], scalar_first=True)
        motion["q"] = (turned * q).as_quat(scalar_first=True)
    else:

        def turning(q: np.ndarray, omega: np.ndarray) -> np.ndarray:
            return product(q, np.array([0, *(omega + TURNS)])) / 2

        motion = exactly(ONE, rates_of(ONE, turning=turning))
    (said,) = named(judged(SCENE, motion, 1e-5))
    words = {"world": "as if the world turned by [0, 0, 0.08", "body": "larger by [0, 0, 0.08"}
    assert words[along] in said


#: Torques that no change makes, of t, R and ω, and what is said of them.
SILENT: dict[str, tuple[Callable[[float, np.ndarray, np.ndarray], np.ndarray], str]] = {
    "along an axis of the body": (
        lambda t, R, omega: np.array([0.0, 0.6, 0.8]) * np.sin(5 * t),
        "it changes along one axis of the body, [0, 0.6, 0.8]",
    ),
    "along an axis of the world": (
        lambda t, R, omega: R.T @ np.array([0.6, 0.0, 0.8]) * np.sin(5 * t),
        "it changes along one axis of the world, [0.6, 0, 0.8]",
    ),
    "across L": (
        lambda t, R, omega: np.cross(INERTIA @ omega, np.sin([5 * t, 4 * t, 3 * t])),
        "it is across L: ‖L‖ is kept",
    ),
}


@pytest.mark.parametrize("name", SILENT)
def test_a_torque_that_nothing_makes_has_a_size_and_axes(name: str) -> None:
    torque, words = SILENT[name]
    (said,) = named(judged(SCENE, made(SCENE, torque), 1e-5))
    assert "ω does not obey Euler's equations: a torque of " in said
    assert " N m at most is missing, at t = " in said
    assert words in said
