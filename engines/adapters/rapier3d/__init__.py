"""Rapier 3D, in single precision, from its Python package `rapier3d`."""

from .engine import Rapier3D
