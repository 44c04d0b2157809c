"""Honest motions over wide ranges: of methods of orders 1 to 4, of real engines, and measured ones.

Nothing is wrong with any of them: whatever is said to be wrong is a false accusation.
"""

import warnings
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from kinds_of_engines import why_missing
from planted_motions import Rates, product, stepped
from scipy.spatial.transform import Rotation
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reference.other_equations import equations_of
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import Scenario, from_tables

Arrays = dict[str, np.ndarray]
#: Those that are there are run; an engine's own order is stated, or none.
METHODS = (
    *(("mujoco", name) for name in ("Euler", "implicit", "implicitfast", "RK4", "discrete")),
    *(("pybullet", name) for name in ("multibody", "maximal")),
    *(("drake", name) for name in ("semi_explicit_euler", "runge_kutta3", "discrete")),
    *(("exudyn", name) for name in ("ExplicitEuler", "ExplicitMidpoint", "RK44")),
    ("exudyn", "TrapezoidalIndex2"),
    ("dartpy", "semi-implicit"),
    *(("pin", name) for name in ("semi-implicit", "RK4")),
    ("rapier3d", "impulse"),
)
SHAPES = ("slender", "flat", "nearly spherical", "symmetric", "any")
ACTING = ("free", "heavy", "drag", "torque", "rotors")
SOURCES = ("order 1", "order 2", "order 3", "order 4", "engine", "engine", "engine", "measured")
#: Steps of a run at most, and part of the files that do not begin with the scene's start.
MOST_STEPS, LATE = 4000, 0.2


@dataclass(frozen=True, eq=False)
class Honest:
    """A motion that nothing is wrong with, and what its file states.

    Attributes
    ----------
    source : what made it
    body : shape of the body, and what acts on it
    """

    source: str
    body: str
    scenario: Scenario
    arrays: Arrays
    settings: dict[str, str]
    order: int

    def judged(self) -> JudgedMotion:
        """The motion as `judge` sees it."""
        recording = Recording(Path("motion.csv"), self.arrays, self.settings)
        return judged_motion(self.scenario, recording, self.order)


def direction(chance: np.random.Generator) -> np.ndarray:
    """A unit vector, (3,)."""
    vector = chance.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def second_moments(shape: str, chance: np.random.Generator) -> np.ndarray:
    """∫x² dm, ∫y² dm and ∫z² dm of a body of 1 kg about its principal axes, m², (3,)."""
    a, b, c = chance.uniform(0.1, 1.0, 3)
    if shape == "slender":
        a, b = np.array([a, b]) * 10 ** chance.uniform(-3, -1)
    if shape == "flat":
        a *= 10 ** chance.uniform(-3, -1)
    if shape == "nearly spherical":
        a, b, c = 0.3 * (1 + 10 ** chance.uniform(-4, -1) * chance.normal(size=3))
    if shape == "symmetric":
        b = a
    return chance.permutation([a, b, c])


def honest_scene(shape: str, acting: str, chance: np.random.Generator) -> Scenario:
    """A scene of a body of that shape, in skew axes or in its own."""
    mass, size, speed = 10 ** chance.uniform(-2, 2), 10 ** chance.uniform(-1.5, 0.3), 1.0
    speed = 10 ** chance.uniform(-1, 2)
    sides = mass * size**2 * second_moments(shape, chance)
    R = Rotation.random(rng=chance).as_matrix() if chance.random() < 0.7 else np.eye(3)
    inertia = R @ np.diag(sides.sum() - sides) @ R.T
    turns = 10 ** chance.uniform(-0.7, 1.7)
    samples = int(min(400, max(12, turns / 10 ** chance.uniform(-2, -0.4))))
    mean = float(np.trace(inertia)) / 3
    tables: dict[str, object] = {
        "title": "Honest",
        "source": "made up",
        "body": {"mass": mass, "inertia": ((inertia + inertia.T) / 2).tolist()},
        "start": {
            "quaternion_wxyz": Rotation.random(rng=chance).as_quat(scalar_first=True).tolist(),
            "omega_body": (speed * direction(chance)).tolist(),
        },
        "window": {"duration": turns / speed, "samples": samples},
    }
    effects: dict[str, object] = {}
    if acting == "heavy" or (acting != "free" and chance.random() < 0.4):
        lever = size * 10 ** chance.uniform(-2, 0)
        tables["body"]["com"] = (lever * direction(chance)).tolist()
        # A pendulum is not much faster than the body turns.
        gravity = min(9.81, mean * speed**2 / (mass * lever) * 10 ** chance.uniform(-1, 0.5))
        effects = {"gravity": {"acceleration": (gravity * direction(chance)).tolist()}, "pivot": {}}
    if acting == "drag":
        effects["drag"] = {"rotational": mean * speed / turns * 10 ** chance.uniform(-2, 0.5)}
    if acting == "torque":
        torque = mean * speed**2 * 10 ** chance.uniform(-2, 0)
        effects["torque"] = {
            str(chance.choice(["body", "world"])): (torque * direction(chance)).tolist()
        }
    if acting == "rotors":
        of_rotor = mean * 10 ** chance.uniform(-3, -1)
        tables["rotors"] = [
            {
                "axis": direction(chance).tolist(),
                "position": (0.3 * size * direction(chance)).tolist(),
                "mass": 0.05 * mass,
                "inertia": [0.6 * of_rotor, of_rotor],
                "spin": float(speed * 10 ** chance.uniform(-1, 1) * chance.choice([-1, 1])),
                "hinge": str(chance.choice(["free", "driven"])),
            }
            for _ in range(chance.integers(1, 3))
        ]
    return from_tables({**tables, "effects": effects}, "honest")


