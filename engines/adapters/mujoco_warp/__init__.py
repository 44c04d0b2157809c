"""MuJoCo Warp, MuJoCo's dynamics in NVIDIA's Warp, in single precision, on the CPU.

How each effect was measured: docs/measured/engines-more.md.
"""

from .engine import MuJoCoWarp
