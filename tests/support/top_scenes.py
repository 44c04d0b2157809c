"""Tops built in memory from the contents of a scenario file's tables, for tests."""

from spincheck.scenarios import Scenario, loads

PIVOT = "[effects.pivot]"
GRAVITY = "[effects.gravity]\nacceleration = [0.0, 0.0, -10.0]"
HEAVY = f"{PIVOT}\n{GRAVITY}"

#: About the pivot, half a metre from the com: I1 = 2, I3 = 1 kg m², M g l = 10 N m.
TOP = """
mass = 2.0
inertia = [2.0, 2.0, 1.0]
inertia_about = "origin"
com = [0.0, 0.0, 0.5]
"""
#: The same about each of the other axes.
TOP_ALONG_X = """
mass = 2.0
inertia = [1.0, 2.0, 2.0]
inertia_about = "origin"
com = [0.5, 0.0, 0.0]
"""
TOP_ALONG_Y = """
mass = 2.0
inertia = [2.0, 1.0, 2.0]
inertia_about = "origin"
com = [0.0, 0.5, 0.0]
"""
ASYMMETRIC = """
mass = 1.0
inertia = [3.0, 4.0, 6.0]
"""


def scene(
    body: str = TOP,
    start: str = "euler_zyz_deg = [0.0, 60.0, 0.0]\neuler_zyz_rates = [1.0, 0.0, 20.0]",
    effects: str = HEAVY,
    window: str = "duration = 2.0\nsamples = 401",
) -> Scenario:
    """A scenario out of the contents of its tables; `effects` comes with its own headers."""
    text = f"""spincheck = 1
title = "made for a test"
source = "no book"
[body]
{body}
[start]
{start}
{effects}
[window]
{window}
"""
    return loads(text, name="made")
