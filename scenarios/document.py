"""The scenario file's format, version 1: one pydantic model for each table.

Constraints of a field say what its value may be. Checks that concern several keys are validators of
the table's model. `schema.json` is generated from these models.
"""

from functools import lru_cache
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, Discriminator, Field, Tag, create_model, model_validator

from .body import Body, body_about_com, body_about_origin, body_of_particles
from .effects import Effects, RotorTable, rotors_of
from .errors import Misfit
from .gyrostat import whole
from .signals import SIGNAL, SIGNALS
from .start import StartTable
from .values import (
    Digest,
    Inertia,
    Matrix,
    NotNegative,
    Number,
    Positive,
    Prose,
    Quaternion,
    Table,
    Text,
    Vector,
    Version,
    check_unit,
    names,
)

T = TypeVar("T", bound=BaseModel)

MAX_SAMPLES = 1_000_000
#: Products of inertia that differ by less, relative to the largest entry, are the same.
SYMMETRIC = 1e-12
MAX_ROTORS = 16


class BodyTable(Table):
    """Mass, centre of mass and inertia; or the point masses that make them up."""

    mass: Positive | None = Field(None, description="kg")
    inertia: Inertia | None = Field(
        None, description="kg m²: three principal moments along the body axes, or a 3×3 matrix"
    )
    inertia_about: Literal["com", "origin"] = Field(
        "com", description='the point the inertia refers to; `"com"` if left out'
    )
    com: Vector | None = Field(
        None, description="m, from the body's origin, body axes; needed with a pivot"
    )
    particles: tuple[tuple[Positive, Number, Number, Number], ...] | None = Field(
        None,
        description="three or more point masses [kg, m, m, m], body axes: instead of mass, com and "
        "inertia",
        min_length=3,
    )

    model: Text | None = Field(
        None, description="path of the URDF or MJCF file that the numbers are from"
    )
    link: Text | None = Field(None, description="name of the link, or of the body, in that file")
    welded: tuple[Text, ...] | None = Field(
        None, description="names of links welded to that one; the numbers include them"
    )
    sha256: Digest | None = Field(None, description="SHA-256 of that file, in hexadecimal")

    @model_validator(mode="after")
    def _whole_origin(self) -> Self:
        origin = ("model", "link", "sha256")
        stated_keys = [key for key in origin if getattr(self, key) is not None]
        if stated_keys and len(stated_keys) < len(origin):
            missing = [key for key in origin if key not in stated_keys]
            raise ValueError(f"{names(stated_keys)} needs {names(missing)} too")
        if self.welded and not stated_keys:
            raise ValueError(f"'welded' needs {names(origin)} too")
        return self

    @model_validator(mode="after")
    def _whole(self) -> Self:
        stated_keys = {"mass", "inertia", "inertia_about", "com"} & self.model_fields_set
        if self.particles is not None:
            if stated_keys:
                raise ValueError(
                    f"'particles' replaces mass, com and inertia; remove {names(stated_keys)}"
                )
        elif missing := [key for key in ("mass", "inertia") if getattr(self, key) is None]:
            raise ValueError(f"missing {names(missing)}; or give 'particles'")
        if asymmetric := self._asymmetric():
            i, j, one, other = asymmetric
            raise Misfit(
                f"must be a symmetric matrix, got {one:g} in row {i + 1}, column {j + 1}, and "
                f"{other:g} in row {j + 1}, column {i + 1}",
                "inertia",
            )
        try:
            self.body()
        except ValueError as error:
            raise Misfit(str(error), "inertia" if self.particles is None else "particles") from None
        return self

    def _asymmetric(self) -> tuple[int, int, float, float] | None:
        """Return i, j, I_ij and I_ji of the first product of inertia for which I_ij is not I_ji.

        Products that differ by rounding only, as of a matrix R D Rᵀ, count as equal. It is None if
        the matrix is symmetric, or if the inertia is not a matrix.
        """
        if self.inertia is None or not isinstance(self.inertia[0], tuple):
            return None
        rows = self.inertia
        slack = SYMMETRIC * max(abs(number) for row in rows for number in row)
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if not abs(rows[i][j] - rows[j][i]) <= slack:
                return i, j, rows[i][j], rows[j][i]
        return None

    @property
    def inertia_matrix(self) -> Matrix | None:
        """The inertia as a full symmetric matrix, kg m², body axes; None if the table states none.

        It is about the point that `inertia_about` names. Products that differ by rounding are
        replaced by their mean.
        """
        if self.inertia is None:
            return None
        if isinstance(self.inertia[0], tuple):
            (a, d, e), (f, b, g), (h, i, c) = self.inertia
            d, e, g = d / 2 + f / 2, e / 2 + h / 2, g / 2 + i / 2
            return ((a, d, e), (d, b, g), (e, g, c))
        a, b, c = self.inertia
        return ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))

    def body(self) -> Body:
        """Return the rigid body that this table describes; ValueError if no such body exists."""
        return _body(self)


class Window(Table):
    """The span that is simulated, and how often it is sampled."""

    duration: Positive = Field(description="s")
    samples: Annotated[int, Field(strict=True, ge=2, le=MAX_SAMPLES)] = Field(
        description="number of evenly spaced times, t = 0 and the end included"
    )


class SomeComponents(Table):
    """Those components of a vector that are known, such as `{ z = 0.3 }`."""

    x: Number | None = Field(None, description="the first component, in the vector's unit")
    y: Number | None = Field(None, description="the second component")
    z: Number | None = Field(None, description="the third component")

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.x is self.y is self.z is None:
            raise ValueError("names no component; give any of 'x', 'y', 'z'")
        return self


def _vector_form(value: Any) -> str:
    return "some" if isinstance(value, dict | SomeComponents) else "all"


