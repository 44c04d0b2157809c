"""The conservation laws of tops, each with the rule for when it holds, as data."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..scenarios import EFFECTS, FloatArray, Scenario, Trajectory, angular_momentum_world
from ..scenarios import energy as energy_of
from ..scenarios.effects import Effect
from . import integrable_cases
from .effect_terms import TERMS, turning
from .problem import Problem
from .symmetry import (
    angular_momentum_axes,
    gravity_torque_scale,
    norm,
    symmetry_axis,
    to_body,
    up_world,
)

#: Direction of the normal of a table, in world axes.
UP_WORLD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class InvariantScales:
    """Sizes that are typical of one scene, from which `Law.scale` is computed.

    Each size includes what gravity can add to a body that starts at rest, so that a size is zero
    only if the body cannot move in the corresponding way.
    """

    scenario: Scenario
    problem: Problem

    @cached_property
    def pull(self) -> float:
        """M g l, the largest torque of gravity, N m; 0 for a free body."""
        return float(gravity_torque_scale(self.problem))

    @cached_property
    def rate(self) -> float:
        """An upper estimate of ‖ω‖, rad/s: ‖ω‖ at t = 0 plus 2√(M g l/I).

        The second term is the rate that a pendulum gains in falling from the top to the bottom.
        M g l is the largest torque of gravity, `pull`, and I the least principal moment.
        """
        fall = 2 * np.sqrt(self.pull / float(min(self.problem.moments)))
        return float(norm(self.problem.omega_axes)) + float(fall)

    @cached_property
    def angular_momentum(self) -> float:
        """An upper estimate of ‖L‖, kg m²/s: ‖L‖ at t = 0, plus 2√(M g l I), plus ‖τ‖ t.

        The second term is what a pendulum with the greatest principal moment I gains in falling
        from the top to the bottom; the third is the impulse of the constant torques τ within the
        window's length t.
        """
        fall = 2 * np.sqrt(self.pull * float(max(self.problem.moments)))
        torque = float(norm(self.problem.torque_world) + norm(self.problem.torque_axes))
        impulse = torque * self.duration
        return float(norm(angular_momentum_axes(self.problem))) + float(fall) + impulse

    @cached_property
    def energy(self) -> float:
        """An upper estimate of the kinetic energy, J.

        It is the one at t = 0 plus what gravity can add to it within the window.
        """
        numbers = zip(self.problem.moments, self.problem.omega_axes, strict=True)
        turning = float(sum(moment * w * w for moment, w in numbers)) / 2
        turning += self.scenario.kept_sizes[1]
        turning += 2 * self.pull
        if self.scenario.constraint.is_pivot:
            return turning
        fall = float(np.linalg.norm(self.scenario.gravity_world)) * self.duration
        straight = float(np.linalg.norm(self.scenario.start.velocity_world))
        return turning + self.scenario.body.mass * (straight + fall) ** 2 / 2

    @cached_property
    def speed(self) -> float:
        """Speed of the centre of mass, m/s, if all of `energy` were in its translation."""
        return float(np.sqrt(2 * self.energy / self.scenario.body.mass))

    @cached_property
    def radius(self) -> float:
        """Radius of gyration √(tr I/2m), m, about the pivot, or about the com without one."""
        trace = float(sum(self.problem.moments))
        return float(np.sqrt(trace / (2 * self.scenario.body.mass)))

    @cached_property
    def duration(self) -> float:
        """Length of the window, s."""
        return self.scenario.window.duration

    @cached_property
    def up_world(self) -> FloatArray:
        """The upward vertical, world axes, unit vector (3,).

        On a table it is the normal of the table, otherwise −g/|g|, for which g must not be zero.
        """
        return UP_WORLD if self.problem.slides else up_world(self.problem)

    @property
    def is_flying(self) -> FloatArray:
        """1 along each axis of the world along which nothing holds the body, else 0, (3,)."""
        return 1.0 - np.array(self.scenario.constraint.is_held)

    @cached_property
    def axis_body(self) -> FloatArray:
        """Unit vector of a symmetric top's axis, body axes, (3,)."""
        axis = symmetry_axis(self.problem)
        assert axis is not None, "a symmetric top has an axis"
        return np.array(to_body(self.problem, axis), dtype=float)


