"""A scenario as the rest of the program sees it: a body, its start, what acts on it, a window."""

import hashlib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from . import exact
from .body import Body
from .constraint import Constraint
from .document import Document, Expect, Window
from .effects import EFFECTS, Effect, Effects, EffectTable, rotors_of
from .effects.effect import Answer
from .float_array import FloatArray, read_only
from .gyrostat import Rotors, whole, without_free_axes
from .start import Start, StartTable, start_of
from .values import Table
from .write import to_toml

T = TypeVar("T", bound=EffectTable)

#: Tables that hold for one particular scene, not for a scene with another start or another number.
OF_THE_SCENE_ALONE = ("published", "expect", "known")
#: Number of scenes that a worker process keeps of those it is sent: more than are run at a time.
KEPT = 64


@dataclass(frozen=True, eq=False)
class Scenario:
    """One scene, whose values have been checked.

    Attributes
    ----------
    name : name of the scene, the stem of its file
    path : the file that the scene was read from; None for a scene built in memory
    text : text of the file, as read or as it would be written
    document : the tables of the file, parsed
    carrier : the body without its rotors
    rotors : its rotors
    start : the state at t = 0
    """

    name: str
    path: Path | None
    text: str
    document: Document
    carrier: Body
    rotors: Rotors
    start: Start

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the scene as text: mpmath would round its numbers to double precision."""
        return _rebuilt, (self.text, self.name, self.path)

    @cached_property
    def digest(self) -> str:
        """SHA-256, hexadecimal, of all that the motion depends on: identifies runs of the scene."""
        return self._digest("body", "rotors", "start", "effects", "window")

    @cached_property
    def judged_digest(self) -> str:
        """SHA-256, hexadecimal, of all that verdicts depend on: `expect` and `known` included."""
        return self._digest("body", "rotors", "start", "effects", "window", "expect", "known")

    def _digest(self, *tables: str) -> str:
        """Return the SHA-256, hexadecimal, of those tables of the file that `tables` names."""
        # Absent tables and keys are left out, so that a new effect in the format changes no other
        # scene's digest.
        written = self.document.model_dump_json(include=set(tables), exclude_none=True)
        return hashlib.sha256(written.encode()).hexdigest()

    @property
    def title(self) -> str:
        """The scene's title, one line."""
        return self.document.title

    @property
    def effects(self) -> Effects:
        """The tables in the file's `[effects]`, parsed."""
        return self.document.effects

    @property
    def window(self) -> Window:
        """The time span that is simulated, and the number of samples."""
        return self.document.window

    @property
    def expect(self) -> tuple[Expect, ...]:
        """What the scene expects of single runs: bounds on errors, or outcomes."""
        return self.document.expect

    @property
    def hard(self) -> bool:
        """Whether the scene is tagged `hard`: runs may blow up on it at ordinary timesteps."""
        return "hard" in self.document.tags

    @cached_property
    def called_for(self) -> frozenset[str]:
        """Names of the effects that the scene calls for, out of `EFFECTS`."""
        return frozenset(effect.name for effect in self.acting)

    @cached_property
    def acting(self) -> tuple[Effect, ...]:
        """The effects to simulate, in the order of `EFFECTS`."""
        return tuple(one for one in EFFECTS.values() if one.is_called_for(self.document))

    @cached_property
    def answer(self) -> Answer | None:
        """The function that adds the force of a table to torque and acceleration (`Effect.answer`).

        It is None for a free body, and for a body on a pivot.
        """
        return next((one.answer for one in self.acting if one.answer is not None), None)

    @cached_property
    def constraint(self) -> Constraint:
        """The constraint that holds the body; a free body has one that holds along no axis."""
        return _constraint(self.document, self.body)

    @property
    def is_jointed(self) -> bool:
        """Whether engines need joints for the scene: the body is held, or has rotors."""
        return not self.constraint.is_free or any(effect.is_part for effect in self.acting)

    @property
    def about(self) -> str:
        """The point that L and the moments of inertia are about: "pivot" or "com"."""
        return "pivot" if self.constraint.is_pivot else "com"

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return each rotor's constant angular momentum about its axle, kg m²/s, (n, rotors).

        On a free hinge it is C (u·ω + s), with u the unit vector of the axle, C the rotor's moment
        about it and s its spin; on any other hinge it is C s.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        spins : spins of the rotors in these states, relative to the body, rad/s, (n, rotors)
        """
        return self.rotors.kept(omega_body, spins)

    @cached_property
    def kept_at_start(self) -> FloatArray:
        """The constant angular momenta of the rotors about their axles, kg m²/s, (rotors,)."""
        return self.kept(self.start.omega_body, self.start_spins)

    @property
    def start_spins(self) -> FloatArray:
        """The spins of the rotors at t = 0, relative to the body, rad/s, (rotors,)."""
        return self.rotors.start_spins

    @property
    def largest_part(self) -> float:
        """The largest moment of a rotor about its axle, kg m²; 0 without rotors."""
        return float(max(self.rotors.along, default=0.0))

    @cached_property
    def kept_sizes(self) -> tuple[FloatArray, float]:
        """Sizes of the rotors' angular momenta, kg m²/s, (rotors,), and of their energy, J.

        With C a rotor's moment about its axle u and s its spin at the start, the size of its
        angular momentum is C (|s| + |u·ω|), and the size of the energy is Σ ½ C (|s| + |u·ω|)².
        """
        return self.rotors.sizes(self.start.omega_body)

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """Return the vector sum of the rotors' angular momenta, kg m²/s, body axes, (n, 3) or (3,).

        Parameters
        ----------
        kept : constant angular momentum of each rotor about its axle, kg m²/s, in n states,
            (n, rotors), or in one, (rotors,)
        """
        return self.rotors.kept_body(kept)

    def spins(self, omega_body: FloatArray, kept: FloatArray) -> FloatArray:
        """Return the rotors' spins, rad/s, (n, rotors), given their constant angular momenta.

        Parameters
        ----------
        omega_body : ω in n states, rad/s, body axes, (n, 3)
        kept : each rotor's constant angular momentum about its axle, kg m²/s, in these states,
            (n, rotors), or the same in all of them, (rotors,)
        """
        return self.rotors.spins(omega_body, kept)

    def cancelling(self, spins: FloatArray, far: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return sizes of inertial forces, N, and torques, N m, that cancel each other, (n,) each.

        They arise in coordinates that turn with the rotors. An engine that uses such coordinates
        makes rounding errors in proportion to these sizes; the formulas are in `Rotors.cancelling`.

        Parameters
        ----------
        spins : spins of the rotors in n states, rad/s, (n, rotors)
        far : distance of the coordinates' origin from the com, m
        """
        return self.rotors.cancelling(spins, self.body.com, far)

    @cached_property
    def body(self) -> Body:
        """The body, with its rotors counted as fixed parts of it."""
        return whole(self.carrier, self.rotors)

    @cached_property
    def inertia_exact(self) -> exact.Tensor:
        """Inertia tensor about the pivot, or the com where there is none, kg m², body axes.

        It is the tensor that multiplies ω': the moments of rotors on free hinges about their axles
        are left out.
        """
        body = self.body
        tensor = body.inertia_origin_exact if self.about == "pivot" else body.inertia_com_exact
        return self.without_free_axes(tensor)

    def without_free_axes(self, inertia: exact.Tensor) -> exact.Tensor:
        """Return an inertia tensor minus the axial moments of rotors on free hinges, kg m²."""
        return without_free_axes(inertia, self.rotors)

    @cached_property
    def inertia(self) -> FloatArray:
        """Inertia tensor about the pivot, or the com where there is none, kg m², body axes, (3, 3).

        The moments of rotors on free hinges about their axles are left out.
        """
        return read_only(self.inertia_exact)

    @cached_property
    def gravity_world(self) -> FloatArray:
        """Gravitational acceleration, m/s², world axes, (3,); zeros where there is none."""
        gravity = self.effects.gravity
        return read_only(gravity.acceleration if gravity else exact.ZERO)

    @cached_property
    def pushed(self) -> dict[str, Any]:
        """The parameters of the torques that `effects.push.push` adds up, by the effects' names.

        They are `torque_body` and `torque_world`, N m, (3,), in body and in world axes, and `drag`,
        the coefficient of drag, N m s. They are zero for effects that the scene does not call for.
        """
        return {
            one.name: one.pushed(one.table_in(self.document))
            for one in EFFECTS.values()
            if one.pushed
        }

    def table_of(self, model: type[T]) -> T | None:
        """Return an effect's parsed table in the scene's `[effects]`; None if it is not there.

        Parameters
        ----------
        model : class of the parsed table
        """
        return next((table for _, table in self.effects if isinstance(table, model)), None)

    @cached_property
    def times(self) -> FloatArray:
        """The window's sample times, s, (samples,)."""
        return read_only(np.linspace(0.0, self.window.duration, self.window.samples))


