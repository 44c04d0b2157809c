"""Writes the errors of docs/explanation/sensitivities.md: free, heavy and table scenes."""

from pathlib import Path
from time import process_time

import numpy as np
from differenced import derivatives
from spincheck.reference import ExactMotion, IntegrationError, Sensitivity, sensitivity
from spincheck.scenarios import LIBRARY, Scenario, find, load
from spincheck.scenarios.fastest_rate import fastest_rate

FOLDERS = ("free", "heavy", "table")
PAGE = Path(__file__).parents[2] / "docs/explanation/sensitivities.md"
#: Names of figures, and how the page says them.
FIGURES = {
    "uncertainty": "uncertainty that is stated, over the largest value of the array",
    "from differences": "distance from differences in 40 digits, likewise",
    "conditioning": "conditioning",
    "seconds": "CPU time, s",
}
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


def lines_of(rows: dict[str, dict[str, float]]) -> list[str]:
    """The largest of each figure, and on which scene."""
    lines = ["| largest | | on |", "|---|---|---|"]
    for figure, words in FIGURES.items():
        worst = max(rows, key=lambda name: rows[name][figure])
        lines.append(f"| {words} | {rows[worst][figure]:.1e} | {worst} |")
    return lines


def main() -> None:
    """Measure the scenes of all folders, and write the table of the page."""
    rows, refused = {}, []
    for path in find([str(LIBRARY / folder) for folder in FOLDERS]):
        try:
            rows[path.stem] = measured(load(path))
        except IntegrationError as error:
            refused.append(f"Refused is `{path.stem}`: {error}.")
            continue
        print(path.stem, *(f"{name} {x:.1e}" for name, x in rows[path.stem].items()), flush=True)
    begin, end = "<!-- measured -->\n", "<!-- end of measured -->"
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    _, _, after = rest.partition(end)
    count = f"{len(rows)} scenes."
    table = "\n".join([*lines_of(rows), "", " ".join([count, *refused])]) + "\n"
    PAGE.write_text(before + begin + table + end + after, encoding="utf-8")


if __name__ == "__main__":
    main()
