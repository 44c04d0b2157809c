"""A result file's contents without a study: made-up motions whose errors are known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engines import Method
from spincheck.reference import Solution
from spincheck.reports.results.evidence import (
    CONSISTENT,
    Evidence,
    Explanation,
    GainCurve,
    ReplayEvidence,
    StepEvidence,
    StepFault,
)
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results, SceneResult
from spincheck.reports.results.store import Store
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import EFFECTS, Errors, Scenario, Trajectory, errors_between, loads

#: What the made-up exact motion is good for; the finest runs of high order are below it.
UNCERTAINTY = Errors(1e-13, 2e-13, 3e-13, 4e-13, 5e-13, 6e-13)
CONDITIONING = Errors(1e-15, 1e-14, 1e-15, 1e-15, 1e-15, 1e-15)
#: s; halved from rung to rung.
TIMESTEPS = tuple(0.02 / 2**k for k in range(6))
#: s; two of them stand for an engine's own stock timestep and for the one of all engines.
STOCK = TIMESTEPS[1:3]
#: Error of a method of order p with the coarsest timestep; with dt, (dt/`TIMESTEPS[0]`)^p of it.
#: That of order 4 falls below the uncertainty of the exact motion.
SIZE = {1: 0.05, 2: 1e-3, 3: 1e-5, 4: 1e-8}
SECONDS_PER_STEP = 1.5e-6
WALL_SECONDS_PER_STEP = 1.75e-6
#: What verdicts rest on: numbers of states and of intervals, and how well limits are known.
STATES, INTERVALS, KNOWN_TO = 17, 64, 1e-12
#: What steps of a method that disagrees show.
HEAVIER = StepFault(
    "limit",
    "angular momentum",
    0.5,
    TIMESTEPS[-1],
    (0.0, 0.2, 0.0),
    (0.0, 0.1, 0.0),
    (Explanation("gravity's size", (1.0,)),),
)
#: In titles and descriptions, where a user could have written it.
MISCHIEF = "<script>alert('x')</script>"

#: By an engine, on the terminal.
PRINTED = f"warning: {MISCHIEF}\n```"

TOP = f"""
spincheck = 1
title = "A top | with *marks* and {MISCHIEF}"
source = "A book & its <author>"
description = "Spun **fast**. {MISCHIEF} ![picture](http://example.org/x.png)"
tags = ["heavy", "<b>"]
[body]
mass = 1.0
inertia = [0.0025, 0.0025, 0.005]
com = [0.0, 0.0, 0.05]
[start]
euler_zyz_deg = [0.0, 30.0, 0.0]
omega_body = [0.0, 0.0, 40.0]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 2.0
samples = 101
"""
BRICK = """
spincheck = 1
title = "A brick"
source = "A book"
[body]
mass = 1.0
inertia = [1.0, 2.0, 2.5]
[start]
quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]
omega_body = [0.1, 1.0, 0.1]
[window]
duration = 2.0
samples = 101
"""


@dataclass(frozen=True)
class MadeUp:
    """A method's order and what it is to be found to do."""

    engine: str
    method: str
    order: int
    verdict: str = "converges"
    reason: str = ""


METHODS = (
    MadeUp("mujoco", "Euler", 1),
    MadeUp("mujoco", "RK4", 4),
    MadeUp("mujoco-urdf", "RK4", 4, "disagrees"),
    MadeUp("pybullet", "multibody", 1, "diverges", "the state is no longer finite at 1.2 s"),
    MadeUp("pybullet", "maximal", 1, "unresolved"),
    MadeUp("elsewhere", "fancy<i>", 2, "failed", "did not finish within 120 s"),
    MadeUp("elsewhere", "plain", 2, "unsupported", "elsewhere plain cannot simulate pivot"),
)


def results(samples: int = 101, methods: Sequence[MadeUp] = METHODS) -> Results:
    """Two scenes, one that could not be solved, and every kind of verdict."""
    scenes, rows, verdicts, judged_by = {}, [], [], []
    for name, text in (("made-up-top", TOP), ("made-up-brick", BRICK)):
        scenario = loads(text, name)
        exact = _exact(scenario, samples)
        scenes[name] = SceneResult(
            scenario, Solution(exact, "made up", UNCERTAINTY, CONDITIONING, horizon=None)
        )
        for method in methods:
            key = Key(name, method.engine, method.method)
            rows += _rows(scenario, exact, key, method)
            judged_by.append(evidence(key, method))
            verdicts.append(_verdict(judged_by[-1], method))
    unsolved = Key("unsolved", "mujoco", "Euler")
    reason = "the reference could not be solved: it blew up"
    rows.append(Row(unsolved, "1.0", 0.0, "failed", reason))
    verdicts.append(Verdict(unsolved, "failed", reason))
    environment = {"date": "2026-01-01T00:00:00+00:00", "processor": "a <fast> one"}
    declared = {(m.engine, m.method): _declared(m) for m in methods}
    return Results(environment, scenes, rows, verdicts, methods=declared, evidence=judged_by)


def put(store: Store, stored: Results) -> None:
    """Store scenes, rows and verdicts."""
    for result in stored.scenes.values():
        store.put_scene(result.scenario, result.solution)
    store.put(*stored.rows, *stored.evidence)
    for verdict in stored.verdicts:
        store.put_verdict(verdict)


