"""Honest recordings of the library's scenes: runs of known order, printed digits, and noise.

Nothing is wrong with any of them: whatever is said to be wrong is a false accusation.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from library_scenes import library
from scipy.spatial.transform import Rotation
from spincheck.reference import solve
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import Scenario, Trajectory
from spincheck.scenarios.fastest_rate import fastest_rate
from stepped import METHODS, SteppedEngine

Arrays = dict[str, np.ndarray]
#: Angles of a step at the fastest rate, rad; the most steps, and samples, of a run.
TURNS, MOST_STEPS, SAMPLES = (0.02, 0.1), 60_000, 200
#: Standard deviations of noise, rad, and of ω relative to its largest.
NOISES = (1e-4, 1e-2)
#: Scenes that are left out: a million turns take long, and beyond a horizon nothing is exact.
LEFT_OUT = ("million-turns", "chaos-beyond-the-horizon")


@dataclass(frozen=True, eq=False)
class OfLibrary:
    """An honest recording of a library scene, and what made it."""

    source: str
    scenario: Scenario
    arrays: Arrays
    settings: dict[str, str]
    order: int = 1

    def judged(self) -> JudgedMotion:
        """The recording as `judge` sees it."""
        recording = Recording(Path("motion.csv"), self.arrays, self.settings)
        return judged_motion(self.scenario, recording, self.order)


def stepped_run(scenario: Scenario, which: int, turn: float) -> OfLibrary | None:
    """About 200 samples of a run by one of the tests' own methods; None if it blows up.

    `turn` is the angle of a step at the fastest rate, rad.
    """
    method = METHODS[which]
    rate = fastest_rate(scenario, _exact(scenario).omega_body) or 1.0
    steps = min(MOST_STEPS, round(scenario.window.duration * rate / turn))
    samples = np.arange(0, steps + 1, max(1, steps // SAMPLES))
    run = SteppedEngine().run(scenario, method, turn / rate, samples)
    if run.outcome != "ok" or run.trajectory is None:
        return None
    motion, stated = run.trajectory, {"timestep": repr(turn / rate)}
    return OfLibrary(f"order {method.order}", scenario, arrays_of(motion), stated, method.order)


def noisy(scenario: Scenario, size: float, *, is_stated: bool) -> OfLibrary:
    """The exact motion with normal noise, `size` rad in attitude, and relative in ω."""
    chance, exact = np.random.default_rng(7), _exact(scenario)
    speed = float(np.linalg.norm(exact.omega_body, axis=1).max()) or 1.0
    turned = Rotation.from_rotvec(chance.normal(0, size, exact.omega_body.shape))
    q = Rotation.from_quat(exact.q_world_body_wxyz, scalar_first=True) * turned
    omega = exact.omega_body + chance.normal(0, size * speed, exact.omega_body.shape)
    arrays = arrays_of(exact) | {"q": q.as_quat(scalar_first=True), "omega": omega}
    noise = {"noise_attitude": repr(size), "noise_omega": repr(size * speed)}
    source = "noise that is stated" if is_stated else "noise that is not stated"
    return OfLibrary(source, scenario, arrays, noise if is_stated else {})


def printed(scenario: Scenario) -> Iterator[OfLibrary]:
    """The exact motion in all digits, in nine, and in single precision."""
    arrays = arrays_of(_exact(scenario))
    nine = np.vectorize(lambda x: float(f"{x:.9g}"), otypes=[float])
    for source, written in (
        ("all digits", lambda x: x),
        ("nine digits", nine),
        ("single precision", lambda x: x.astype(np.float32).astype(float)),
    ):
        some = {name: x if name == "t" or not x.size else written(x) for name, x in arrays.items()}
        yield OfLibrary(source, scenario, some, {})


def honest_recordings() -> Iterator[OfLibrary]:
    """Recordings of every scene of the library that can be solved throughout."""
    for scenario in library():
        if scenario.name in LEFT_OUT:
            continue
        yield from printed(scenario)
        for size in NOISES:
            yield from (noisy(scenario, size, is_stated=stated) for stated in (False, True))
        if scenario.rotors or not (scenario.constraint.is_pivot or scenario.constraint.is_free):
            continue
        for which in range(len(METHODS)):
            yield from filter(None, (stepped_run(scenario, which, turn) for turn in TURNS))


def _exact(scenario: Scenario) -> Trajectory:
    return solve(scenario, scenario.times).trajectory


def arrays_of(motion: Trajectory) -> Arrays:
    """The arrays of a recording, com, velocity and spins among them."""
    names = {"t": "t", "q": "q_world_body_wxyz", "omega": "omega_body"}
    names |= {"com": "com_world", "velocity": "velocity_world"}
    names |= {"spins": "spins"} if motion.spins.size else {}
    return {key: np.array(getattr(motion, name)) for key, name in names.items()}
