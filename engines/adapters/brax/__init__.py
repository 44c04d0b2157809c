"""Brax's three pipelines, in single precision, on the CPU."""

from .engine import Brax
