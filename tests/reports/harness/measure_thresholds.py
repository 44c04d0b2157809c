"""The smallest planted fault that a verdict detects, by kind, class of method and scene.

Written to docs/measured/thresholds.md. Engines are MuJoCo with the fault planted
(`faulty_mujoco`); sizes are tried from the smallest upwards.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from faulty_mujoco import KINDS, FaultyMuJoCo, PlantedFault, applies
from library_scenes import library_scene
from spincheck.reports.harness.prepared import Prepared, prepare
from spincheck.reports.harness.study import convergence_study_of
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS
from spincheck.scenarios import Scenario
from studies import verdict_of

#: Plain ones, and five on which errors saturate at first order.
SCENES = (
    "nutation-loops",
    "hammer",
    "chaos-beyond-the-horizon",
    "toutatis",
    "separatrix-within-1e-10",
    "passes-the-upright-1e-4",
    "gyroscope-at-24000-rpm",
)
METHODS = {"Euler": "first order", "RK4": "fourth order"}
#: Sizes tried.
SIZES = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
MOST_STEPS = QUICK_STEPS


def name_of_fault(scenario: Scenario, prepared: Prepared, method: str, fault: PlantedFault) -> str:
    """How a verdict names a fault; empty where it passes."""
    engine = FaultyMuJoCo(fault)
    study = convergence_study_of(scenario, engine, engine.method(method), prepared)
    verdict = verdict_of(study)
    if verdict.agrees and verdict.verdict != "diverges":
        return ""
    _, is_explained, words = verdict.reason.partition("as if ")
    if is_explained:
        return words.split(":")[0]
    fault = next(
        (one.fault for one in (verdict.steps, verdict.own_steps) if one and one.fault), None
    )
    return f"{fault.quantity}: {fault.kind}" if fault else verdict.reason.split(":")[0]


def threshold(scenario: Scenario, prepared: Prepared, method: str, kind: str) -> tuple[str, str]:
    """The smallest size told, and how it is named."""
    # Rounding has one size.
    for size in SIZES if kind != "float32" else (2.0**-24,):
        if words := name_of_fault(scenario, prepared, method, PlantedFault(kind, size)):
            return f"{size:.0e}", words
    return "never", ""


def rows(names: tuple[str, ...]) -> Iterator[str]:
    """A line of the table for each scene, method and kind."""
    for name in names:
        scenario = library_scene(name)
        prepared = prepare(scenario, [], MOST_STEPS)
        for method, order in METHODS.items():
            for kind in KINDS:
                if applies(PlantedFault(kind, 1.0), scenario):
                    smallest, words = threshold(scenario, prepared, method, kind)
                    print(name, order, kind, smallest, words, flush=True)
                    yield f"| {name} | {order} | {kind} | {smallest} | {words} |"


TITLE = "The smallest faults that are detected"
TEXT = f"""
The table has the smallest fault of each kind that spincheck detects, out of sizes of
{", ".join(f"{size:.0e}" for size in SIZES)}.
MuJoCo was run with the fault planted, hidden from the read-back before the first step, on
ladders of up to {MOST_STEPS} steps. Sizes are relative; of turns in rad; of a com and its drift
relative to the radius of gyration. *Named* is what the verdict says: the change of the model that
single steps show, else the quantity that shows the fault, and in which way. Made by
`make thresholds`.

| scene | method | fault | smallest detected | named |
|---|---|---|---|---|
"""


PAGE = Path(__file__).parents[3] / "docs/measured/thresholds.md"


def main() -> None:
    """Measure the scenes named, or all of `SCENES`."""
    names = tuple(sys.argv[1:]) or SCENES
    text = TEXT + "\n".join(rows(names)) + "\n"
    PAGE.write_text(f"# {TITLE}\n{text}", encoding="utf-8")


if __name__ == "__main__":
    main()
