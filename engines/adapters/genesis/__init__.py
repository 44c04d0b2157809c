"""Genesis's rigid solver, in single precision, on the CPU."""

from .engine import Genesis
