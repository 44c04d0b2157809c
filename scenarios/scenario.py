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

#: Tables that hold of one very scene: not of one with another start or another number in it.
OF_THE_SCENE_ALONE = ("published", "expect", "known")
#: Scenes that a process keeps of those it is sent: more than are run at a time.
KEPT = 64


@dataclass(frozen=True, eq=False)
class Scenario:
    """One scene, valid if it exists.

    Attributes
    ----------
    name : the file's stem
    path : the file it was read from, or None for one built in memory
    text : the file, as read or as it would be written
    document : its tables
    carrier, rotors, start : what they describe: the body without its rotors, these, and their start
    """

    name: str
    path: Path | None
    text: str
    document: Document
    carrier: Body
    rotors: Rotors
    start: Start

    def __reduce__(self) -> tuple[object, ...]:
        """Pickled as text and rebuilt: mpmath would round its numbers to double precision."""
        return _rebuilt, (self.text, self.name, self.path)

    @cached_property
    def digest(self) -> str:
        """SHA-256, hexadecimal, of what the motion depends on: whether a run is of this scene."""
        return self._digest("body", "rotors", "start", "effects", "window")

    @cached_property
    def judged_digest(self) -> str:
        """Likewise of what verdicts depend on: also expectations and expected failures."""
        return self._digest("body", "rotors", "start", "effects", "window", "expect", "known")

    def _digest(self, *tables: str) -> str:
        # Without what is not there: an effect that is new to the format leaves all other scenes be.
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
        """The effects that the scene calls for, in the order of `EFFECTS`."""
        return tuple(one for one in EFFECTS.values() if one.is_called_for(self.document))

    @cached_property
    def answer(self) -> Answer | None:
        """What a constraint besides a pivot does about torques and accelerations; None without."""
        return next((one.answer for one in self.acting if one.answer is not None), None)

    @cached_property
    def constraint(self) -> Constraint:
        """What holds the body."""
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
        """The angular momentum that each part keeps as it turns, kg m²/s, (n, parts)."""
        return self.rotors.kept(omega_body, spins)

    @cached_property
    def kept_at_start(self) -> FloatArray:
        """What each part keeps at t = 0, kg m²/s, (parts,)."""
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
        """Sizes of what parts keep, kg m²/s, (parts,), and of the energy of that, J."""
        return self.rotors.sizes(self.start.omega_body)

    def kept_body(self, kept: FloatArray) -> FloatArray:
        """The sum of what parts keep, body axes, (n, 3)."""
        return self.rotors.kept_body(kept)

    def spins(self, omega_body: FloatArray, kept: FloatArray) -> FloatArray:
        """The spins of parts that keep so much, rad/s, (n, parts)."""
        return self.rotors.spins(omega_body, kept)

    def cancelling(self, spins: FloatArray, far: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Force, N, and torque, N m, (n,), that cancel in coordinates which turn with parts.

        Parameters
        ----------
        far : m, from the origin relative to which places are rounded
        """
        return self.rotors.cancelling(spins, self.body.com, far)

    @cached_property
    def body(self) -> Body:
        """The body with its rotors as if they did not turn in it."""
        return whole(self.carrier, self.rotors)

    @cached_property
    def inertia_exact(self) -> exact.Tensor:
        """Inertia tensor about the pivot, or the com where there is none, kg m², body axes.

        It is what ω' is multiplied by: without what rotors that turn freely have about their axles.
        """
        body = self.body
        tensor = body.inertia_origin_exact if self.about == "pivot" else body.inertia_com_exact
        return self.without_free_axes(tensor)

    def without_free_axes(self, inertia: exact.Tensor) -> exact.Tensor:
        """A tensor less what rotors that turn freely have about their axles, kg m²."""
        return without_free_axes(inertia, self.rotors)

    @cached_property
    def inertia(self) -> FloatArray:
        """The tensor `inertia_exact` in double precision, kg m², (3, 3)."""
        return read_only(self.inertia_exact)

    @cached_property
    def gravity_world(self) -> FloatArray:
        """Gravitational acceleration, m/s², (3,); zeros where there is none."""
        gravity = self.effects.gravity
        return read_only(gravity.acceleration if gravity else exact.ZERO)

    @cached_property
    def pushed(self) -> dict[str, Any]:
        """The numbers of torques that `push` takes, SI; zero of those that the scene has not."""
        return {
            one.name: one.pushed(one.table_in(self.document))
            for one in EFFECTS.values()
            if one.pushed
        }

    def table_of(self, model: type[T]) -> T | None:
        """The table of an effect, None where the scene has none."""
        return next((table for _, table in self.effects if isinstance(table, model)), None)

    @cached_property
    def times(self) -> FloatArray:
        """The window's sample times, s, (samples,)."""
        return read_only(np.linspace(0.0, self.window.duration, self.window.samples))


@lru_cache(maxsize=KEPT)
def _rebuilt(text: str, name: str, path: Path | None) -> Scenario:
    """The scene of a valid text, the same object each time: a worker is sent it for every run."""
    return build(Document.model_validate(tomllib.loads(text)), name, text, path)


def build(document: Document, name: str, text: str, path: Path | None = None) -> Scenario:
    """Turn a validated document, whose text this is, into a scenario."""
    carrier, rotors = document.body.body(), rotors_of(document.rotors)
    start = _start(document, carrier, rotors)
    return Scenario(name, path, text, document, carrier, rotors, start)


def with_tables(scenario: Scenario, **tables: Table | tuple[Table, ...] | None) -> Scenario:
    """The scene with other tables, such as `window`, under the same name; its text is rewritten.

    Published values and expectations are left out: they hold of the scene as it was.
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
    """The scene with another state at its start, as `with_tables`.

    Parameters
    ----------
    q_world_body_wxyz : attitude, takes body to world components, unit quaternion, (4,)
    omega_body : angular velocity, rad/s, body axes, (3,)
    com_world, velocity_world : of the centre of mass, m and m/s, (3,); along axes along which the
        body is held they follow from the other two and are not looked at
    spins : of the rotors, relative to the body, rad/s, (rotors,); as they are if None

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
    """What holds a body; of one that is free, nothing."""
    called_for = (one for one in EFFECTS.values() if one.is_called_for(document))
    holding = [one.constraint(one.table_in(document), body) for one in called_for if one.constraint]
    return holding[0] if holding else Constraint((False, False, False), body.com_exact)
