"""The effects that a scene can call for, one module for each."""

from pydantic import Field

from ..values import Table
from .drag import EFFECT as DRAG
from .drag import DragTable
from .effect import Effect, EffectTable
from .gravity import EFFECT as GRAVITY
from .gravity import GravityTable
from .pivot import EFFECT as PIVOT
from .pivot import PivotTable
from .push import push
from .rotors import EFFECT as ROTORS
from .rotors import RotorTable, rotors_of
from .table import EFFECT as TABLE
from .table import TableTable
from .torque import TORQUE_BODY, TORQUE_WORLD, TorqueTable

__all__ = [
    "EFFECTS",
    "PUSHED",
    "Effect",
    "EffectTable",
    "Effects",
    "RotorTable",
    "push",
    "rotors_of",
]

#: All effects by name, in the order in which they are listed everywhere.
EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (GRAVITY, PIVOT, TABLE, DRAG, TORQUE_BODY, TORQUE_WORLD, ROTORS)
}
#: Names of the effects whose torques `push` includes.
PUSHED = frozenset(name for name, effect in EFFECTS.items() if effect.pushed)


class Effects(Table):
    """What acts on the body: an effect is simulated if its table is here, and only then."""

    gravity: GravityTable | None = Field(default=None, description="a uniform field")
    pivot: PivotTable | None = Field(default=None, description="a ball joint at the body's origin")
    table: TableTable | None = Field(
        default=None, description="a smooth plane that the body's tip slides on"
    )
    drag: DragTable | None = Field(
        default=None, description="a torque against the angular velocity"
    )
    torque: TorqueTable | None = Field(default=None, description="a constant torque")
