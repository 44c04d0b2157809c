"""DART, multibody dynamics in joint coordinates, in double precision."""

from .engine import Dart