@lru_cache(maxsize=KEPT)
def _rebuilt(text: str, name: str, path: Path | None) -> Scenario:
    """Return the scene of a file's text; it is cached, so that equal texts give the same object."""
    return build(Document.model_validate(tomllib.loads(text)), name, text, path)


def build(document: Document, name: str, text: str, path: Path | None = None) -> Scenario:
    """Return the scenario of a parsed document.

    Parameters
    ----------
    name : name of the scene
    text : the text of its file
    path : the file; None for a scene built in memory
    """
    carrier, rotors = document.body.body(), rotors_of(document.rotors)
    start = _start(document, carrier, rotors)
    return Scenario(name, path, text, document, carrier, rotors, start)


def with_tables(scenario: Scenario, **tables: Table | tuple[Table, ...] | None) -> Scenario:
    """Return a scene with some tables of its file, such as `window`, replaced.

    The new tables are given in parsed form, by their names; `rotors=None` removes the rotors. The
    text of the new scene is generated from its tables. Published values and expectations are left
    out, as they hold only for the unchanged scene. The caller must make sure that the tables fit
    together, and that no quantity is too large or too small: this is not checked again.
    """
    alone: dict[str, object] = dict.fromkeys(OF_THE_SCENE_ALONE, ())
    document = scenario.document.model_copy(update=alone | tables)
    carrier = document.body.body() if "body" in tables else scenario.carrier
    rotors = rotors_of(document.rotors) if "rotors" in tables else scenario.rotors
    return replace(
        scenario,
        text=to_toml(document.model_dump(mode="json", exclude_defaults=True)),
        document=document,
        carrier=carrier,
        rotors=rotors,
        start=_start(document, carrier, rotors),
    )


