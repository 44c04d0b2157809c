"""MJX, MuJoCo's dynamics written in JAX, on the CPU.

In single precision, as JAX is by default, and in double precision. How each effect was measured:
docs/measured/engines-more.md.
"""

from .engine import MJX, MJXSingle
