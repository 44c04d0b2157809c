"""Changes of what acts on a body: gravity, drag, torques, rotors, the centre of mass."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ....reference.other_equations import OtherEquations
from ....scenarios import FloatArray, Scenario
from .hypothesis import Change, Hypothesis, factors, fitted, set_to


def of_effects(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Changes of gravity, drag and torques."""
    # Of a free body a recording does not show gravity, and an engine's steps do.
    if e.gravity_world.any():
        yield from factors("gravity's size", 0.0, -1.0, gravity_world=e.gravity_world)
    yield from resistance(scenario, e)
    rate, none = _fastest(scenario, e), np.zeros(3)
    yield fitted("decay", none[:1], rate, lambda h, n: _slowed(h, 0.0, n[0]))
    yield fitted(
        "decays",
        *(none[:2], np.array([rate, 1.0])),
        lambda h, n: _slowed(h, 0.0, *n),
    )
    if e.torque.any() or e.torque_world.any():
        pushes: dict[str, Any] = {"torque": e.torque, "torque_world": e.torque_world}
        yield from factors("torque's size", 0.0, -1.0, **pushes)
        along_other_axes: dict[str, Any] = {"torque": e.torque_world, "torque_world": e.torque}
        yield set_to("torque along other axes", **along_other_axes)
    if e.slowing[0]:
        yield from factors("resistance's size", 0.0, -1.0, slowing=e.slowing)
    if e.gravity_world.any():
        size = float(np.linalg.norm(e.gravity_world))
        yield fitted("gravity", e.gravity_world, size, lambda h, g: h.of(gravity_world=g))
    size = mean_moment(e) * rate**2
    for kind, name in (
        ("torque along body axes", "torque"),
        ("torque along world axes", "torque_world"),
    ):
        yield fitted(kind, none, size, partial(_pushed, name))


def _pushed(name: str, h: Hypothesis, torque: FloatArray) -> Hypothesis:
    return h.of(**{name: getattr(h.equations, name) + torque})


def _slowed(h: Hypothesis, c: float, a: float = 0.0, b: float = 0.0) -> Hypothesis:
    return h.of(slowing=h.equations.slowing + np.array([c, a, b]))


def resistance(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """A torque that opposes ω, beside the scene's own torques; one number is fitted."""
    size = mean_moment(e) * _fastest(scenario, e)
    yield fitted("resistance", np.zeros(1), size, lambda h, n: _slowed(h, n[0]))


def com(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """The centre of mass, where a motion shows it: of a body on a pivot under gravity."""
    if scenario.constraint.is_pivot and e.gravity_world.any():
        place, mass = np.array(scenario.body.com), scenario.body.mass

        def moved(h: Hypothesis, com: FloatArray) -> Hypothesis:
            here, there = (mass * (r @ r * np.eye(3) - np.outer(r, r)) for r in (place, com))
            return h.of_tensor(e.inertia - here + there).of(pull=mass * com)

        yield fitted("com", place, float(np.linalg.norm(place)) or 1.0, moved)


def mean_moment(e: OtherEquations) -> float:
    """The mean moment, kg m²."""
    return float(np.trace(e.inertia)) / 3


def _fastest(scenario: Scenario, e: OtherEquations) -> float:
    """The rate at which the scene's state changes, or |ω| at its start, rad/s."""
    return e.rate or float(np.linalg.norm(scenario.start.omega_body)) or 1.0
