"""What each effect adds to the equations of motion: its numbers, and its terms of ω'.

A term has one of the forms that `taylor_coefficients` knows the series of. A pivot has none: it
is why the equations are about the body's origin.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from mpmath import mpf

from ..scenarios import Scenario
from ..scenarios.exact import ZERO, Quaternion, Vector, rotate, vector
from ..scenarios.gyrostat import kept_exact
from .problem import Problem
from .taylor_coefficients import (
    CONSTANT,
    DOWN_AND_RADIUS,
    GRAVITY_WORLD,
    LEVER_AFTER,
    LEVER_NEXT,
    LINEAR,
    MASS_OVER_MOMENT,
    MOMENTUM,
    TIP,
    TORQUE_WORLD,
    UP_WORLD,
)

#: A lever times a vector fixed in the world; a torque fixed in the world; one fixed in the body,
#: which is a constant; one proportional to ω; a force that keeps a point on a plane; a momentum
#: fixed in the body, times ω.
Form = Literal["lever", "world", "constant", "linear", "plane", "momentum"]


@dataclass(frozen=True, eq=False)
class EffectTerms:
    """The terms of one effect.

    Attributes
    ----------
    form : of its term
    posed : its numbers as attributes of a `Problem`, given what takes body components to axes'
    turns : whether it turns the body of a problem at all
    constants : by row of the table of constants, for one axis i and the next two j and k
    """

    form: Form
    posed: Callable[[Scenario, Quaternion], dict[str, Any]]
    turns: Callable[[Problem], bool]
    constants: Callable[[Problem, int, int, int], dict[int, mpf]]


def _lever_body(scenario: Scenario) -> Vector:
    """Mass times com, kg m, where gravity has a pivot to pull about."""
    if not {"pivot", "gravity"} <= scenario.called_for:
        return ZERO
    x, y, z = scenario.body.com_exact
    mass = scenario.body.mass_exact
    return (mass * x, mass * y, mass * z)


GRAVITY = EffectTerms(
    form="lever",
    posed=lambda scenario, q: {
        "lever_axes": rotate(q, _lever_body(scenario)),
        "gravity_world": vector(scenario.gravity_world),
    },
    turns=lambda problem: any(problem.lever_axes) and any(problem.gravity_world),
    constants=lambda problem, i, j, k: {
        LEVER_NEXT: problem.lever_axes[j] / problem.moments[i],
        LEVER_AFTER: -problem.lever_axes[k] / problem.moments[i],
        GRAVITY_WORLD: problem.gravity_world[i],
    },
)

DRAG = EffectTerms(
    form="linear",
    posed=lambda scenario, _: {"drag": mpf(scenario.pushed["drag"])},
    turns=lambda problem: bool(problem.drag),
    constants=lambda problem, i, *_: {LINEAR: -problem.drag / problem.moments[i]},
)

TORQUE_OF_BODY = EffectTerms(
    form="constant",
    posed=lambda scenario, q: {"torque_axes": rotate(q, vector(scenario.pushed["torque_body"]))},
    turns=lambda problem: any(problem.torque_axes),
    constants=lambda problem, i, *_: {CONSTANT: problem.torque_axes[i] / problem.moments[i]},
)

TORQUE_OF_WORLD = EffectTerms(
    form="world",
    posed=lambda scenario, _: {"torque_world": vector(scenario.pushed["torque_world"])},
    turns=lambda problem: any(problem.torque_world),
    constants=lambda problem, i, *_: {TORQUE_WORLD: problem.torque_world[i]},
)


def _posed_table(scenario: Scenario, q: Quaternion) -> dict[str, Vector | mpf]:
    table = scenario.effects.table
    if table is None:
        return {}
    x, y, z = rotate(q, scenario.constraint.lever_exact)
    radius, mass = mpf(table.radius), scenario.body.mass_exact
    return {"tip_axes": (-x, -y, -z), "tip_radius": radius, "mass": mass}


TABLE = EffectTerms(
    form="plane",
    posed=_posed_table,
    turns=lambda problem: any(problem.tip_axes),
    constants=lambda problem, i, *_: {
        TIP: problem.tip_axes[i],
        MASS_OVER_MOMENT: problem.mass / problem.moments[i],
        UP_WORLD: mpf(i == 2),
        DOWN_AND_RADIUS: (
            -problem.gravity_world[2],
            problem.tip_radius,
            mpf(problem.ends_at_lift_off),
        )[i],
    },
)

ROTORS = EffectTerms(
    form="momentum",
    posed=lambda scenario, q: {
        "kept": tuple(
            kept_exact(rotor, scenario.start.omega_body_exact) for rotor in scenario.rotors.each
        ),
        "rotors_axes": tuple(rotate(q, rotor.axis) for rotor in scenario.rotors.each),
    },
    turns=lambda problem: any(problem.rotors_momentum),
    constants=lambda problem, i, *_: {MOMENTUM: problem.rotors_momentum[i]},
)

#: By the effect's name.
TERMS = {
    "gravity": GRAVITY,
    "table": TABLE,
    "drag": DRAG,
    "torque_body": TORQUE_OF_BODY,
    "torque_world": TORQUE_OF_WORLD,
    "rotors": ROTORS,
}


def turning(problem: Problem) -> frozenset[str]:
    """Names of the effects that turn the body: gravity only about a pivot that is not the com."""
    return frozenset(name for name, terms in TERMS.items() if terms.turns(problem))
