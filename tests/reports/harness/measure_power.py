"""Faults planted at random, by somebody who did not write the checks: what is found and named.

An engine of a few lines integrates exactly what a scene asks for, at order 1, 2 or 4, in double or
single precision, but for one fault out of `power_faults.FAULTS`; others are planted around MuJoCo
and PyBullet. What is a fault is said beforehand, by theory: one whose effect vanishes with the
timestep is none.

    measure_power.py COUNT SEED

The page is of all seeds in build/power.
"""

import json
import re
import sys
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.linalg import norm
from power_faults import FAULTS, F, Fault, Top, V, Wrapped
from spincheck.engine import Engine, Method, Scenario, Session
from spincheck.engines import engines
from spincheck.reports.harness.prepared import Prepared, prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.scenarios import EFFECTS, find, load, loads
from spincheck.scenarios.rotation import matrix
from studies import verdict_of

#: Five of each kind.
COUNT, SEED = 5 * len(FAULTS), 34
MOST_STEPS = 1 << 9
#: The stock timestep, in longest timesteps that are examined, unless it is a 300th of the window.
STOCK = 0.37
SIZES = (0.1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9)
#: A fault of less than that, relative to the largest terms on the exact motion, is drawn anew.
LEAST = 5e-10
#: Standard errors of the limit, below which the model cannot tell a limit from zero at its level.
SURE = 6.5
KEPT = Path("build/power")
PAGE = Path(__file__).parents[3] / "docs/measured/power.md"
FAR = """spincheck = 1
title = "a pivot 100 radii of gyration from the com"
source = "a generator"
[body]
mass = 1.0
inertia = [[2e-4, 2e-5, 0], [2e-5, 3e-4, 1e-5], [0, 1e-5, 4e-4]]
com = [1.2, -0.4, 1.1]
[start]
rotation_vector_deg = [20, -35, 10]
omega_body = [2.0, -1.0, 3.0]
[effects]
gravity = { acceleration = [0, 0, -9.81] }
pivot = {}
drag = { rotational = 0.2 }
[window]
duration = 4.0
samples = 41
"""
SCENES = (
    *("tennis-racket", "book-in-skew-axes", "football-spiral", "nutation-loops", "lopsided-body"),
    *("sleeping-top", "kovalevskaya", "spherical-pendulum", "book-with-drag", "tiring-top"),
    *("drag-until-rest", "motor-driven-top", "book-pushed", "hurried-top", "far"),
    *("satellite-and-its-wheel", "gyroscope-in-its-frame", "dual-spin-turn"),
    *("hammer", "juggling-club", "far-from-the-origin"),
)


@dataclass(frozen=True)
class Planted:
    """A fault of a size in a method on a scene."""

    fault: Fault
    size: float
    scene: str
    order: int
    single: bool
    real: str
    axis: Any
    part: float
    unit: float
    speeds: tuple[float, float]
    stock: float
    long: bool


class PlantedEngine(Engine):
    interface, name, version = 2, "planted", "1"

    def __init__(self, p: Planted) -> None:
        self.p, self.single_precision, self.stock_timestep = p, p.single, p.stock
        self.real = tuple(p.real.split()) or None
        one = Method("m", p.order, p.order, "planted", frozenset(EFFECTS))
        if self.real:
            one = replace(engines()[self.real[0]].method(self.real[1]), name="m")
        self.methods = (one,)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        if not self.real:
            return Top(scenario, self.p.order, self.p.single, timestep, self.p)
        engine = engines()[self.real[0]]
        factor = 1 + self.p.size if self.p.fault.name.endswith("timestep 1 + e") else 1.0
        inner = engine.open(scenario, engine.method(self.real[1]), timestep * factor)
        return Wrapped(inner, scenario, timestep, self.p)


