"""An ensemble without a run: points whose errors and ends are known."""

from dataclasses import replace

from spincheck.engines import Method
from spincheck.reports.results.ensemble_records import Ensemble, EnsembleResult
from spincheck.reports.results.records import Key, Row, variation
from spincheck.reports.results.results import Results
from spincheck.scenarios import EFFECTS, Errors, Scenario, loads

MISCHIEF = "<script>alert('x')</script>"
ALL = frozenset(EFFECTS)
METHODS = {
    ("mujoco", "Euler"): Method("Euler", 1, 1, "one", ALL),
    ("mujoco", "RK4"): Method("RK4", 4, 4, "four", ALL),
    ("pybullet", "multibody"): Method(
        "multibody", 1, 1, "clamps", ALL, max_rotation_per_step=3.141592653589793 / 4
    ),
}
#: I1 = 2, I3 = 1 kg m² about the pivot, M g l = 10 N m: sleeps from √80 = 8.94 rad/s on.
UPRIGHT = f"""spincheck = 1
title = "A top {MISCHIEF}"
source = "no book"
[body]
mass = 2.0
inertia = [2.0, 2.0, 1.0]
inertia_about = "origin"
com = [0.0, 0.0, 0.5]
[start]
euler_zyz_deg = [0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, 20.0]
[effects.gravity]
acceleration = [0.0, 0.0, -10.0]
[effects.pivot]
[window]
duration = 1.0
samples = 11
"""
#: Free, its rate half of its spin.
DISC = """spincheck = 1
title = "A disc"
source = "no book"
[body]
mass = 1.0
inertia = [2.0, 2.0, 3.0]
[start]
euler_zyz_deg = [0.0, 0.0, 0.0]
omega_body = [0.1, 0.0, 2.0]
[window]
duration = 10.0
samples = 11
"""
#: Of the reference, in ω; the finest runs of RK4 are better.
UNCERTAINTY = 1e-11
#: Of every motion.
TURNS = 12.0


def scene(text: str = DISC, name: str = "disc") -> Scenario:
    return loads(text, name)


def ensemble_result(members: int = 10, name: str = "disc") -> EnsembleResult:
    """Member k is off by k + 1 hundredths with Euler, RK4 by a millionth of that.

    Of PyBullet every second member diverges, the later the earlier.
    """
    base = scene(DISC, name)
    points = []
    for k in range(members):
        for pair in METHODS:
            key = Key(name, *pair)
            varied = {"variation": variation({"member": k, "seed": 7, "timestep": 0.01})}
            if pair[0] == "pybullet" and k % 2:
                ended = ("diverged", f"blew up {MISCHIEF}", "not-finite", 10.0 - k)
                points.append(Row(key, "", 0.01, *ended, turns=k / 10, **varied))
                continue
            error = (k + 1) / 100 * (1e-6 if pair[1] == "RK4" else 1.0)
            errors = Errors(*(k * error for k in range(1, 7)))
            kept = {"errors": errors, "reference_uncertainty": UNCERTAINTY, "steps": 1000}
            within = TURNS / (k + 1) if pair == ("mujoco", "Euler") else None
            kept |= {"turns": TURNS, "turns_within_1deg": within, "attitude_a_turn": error / TURNS}
            points.append(Row(key, "", 0.01, "ok", **kept, **varied))
    return EnsembleResult(Ensemble(name, members, 7, 0.01), base, tuple(points))


def at_stock() -> Results:
    """The ensemble at stock timesteps, its Euler as shipped."""
    ensemble = ensemble_result()
    ensembles = [replace(ensemble, ensemble=replace(ensemble.ensemble, timestep=None))]
    shipped = replace(METHODS["mujoco", "Euler"], as_shipped=True)
    methods = METHODS | {("mujoco", "Euler"): shipped}
    environment = {"processor": "a fast one"}
    return Results(environment, {}, [], [], methods=methods, ensembles=ensembles)
