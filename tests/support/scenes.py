"""The scenes of the contract, for all other tests of engines."""

from spincheck.suite.contract_scenes import (
    ASYMMETRIC,
    DRAG,
    GRAVITY,
    PIVOT,
    SCENES,
    SKEW_GRAVITY,
    SPUN_UP,
    THROWN,
    TILTED,
    TILTED_PLATE,
    TOP,
    TORQUE_BODY,
    TORQUE_WORLD,
    TUMBLE,
    scene,
)

__all__ = [
    "ASYMMETRIC",
    "DRAG",
    "GRAVITY",
    "PIVOT",
    "SCENES",
    "SKEW_GRAVITY",
    "SPUN_UP",
    "THROWN",
    "TILTED",
    "TILTED_PLATE",
    "TOP",
    "TORQUE_BODY",
    "TORQUE_WORLD",
    "TUMBLE",
    "scene",
]