def started_at(
    scenario: Scenario,
    q_world_body_wxyz: Sequence[float] | FloatArray,
    omega_body: Sequence[float] | FloatArray,
    com_world: Sequence[float] | FloatArray,
    velocity_world: Sequence[float] | FloatArray,
    spins: Sequence[float] | FloatArray | None = None,
) -> Scenario:
    """Return a scene with another state at its start.

    Its text is written anew, without published values and expectations, which hold only for the
    original scene.

    Parameters
    ----------
    q_world_body_wxyz : attitude, takes body to world components, unit quaternion, (4,)
    omega_body : angular velocity, rad/s, body axes, (3,)
    com_world, velocity_world : position, m, and velocity, m/s, of the centre of mass, (3,); along
        axes along which the body is held they follow from attitude and ω and are ignored
    spins : spins of the rotors, relative to the body, rad/s, (rotors,); unchanged if None

    Raises
    ------
    ValueError
        If a number is not finite, the quaternion is not of norm 1, or an array has a wrong length.
    """
    numbers = {"quaternion_wxyz": q_world_body_wxyz, "omega_body": omega_body}
    if not scenario.constraint.is_pivot:
        numbers |= {"position": com_world, "velocity": velocity_world}
    constraint = scenario.constraint
    start = {key: tuple(float(value) for value in values) for key, values in numbers.items()}
    if not (constraint.is_free or constraint.is_pivot):
        on_plane = start_of(StartTable.model_validate(start), constraint)
        start["position"] = tuple(on_plane.position_world.tolist())
        start["velocity"] = tuple(on_plane.velocity_world.tolist())
    tables: dict[str, Any] = {"start": StartTable.model_validate(start)}
    if scenario.rotors and spins is not None:
        tables["rotors"] = tuple(
            table.model_copy(update={"spin": float(spin)})
            for table, spin in zip(scenario.document.rotors or (), spins, strict=True)
        )
    return with_tables(scenario, **tables)


def _start(document: Document, carrier: Body, rotors: Rotors) -> Start:
    """Return the state at t = 0 of a body, `carrier`, with its rotors."""
    return start_of(document.start, _constraint(document, whole(carrier, rotors)))


def _constraint(document: Document, body: Body) -> Constraint:
    """Return the constraint that holds a body; a free body has one that holds along no axis."""
    called_for = (one for one in EFFECTS.values() if one.is_called_for(document))
    holding = [one.constraint(one.table_in(document), body) for one in called_for if one.constraint]
    return holding[0] if holding else Constraint((False, False, False), body.com_exact)
