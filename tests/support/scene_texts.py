"""Texts of scenario files: as small as one can be, with ways to change it, and a fast top."""

from spincheck.scenarios import Scenario, loads

TEXT = """spincheck = 1
title = "t"
source = "s"
[body]
mass = 2.0
inertia = [1.0, 2.0, 2.5]
com = [0.1, 0.2, 0.3]
[start]
euler_zyz_deg = [10.0, 30.0, 20.0]
omega_body = [0.5, 1.0, -2.0]
[window]
duration = 1.0
samples = 5
"""

#: A heavy top that spins fast: 40 rad/s about its axis, tilted by 30°.
FAST_TOP = """spincheck = 1
title = "A fast top"
source = "made up"
[body]
mass = 1.0
inertia = [0.02, 0.02, 0.01]
com = [0.0, 0.0, 0.1]
[start]
euler_zyz_deg = [0.0, 30.0, 0.0]
omega_body = [0.0, 0.0, 40.0]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 5.0
samples = 101
"""


def changed(*replacements: tuple[str, str], more: str = "") -> str:
    """TEXT with lines replaced, each of which must be there, and tables added at the end."""
    text = TEXT
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    return text + more


def scene(*replacements: tuple[str, str], more: str = "") -> Scenario:
    """The scene of the changed text."""
    return loads(changed(*replacements, more=more), name="made")
