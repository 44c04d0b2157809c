"""The library libbox3d, in single precision, from its Python package `pybox3d`."""

from .engine import PyBox3D
