"""Honest methods on random scenes of wide ranges: false accusations, and the smallest tails.

Each scene is seen by single steps and by replays of a ladder of a few runs. Several processes may
share the scenes, one part each:

    measure_random.py COUNT FIRST

runs scenes FIRST to FIRST + COUNT - 1. The page is of all parts in build/random-scenes. With
`single` as a third word the methods are those of single precision, and the page
random-scenes-single.md.
"""

import json
import sys
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time

import numpy as np
from kinds_of_engines import why_missing
from scipy.spatial.transform import Rotation
from spincheck.engines import Engine, Method, engines
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.results.evidence import LEVEL
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario, loads
from studies import verdict_of

COUNT, SEED = 1000, 1
#: Largest number of steps of a run: two or three halvings.
MOST_STEPS = 1 << 8
PAGES = Path(__file__).parents[3] / "docs/measured"
#: Those that are there are run.
METHODS = (
    ("mujoco", "Euler"),
    ("mujoco", "implicitfast"),
    ("mujoco", "RK4"),
    ("pybullet", "multibody"),
    ("dartpy", "semi-implicit"),
    ("drake", "runge_kutta3"),
    ("exudyn", "RK44"),
    ("pin", "RK4"),
)
#: Those of single precision, with a gyroscopic torque and pivots that are no springs.
SINGLE = (
    ("newton", "mujoco-rk4"),
    ("newton", "mujoco-implicitfast"),
    ("newton", "featherstone"),
    ("newton", "steel"),
    ("mujoco-warp", "RK4"),
    ("mujoco-warp", "Euler"),
    ("brax", "generalized"),
    ("genesis", "Euler"),
)
SAMPLES = 41
#: Verdicts that accuse an honest method.
ACCUSING = ("disagrees", "failed")
#: Why a method is accused, where that was found out, by scene and method.
CAUSES = {
    "random-123, newton featherstone": "It falls to 36 m from the world's origin, about which the "
    "solver has inertia and torques: what single precision leaves of them there is off so much "
    "(engines-more.md, Newton).",
    "random-887, newton featherstone": "It falls to 782 m from the world's origin, likewise; with "
    "the same rotation and no gravity it converges.",
    "random-177, brax generalized": "There the body is 2.0° from the pole of the three hinges that "
    "stand for a ball joint.",
}
#: Smallest tails that are printed.
SHOWN = 10
KEPT = Path("build")
HEAD = """# Verdicts on honest methods{kind} on random scenes

Made by `make {name}` from {scenes} scenes, {pairs} pairs of a scene and a method, in
{seconds:.2f} s of CPU time each. Bodies have skew tensors, of any shape down to rods whose moments
differ by a factor of 1000, and spin with 0.1 to 1000 rad/s. Effects come in all combinations; drag
is up to 100 times as fast as the body turns, and the com up to 1000 radii of gyration from the
origin of a body that is free. A pair is judged by single steps and by replays of runs of up to
{steps} steps.

| method | {words} |
|---|{rule}|
{table}

A row adds up to the scenes that the method was run on and supports.

False accusations (`disagrees` or `failed`): {accused}.

The smallest tails (one of so many is as small as {expected:.0e}; a verdict is held to {level:.0e}):

| scene | method | tail |
|---|---|---|
{smallest}

Accused:

{wrong}
"""


def random_scene(number: int) -> Scenario:
    """The scene of that number: the same however many there are."""
    rng = np.random.default_rng([SEED, number])
    # Moments of three masses on the axes obey the triangle inequality; of a rod two are small.
    a, b, c = 10 ** rng.uniform(-3.0 if rng.random() < 0.5 else -1.0, 0.0, 3)
    R = Rotation.random(rng=rng).as_matrix()
    inertia = R @ np.diag([b + c, a + c, a + b]) @ R.T
    inertia = (inertia + inertia.T) / 2
    mass, speed = rng.uniform(0.5, 2.0), 10 ** rng.uniform(-1, 3)
    gyration = float(np.sqrt(np.trace(inertia) / 3 / mass))
    has = dict(zip(("gravity", "pivot", "drag", "torque"), rng.random(4) < 0.5, strict=True))
    # Of a body on a pivot far from its com the motion is a pendulum's, and its spin adds nothing.
    far = 10 ** rng.uniform(-2, 0 if has["pivot"] else 3)
    unit = float(np.trace(inertia)) / 3 * speed
    duration = rng.uniform(0.5, 5) * 2 * np.pi / speed
    lines = [
        "spincheck = 1",
        'title = "random"',
        'source = "a generator"',
        "[body]",
        f"mass = {mass!r}",
        f"inertia = {inertia.tolist()!r}",
        f"com = {(far * gyration * _direction(rng)).tolist()!r}",
        "[start]",
        f"rotation_vector_deg = {rng.uniform(-90, 90, 3).tolist()!r}",
        f"omega_body = {(speed * _direction(rng)).tolist()!r}",
    ]
    if has["gravity"]:
        lines += ["[effects.gravity]", f"acceleration = {rng.uniform(-10, 10, 3).tolist()!r}"]
    if has["pivot"]:
        lines += ["[effects.pivot]"]
    if has["drag"]:
        lines += ["[effects.drag]", f"rotational = {unit * 10 ** rng.uniform(-3, 2)!r}"]
    if has["torque"]:
        axes, size = rng.choice(["body", "world"]), unit * speed * 10 ** rng.uniform(-3, 0)
        lines += ["[effects.torque]", f"{axes} = {(size * _direction(rng)).tolist()!r}"]
    lines += ["[window]", f"duration = {duration!r}", f"samples = {SAMPLES}"]
    return loads("\n".join(lines) + "\n", f"random-{number}")


