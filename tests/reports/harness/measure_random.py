"""Faultless methods on random scenes: false verdicts, and tolerances below the true error, counted.

Bodies have skew tensors, effects come in all combinations, windows are of 2 to 20 periods.
"""

import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engines import Method, engines
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.harness.study import convergence_study_of, prepare, run_rungs
from spincheck.reports.results.records import Verdict
from spincheck.scenarios import Scenario, loads

COUNT, SEED = 1000, 1
MOST_STEPS = 1 << 15
ENGINES = ("mujoco", "pybullet")
SAMPLES = 41


def random_scene(number: int) -> Scenario:
    """The scene of that number: the same however many there are."""
    rng = np.random.default_rng([SEED, number])
    # Moments of three masses on the axes obey the triangle inequality.
    a, b, c = rng.uniform(0.1, 1.0, 3)
    R = Rotation.random(rng=rng).as_matrix()
    inertia = R @ np.diag([b + c, a + c, a + b]) @ R.T
    inertia = (inertia + inertia.T) / 2
    speed = 10 ** rng.uniform(0, 1.5)
    direction = rng.normal(size=3)
    omega = speed * direction / np.linalg.norm(direction)
    has = dict(zip(("gravity", "pivot", "drag", "torque"), rng.random(4) < 0.5, strict=True))
    duration = rng.uniform(2, 20) * 2 * np.pi / speed
    lines = [
        "spincheck = 1",
        'title = "random"',
        'source = "a generator"',
        "[body]",
        f"mass = {rng.uniform(0.5, 2.0)!r}",
        f"inertia = {inertia.tolist()!r}",
        f"com = {rng.uniform(-0.3, 0.3, 3).tolist()!r}",
        "[start]",
        f"rotation_vector_deg = {rng.uniform(-90, 90, 3).tolist()!r}",
        f"omega_body = {omega.tolist()!r}",
    ]
    if has["gravity"]:
        lines += ["[effects.gravity]", f"acceleration = {rng.uniform(-10, 10, 3).tolist()!r}"]
    if has["pivot"]:
        lines += ["[effects.pivot]"]
    if has["drag"]:
        lines += ["[effects.drag]", f"rotational = {rng.uniform(0.01, 0.1)!r}"]
    if has["torque"]:
        axes = rng.choice(["body", "world"])
        lines += ["[effects.torque]", f"{axes} = {rng.uniform(-0.5, 0.5, 3).tolist()!r}"]
    lines += ["[window]", f"duration = {duration!r}", f"samples = {SAMPLES}"]
    return loads("\n".join(lines) + "\n", f"random-{number}")


def verdicts(scenario: Scenario) -> Iterator[tuple[Method, Verdict]]:
    """Of every clean method that can do the scene."""
    prepared = prepare(scenario, [], MOST_STEPS)
    for engine in (engines()[name] for name in ENGINES):
        for method in engine.methods:
            if method.as_shipped or engine.unsupported(scenario, method):
                continue
            study = convergence_study_of(scenario, engine, method, prepared)
            for _ in run_rungs(study, InProcess()):
                pass
            yield method, study.verdict()


def main() -> int:
    """Run so many scenes; 1 if anything is judged wrongly."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    counts: Counter[str] = Counter()
    for number in range(count):
        for method, verdict in verdicts(random_scene(number)):
            order = "fourth order" if method.order == 4 else "first order"
            counts[f"{order}: {verdict.verdict}"] += 1
            below = [
                one
                for one in verdict.signals
                if one.limit_error is not None and one.limit_error > (one.tolerance or 0.0)
            ]
            counts[f"{order}: tolerances below the true error"] += len(below)
            if verdict.verdict == "disagrees" or (
                method.order == 4 and verdict.verdict == "unresolved"
            ):
                counts["wrong"] += 1
                key = verdict.key
                print(
                    f"{key.scenario} {key.engine} {key.method}: {verdict.verdict}: {verdict.reason}"
                )
    for what, times in sorted(counts.items()):
        print(f"{times:6d}  {what}")
    return min(1, counts["wrong"])


if __name__ == "__main__":
    sys.exit(main())
