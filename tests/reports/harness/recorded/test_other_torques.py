"""Torques, rotors and numbers that change in time, planted in motions, are named and no other.

The motions are computed here by scipy, with nothing of what explains them.
"""

from collections.abc import Callable

import numpy as np
import pytest
from library_scenes import library_scene
from planted_motions import case, product
from reported_faults import Arrays, judged, named
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from spincheck.reference.other_equations import equations_of
from spincheck.scenarios import Scenario

pytestmark = pytest.mark.slow

#: Of t, R and ω in the body: the torque beside ω × (I ω + h), body axes, N m.
Torque = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
FREE, HEAVY = case(141), case(241, is_pivoted=True)
DRAGGED, PUSHED, WHEEL = map(library_scene, ("book-with-drag", "book-pushed", "wheel-in-a-box"))
#: When a torque begins, s; drag of the scene, N m s.
LATE, C = 2.0, DRAGGED.effects.drag.rotational
LEVER = HEAVY.scenario.body.mass * np.add(HEAVY.com, [0.05, 0.0, 0.0])


def made(scene: Scenario, torque: Torque, **terms: np.ndarray) -> Arrays:
    """A motion with a torque in place of the scene's; `terms`: the rotors' h."""
    e = equations_of(scene)
    inertia, h = terms.get("inertia", e.inertia), terms.get("kept", e.kept)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, omega = y[:4], y[4:]
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        of_body = torque(t, R, omega) - np.cross(omega, inertia @ omega + h)
        turning = product(q, np.array([0, *omega])) / 2
        return np.concatenate([turning, np.linalg.solve(inertia, of_body)])

    y = np.concatenate([scene.start.q_world_body_wxyz, scene.start.omega_body])
    times, found = scene.times, [y]
    for k in range(1, len(times)):
        y = solve_ivp(rates, times[k - 1 : k + 1], y, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        found.append(y / np.repeat([np.linalg.norm(y[:4]), 1.0], [4, 3]))
    table = np.array(found)
    return {"t": times.copy(), "q": table[:, :4], "omega": table[:, 4:]}


def none(t: float, R: np.ndarray, omega: np.ndarray) -> np.ndarray:
    return np.zeros(3)


def pushed(t: float, R: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """The torque of `PUSHED`, from a time on."""
    return np.asarray(R.T @ equations_of(PUSHED).torque_world * (t >= LATE))


#: What is planted: the scene, the torque, the tensor and the rotors' momentum, and words.
PLANTED: dict[str, tuple[Scenario, Torque, dict[str, np.ndarray], str]] = {
    "dry friction": (
        FREE.scenario,
        lambda t, R, omega: -0.3 * omega / np.linalg.norm(omega),
        {},
        "drag were dry friction of 0.3 N m",
    ),
    "drag of each axis": (
        FREE.scenario,
        lambda t, R, omega: -np.array([0.1, 0.2, 0.3]) * omega,
        {},
        "the drag along the body's axes were [0.1, 0.2, 0.3] N m s",
    ),
    "a law in place of the scene's": (
        DRAGGED,
        lambda t, R, omega: -3e-4 * np.linalg.norm(omega) * omega,
        {},
        "drag were 0.0003 ‖ω‖^2 N m",
    ),
    "a decay in place of drag": (
        DRAGGED,
        lambda t, R, omega: -0.4 * equations_of(DRAGGED).inertia @ omega,
        {},
        "L were slowed by 0.4 /s, in place of the drag",
    ),
    "drag of ω along world axes": (
        DRAGGED,
        lambda t, R, omega: -C * R @ omega,
        {},
        "the drag along body axes were against ω along world axes",
    ),
    "drag turned once too often": (
        DRAGGED,
        lambda t, R, omega: -C * R.T @ omega,
        {},
        "the drag along world axes were against ω along body axes",
    ),
    "gravity turned by the transpose": (
        HEAVY.scenario,
        lambda t, R, omega: HEAVY.torque(R.T),
        {},
        "turned by R for its transpose",
    ),
    "gravity that turns with the body": (
        HEAVY.scenario,
        lambda t, R, omega: HEAVY.torque(np.eye(3)),
        {},
        "gravity and torques along world axes turned with the body",
    ),
    "a com in the torque alone": (
        HEAVY.scenario,
        lambda t, R, omega: np.cross(LEVER, R.T @ HEAVY.gravity),
        {},
        "gravity's lever, mass times the com, were",
    ),
    "a wheel along another axis": (
        WHEEL,
        none,
        {"kept": np.array([0.21, 0.0, 0.0])},
        "the rotors had an angular momentum of [0.21, 0, 0] N m s",
    ),
    "a torque that is late": (
        PUSHED,
        pushed,
        {},
        "it moves as if there were no torque until t = 1.9",
    ),
    "a drag that the scene lacks, and that is late": (
        FREE.scenario,
        lambda t, R, omega: -0.2 * omega * (t >= LATE),
        {},
        "all were as in the scene until t = 1.96 s, and from then on it were slowed by 0.2 N m s",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_torque_is_named_and_no_other(name: str) -> None:
    scene, torque, terms, words = PLANTED[name]
    found = judged(scene, made(scene, torque, **terms), 1e-5)
    (said,) = named(found)
    assert words in said