def _direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def methods(named: Sequence[tuple[str, str]]) -> Iterator[tuple[Engine, Method]]:
    """Of the engines that are there."""
    for name, of_engine in named:
        if not why_missing(name):
            engine = engines()[name]
            yield engine, engine.method(of_engine)


def verdicts(number: int, named: Sequence[tuple[str, str]] = METHODS) -> Iterator[Verdict]:
    """Of every method that can simulate the scene."""
    scenario = random_scene(number)
    prepared = prepare(scenario, [], MOST_STEPS)
    for engine, method in methods(named):
        if not engine.unsupported(scenario, method):
            with warnings.catch_warnings():
                # What overflows in an engine's own process is a run that blows up.
                warnings.simplefilter("ignore")
                yield verdict_of(convergence_study_of(scenario, engine, method, prepared))


def is_wrong(verdict: Verdict) -> bool:
    """Whether an honest method is accused."""
    return verdict.verdict in ACCUSING


@dataclass
class Counts:
    """What was counted of so many scenes, as it is kept beside the page.

    Attributes
    ----------
    words : verdicts by method and word
    tails : the smallest, each with scene and method
    wrong : a line each
    """

    scenes: int = 0
    seconds: float = 0.0
    words: Counter[str] = field(default_factory=Counter)
    tails: list[tuple[float, str, str]] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def add(self, verdict: Verdict) -> None:
        """Count a verdict."""
        key, method = verdict.key, f"{verdict.key.engine} {verdict.key.method}"
        self.words[f"{method}: {verdict.verdict}"] += 1
        if verdict.tail is not None:
            self.tails = sorted([*self.tails, (verdict.tail, key.scenario, method)])[:SHOWN]
        if is_wrong(verdict):
            told = f"{verdict.verdict}: {verdict.reason}"
            self.wrong.append(f"{key.scenario}, {method}: {told}")

    def joined(self, other: "Counts") -> "Counts":
        """Of the scenes of both."""
        return Counts(
            self.scenes + other.scenes,
            self.seconds + other.seconds,
            self.words + other.words,
            sorted([*self.tails, *other.tails])[:SHOWN],
            self.wrong + other.wrong,
        )

    @staticmethod
    def read(text: str) -> "Counts":
        """As `written` wrote it."""
        stored = json.loads(text)
        tails = [tuple(one) for one in stored["tails"]]
        return Counts(**stored | {"words": Counter(stored["words"]), "tails": tails})

    @property
    def written(self) -> str:
        """As JSON."""
        return json.dumps(vars(self))

    def page(self, name: str) -> str:
        """As Markdown, as made by `make name`."""
        found = sorted({line.split(": ")[1] for line in self.words})
        pairs = sum(self.words.values())
        names = sorted({line.split(": ")[0] for line in self.words})
        rows = [[name, *(str(self.words[f"{name}: {one}"]) for one in found)] for name in names]
        smallest = [[scene, method, f"{tail:.1e}"] for tail, scene, method in self.tails]
        return HEAD.format(
            name=name,
            kind=" of single precision" if name.endswith("single") else "",
            scenes=self.scenes,
            pairs=pairs,
            seconds=self.seconds / max(1, pairs),
            steps=MOST_STEPS,
            words=" | ".join(found),
            rule="|".join("---" for _ in found),
            table=_lines(rows),
            accused=len(self.wrong),
            expected=1 / max(1, pairs),
            level=LEVEL,
            smallest=_lines(smallest),
            wrong="\n".join(map(_with_cause, self.wrong)) or "None.",
        )


def _with_cause(line: str) -> str:
    return f"- {line}. {CAUSES.get(line.split(': ')[0], '')}".rstrip()


def _lines(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def measured(numbers: Sequence[int], named: Sequence[tuple[str, str]] = METHODS) -> Counts:
    """Of the scenes of these numbers."""
    counts, begun = Counts(), process_time()
    for number in numbers:
        for verdict in verdicts(number, named):
            counts.add(verdict)
            if is_wrong(verdict):
                print(counts.wrong[-1], flush=True)
        counts.scenes += 1
        counts.seconds = process_time() - begun
    return counts


def main(arguments: Sequence[str]) -> int:
    """Run so many scenes, and write the page; 1 if a method is accused."""
    is_single = arguments[2:] == ["single"]
    name = "random-single" if is_single else "random"
    count, first, *_ = [*map(int, arguments[:2]), *(COUNT, 0)[len(arguments) :]]
    counts = measured(range(first, first + count), SINGLE if is_single else METHODS)
    kept = KEPT / name.replace("random", "random-scenes")
    kept.mkdir(parents=True, exist_ok=True)
    (kept / f"{first}.json").write_text(counts.written, encoding="utf-8")
    parts = [Counts.read(one.read_text(encoding="utf-8")) for one in sorted(kept.glob("*.json"))]
    joined = Counts()
    for part in parts:
        joined = joined.joined(part)
    page = joined.page(name)
    (PAGES / f"{kept.name}.md").write_text(page, encoding="utf-8")
    print(page)
    return int(bool(joined.wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