@cache
def scene(name: str, long: bool = False) -> tuple[Scenario, Prepared, float]:
    """With its exact motion and a stock timestep, s."""
    scenario = loads(FAR, "far") if name == "far" else load(find([name])[0])
    stock, places = scenario.window.duration / 300, prepare(scenario, [], MOST_STEPS).places
    if places and not long:
        stock = STOCK * float(places.timesteps[0])
    return scenario, prepare(scenario, [], MOST_STEPS, [stock]), stock


def planted(
    fault: Fault, size: float, name: str, order: int, single: bool, real: str, rng: Any
) -> Planted:
    """With the scales of the scene."""
    is_long = bool(rng.random() < 0.25)
    scenario, prepared, stock = scene(name, is_long)
    exact, axis = prepared.solution.trajectory, rng.normal(size=3)
    momenta = exact.omega_body @ np.array(scenario.inertia)
    top = float(norm(exact.omega_body, axis=1).max())
    scales = (float(prepared.places.timesteps[0]) if prepared.places else stock), top
    where = fault, size, name, order, single, real, axis / norm(axis), rng.random()
    p = Planted(*where, 1.0, scales, stock, is_long)
    honest = Top(scenario, 4, False, stock, replace(p, fault=F("")))
    states = zip(exact.q_world_body_wxyz, exact.omega_body, strict=True)
    torques = [float(norm(honest.honest(matrix(q), w))) for q, w in states]
    return replace(p, unit=max(float(norm(momenta, axis=1).max()) * top, *torques))


def effect(p: Planted) -> float:
    """What is besides, relative to the largest terms, at most on the exact motion."""
    fault, (scenario, prepared, _) = p.fault, scene(p.scene, p.long)
    if p.real or fault.nominal or fault.vanishes or not (fault.torque or fault.turn or fault.fall):
        return p.size
    x = prepared.solution.trajectory
    one, found = Top(scenario, 4, False, p.stock, p), 0.0
    one.h = scenario.window.duration / len(x.t)
    for k, t in enumerate(x.t):
        one.n, one.t = k, float(t)
        one.y = np.concatenate(
            [x.q_world_body_wxyz[k], x.omega_body[k], x.com_world[k], x.velocity_world[k]]
        )
        R, w = matrix(one.y[:4]), one.y[4:7]
        fallen = (float(norm(one.g)) + p.speeds[1] * float(norm(one.y[V]))) or 1.0
        besides = (
            (fault.torque and fault.torque(one, R, w), p.unit),
            (fault.turn and fault.turn(one, R, w), p.speeds[1]),
            (fault.fall and fault.fall(one), fallen),
        )
        found = max(
            found, *(float(norm(what)) / scale for what, scale in besides if what is not None)
        )
    return found


def has(name: str) -> str:
    """Letters of `Fault.needs` that a scene has."""
    scenario, prepared, _ = scene(name)
    held, called = scenario.constraint.is_pivot, scenario.called_for
    speeds = norm(prepared.solution.trajectory.omega_body, axis=1)
    letters = {"g": held and "gravity" in called, "d": "drag" in called, "p": held, "f": not held}
    letters |= {"w": not held and "gravity" in called, "r": bool(scenario.rotors), "n": True}
    letters |= {"t": bool({"torque_body", "torque_world"} & called), "b": not scenario.rotors}
    letters |= {"m": not scenario.rotors, "v": np.ptp(speeds) > 1e-3 * speeds.max()}
    return "".join(letter for letter, is_there in letters.items() if is_there)


def drawn(fault: Fault, rng: Any) -> tuple[Planted, float] | None:
    """One planting of a kind that has an effect; None if none is found."""
    for _ in range(40):
        name = str(rng.choice(SCENES))
        single = "n" not in fault.needs and bool(rng.random() < 0.15)
        size = float(rng.choice(SIZES[: 3 if single else None]))
        real, order = "", int(rng.choice([1, 2, 4]))
        if not set(fault.needs) <= set(has(name)):
            continue
        if set(fault.needs) & set("mb"):
            real, single = str(rng.choice(REAL["m" if "m" in fault.needs else "b"])), False
            engine = engines()[real.split()[0]]
            if engine.unsupported(scene(name)[0], engine.method(real.split()[1])):
                continue
        p = planted(fault, size, name, order, single, real, rng)
        if (felt := effect(p)) >= LEAST:
            return p, felt
    return None