Components = Annotated[
    Annotated[Vector, Tag("all")] | Annotated[SomeComponents, Tag("some")],
    Discriminator(_vector_form),
]


class Published(Table):
    """Published values, which the reference is compared with."""

    t: NotNegative = Field(description="s")
    omega_body: Components | None = Field(None, description="rad/s, body axes")
    omega_world: Components | None = Field(None, description="rad/s, world axes")
    quaternion_wxyz: Quaternion | None = Field(None, description="body to world, up to its sign")
    com_world: Components | None = Field(None, description="m")
    L_world: Components | None = Field(None, description="kg m²/s, about the pivot, else the com")
    energy: Number | None = Field(None, description="J")
    tolerance: Positive = Field(description="absolute, from the digits printed")
    source: Text = Field(description="who printed it, and where")

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not self.values():
            quantities = set(type(self).model_fields) - {"t", "tolerance", "source"}
            raise ValueError(f"names no value to compare with; give any of {names(quantities)}")
        if self.quaternion_wxyz is not None:
            check_unit(self.quaternion_wxyz)
        return self

    def values(self) -> dict[str, Any]:
        """Return the stated quantities by their keys, such as `omega_body`, in the key's unit.

        Vectors are tuples, in which components that are not stated are None.
        """
        fields = self.model_dump(exclude={"t", "tolerance", "source"})
        return {
            name: tuple(value.values()) if isinstance(value, dict) else value
            for name, value in fields.items()
            if value is not None
        }


def _with_bounds(model: type[T]) -> type[T]:
    """Return a table's model with a key added for each signal: a bound on the signal's error."""
    bounds: dict[str, Any] = {
        signal.name: (Positive | None, Field(None, description=f"bound on the error in {signal}"))
        for signal in SIGNALS
    }
    return create_model(
        model.__name__, __base__=model, __module__=__name__, __doc__=model.__doc__, **bounds
    )


@_with_bounds
class Expect(Table):
    """What the scene expects of one engine, method and timestep."""

    engine: Text = Field(description="as `spincheck engines` names it")
    method: Text = Field(description="one of its methods")
    timestep: Positive = Field(description="s; run in addition to the halved timesteps")
    outcome: Literal["diverges"] | None = Field(None, description="the run is expected to blow up")

    @model_validator(mode="after")
    def _bounds_or_outcome(self) -> Self:
        if bool(self.bounds()) == (self.outcome is not None):
            raise ValueError(f"takes bounds ({names(SIGNAL)}), or 'outcome'; one of the two")
        return self

    def bounds(self) -> dict[str, float]:
        """Return the stated bounds on errors, by the names of the signals."""
        return {name: getattr(self, name) for name in SIGNAL if getattr(self, name) is not None}


class Known(Table):
    """An expected failure of an engine's method on this scene; reported if it is gone."""

    engine: Text = Field(description="as `spincheck engines` names it")
    method: Text = Field(description="one of its methods")
    verdict: Literal["disagrees"] = Field(description="the method goes to another motion")
    reason: Text = Field(description="the cause, and where it is documented")


class Document(Table):
    """A spincheck scenario: a rigid body, how it starts, what acts on it, and for how long."""

    spincheck: Version = Field(
        description="the first key: format version; marks the file as a scenario"
    )
    title: Text = Field(description="one line; what pages and lists call the scene")
    source: Text = Field(description="book, section or paper the scene comes from")
    description: Prose = Field("", description="Markdown")
    tags: tuple[Text, ...] = Field(
        (), description="words to filter by; `hard` keeps a scene out of quick runs"
    )
    body: BodyTable = Field(description="the rigid body")
    start: StartTable = Field(description="the state at t = 0")
    rotors: tuple[RotorTable, ...] | None = Field(
        None,
        description=f"parts that turn in the body, {MAX_ROTORS} at most",
        max_length=MAX_ROTORS,
    )
    effects: Effects = Field(Effects(), description="what acts on the body")
    window: Window = Field(description="duration and samples")
    published: tuple[Published, ...] = Field((), description="values from the literature")
    expect: tuple[Expect, ...] = Field((), description="what is expected of single runs")
    known: tuple[Known, ...] = Field((), description="disagreements that are known and accepted")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.effects.pivot is not None:
            if self.body.com is None and self.body.particles is None:
                raise Misfit("needs 'com' with a pivot", "body")
            for key in ("position", "velocity"):
                if key in self.start.model_fields_set:
                    raise Misfit("for free bodies; this one has a pivot", "start", key)
        rotors = self.rotors or ()
        for k in range(len(rotors)):
            try:
                whole(self.body.body(), rotors_of(rotors[: k + 1]))
            except ValueError as error:
                raise Misfit(f"with it in the body, {error}", "rotors", k) from None
        duration = self.window.duration
        for index, value in enumerate(self.published):
            if value.t > duration:
                raise Misfit(
                    f"must lie in the window, got {value.t:g} s of {duration:g} s",
                    *("published", index, "t"),
                )
        for index, expected in enumerate(self.expect):
            if expected.timestep > duration:
                raise Misfit(
                    f"must not exceed the window, got {expected.timestep:g} s of {duration:g} s",
                    *("expect", index, "timestep"),
                )
        return self


@lru_cache(maxsize=1)
def _body(table: BodyTable) -> Body:
    """Return the body that `[body]` describes; cached, because the file's checks make it first."""
    if table.particles is not None:
        return body_of_particles(table.particles)
    mass, matrix = table.mass, table.inertia_matrix
    assert mass is not None
    assert matrix is not None
    build = body_about_com if table.inertia_about == "com" else body_about_origin
    return build(mass, table.com or (0.0, 0.0, 0.0), matrix)
