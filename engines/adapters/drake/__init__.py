"""Drake, multibody dynamics with integrators of fixed step, in double precision."""

from .engine import Drake