REAL = {"m": ("mujoco Euler", "mujoco implicitfast", "mujoco RK4")}
REAL["b"] = (*REAL["m"], "pybullet multibody")
KINDS = {one.name: one for one in FAULTS}
#: How a fault that is found is named, and what becomes of others.
FOUND, NOT_FOUND = ("rightly", "as a quantity", "otherwise"), ("below noise", "open", "passes")
#: Relative difference of a size that is named rightly.
NEAR = 0.2
#: Letters of a reason that are shown.
LONG = 240
HEAD = """# Faults planted by an outsider

Made by `make power`: {planted} faults of {kinds} kinds, drawn at random on {scenes} scenes,
judged as `spincheck run` judges. Who wrote the catalogue, `tests/support/power_faults.py`, did not
write the checks. A small engine integrates what a scene asks for at order 1, 2 or 4, in double
or single precision, but for the fault; some are planted in MuJoCo and PyBullet. Sizes are from
0.1 to 1e-9 of the largest terms; a fault that comes to less than {least:.0e} of them on the exact
motion was drawn anew. Runs have up to {steps} steps. A verdict takes {seconds:.2f} s of CPU time
on average, {longest:.1f} s at most.

**Found**: {found} of {planted}.

- *rightly*: the reason names the change, and its size to 20 %.
- *as a quantity*: it says which rate is off, or that a step depends on more than the state, and
  by how much.
- *otherwise*: it says "as if" of something else. Some are as good: a torque that acts in few
  states is a torque besides there.
- *below noise*: the fault is smaller than {sure} standard errors to which the limit of what steps
  gain is known.
- *open*: `unresolved`, `unsupported` or `diverges`.
- *passes*: `converges`. Each is listed below.

| kind | planted | found | rightly | as a quantity | otherwise | below noise | open | passes |
|---|---|---|---|---|---|---|---|---|
{table}
{sums}

## What passes
{passes}

## What stays open
{open}

## No faults
Engines without a fault (`none`), and with one whose effect vanishes with the timestep. Where that
is at half of the declared order or less, the reason says so, which is no accusation.

| kind | judged | accused |
|---|---|---|
{honest}

Accused:

{accused}

## Named otherwise
{otherwise}
"""


def judged(p: Planted, felt: float) -> dict[str, Any]:
    scenario, prepared, _ = scene(p.scene, p.long)
    engine, begun = PlantedEngine(p), process_time()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        verdict = verdict_of(convergence_study_of(scenario, engine, engine.methods[0], prepared))
    steps = verdict.steps
    kept = {"kind": p.fault.name, "size": p.size, "felt": felt, "scene": p.scene, "order": p.order}
    kept |= {"single": p.single, "real": p.real, "verdict": verdict.verdict, "tail": verdict.tail}
    kept |= {"reason": verdict.reason, "known": steps.known_to if steps else None}
    return kept | {"shown": steps.order if steps else 0, "seconds": process_time() - begun}


def outcome(row: dict[str, Any]) -> str:
    """In a word; a low order is no accusation."""
    accused = row["verdict"] in ("disagrees", "failed")
    if row["kind"] == "none" or KINDS[row["kind"]].vanishes:
        # Told as what it is: the declared order is not reached.
        told = "vanishes with the timestep at order" in row["reason"]
        return "accused" if accused and not told else "not accused"
    if accused:
        return naming(row)
    if row["verdict"] != "converges":
        return "open"
    return "below noise" if row["felt"] < SURE * (row["known"] or 0.0) else "passes"


