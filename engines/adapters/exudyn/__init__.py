"""Exudyn, flexible multibody dynamics, in double precision."""

from .engine import Exudyn
