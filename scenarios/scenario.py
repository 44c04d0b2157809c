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
    """One scene; a `Scenario` that exists has valid values.

    Attributes
    ----------
    name : the file's stem
    path : the file it was read from, or None for one built in memory
    text : the file, as read or as it would be written
    document : its tables
    carrier, rotors, start : the body without its rotors, the rotors, and the state at t = 0
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
        """SHA-256, hexadecimal, of all that verdicts depend on: also `expect` and `known`."""
        return self._digest("body", "rotors", "start", "effects", "window", "expect", "known")

    def _digest(self, *tables: str) -> str:
        # Absent tables and keys are left out, so that a new effect in the format changes no other
        # scene's digest.
        written = self.document.model_dump_json(include=set(tables), exclude_none=True)
        return hashlib.sha256(written.encode()).hexdigest()

    @property
    def title(self) -> str:
        """One line that says what the scene shows."""
        return self.document.title

    @property
    def effects(self) -> Effects:
        """The tables of the effects the scene calls for."""
        return self.document.effects

    @property
    def window(self) -> Window:
        """Duration and number of samples."""
        return self.document.window

    @property
    def expect(self) -> tuple[Expect, ...]:
        """Bounds on errors, or outcomes, expected of engines."""
        return self.document.expect

    @property
    def hard(self) -> bool:
        """Whether the scene is tagged `hard`: runs may blow up on it at ordinary timesteps."""
        return "hard" in self.document.tags

    @cached_property
    def called_for(self) -> frozenset[str]:
        """The effects to simulate, names out of `EFFECTS`."""
        return frozenset(effect.name for effect in self.acting)

    @cached_property
    def acting(self) -> tuple[Effect, ...]:
        """The effects to simulate, in the order of `EFFECTS`."""
        return tuple(one for one in EFFECTS.values() if one.is_called_for(self.document))

    @cached_property
    def answer(self) -> Answer | None:
        """`Effect.answer` of the constraint that holds the body; None for a pivot or none."""
        return next((one.answer for one in self.acting if one.answer is not None), None)

    @cached_property
    def constraint(self) -> Constraint:
        """How the body is held."""
        return _constraint(self.document, self.body)

    @property
    def is_jointed(self) -> bool:
        """Whether joints hold the body, or parts of it."""
        return not self.constraint.is_free or any(effect.is_part for effect in self.acting)

    @property
    def about(self) -> str:
        """The point that L and the moments of inertia are about: "pivot" or "com"."""
        return "pivot" if self.constraint.is_pivot else "com"

    def kept(self, omega_body: FloatArray, spins: FloatArray) -> FloatArray:
        """Return the constant angular momentum of each part about its axis, kg m²/s, (n, parts)."""
        return self.rotors.kept(omega_body, spins)

    @cached_property
    def kept_at_start(self) -> FloatArray:
        """What `kept` returns for the state at t = 0, kg m²/s, (parts,)."""
        return self.kept(self.start.omega_body, self.start_spins)

    @property
    def start_spins(self) -> FloatArray:
        """The spins of parts at t = 0, relative to the body, rad/s, (parts,)."""
        return self.rotors.start_spins

    @property
    def largest_part(self) -> float:
        """The largest moment of a part about its axis, kg m²; 0 without parts."""
        return float(max(self.rotors.along, default=0.0))

    @cached_property
    def kept_sizes(self) -> tuple[FloatArray, float]:
        """Sizes of the parts' angular momenta, kg m²/s, (parts,), and of their energy, J."""
        return self.rotors.sizes(self.start.omega_body)

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """Return the vector sum of the parts' angular momenta, body axes, kg m²/s, (n, 3)."""
        return self.rotors.kept_body(kept)

    def spins(self, omega_body: FloatArray, kept: FloatArray) -> FloatArray:
        """Return the spins, rad/s, (n, parts), of parts whose angular momenta are `kept`."""
        return self.rotors.spins(omega_body, kept)

    def cancelling(self, spins: FloatArray, far: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return sizes of force, N, and torque, N m, (n,), that cancel in axes turning with parts.

        Parameters
        ----------
        far : distance of the origin of the coordinates from the com, m, which places are rounded by
        """
        return self.rotors.cancelling(spins, self.body.com, far)

    @cached_property
    def body(self) -> Body:
        """The body, with its rotors counted as fixed parts of it."""
        return whole(self.carrier, self.rotors)

    @cached_property
    def inertia_exact(self) -> exact.Tensor:
        """Inertia tensor about the pivot, or the com where there is none, kg m², body axes.

        It is the tensor that multiplies ω': moments of freely turning rotors about their axes are
        left out.
        """
        body = self.body
        tensor = body.inertia_origin_exact if self.about == "pivot" else body.inertia_com_exact
        return self.without_free_axes(tensor)

    def without_free_axes(self, inertia: exact.Tensor) -> exact.Tensor:
        """Return a tensor less the axial moments of rotors that turn freely, kg m²."""
        return without_free_axes(inertia, self.rotors)

    @cached_property
    def inertia(self) -> FloatArray:
        """`inertia_exact` as doubles, kg m², body axes, (3, 3)."""
        return read_only(self.inertia_exact)

    @cached_property
    def gravity_world(self) -> FloatArray:
        """Gravitational acceleration, m/s², (3,); zeros where there is none."""
        gravity = self.effects.gravity
        return read_only(gravity.acceleration if gravity else exact.ZERO)

    @cached_property
    def pushed(self) -> dict[str, Any]:
        """The parameters that the function `push` reads, SI; zero for effects not called for."""
        return {
            one.name: one.pushed(one.table_in(self.document))
            for one in EFFECTS.values()
            if one.pushed
        }

    def table_of(self, model: type[T]) -> T | None:
        """Return the table of an effect; None if the scene has none."""
        return next((table for _, table in self.effects if isinstance(table, model)), None)

    @cached_property
    def times(self) -> FloatArray:
        """The window's sample times, s, (samples,)."""
        return read_only(np.linspace(0.0, self.window.duration, self.window.samples))


@lru_cache(maxsize=KEPT)
def _rebuilt(text: str, name: str, path: Path | None) -> Scenario:
    """Return the scene of a text, the same object each time a worker is sent the text."""
    return build(Document.model_validate(tomllib.loads(text)), name, text, path)


def build(document: Document, name: str, text: str, path: Path | None = None) -> Scenario:
    """Return the scenario of a validated document, whose text is `text`."""
    carrier, rotors = document.body.body(), rotors_of(document.rotors)
    start = _start(document, carrier, rotors)
    return Scenario(name, path, text, document, carrier, rotors, start)


def with_tables(scenario: Scenario, **tables: Table | tuple[Table, ...] | None) -> Scenario:
    """Return the scene with other tables, such as `window`, and its text rewritten.

    Published values and expectations are left out: they hold only for the unchanged scene.
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
    """Return the scene with another state at its start, as `with_tables` does.

    Parameters
    ----------
    q_world_body_wxyz : attitude, takes body to world components, unit quaternion, (4,)
    omega_body : angular velocity, rad/s, body axes, (3,)
    com_world, velocity_world : of the centre of mass, m and m/s, (3,); along axes along which the
        body is held they follow from attitude and ω and are ignored
    spins : of the rotors, relative to the body, rad/s, (rotors,); unchanged if None

    Raises
    ------
    ValueError
        If a number is not finite, or the quaternion is not of norm 1.
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
    return start_of(document.start, _constraint(document, whole(carrier, rotors)))


def _constraint(document: Document, body: Body) -> Constraint:
    """Return what holds a body; if it is free, a constraint that holds it along no axis."""
    called_for = (one for one in EFFECTS.values() if one.is_called_for(document))
    holding = [one.constraint(one.table_in(document), body) for one in called_for if one.constraint]
    return holding[0] if holding else Constraint((False, False, False), body.com_exact)
