"""Pinocchio, rigid-body dynamics without integrators of its own, in double precision."""

from .engine import Pinocchio
