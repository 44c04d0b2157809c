"""Changes of what acts on a body: gravity, drag, torques, rotors, the centre of mass."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ....reference.other_equations import (
    TORQUE_UNTURNED,
    TURNED_ON,
    UNTURNED,
    OtherEquations,
)
from ....scenarios import FloatArray, Scenario
from .hypothesis import Change, Hypothesis, factors, fitted, set_to

#: Largest absolute value of p where a drag f ‖ω‖ᵖ ω is fitted.
POWER = 4.0
#: The powers p of quadratic drag and of dry friction.
POWERS = 1.0, -1.0
#: The names of the numbers of `OtherEquations.slowing`.
SLOWING = "c", "a", "b"


def of_effects(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes of gravity, drag and torques.

    Parameters
    ----------
    e : the scene's own equations
    """
    # Gravity does not change the rotation of a free body, but the com's motion shows it.
    if e.gravity_world.any():
        yield from factors("gravity's size", 0.0, -1.0, gravity_world=e.gravity_world)
    of_com = scenario.body.mass * np.array(scenario.body.com)
    if e.gravity_world.any() and of_com.any() and not (scenario.constraint.is_pivot or e.mobility):
        yield set_to("gravity on a free body", pull=of_com)
    yield from resistance(scenario, e)
    rate = usual_rate(scenario, e)
    yield from _of_decay(e, rate)
    yield from _scaled_torques(e)
    if e.torque.any() or e.torque_world.any():
        along_other_axes: dict[str, Any] = {"torque": e.torque_world, "torque_world": e.torque}
        yield set_to("torque along other axes", **along_other_axes)
    if (e.pull.any() and e.gravity_world.any()) or e.torque_world.any():
        yield set_to("world vectors turned on", world_vectors=TURNED_ON)
        yield set_to("world vectors unturned", world_vectors=UNTURNED)
    if e.pull.any() and e.gravity_world.any():
        yield set_to("torques unturned", world_vectors=TORQUE_UNTURNED)
    yield from _of_drag(scenario, e)
    if e.gravity_world.any():
        size = float(np.linalg.norm(e.gravity_world))
        yield fitted("gravity", e.gravity_world, size, lambda h, g: h.of(gravity_world=g))
    yield from _additional_torques(scenario, e)


