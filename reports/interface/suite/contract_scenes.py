"""Small scenes, built in memory, with each effect and with bodies that adapters often get wrong.

`SCENES` holds them by name. The function `scene` builds a scene from the texts of its TOML tables.
"""

from spincheck.scenarios import Scenario, loads
from spincheck.scenarios.scenario import started_at

#: A body whose principal moments all differ and satisfy the triangle inequality with room to spare.
ASYMMETRIC = """
mass = 1.5
inertia = [1.0, 2.0, 2.5]
"""
#: A body whose principal axes are not those of its frame, with its com off the origin and off the
#: axis of ω: mixed-up axes or points change its motion.
TILTED = """
mass = 1.3
inertia = [[1.4, 0.2, -0.1], [0.2, 1.1, 0.3], [-0.1, 0.3, 0.9]]
com = [0.15, -0.1, 0.2]
"""
#: A plate: its largest principal moment is the sum of the other two, and its principal axes are not
#: those of its frame. Some engines' readers of models refuse such bodies.
TILTED_PLATE = """
mass = 0.7
inertia = [[1.5, 0.5, 0.0], [0.5, 1.5, 0.0], [0.0, 0.0, 3.0]]
com = [0.0, 0.0, 0.0]
"""
#: A toy top: moments about its com, and a pivot 4 cm below it.
TOP = """
mass = 0.1
inertia = [2.0e-4, 2.0e-4, 1.0e-4]
com = [0.0, 0.0, 0.04]
"""

TUMBLE = """
rotation_vector_deg = [20.0, -50.0, 35.0]
omega_body = [1.0, -2.0, 3.0]
"""
THROWN = (
    TUMBLE
    + """
position = [0.3, -0.1, 0.5]
velocity = [0.2, 1.0, -0.4]
"""
)
SPUN_UP = """
euler_zyz_deg = [25.0, 30.0, 10.0]
omega_body = [0.3, -0.2, 40.0]
"""

PIVOT = "[effects.pivot]\n"
GRAVITY = "[effects.gravity]\nacceleration = [0.0, 0.0, -9.81]\n"
#: Gravity along no axis of the world: a swapped or flipped component changes the motion.
SKEW_GRAVITY = "[effects.gravity]\nacceleration = [1.0, -2.0, -9.0]\n"
TABLE = "[effects.table]\nheight = 0.1\ntip = [0.0, 0.0, -0.005]\nradius = 0.02\n"
DRAG = "[effects.drag]\nrotational = 0.3\n"
TORQUE_BODY = "[effects.torque]\nbody = [0.4, -0.3, 0.2]\n"
#: A torque for the toy top.
FEEBLE = "[effects.torque]\nbody = [1e-4, -2e-4, 3e-4]\n"
TORQUE_WORLD = "[effects.torque]\nworld = [0.4, -0.3, 0.2]\n"
#: A rotor on each kind of hinge, its axle along no axis of the body; spins have both signs.
ROTORS = """
[[rotors]]
axis = [1.0, 2.0, -1.0]
position = [0.1, 0.0, 0.2]
mass = 0.5
inertia = [0.1, 0.15]
spin = 9.0
hinge = "free"
[[rotors]]
axis = [1.0, 0.0, 1.0]
position = [-0.1, 0.1, 0.0]
mass = 0.2
inertia = [0.05, 0.08]
hinge = "locked"
[[rotors]]
axis = [0.0, -1.0, 1.0]
position = [0.0, 0.2, -0.1]
mass = 0.3
inertia = [0.1, 0.12]
spin = -5.0
hinge = "driven"
"""
#: Rotors for the toy top.
SMALL_ROTORS = """
[[rotors]]
axis = [0.1, 0.0, 1.0]
position = [0.0, 0.0, 0.05]
mass = 0.02
inertia = [1e-5, 1.5e-5]
spin = 100.0
hinge = "free"
[[rotors]]
axis = [0.0, 1.0, 1.0]
position = [0.01, 0.0, 0.03]
mass = 0.01
inertia = [5e-6, 6e-6]
spin = -30.0
hinge = "driven"
"""


def scene(
    name: str,
    body: str = ASYMMETRIC,
    start: str = TUMBLE,
    effects: str = "",
    duration: float = 1.0,
    samples: int = 11,
) -> Scenario:
    """Return a scene, given the contents of its TOML tables.

    Parameters
    ----------
    body, start : the lines of the TOML tables `body` and `start`
    effects : TOML tables of effects, headings included
    duration : length of the window, s
    samples : number of samples
    """
    return loads(
        f"""spincheck = 1
title = "{name}"
source = "a scene for tests"
[body]{body}
[start]{start}
{effects}
[window]
duration = {duration!r}
samples = {samples}
""",
        name=name,
    )


def from_elsewhere(scenario: Scenario) -> Scenario:
    """Return a scene with another start: attitude, ω, spins, and position and velocity if free.

    A body on a table leans only a little, in another direction, so that the table still pushes it.
    """
    motion = ((-2.5, 0.5, 1.5), (-0.2, 0.7, 0.1), (1.5, 0.3, -0.6))
    spins = -scenario.rotors.start_spins / 2
    attitude = (-0.5, 0.5, -0.1, 0.7) if scenario.effects.table is None else (0.96, -0.28, 0.0, 0.0)
    return started_at(scenario, attitude, *motion, spins)


SCENES: dict[str, Scenario] = {
    built.name: built
    for built in (
        scene("free"),
        scene("free-thrown", start=THROWN),
        scene("free-tilted", body=TILTED, start=THROWN),
        scene("free-tilted-plate", body=TILTED_PLATE),
        scene("free-falling", body=TILTED, start=THROWN, effects=SKEW_GRAVITY),
        scene("free-drag", body=TILTED, start=THROWN, effects=DRAG),
        scene("free-torque-body", body=TILTED, start=THROWN, effects=TORQUE_BODY),
        scene("free-torque-world", body=TILTED, start=THROWN, effects=TORQUE_WORLD),
        scene("pivot", body=TILTED, effects=PIVOT),
        scene("pivot-plate", body=TILTED_PLATE, effects=PIVOT),
        scene("heavy-top", body=TOP, start=SPUN_UP, effects=PIVOT + GRAVITY),
        scene("heavy-tilted", body=TILTED, effects=PIVOT + SKEW_GRAVITY),
        scene("pivot-drag", body=TILTED, effects=PIVOT + DRAG),
        scene("pivot-torque-body", body=TILTED, effects=PIVOT + TORQUE_BODY),
        scene("pivot-torque-world", body=TILTED, effects=PIVOT + TORQUE_WORLD),
        scene("free-rotors", body=TILTED, start=THROWN, effects=SKEW_GRAVITY + ROTORS),
        scene("pivot-rotors", body=TILTED, effects=PIVOT + SKEW_GRAVITY + ROTORS),
        scene("table", body=TOP, start=SPUN_UP, effects=TABLE + GRAVITY),
        scene("table-torque-body", body=TOP, start=SPUN_UP, effects=TABLE + GRAVITY + FEEBLE),
        scene("table-rotors", body=TOP, start=SPUN_UP, effects=TABLE + GRAVITY + SMALL_ROTORS),
        scene("everything", body=TILTED, effects=PIVOT + SKEW_GRAVITY + DRAG + TORQUE_WORLD),
    )
}
