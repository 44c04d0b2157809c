"""A result file with something in each of its tables, made without a run."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import made_up
import made_up_ensembles
from spincheck.reports.results.cost_records import MethodCost, Ratio, StepCost
from spincheck.reports.results.ensemble_records import DefinedEnsemble
from spincheck.reports.results.provenance_records import Fingerprint
from spincheck.reports.results.records import Key, variation
from spincheck.reports.results.store import open_store

SCENE = "made-up-top"
#: Samples of every motion.
SAMPLES = 5
SWEPT = "disc"
KEY = Key(SCENE, "mujoco", "Euler")
WHOLE = MethodCost(
    KEY,
    "a processor",
    StepCost(1.2e-6, 1e-7, 1.2e-6, ratio=Ratio(1.2, 0.02)),
    variation({"left_in": ["contact"]}),
    difference=0.0,
    compared_until=1.0,
)
MEMBERS = 2
#: With a fault, so that there is something in each field.
EVIDENCE = made_up.evidence(KEY, made_up.METHODS[2])


def write(path: Path) -> Path:
    """Begin the file and fill it."""
    stored = made_up.results(SAMPLES, made_up.METHODS[:1])
    with open_store(path, create=True) as store:
        store.put_environment(stored.environment)
        methods = tuple(stored.methods.values())
        store.put_methods(
            [
                SimpleNamespace(
                    name="mujoco", methods=methods, stock_timestep=0.002, single_precision=False
                )
            ]
        )
        store.rest_on(
            [
                Fingerprint(SCENE, "mujoco" * (kind == "engine"), kind, f"a digest of {kind}")
                for kind in ("motion", "run", "timing", "verdict", "engine")
            ]
        )
        result = stored.scenes[SCENE]
        store.put_scene(result.scenario, result.solution)
        rows = [row for row in stored.rows if row.key == KEY]
        for row in rows[-2:]:
            store.put(row)
        for verdict in stored.verdicts:
            if verdict.key == KEY:
                store.put_verdict(replace(verdict, steps=EVIDENCE.steps, own_steps=EVIDENCE.steps))
        # What has something in each field comes first: it is what is forged.
        store.put(WHOLE, MethodCost(KEY, "a processor", StepCost(1e-6, 1e-7, 1e-6)))
        store.put(EVIDENCE)
        of_default = replace(rows[0], variation=variation({"defaults": ["damping"]}), motion=None)
        store.put(of_default)
        _put_ensemble(store)
    return path


def _put_ensemble(store) -> None:
    made_up = made_up_ensembles.ensemble_result(MEMBERS)
    store.put(DefinedEnsemble(SWEPT, made_up.ensemble, made_up.scenario.text))
    store.put(*made_up.points)
