"""Texts of scenario files: as small as one can be, with ways to change it; a fast top; a sphere."""

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


def sphere_text(
    omega_body: tuple[float, float, float] = (0.0, 0.0, 1.0),
    duration: float = 1.0,
    samples: int = 11,
    tilt_deg: float = 0.0,
) -> str:
    """A free sphere of 1 kg and 1 kg m²: it turns steadily at `omega_body`, rad/s."""
    return f"""spincheck = 1
title = "A spinning sphere"
source = "made up"
[body]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
[start]
euler_zyz_deg = [0.0, {tilt_deg}, 0.0]
omega_body = {list(omega_body)}
[window]
duration = {duration}
samples = {samples}
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
