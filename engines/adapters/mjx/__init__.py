"""MJX, MuJoCo's dynamics written in JAX, on the CPU, in single precision and in double precision.

Single precision is JAX's default. docs/measured/engines-more.md says how each effect was measured.
"""

from .engine import MJX, MJXSingle
