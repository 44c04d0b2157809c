"""What each effect adds to the equations of motion: its numbers, and its terms of ω'.

Each entry also names the conservation laws that the effect leaves valid, and yields derived facts
of its own.

A term has one of the forms whose series `taylor_coefficients` computes. A pivot adds no term,
because the equations are about the point that it holds.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from mpmath import mpf

from ..scenarios import Scenario
from ..scenarios.effects.rotors import gyroscopic_rate
from ..scenarios.exact import ZERO, Quaternion, Vector, rotate, vector
from ..scenarios.gyrostat import kept_exact
from ..scenarios.principal import IDENTITY
from .fact import Fact
from .problem import Problem
from .symmetry import moment_about, norm, symmetry_axis
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

#: Forms of terms of I ω', in this order: the cross product of a lever and a vector fixed in the
#: world; a torque fixed in the world; a torque fixed in the body, which is a constant; a torque
#: proportional to ω; a force that keeps a point on a plane; the cross product of an angular
#: momentum fixed in the body and ω.
Form = Literal["lever", "world", "constant", "linear", "plane", "momentum"]


#: Changes of a problem's numbers, in extended precision, by the attribute of `Problem`.
Numbers = dict[str, Any]
#: Changes for one unit of each parameter, by its name: a list for a vector, one entry for a scalar.
ByParameter = dict[str, list[Numbers] | Numbers]


class BodyChange(NamedTuple):
    """A change of the numbers in a scene's table `[body]`.

    Attributes
    ----------
    mass : change of the mass, kg
    moment_body : change of mass times com, Σ m r from the body's origin, kg m, body axes
    lever_body : change of the vector to the com from the point that is held, or from the origin of
        a free body, m, body axes
    """

    mass: mpf
    moment_body: Vector
    lever_body: Vector


def _no_facts(scenario: Scenario, problem: Problem) -> Iterator[Fact]:  # noqa: ARG001
    yield from ()


def _no_parameters(scenario: Scenario, q: Quaternion) -> ByParameter:  # noqa: ARG001
    return {}


def _no_change(*_: object) -> Numbers:
    return {}


@dataclass(frozen=True, eq=False)
class EffectTerms:
    """The terms that one effect adds to the equations of motion.

    Attributes
    ----------
    form : mathematical form of the effect's torque, such as "constant" or "linear" in ω
    posed : returns the effect's numbers, by attribute of `Problem`, given the scene and the
        quaternion from body axes to principal axes
    turns : returns whether the effect turns the body of a problem at all
    constants : returns the effect's constants, by the rows that `taylor_coefficients` names, for
        one axis i and the next two axes j and k
    keeps : names of the conservation laws that hold although the effect turns the body
    facts : yields the derived numbers of a scene that come from the effect
    parameters : returns how much the numbers in `posed` change for one unit of each parameter of
        the effect; all constants are linear in these numbers
    by_omega : returns how much these numbers change for a change of ω at the start, rad/s, body
        axes
    by_body : returns how much these numbers change for a change of the body
    """

    form: Form
    posed: Callable[[Scenario, Quaternion], dict[str, Any]]
    turns: Callable[[Problem], bool]
    constants: Callable[[Problem, int, int, int], dict[int, mpf]]
    keeps: frozenset[str] = frozenset()
    facts: Callable[[Scenario, Problem], Iterator[Fact]] = _no_facts
    parameters: Callable[[Scenario, Quaternion], ByParameter] = _no_parameters
    by_omega: Callable[[Scenario, Vector], Numbers] = _no_change
    by_body: Callable[[Scenario, Quaternion, BodyChange], Numbers] = _no_change

    @property
    def pulls(self) -> bool:
        """Whether the effect is a force of fixed direction in the world that exerts a torque."""
        return self.form in ("lever", "plane")


def _lever_body(scenario: Scenario) -> Vector:
    """Return mass times com, kg m, body axes; zero unless the scene has gravity and a pivot."""
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
    keeps=frozenset({"energy", "L_vertical", "L_axial"}),
    parameters=lambda *_: {"gravity": [{"gravity_world": unit} for unit in IDENTITY]},
    by_body=lambda scenario, q, change: (
        {"lever_axes": rotate(q, change.moment_body)} if scenario.constraint.is_pivot else {}
    ),
)


def _spin_down(scenario: Scenario, problem: Problem) -> Iterator[Fact]:  # noqa: ARG001
    """Yield the spin-down time, s, of a symmetric body under drag; nothing for any other body.

    `scenario` is not used: all effects' functions that yield facts have the same parameters.
    """
    axis = symmetry_axis(problem)
    if problem.drag and axis is not None:
        time = float(moment_about(problem, axis) / problem.drag)
        meaning = "I3/c: ω3 falls as exp(−t c/I3) under drag alone"
        yield Fact("spin-down time", time, "s", meaning)


DRAG = EffectTerms(
    form="linear",
    posed=lambda scenario, _: {"drag": mpf(scenario.pushed["drag"])},
    turns=lambda problem: bool(problem.drag),
    constants=lambda problem, i, *_: {LINEAR: -problem.drag / problem.moments[i]},
    facts=_spin_down,
    parameters=lambda *_: {"drag": {"drag": mpf(1)}},
)

TORQUE_OF_BODY = EffectTerms(
    form="constant",
    posed=lambda scenario, q: {"torque_axes": rotate(q, vector(scenario.pushed["torque_body"]))},
    turns=lambda problem: any(problem.torque_axes),
    constants=lambda problem, i, *_: {CONSTANT: problem.torque_axes[i] / problem.moments[i]},
    keeps=frozenset({"L_axial"}),
    parameters=lambda _, q: {"torque_body": [{"torque_axes": rotate(q, u)} for u in IDENTITY]},
)

TORQUE_OF_WORLD = EffectTerms(
    form="world",
    posed=lambda scenario, _: {"torque_world": vector(scenario.pushed["torque_world"])},
    turns=lambda problem: any(problem.torque_world),
    constants=lambda problem, i, *_: {TORQUE_WORLD: problem.torque_world[i]},
    keeps=frozenset({"L_world", "L_vertical"}),
    parameters=lambda *_: {"torque_world": [{"torque_world": unit} for unit in IDENTITY]},
)


def _posed_table(scenario: Scenario, q: Quaternion) -> dict[str, Vector | mpf]:
    """Return the attributes of `Problem` that describe a scene's table; empty without a table.

    `q` is the quaternion from body axes to principal axes.
    """
    table = scenario.effects.table
    if table is None:
        return {}
    x, y, z = rotate(q, scenario.constraint.lever_exact)
    radius, mass = mpf(table.radius), scenario.body.mass_exact
    return {"tip_axes": (-x, -y, -z), "tip_radius": radius, "mass": mass}


def _body_on_table(scenario: Scenario, q: Quaternion, change: BodyChange) -> Numbers:  # noqa: ARG001
    """Return the changes of `tip_axes`, m, and `mass`, kg, in `Problem`, for a body on a table.

    Parameters
    ----------
    scenario : not used; other effects' functions of this kind need it
    q : the quaternion from body axes to principal axes
    change : the change of the body
    """
    x, y, z = rotate(q, change.lever_body)
    return {"tip_axes": (-x, -y, -z), "mass": change.mass}


TABLE = EffectTerms(
    form="plane",
    posed=_posed_table,
    turns=lambda problem: problem.slides,
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
    keeps=GRAVITY.keeps,
    by_body=_body_on_table,
)


def _momentum_of_rotors(scenario: Scenario, problem: Problem) -> Iterator[Fact]:
    """Yield ‖h‖, kg m²/s, and the rate at which h × ω turns ω, rad/s; nothing without rotors.

    h is the sum of the rotors' constant angular momenta.
    """
    if problem.kept:
        kept, rate = float(norm(problem.kept_momentum)), gyroscopic_rate(scenario)
        yield Fact("rotors' momentum", kept, "kg m²/s", "‖h‖, what free and driven hinges keep")
        yield Fact("gyroscopic rate", rate, "rad/s", "‖h‖ over the least moment across h")


def _spins(scenario: Scenario, q: Quaternion) -> ByParameter:  # noqa: ARG001
    """Return the changes of the rotors' constant angular momenta by 1 rad/s more of each spin.

    The dictionary has one entry, "spins": for each rotor, `{"kept": changes}`, where the changes,
    kg m²/s, are those of all rotors by this rotor's spin. They are zero if it is on a locked hinge.
    `q` is not used.
    """
    rotors = scenario.rotors.each
    return {
        "spins": [
            {"kept": [one.along * (one is other and one.hinge != "locked") for other in rotors]}
            for one in rotors
        ]
    }


def _kept_of_omega(scenario: Scenario, omega_body: Vector) -> Numbers:
    """Return how much the rotors' angular momenta about their axles change if ω at t = 0 changes.

    Along a motion each of these momenta is constant. It is C (u·ω + s) for a rotor on a free hinge,
    so that it depends on ω at t = 0; for other rotors the change is zero. The dictionary has one
    entry, "kept": a list of the changes, kg m²/s, one for each rotor.

    Parameters
    ----------
    omega_body : the change of ω at t = 0, rad/s, body axes
    """
    still = [replace(rotor, spin=mpf(0)) for rotor in scenario.rotors.each]
    return {"kept": [kept_exact(rotor, omega_body) for rotor in still]}


ROTORS = EffectTerms(
    form="momentum",
    posed=lambda scenario, q: {
        "kept": tuple(
            kept_exact(rotor, scenario.start.omega_body_exact) for rotor in scenario.rotors.each
        ),
        "kept_axes": tuple(rotate(q, rotor.axis) for rotor in scenario.rotors.each),
    },
    turns=lambda problem: any(problem.kept_momentum),
    constants=lambda problem, i, *_: {MOMENTUM: problem.kept_momentum[i]},
    keeps=frozenset({"energy", "L_world", "L_norm", "L_vertical"}),
    facts=_momentum_of_rotors,
    parameters=_spins,
    by_omega=_kept_of_omega,
)

#: The terms of each effect, by the effect's name.
TERMS = {
    "gravity": GRAVITY,
    "table": TABLE,
    "drag": DRAG,
    "torque_body": TORQUE_OF_BODY,
    "torque_world": TORQUE_OF_WORLD,
    "rotors": ROTORS,
}


def turning(problem: Problem) -> frozenset[str]:
    """Return the names of the effects that turn a problem's body.

    Gravity is among them only if there is a pivot that is not the com; on a table the effect that
    turns the body is the table.
    """
    return frozenset(name for name, terms in TERMS.items() if terms.turns(problem))


def is_undriven(problem: Problem) -> bool:
    """Whether no effect but gravity turns the body."""
    return turning(problem) <= {"gravity"}


def nutates(problem: Problem) -> bool:
    """Whether nothing turns the body but gravity and the force of a pivot or a table."""
    return is_undriven(problem) or turning(problem) == {"table"}


def is_free(problem: Problem) -> bool:
    """Whether no effect turns the body: no torque about the fixed point, no momentum of rotors."""
    return not turning(problem)
