"""Faultless methods on random scenes: false verdicts, and errors above their tolerances, counted.

Bodies have skew tensors, effects come in all combinations, windows are of 2 to 20 periods.
"""

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engines import Engine, Method, engines
from spincheck.reports.harness.judging.best_window import SHARP
from spincheck.reports.harness.prepared import Prepared, prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario, loads
from studies import verdict_of

COUNT, SEED = 1000, 1
#: Largest number of steps of a ladder: where errors over the whole window are large, pieces decide.
MOST_STEPS = 1 << 12
#: Of ladders that are run again as they were too short.
RESOLVING_STEPS = 1 << 19
PAGE = Path(__file__).parents[3] / "docs/measured/random-scenes.md"
#: Of first order in two engines, and of fourth.
METHODS = (("mujoco", "Euler"), ("pybullet", "multibody"), ("mujoco", "RK4"))
SAMPLES = 41
#: Said of `unresolved` ladders that no method can resolve.
TOO_UNCERTAIN = f", as the exact motion, body and start are uncertain by more than {SHARP:g}"
HEAD = f"""# Verdicts on faultless methods on random scenes

Made by `make random` from {{scenes}} scenes and {{methods}}.
Bodies have skew tensors, effects come in all combinations, windows are of 2 to 20 periods. Ladders
have runs of up to {MOST_STEPS} steps; where the verdict is not `converges`, they are run again, up
to {RESOLVING_STEPS} steps. A limit's error that exceeds its tolerance makes a signal
`unresolved`; four times that, over two rungs, `disagrees`.

| | number |
|---|---|
{{table}}

Judged wrongly (`disagrees` or `failed`; at fourth order also `diverges`, and `unresolved` though
the exact motion, body and start are known well enough for a verdict):

{{wrong}}
"""


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


def verdicts(number: int) -> Iterator[tuple[Method, Verdict, bool]]:
    """Of every method, on ladders that resolve it.

    And whether the exact motion, body and start are known too badly for any other verdict.
    """
    scenario = random_scene(number)
    prepared = prepare(scenario, [], MOST_STEPS)
    for name, of_engine in METHODS:
        engine = engines()[name]
        method = engine.method(of_engine)
        verdict, is_too_uncertain = judged(scenario, engine, method, prepared)
        if verdict.verdict != "converges":
            longer = prepare(scenario, [], RESOLVING_STEPS)
            verdict, is_too_uncertain = judged(scenario, engine, method, longer)
        yield method, verdict, is_too_uncertain


def judged(
    scenario: Scenario, engine: Engine, method: Method, prepared: Prepared
) -> tuple[Verdict, bool]:
    """Run the ladder in this process."""
    study = convergence_study_of(scenario, engine, method, prepared)
    verdict = verdict_of(study)
    signals = study.records.ladder.signals
    return verdict, any(one.sequence.uncertainty > SHARP for one in signals)


def is_wrong(method: Method, verdict: Verdict) -> bool:
    """Whether a faultless method is judged wrongly; at first order a ladder may be too short."""
    return verdict.verdict in ("disagrees", "failed") or (
        method.order == 4 and verdict.verdict != "converges"
    )


def is_too_sure(signal: SignalVerdict) -> bool:
    """Whether the limit's error exceeds its stated tolerance."""
    return signal.limit_error is not None and signal.limit_error > (signal.tolerance or 0.0)


def page(scenes: int, counts: Counter[str], wrong: Sequence[str]) -> str:
    """The counts as Markdown."""
    lines = [f"| {what} | {times} |" for what, times in sorted(counts.items())]
    return HEAD.format(
        scenes=scenes,
        methods=", ".join(f"{of} {engines()[of].version} {name}" for of, name in METHODS),
        table="\n".join(lines),
        wrong="\n".join(f"- {line}" for line in wrong) or "None.",
    )


def main() -> int:
    """Run so many scenes, and write the page; 1 if anything is judged wrongly."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    counts: Counter[str] = Counter()
    wrong: list[str] = []
    for number in range(count):
        for method, verdict, is_too_uncertain in verdicts(number):
            order = "fourth order" if method.order == 4 else "first order"
            is_open = is_too_uncertain and verdict.verdict == "unresolved"
            counts[f"{order}: {verdict.verdict}{TOO_UNCERTAIN if is_open else ''}"] += 1
            counts[f"{order}: signals judged"] += len(verdict.signals)
            counts[f"{order}: signals whose limit's error exceeds its tolerance"] += sum(
                is_too_sure(signal) for signal in verdict.signals
            )
            if is_wrong(method, verdict) and not is_open:
                key = verdict.key
                wrong.append(
                    f"{key.scenario}, {key.engine} {key.method}: {verdict.verdict}: "
                    f"{verdict.reason}"
                )
        # A study that is stopped leaves the page of the scenes so far.
        PAGE.write_text(page(number + 1, counts, wrong), encoding="utf-8")
    print(PAGE.read_text(encoding="utf-8"))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
