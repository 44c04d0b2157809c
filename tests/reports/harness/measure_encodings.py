"""Counts false alarms of encodings: random bodies, each described in every way, in real engines.

`make encodings COUNT=1000`; with `FROM=700` it goes on after the first 700. An encoding that an
engine is known to answer otherwise (docs/how-to/encodings.md) is counted, but is no false alarm.
"""

import sys
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engines import engines
from spincheck.engines.encodings import ENCODINGS
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.varied.encodings import run_encodings
from spincheck.scenarios import Scenario, loads
from studies import Nowhere

#: Engine and encoding: what is known of it.
KNOWN = {
    ("mujoco", "offset"): {"coarser"},
    # The scene as it is drifts, where its com is off its frame.
    ("mujoco", "aligned"): {"coarser"},
    ("mujoco", "slides-ball"): {"coarser"},
    ("mujoco", "hinges"): {"coarser", "ends early", "open"},
    # Below 0.001 rad a unit of time it takes the first terms of the exponential.
    ("pybullet", "ms"): {"coarser"},
    ("pybullet", "welded"): {"ends early"},
    ("pybullet", "nested"): {"ends early"},
    ("pybullet", "full-tensor"): {"other body"},
    ("pybullet", "shape"): {"other body"},
    # In maximal coordinates all but the first are dropped, and what is left turns too far a step.
    ("pybullet", "halves"): {"coarser", "other body", "ends early"},
    ("pybullet", "thirds"): {"coarser", "other body", "ends early"},
}
#: Of so many bodies, one has rotors; one has its com off its frame.
WITH_ROTORS, OFF_ITS_FRAME = 3, 2
METHODS = ("RK4", "implicitfast", "multibody", "maximal")


def random_scene(seed: int) -> Scenario:
    """A free body of 0.1 to 10 kg and 5 to 50 cm, that tumbles for 1 s.

    Some have rotors, some a com off their frame.
    """
    rng = np.random.default_rng(seed)
    mass, size = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1.3, -0.3)
    spread = mass * size**2 * 10 ** rng.uniform(-2, 0, 3)
    turn = Rotation.random(random_state=seed).as_rotvec(degrees=True)
    omega = rng.normal(size=3) * 10 ** rng.uniform(-1, 1)
    numbers = {"inertia": spread.sum() - spread, "turn": turn, "omega": omega}
    numbers["velocity"] = rng.normal(size=3)
    inertia, turn, omega, velocity = (values.tolist() for values in numbers.values())
    rotors = "".join(random_rotors(rng, mass, size)) if seed % WITH_ROTORS == 0 else ""
    com = (rng.normal(size=3) * size * (seed % OFF_ITS_FRAME == 0)).tolist()
    return loads(
        f"""spincheck = 1
title = "A random body"
source = "measure_encodings.py"
[body]
mass = {mass}
inertia = {inertia}
com = {com}
[start]
rotation_vector_deg = {turn}
omega_body = {omega}
velocity = {velocity}
{rotors}[window]
duration = 1.0
samples = 11
""",
        f"random-{seed}",
    )


def random_rotors(rng: np.random.Generator, mass: float, size: float) -> Iterator[str]:
    """One to three rotors of a hundredth to a tenth of a body's mass, on hinges of every kind."""
    for _ in range(rng.integers(1, 4)):
        share = 10 ** rng.uniform(-2, -1)
        across = mass * share * (size * 10 ** rng.uniform(-1, 0)) ** 2
        hinge = str(rng.choice(["free", "driven", "locked"]))
        spin = 0.0 if hinge == "locked" else float(rng.normal() * 10 ** rng.uniform(0, 3))
        yield f"""[[rotors]]
axis = {rng.normal(size=3).tolist()}
position = {(rng.normal(size=3) * size).tolist()}
mass = {mass * share}
inertia = {[across, across * rng.uniform(0.1, 1.9)]}
spin = {spin}
hinge = "{hinge}"
"""


def main(count: int, first: int = 0) -> int:
    """Print what came of `count` bodies but the `first` ones; 1 if there was a false alarm."""
    choice = Choice(
        tuple(engines()[name] for name in ("mujoco", "pybullet")), methods=METHODS, timesteps=()
    )
    names = [name for name in ENCODINGS if name != "plain"]
    words, false, known = Counter(), 0, 0
    for seed in range(first, count):
        scene = random_scene(seed)
        with InProcess() as executor:
            made = run_encodings([scene], choice, names, Nowhere(), executor)
        for row in made:
            what, word = (row.key.engine, row.encoding), row.beside.word
            words[*what, word] += 1
            if word in {"same", "left out"}:
                continue
            if word in KNOWN.get(what, set()):
                known += 1
                continue
            false += 1
            print(seed, row.key.label, row.encoding, row.beside, flush=True)
        if (seed + 1) % 50 == 0:
            print(found(first, seed + 1, words, false, known), flush=True)
    for what, number in sorted(words.items()):
        print(*what, number)
    print(found(first, count, words, false, known))
    return int(bool(false))


def found(first: int, end: int, words: Counter, false: int, known: int) -> str:
    """What came of the bodies from one to another, in a line."""
    seconds = time.process_time() / (end - first)
    counts = f"{false} false alarms, {known} known answers in {words.total()} answers"
    return f"bodies {first} to {end - 1}: {counts}; {seconds:.2f} CPU s a body"


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:] or ("20",))))