def torques(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that scale the scene's constant torques, or add a constant torque.

    Parameters
    ----------
    e : the scene's own equations
    """
    yield from _scaled_torques(e)
    yield from _additional_torques(scenario, e)


def _additional_torques(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that add a fitted constant torque, along body axes or along world axes.

    `e` are the scene's own equations, from which the torque's typical size is computed.
    """
    size = usual_torque(scenario, e)
    for kind, name in (
        ("torque along body axes", "torque"),
        ("torque along world axes", "torque_world"),
    ):
        yield fitted(kind, np.zeros(3), size, partial(_with_torque, name))


def _scaled_torques(e: OtherEquations) -> Iterator[Change]:
    """Yield changes that scale the constant torques of a scene; none if it has no such torques.

    `e` are the scene's own equations.
    """
    if e.torque.any() or e.torque_world.any():
        terms_of_torque: dict[str, Any] = {"torque": e.torque, "torque_world": e.torque_world}
        yield from factors("torque's size", 0.0, -1.0, **terms_of_torque)


def _of_decay(e: OtherEquations, rate: float) -> Iterator[Change]:
    """Yield changes in which angular momentum decays, beside the scene's drag or in place of it.

    Parameters
    ----------
    e : the scene's own equations
    rate : typical size of the fitted rate, 1/s
    """
    none = np.zeros(2)
    yield fitted("decay", none[:1], rate, partial(_with_drag, "a"))
    if e.slowing[0]:
        yield fitted(
            "decay for drag",
            *(none[:1], rate),
            lambda h, n: h.of(slowing=n * np.eye(3)[1]),
        )
    # If L decays at the rate a + b ‖ω‖, a and b must have the same sign to be plausible.
    yield fitted(
        "decays",
        *(none, np.array([rate, 1.0])),
        partial(_with_drag, "ab"),
        lambda _, n: float(np.prod(n)) >= 0,
    )


def drags_law(scenario: Scenario, e: OtherEquations, power: float | None = None) -> Change:
    """Return the change that replaces the scene's drag by a drag f ‖ω‖ᵖ ω, with a fitted f.

    Parameters
    ----------
    e : the scene's own equations
    power : the power p; fitted as well if None
    """
    c, rate = e.slowing[0], usual_rate(scenario, e)

    def friction(n: FloatArray) -> FloatArray:
        """Return f and p of a drag f ‖ω‖ᵖ ω, (..., 2), given parameters n, (..., 1) or (..., 2).

        The first parameter is f rateᵖ − c, with c the coefficient of the scene's drag: by this much
        the coefficient at ‖ω‖ = `rate` differs from the scene's. The second, if any, is p.
        """
        added = n[..., 0]
        p = np.clip(n[..., 1], -POWER, POWER) if power is None else np.full_like(added, power)
        return np.stack([(c + added) * rate**-p, p], axis=-1)

    return Change(
        "drag's law",
        lambda h, n: h.of(slowing=np.zeros(3), friction=friction(n)),
        np.array([mean_moment(e) * rate, 1.0][: 2 if power is None else 1]),
        lambda n: friction(n) + np.array([0.0, 1.0]),
    )


def drags_of_other_powers(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield the changes that replace drag by quadratic drag and by dry friction, of fitted size.

    Parameters
    ----------
    e : the scene's own equations
    """
    yield from (drags_law(scenario, e, power) for power in POWERS)


def _of_drag(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that replace the scene's drag by another function of ω.

    `e` are the scene's own equations.
    """
    c, size = e.slowing[0], mean_moment(e) * usual_rate(scenario, e)
    yield drags_law(scenario, e)
    yield fitted(
        "drag along each axis",
        *(np.full(3, c), size),
        lambda h, n: h.of(slowing=np.zeros(3), damping=n),
    )
    if c:
        for axes, turned in ("of ω in the world", np.eye(2)[0]), ("turned back", np.eye(2)[1]):
            yield set_to(f"drag {axes}", slowing=np.zeros(3), turned_drag=c * turned)


def _with_torque(name: str, h: Hypothesis, torque: FloatArray) -> Hypothesis:
    """Return H hypotheses `h`, with torques added to their constant torques in body or world axes.

    Parameters
    ----------
    name : "torque" for body axes, "torque_world" for world axes
    torque : N m, (H, 3)
    """
    return h.of(**{name: getattr(h, name) + torque})


def _with_drag(names: Sequence[str], h: Hypothesis, n: FloatArray) -> Hypothesis:
    """Return H hypotheses `h`, with numbers added to their coefficients of drag and decay.

    Parameters
    ----------
    names : names of the k coefficients: c, of linear drag, N m s; a, 1/s, and b, with which the
        angular momentum decays at the rate a + b ‖ω‖
    n : the numbers, (H, k)
    """
    return h.of(slowing=h.slowing + n @ np.eye(3)[[SLOWING.index(name) for name in names]])


def resistance(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that scale the scene's drag, or add linear drag if the scene has none.

    Parameters
    ----------
    e : the scene's own equations
    """
    if e.slowing[0]:
        yield from factors("resistance's size", 0.0, -1.0, slowing=e.slowing)
        return
    size = mean_moment(e) * usual_rate(scenario, e)
    yield fitted("resistance", np.zeros(1), size, partial(_with_drag, "c"))


def com(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield the change of the com, and with it of gravity's torque and the tensor about the pivot.

    It is yielded only for a body on a pivot under gravity, as other motions do not show it.

    Parameters
    ----------
    e : the scene's own equations
    """
    if scenario.constraint.is_pivot and e.gravity_world.any():
        place, mass = np.array(scenario.body.com), scenario.body.mass
        about_com = e.inertia - mass * _of_parallel_axes(place)

        def moved(h: Hypothesis, com: FloatArray) -> Hypothesis:
            return h.with_inertia(about_com + mass * _of_parallel_axes(com)).of(pull=mass * com)

        yield fitted("com", place, float(np.linalg.norm(place)) or 1.0, moved)


def _of_parallel_axes(r: FloatArray) -> FloatArray:
    """Return the tensors of inertia of a unit mass at r about the origin, m², (..., 3, 3).

    They are r² 1 − r rᵀ, the term of the parallel axis theorem.

    Parameters
    ----------
    r : vectors, m, (..., 3)
    """
    squares = np.sum(r**2, axis=-1)[..., None, None]
    return np.asarray(squares * np.eye(3) - r[..., :, None] * r[..., None, :])


def lever(e: OtherEquations) -> Iterator[Change]:
    """Yield the change of gravity's lever, mass times com, kg m, while the tensor stays as it is.

    It is yielded only if gravity has a torque.

    Parameters
    ----------
    e : the scene's own equations
    """
    if e.pull.any() and e.gravity_world.any():
        size = float(np.linalg.norm(e.pull))
        yield fitted("lever", e.pull, size, lambda h, n: h.of(pull=n))


def of_momentum(e: OtherEquations) -> Iterator[Change]:
    """Yield changes that scale the rotors' angular momentum; none if it is zero.

    Parameters
    ----------
    e : the scene's own equations
    """
    if e.kept.any():
        yield from factors("momentum", 0.0, -1.0, kept=e.kept)


def mean_moment(e: OtherEquations) -> float:
    """Return the mean principal moment of inertia in equations `e`, kg m²."""
    return float(np.trace(e.inertia)) / 3


def usual_torque(scenario: Scenario, e: OtherEquations) -> float:
    """Return a typical torque, N m: it changes ω by ‖ω‖ or so while the body turns by a radian.

    Parameters
    ----------
    e : the scene's own equations
    """
    return mean_moment(e) * usual_rate(scenario, e) ** 2


def usual_rate(scenario: Scenario, e: OtherEquations) -> float:
    """Return a typical rate of the motion, rad/s, from which scales of parameters are computed.

    It is the fastest rate besides ‖ω‖ at which the state changes, `e.rate`; if that is 0, ‖ω‖ at
    the scene's start; if both are 0, 1.

    Parameters
    ----------
    e : the scene's own equations
    """
    return float(e.rate) or float(np.linalg.norm(scenario.start.omega_body)) or 1.0