@dataclass(frozen=True)
class Law:
    """A quantity that some motions conserve.

    Attributes
    ----------
    name : how results refer to it
    formula, unit : formula and unit of the quantity
    holds : returns whether a scene conserves the quantity
    values : returns the quantity along a trajectory, (n,) or (n, 3)
    scale : returns the size by which changes of the quantity are divided, in its unit
    title : title of the quantity's value among the facts of a scene; empty if it is not shown
    """

    name: str
    formula: str
    unit: str
    holds: Callable[[InvariantScales], bool]
    values: Callable[[InvariantScales, Trajectory], FloatArray]
    scale: Callable[[InvariantScales], float]
    title: str = ""


def _energy(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return kinetic plus potential energy less the work of rotors' motors, J, (n,).

    n is the number of samples. The motors keep the spins of driven rotors constant.
    """
    total = energy_of(scene.scenario, motion)
    for work in filter(None, (effect.work for effect in scene.scenario.acting)):
        total = total - work(scene.scenario, motion)
    return total


def _L_world(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return the angular momentum L less the impulse τ t, world axes, kg m²/s, (n, 3).

    n is the number of samples, and τ the torque that is fixed in the world.
    """
    impulse = motion.t[:, None] * scene.scenario.pushed["torque_world"]
    return np.asarray(angular_momentum_world(scene.scenario, motion) - impulse)


def _L_norm(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return ‖L − τ t‖ at n samples, kg m²/s, (n,), with τ the torque fixed in the world."""
    return np.asarray(np.linalg.norm(_L_world(scene, motion), axis=1))


def _L_vertical(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return the upward component of L − τ t at n samples, kg m²/s, (n,).

    τ is the torque that is fixed in the world.
    """
    return np.asarray(_L_world(scene, motion) @ scene.up_world)


def _L_axial(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return L along the axis of a symmetric top less τ3 t, at n samples, kg m²/s, (n,).

    τ3 is the component of the torque fixed in the body along this axis, and τ3 t its impulse.
    """
    axis_world = motion.R_world_body.apply(scene.axis_body)
    L_world = angular_momentum_world(scene.scenario, motion)
    impulse = motion.t * (scene.scenario.pushed["torque_body"] @ scene.axis_body)
    return np.asarray(np.einsum("ni,ni->n", L_world, axis_world) - impulse)


def _kovalevskaya(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    frame = integrable_cases.kovalevskaya_frame(scene.problem)
    assert frame is not None, "the law holds for Kovalevskaya's top only"
    return integrable_cases.kovalevskaya(scene.problem, frame, motion)


def _goryachev_chaplygin(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    frame = integrable_cases.goryachev_chaplygin_frame(scene.problem)
    assert frame is not None, "the law holds for the Goryachev–Chaplygin top only"
    return integrable_cases.goryachev_chaplygin(scene.problem, frame, motion)


def _momentum(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return m (v − g t), v the com's velocity, at n samples, kg m/s, (n, 3); 0 along held axes."""
    gained = motion.t[:, None] * scene.scenario.gravity_world
    return scene.scenario.body.mass * (motion.velocity_world - gained) * scene.is_flying


def _parabola(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return the com's place at t = 0 if it had fallen freely to each of n states, m, (n, 3).

    It is r − v t + ½ g t², with position r and velocity v of the com; 0 along held axes.
    """
    t = motion.t[:, None]
    fallen = t**2 / 2 * scene.scenario.gravity_world
    return (motion.com_world - t * motion.velocity_world + fallen) * scene.is_flying


def _held_point(scene: InvariantScales, motion: Trajectory) -> FloatArray:
    """Return the place of the body's point that its constraint holds, at n samples, m, (n, 3).

    It is 0 along world axes along which the point is not held.
    """
    constraint = scene.scenario.constraint
    point_world = motion.com_world - motion.R_world_body.apply(np.array(constraint.lever))
    return point_world * constraint.is_held


def _is_left(law: str) -> Callable[[InvariantScales], bool]:
    """Return a function that tells whether no effect of a scene breaks the law of a given name.

    An effect that turns the body breaks all laws except those in its `EffectTerms.keeps`.
    """
    return lambda scene: all(law in TERMS[name].keeps for name in turning(scene.problem))


def _is_heavy(scene: InvariantScales) -> bool:
    """Whether a vertical force turns the body, and no effect changes the vertical part of L."""
    pulls = any(TERMS[name].pulls for name in turning(scene.problem))
    return pulls and _is_left("L_vertical")(scene)


def _is_symmetric(scene: InvariantScales) -> bool:
    """Whether the body has an axis of symmetry, and no effect changes L along it."""
    return _is_left("L_axial")(scene) and symmetry_axis(scene.problem) is not None


def _is_thrown(scene: InvariantScales) -> bool:
    """Whether the body has no pivot, and gravity is the only force on its com.

    Forces along world axes along which the body is held do not count.
    """
    forces = {effect.name for effect in scene.scenario.acting if effect.is_force}
    return not scene.scenario.constraint.is_pivot and forces <= {"gravity"}


def _of_held_point(effect: Effect) -> Law:
    """Return the law that the point held by a constraint stays in its place.

    The law has the name of the effect that is the constraint.
    """
    return Law(
        name=effect.name,
        formula=effect.place_formula,
        unit="m",
        holds=lambda scene: effect in scene.scenario.acting,
        values=_held_point,
        scale=lambda scene: scene.radius,
    )


LAWS = (
    Law(
        name="energy",
        formula="E = T + V, less the work of drives",
        unit="J",
        holds=_is_left("energy"),
        values=_energy,
        scale=lambda scene: scene.energy,
    ),
    Law(
        name="L_world",
        formula="L − τ t, as vectors",
        unit="kg m²/s",
        holds=_is_left("L_world"),
        values=_L_world,
        scale=lambda scene: scene.angular_momentum,
    ),
    Law(
        name="L_norm",
        formula="‖L‖",
        unit="kg m²/s",
        holds=_is_left("L_norm"),
        values=_L_norm,
        scale=lambda scene: scene.angular_momentum,
    ),
    Law(
        name="L_vertical",
        formula="p_α − τ·(−ĝ) t, p_α = L·(−ĝ)",
        unit="kg m²/s",
        holds=_is_heavy,
        values=_L_vertical,
        scale=lambda scene: scene.angular_momentum,
    ),
    Law(
        name="L_axial",
        formula="p_γ − τ3 t, p_γ = I3 ω3",
        unit="kg m²/s",
        holds=_is_symmetric,
        values=_L_axial,
        scale=lambda scene: scene.angular_momentum,
    ),
    Law(
        name="kovalevskaya",
        formula="|(ω1 + iω2)² − (M g l/I3)(γ1 + iγ2)|²",
        unit="rad⁴/s⁴",
        holds=lambda scene: integrable_cases.kovalevskaya_frame(scene.problem) is not None,
        values=_kovalevskaya,
        scale=lambda scene: scene.rate**4,
        title="Kovalevskaya's constant",
    ),
    Law(
        name="goryachev_chaplygin",
        formula="ω3(ω1² + ω2²) − (M g l/I3) ω1 γ3",
        unit="rad³/s³",
        holds=lambda scene: integrable_cases.goryachev_chaplygin_frame(scene.problem) is not None,
        values=_goryachev_chaplygin,
        scale=lambda scene: scene.rate**3,
        title="Goryachev–Chaplygin constant",
    ),
    Law(
        name="rotors_momentum",
        formula="C (u·ω + s) on free hinges, C s on driven ones",
        unit="kg m²/s",
        holds=lambda scene: bool(scene.problem.kept),
        values=lambda scene, motion: scene.scenario.kept(motion.omega_body, motion.spins),
        scale=lambda scene: float(scene.scenario.kept_sizes[0].sum()),
    ),
    Law(
        name="momentum_less_impulse",
        formula="m (v − g t), of a body on a table along it",
        unit="kg m/s",
        holds=_is_thrown,
        values=_momentum,
        scale=lambda scene: scene.scenario.body.mass * scene.speed,
    ),
    Law(
        name="com_parabola",
        formula="r − v t + ½ g t², of a body on a table along it",
        unit="m",
        holds=_is_thrown,
        values=_parabola,
        scale=lambda scene: scene.speed * scene.duration,
    ),
    *(_of_held_point(effect) for effect in EFFECTS.values() if effect.constraint is not None),
)
