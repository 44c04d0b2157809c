"""Newton's rigid-body solvers, in single precision, on the CPU."""

from .engine import Newton