def naming(row: dict[str, Any]) -> str:
    """How the reason of a fault that is found names it."""
    words, reason = KINDS[row["kind"]].words, row["reason"]
    if words and (match := re.search(words, reason)):
        number = next(filter(None, match.groups()), "")
        sizes = (row["size"], row["felt"])
        off = [abs(abs(float(number) - 1) / x - 1) for x in sizes] if number else [0.0]
        return "rightly" if min(off) < NEAR else "otherwise"
    return "otherwise" if "as if" in reason else "as a quantity"


def page(rows: Sequence[dict[str, Any]]) -> str:
    """As Markdown."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        counts[row["kind"]][outcome(row)] += 1
    faults = [kind for kind in counts if kind != "none" and not KINDS[kind].vanishes]
    total = sum((counts[kind] for kind in faults), Counter())
    lines = [_line(kind, counts[kind]) for kind in faults]
    honest = [
        f"| {kind} | {counts[kind].total()} | {counts[kind]['accused']} |"
        for kind in counts
        if kind not in faults
    ]
    listed = {
        which: "\n".join(map(_told, (row for row in rows if outcome(row) == which))) or "None."
        for which in ("passes", "open", "accused", "otherwise")
    }
    return HEAD.format(
        planted=total.total(),
        kinds=len(faults),
        scenes=len({row["scene"] for row in rows}),
        found=sum(total[word] for word in FOUND),
        seconds=sum(row["seconds"] for row in rows) / len(rows),
        longest=max(row["seconds"] for row in rows),
        steps=MOST_STEPS,
        least=LEAST,
        sure=SURE,
        sums=_line("all", total),
        table="\n".join(lines),
        honest="\n".join(honest),
        **listed,
    )


def _line(kind: str, words: Counter[str]) -> str:
    found = sum(words[word] for word in FOUND)
    columns = (words.total(), found, *(words[one] for one in (*FOUND, *NOT_FOUND)))
    return f"| {kind.replace('|', '‖')} | {' | '.join(map(str, columns))} |"


def _told(row: dict[str, Any]) -> str:
    method = row["real"] or f"order {row['order']}{', single precision' if row['single'] else ''}"
    reason = row["reason"] if len(row["reason"]) < LONG else f"{row['reason'][:LONG]} …"
    size = f"{row['size']:.0e} (on the motion {row['felt']:.0e})"
    return f"- {row['kind']}, {size}, {row['scene']}, {method}: {row['verdict']}, {reason}"


def main(arguments: Sequence[str]) -> None:
    count, seed = [*map(int, arguments), *(COUNT, SEED)[len(arguments) :]]
    KEPT.mkdir(parents=True, exist_ok=True)
    with (KEPT / f"{seed}.jsonl").open("w", encoding="utf-8") as file:
        for p, felt in plan(count, seed):
            print(json.dumps(judged(p, felt), ensure_ascii=False), file=file, flush=True)
    PAGE.write_text(page(kept()), encoding="utf-8")


def kept() -> list[dict[str, Any]]:
    """What was judged with all seeds, of kinds that there are."""
    texts = [path.read_text(encoding="utf-8") for path in sorted(KEPT.glob("*.jsonl"))]
    rows = [json.loads(line) for text in texts for line in text.splitlines()]
    return [row for row in rows if row["kind"] in KINDS or row["kind"] == "none"]


def plan(count: int, seed: int) -> Iterator[tuple[Planted, float]]:
    """Every scene without a fault, then so many faults, of one kind after the other."""
    for name in SCENES:
        for order, single in ((1, False), (2, False), (4, False), (1, True), (4, True)):
            rng = np.random.default_rng(seed)
            yield planted(F("none"), 0.0, name, order, single, "", rng), 0.0
    for number in range(count):
        if found := drawn(FAULTS[number % len(FAULTS)], np.random.default_rng([seed, number])):
            yield found


if __name__ == "__main__":
    main(sys.argv[1:])