def at_stock(stored: Results) -> Results:
    """The same with the runs at `STOCK` marked as those at stock timesteps."""
    rows = [replace(row, stock=row.timestep in STOCK) for row in stored.rows]
    return replace(stored, rows=rows)


def _declared(method: MadeUp) -> Method:
    summary = f"a method of order {method.order} | {MISCHIEF}"
    return Method(method.method, method.order, method.order, summary, frozenset(EFFECTS))


def _rows(scenario: Scenario, exact: Trajectory, key: Key, method: MadeUp) -> list[Row]:
    if method.verdict in ("unsupported", "failed"):
        row = Row(key, "0.9", TIMESTEPS[0], method.verdict, method.reason, printed=PRINTED)
        return [row]
    rows = []
    for dt in TIMESTEPS:
        diverged = method.verdict == "diverges"
        n = len(exact.t) // 2 if diverged else len(exact.t)
        motion = _disturbed(
            exact.until(n), SIZE[method.order] * (dt / TIMESTEPS[0]) ** method.order, scenario
        )
        rows.append(
            Row(
                key,
                "1.0",
                dt,
                "diverged" if diverged else "ok",
                method.reason if diverged else "",
                stopped_at=float(exact.t[n]) if diverged else None,
                errors=None if diverged else errors_between(scenario, motion, exact),
                drifts={"energy": 1e-3 * dt, "L_norm": 1e-4 * dt},
                reference_uncertainty=UNCERTAINTY.omega,
                steps=round(exact.t[n - 1] / dt),
                seconds_per_step=SECONDS_PER_STEP,
                seconds_spread=SECONDS_PER_STEP / 10,
                wall_seconds_per_step=WALL_SECONDS_PER_STEP,
                motion=motion,
            )
        )
    return rows


#: Noise of what steps gain, relative; a wrong limit, which is no noise.
NOISE, OFF = 1e-13, 1e-4


def evidence(key: Key, method: MadeUp) -> Evidence:
    """What its steps and its finest run show: nothing where a method has no steps."""
    if method.verdict in ("unsupported", "failed"):
        return Evidence(key)
    wrong = method.verdict == "disagrees"
    curves = tuple(_curve(quantity, method, wrong) for quantity in ("attitude", "angular momentum"))
    known_to = 2 * CONSISTENT if method.verdict == "unresolved" else KNOWN_TO
    steps = StepEvidence(
        *(STATES, 0.0 if wrong else 0.3, known_to, known_to, method.order, curves),
        HEAVIER if wrong else None,
    )
    replays = () if wrong else (ReplayEvidence(TIMESTEPS[-1], INTERVALS, 0.2, 1e-15),)
    return Evidence(key, steps, None, replays)


def _curve(quantity: str, method: MadeUp, wrong: bool) -> GainCurve:
    """Gains of the declared order, which the longer timesteps predict, and a wrong limit."""
    predicted = [0.1 * (dt / TIMESTEPS[0]) ** method.order for dt in TIMESTEPS]
    gains = [gain + NOISE + OFF * wrong for gain in predicted]
    known_to = [*(1.0, 0.1), *(0.01 * gain + NOISE for gain in predicted[2:])]
    return GainCurve(quantity, TIMESTEPS, *map(tuple, (gains, predicted, known_to, gains)))


def _verdict(judged_by: Evidence, method: MadeUp) -> Verdict:
    broken = ("omega error 1e-2 exceeds the expected 1e-3",) if method.method == "Euler" else ()
    return Verdict(
        judged_by.key,
        method.verdict,
        method.reason,
        judged_by.steps and replace(judged_by.steps, curves=()),
        replays=judged_by.replays,
        unmet=broken,
    )


def _exact(scenario: Scenario, samples: int) -> Trajectory:
    """Regular precession at a tilt of 30°: any motion will do, if its rates are its own."""
    t = np.linspace(0.0, scenario.window.duration, samples)
    beta, precession, spin = np.radians(30.0), 3.0, 7.0
    alpha, gamma = precession * t, spin * t
    turns = np.column_stack([alpha, np.full(samples, beta), gamma])
    R_world_body = Rotation.from_euler("ZYZ", turns)
    omega_body = np.column_stack(
        [
            -precession * np.sin(beta) * np.cos(gamma),
            precession * np.sin(beta) * np.sin(gamma),
            np.full(samples, precession * np.cos(beta) + spin),
        ]
    )
    return _moving(scenario, t, R_world_body, omega_body)


def _disturbed(exact: Trajectory, size: float, scenario: Scenario) -> Trajectory:
    """The exact motion, turned about a fixed axis and sped up along it, both growing with time."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    growth = size * (exact.t / exact.t[-1])[:, None]
    R_world_body = exact.R_world_body * Rotation.from_rotvec(growth * axis)
    return _moving(scenario, exact.t, R_world_body, exact.omega_body + growth * axis)


def _moving(
    scenario: Scenario, t: np.ndarray, R_world_body: Rotation, omega_body: np.ndarray
) -> Trajectory:
    com = np.array(scenario.body.com)
    return Trajectory(
        t=t,
        q_world_body_wxyz=R_world_body.as_quat(scalar_first=True),
        omega_body=omega_body,
        com_world=R_world_body.apply(com),
        velocity_world=R_world_body.apply(np.cross(omega_body, com)),
    )
