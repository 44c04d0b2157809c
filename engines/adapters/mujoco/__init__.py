"""MuJoCo, from the scene as MJCF and from its URDF."""

from .engine import MuJoCo
from .urdf_reader import MuJoCoURDF

__all__ = ["MuJoCo", "MuJoCoURDF"]
