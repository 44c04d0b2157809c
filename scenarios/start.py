"""The state at t = 0, and the format of its table in a scenario file."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

from mpmath import mp
from pydantic import Field, model_validator

from . import exact
from .constraint import Constraint
from .float_array import FloatArray, read_only
from .values import Quaternion, Table, Vector, check_unit, names


class StartTable(Table):
    """Attitude and angular velocity, each given in one of three ways."""

    euler_zyz_deg: Vector | None = Field(None, description="α β γ: R = Rz(α) Ry(β) Rz(γ)")
    quaternion_wxyz: Quaternion | None = Field(None, description="body to world, scalar first")
    rotation_vector_deg: Vector | None = Field(None, description="axis times angle, body to world")
    omega_body: Vector | None = Field(None, description="rad/s, body axes")
    omega_world: Vector | None = Field(None, description="rad/s, world axes")
    euler_zyz_rates: Vector | None = Field(
        None, description="rad/s: α̇ β̇ γ̇; only with euler_zyz_deg"
    )
    position: Vector | None = Field(
        None,
        description="m, of the com, zeros if left out; not with a pivot; on a table z is the "
        "height at which the body stands, and may be left out only with x and y",
    )
    velocity: Vector | None = Field(
        None,
        description="m/s, of the com, zeros if left out; not with a pivot; on a table z is that of "
        "a tip that stays on it, and may be left out only with x and y",
    )

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        attitude = "euler_zyz_deg", "quaternion_wxyz", "rotation_vector_deg"
        self._exactly_one("attitude", attitude, "quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]")
        rates = "omega_body", "omega_world", "euler_zyz_rates"
        self._exactly_one("angular velocity", rates, "omega_body = [0.0, 0.0, 10.0]")
        if self.euler_zyz_rates is not None and self.euler_zyz_deg is None:
            raise ValueError("'euler_zyz_rates' needs the attitude as 'euler_zyz_deg'")
        if self.quaternion_wxyz is not None:
            check_unit(self.quaternion_wxyz)
        return self

    def _exactly_one(self, what: str, keys: tuple[str, ...], example: str) -> None:
        stated_keys = [key for key in keys if getattr(self, key) is not None]
        if len(stated_keys) != 1:
            got = names(stated_keys) if stated_keys else f"none; an example: {example}"
            raise ValueError(f"{what} takes exactly one of {names(keys)}; got {got}")


@dataclass(frozen=True, eq=False)
class Start:
    """The state at t = 0, exact and as doubles.

    Attributes
    ----------
    q_exact : attitude, takes body to world components, unit quaternion w, x, y, z
    omega_body_exact : angular velocity, rad/s, body axes
    position_world, velocity_world : position, m, and velocity, m/s, of the centre of mass, (3,)
    """

    q_exact: exact.Quaternion
    omega_body_exact: exact.Vector
    position_world: FloatArray
    velocity_world: FloatArray

    @cached_property
    def q_world_body_wxyz(self) -> FloatArray:
        """Attitude, unit quaternion w, x, y, z, (4,)."""
        return read_only(self.q_exact)

    @cached_property
    def omega_body(self) -> FloatArray:
        """Angular velocity, rad/s, body axes, (3,)."""
        return read_only(self.omega_body_exact)


def start_of(table: StartTable, constraint: Constraint) -> Start:
    """Return the state that `[start]` describes, for a body with a given constraint.

    On a table, height and vertical velocity of the com follow from attitude and ω.
    """
    q = _attitude(table)
    omega_body = _omega_body(table, q)
    position, velocity = (read_only(v or exact.ZERO) for v in (table.position, table.velocity))
    if not (constraint.is_pivot or constraint.is_free):
        lever = constraint.lever_exact
        with mp.workdps(exact.DIGITS):
            lever_world = exact.rotate(q, lever)
            swing_world = exact.rotate(q, exact.cross(omega_body, lever))
        position = constraint.com_world(read_only(lever_world), position)
        velocity = constraint.velocity_world(read_only(swing_world), velocity)
    return Start(
        q_exact=q,
        omega_body_exact=omega_body,
        position_world=read_only(position),
        velocity_world=read_only(velocity),
    )


def _attitude(table: StartTable) -> exact.Quaternion:
    """Return the attitude that `[start]` states, body to world."""
    if table.euler_zyz_deg is not None:
        return exact.from_euler_zyz_deg(table.euler_zyz_deg)
    if table.rotation_vector_deg is not None:
        return exact.from_rotation_vector_deg(table.rotation_vector_deg)
    assert table.quaternion_wxyz is not None
    return exact.normalised(table.quaternion_wxyz)


def _omega_body(table: StartTable, q_world_body: exact.Quaternion) -> exact.Vector:
    """Return the angular velocity that `[start]` states, rad/s, body axes.

    `q_world_body` is the attitude at the start: `[start]` may state ω along world axes.
    """
    if table.euler_zyz_rates is not None:
        assert table.euler_zyz_deg is not None
        return exact.omega_body_from_zyz_rates(table.euler_zyz_deg, table.euler_zyz_rates)
    omega = table.omega_body if table.omega_body is not None else table.omega_world
    assert omega is not None
    x, y, z = exact.exact(omega)
    if table.omega_body is not None:
        return (x, y, z)
    with mp.workdps(exact.DIGITS):
        return exact.rotate(exact.conjugate(q_world_body), (x, y, z))