def honest(number: int) -> Honest | None:
    """The motion of that number: the same however many there are; None where it cannot be made."""
    chance = np.random.default_rng([35, number])
    shape, acting = SHAPES[number % 5], ACTING[number // 5 % 5]
    source = SOURCES[number % len(SOURCES)]
    scene = honest_scene(shape, acting, chance)
    settings: dict[str, str] = {}
    arrays: Arrays = {"omega": np.array([np.nan])}
    times, order, states_timestep = scene.times, 1, chance.random() < 2 / 3
    if source == "measured":
        arrays = with_noise(scene, settings, chance)
        return Honest(source, f"{shape}, {acting}", scene, arrays, settings, order)
    every = int(min(2 ** chance.integers(0, 8), max(1, MOST_STEPS // len(times))))
    timestep = float(times[1]) / every
    if source == "engine":
        found = of_engine(scene, METHODS[chance.integers(len(METHODS))], timestep, every)
        if found is None:
            return None
        source, order, arrays = found
    else:
        order = int(source[-1])
        with warnings.catch_warnings(action="ignore"), suppress(ValueError):
            arrays = stepped(scene, rates_of(scene), order, timestep, chance)
        if not np.isfinite(arrays["omega"]).all():
            # Explicit steps of stiff drag blow up.
            return None
    if states_timestep:
        settings["timestep"] = repr(timestep)
    written(scene, arrays, settings, chance)
    order = order if chance.random() < 0.7 else 1
    if chance.random() < LATE:
        first = int(chance.integers(1, len(times) // 2))
        arrays = {name: rows[first:] for name, rows in arrays.items()}
    return Honest(source, f"{shape}, {acting}", scene, arrays, settings, order)


def rates_of(scene: Scenario) -> Rates:
    """The rates of q and ω by a scene's own numbers."""
    e = equations_of(scene)

    def rates(q: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        torque = np.cross(e.pull, R.T @ e.gravity_world) + e.torque + R.T @ e.torque_world
        torque -= e.slowing[0] * omega + np.cross(omega, e.inertia @ omega + e.kept)
        return product(q, np.array([0, *omega])) / 2, np.linalg.solve(e.inertia, torque)

    return rates


def of_engine(
    scene: Scenario, which: tuple[str, str], timestep: float, every: int
) -> tuple[str, int, Arrays] | None:
    """What an engine makes of a scene: its names, its method's order and the arrays."""
    if why_missing(which[0]):
        return None
    engine = engines()[which[0]]
    method = engine.method(which[1])
    # Drake steps a ball joint as roll, pitch and yaw, badly at their pole: engines-more.md.
    if engine.unsupported(scene, method) or (engine.name == "drake" and scene.constraint.is_pivot):
        return None
    run = engine.run(scene, method, timestep, every * np.arange(len(scene.times)))
    made = run.trajectory
    if run.outcome != "ok" or made is None:
        return None
    arrays = {"t": made.t, "q": made.q_world_body_wxyz, "omega": made.omega_body}
    arrays = {name: np.array(rows) for name, rows in arrays.items()}
    if made.spins.size:
        arrays["spins"] = made.spins
    return " ".join(which), method.order, arrays


def with_noise(scene: Scenario, settings: dict[str, str], chance: np.random.Generator) -> Arrays:
    """The exact motion as sensors measure it; a file may state their noise."""
    motion = solve(scene, scene.times).trajectory
    speed = float(np.linalg.norm(motion.omega_body, axis=1).max())
    noise = np.radians(10 ** chance.uniform(-2, 0)), speed * 10 ** chance.uniform(-4, -1.5)
    turned = Rotation.from_rotvec(chance.normal(0, noise[0], (len(motion.t), 3)))
    q = Rotation.from_quat(np.array(motion.q_world_body_wxyz), scalar_first=True) * turned
    omega = motion.omega_body + chance.normal(0, noise[1], motion.omega_body.shape)
    if chance.random() < 0.5:
        settings |= {"noise_attitude": repr(float(noise[0])), "noise_omega": repr(float(noise[1]))}
    return {"t": motion.t, "q": q.as_quat(scalar_first=True), "omega": omega}


def written(
    scene: Scenario, arrays: Arrays, settings: dict[str, str], chance: np.random.Generator
) -> None:
    """Print the numbers with some digits, along world axes, or leave ω out, as files do."""
    how = chance.choice(["in full", "digits", "world", "single", "without ω", "without spins"])
    if how == "digits":
        digits = chance.integers(5, 10)
        for name in ("q", "omega"):
            arrays[name] = np.array(
                [float(f"{x:.{digits}g}") for x in arrays[name].ravel()]
            ).reshape(arrays[name].shape)
    if how == "single":
        for name in ("q", "omega"):
            arrays[name] = arrays[name].astype(np.float32).astype(float)
    if how == "world":
        R = Rotation.from_quat(arrays["q"], scalar_first=True)
        arrays["omega"], settings["omega"] = R.apply(arrays["omega"]), "world"
    turn = np.linalg.norm(arrays["omega"], axis=1).max() * scene.times[1]
    if how == "without ω" and turn < 0.5 and not scene.kept_at_start.any():
        del arrays["omega"]
    if how == "without spins":
        arrays.pop("spins", None)


def honest_motions(count: int) -> Iterator[tuple[int, Honest]]:
    """So many of them."""
    number = 0
    while count:
        if (one := honest(number)) is not None:
            yield number, one
            count -= 1
        number += 1
