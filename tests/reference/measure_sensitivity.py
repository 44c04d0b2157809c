"""Prints the errors of docs/explanation/sensitivities.md, over scenes of the library.

PYTHONPATH=tests/support python tests/reference/measure_sensitivity.py [FOLDER]…
"""

import sys
from time import process_time

import numpy as np
from differenced import derivatives
from spincheck.reference import ExactMotion, IntegrationError, Sensitivity, sensitivity
from spincheck.scenarios import LIBRARY, Scenario, find, load
from spincheck.scenarios.fastest_rate import fastest_rate

FOLDERS = ("free", "heavy", "table")
#: rad, turned at most until derivatives are compared with differences, which take long.
TURN = 2.0
#: Samples over a window, for the uncertainty that is stated.
SAMPLES = 9


def from_differences(scenario: Scenario) -> float:
    """The largest distance of an array from differences along a direction, relative."""
    rate = fastest_rate(scenario, scenario.start.omega_body) or 1.0
    times = [min(TURN / rate, scenario.window.duration)]
    found = sensitivity(scenario, ExactMotion(scenario).outline(np.array(times)))
    return max(apart(scenario, found, name, times, rate) for name in found.uncertainty)


def apart(
    scenario: Scenario, found: Sensitivity, name: str, times: list[float], rate: float
) -> float:
    """That of one array; moments are sums of columns of the inertia."""
    if name == "moments":
        return 0.0
    array = getattr(found, name).reshape(1, 6, -1)[0]
    direction = np.random.default_rng(1).choice([-1.0, 1.0], array.shape[-1])
    if name == "state_transition":
        direction *= np.repeat([1.0, rate], 3)
    if name == "spins":
        direction *= [rotor.hinge != "locked" for rotor in scenario.rotors.each]
    right = derivatives(scenario, name, direction, times, 2 * max(rate, found.rate))[0, :6]
    unit = np.repeat([1.0, found.rate], 3)
    size = np.abs(right / unit).max()
    return float(np.abs((array @ direction - right) / unit).max() / size) if size else 0.0


def measured(scenario: Scenario) -> dict[str, float]:
    """Figures of a scene."""
    duration = scenario.window.duration
    motion = ExactMotion(scenario).solve(np.linspace(0.0, duration, SAMPLES)).trajectory
    begun = process_time()
    found = sensitivity(scenario, motion)
    return {
        "seconds": process_time() - begun,
        "conditioning": float(found.conditioning.max()),
        "uncertainty": max(found.uncertainty.values()),
        "from differences": from_differences(scenario),
    }


if __name__ == "__main__":
    rows = {}
    for path in find([str(LIBRARY / folder) for folder in sys.argv[1:] or FOLDERS]):
        try:
            rows[path.stem] = measured(load(path))
        except IntegrationError as error:
            print(f"{path.stem}: {error}")
            continue
        print(path.stem, *(f"{name} {x:.1e}" for name, x in rows[path.stem].items()), flush=True)
    for name in ("seconds", "conditioning", "uncertainty", "from differences"):
        worst = max(rows, key=lambda scene: rows[scene][name])
        print(f"largest {name}: {rows[worst][name]:.1e}, {worst}")
