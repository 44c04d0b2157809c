"""Measures how often the intervals of a measured motion's fit hold what they should.

``python tests/reports/harness/recorded/measure_logs.py [N [FIRST]]`` simulates N logs of bodies of
four kinds, every second one with a gyroscope's bias, judges each by a scene whose tensor and start
are a guess, and prints the table of docs/explanation/recordings.md.
"""

import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from planted_motions import Case, exactly, rates_of
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.fits.measured import Measured
from spincheck.reports.harness.recorded.judged import judged_motion
from spincheck.reports.harness.recorded.samples.sensors import SENSORS
from spincheck.scenarios import Scenario, from_tables

SAMPLES, DURATION = 121, 6.0
#: Of the guess: each entry of the tensor relative to the mean moment, rad, and rad/s.
OFF = 0.05, 0.02, 0.02
ALL = "all"
HEADINGS = (
    *("body", "entries of tensors", "within 1.96 errors", "furthest, in errors"),
    *("of biases", "within", "furthest", "named wrongly"),
)
KINDS = ("of any shape", "two moments 1 % apart", "moments within 3 %", "about a principal axis")
#: Of a normal distribution, between minus and plus so many standard errors is 95 %.
NORMAL_95 = 1.96
#: Standard errors, of a log that is printed.
FAR = 4.0
AT = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)


def moments_of(kind: str, chance: np.random.Generator) -> np.ndarray:
    """Moments of a body, kg m²."""
    sides = chance.uniform(0.3, 1.5, 3) ** 2
    if kind == KINDS[1]:
        sides[1] = 1.01 * sides[0]
    if kind == KINDS[2]:
        sides = sides.mean() * (1 + chance.uniform(-0.03, 0.03, 3))
    return chance.permutation(sides.sum() - sides)


def scene_of(tensor: np.ndarray, q: Rotation, omega: np.ndarray) -> Scenario:
    """A body that turns freely."""
    tables = {
        "title": "A log",
        "source": "made up",
        "body": {"mass": 1.5, "inertia": ((tensor + tensor.T) / 2).tolist()},
        "start": {
            "quaternion_wxyz": q.as_quat(scalar_first=True).tolist(),
            "omega_body": omega.tolist(),
        },
        "window": {"duration": DURATION, "samples": SAMPLES},
    }
    return from_tables(tables, "log")


def guess(tensor: np.ndarray, chance: np.random.Generator) -> np.ndarray:
    """A tensor near another, of a body that can be."""
    while True:
        off = np.triu(chance.normal(0, OFF[0] * np.trace(tensor) / 3, (3, 3)))
        tried = tensor + off + np.triu(off, 1).T
        smallest, middle, largest = np.linalg.eigvalsh(tried)
        if smallest > 0 and largest < smallest + middle:
            return tried


def measured(k: int) -> tuple[str, Measured | None, np.ndarray, np.ndarray]:
    """Log k: its kind, its fit, and the entries, kg m², and bias, rad/s, that it should find."""
    kind, chance = KINDS[k % 4], np.random.default_rng(k)
    axes, q = Rotation.random(random_state=chance), Rotation.random(random_state=chance)
    tensor = axes.as_matrix() * moments_of(kind, chance) @ axes.as_matrix().T
    omega = chance.normal(size=3)
    if kind == KINDS[3]:
        omega = axes.as_matrix()[:, 0] + chance.normal(0, np.radians(1), 3)
    omega *= chance.uniform(1.5, 4.0) / np.linalg.norm(omega)
    one = Case(scene_of(tensor, q, omega), tensor, np.zeros(3), np.zeros(3))
    arrays = exactly(one, rates_of(one))
    attitude, rate = 10.0 ** chance.uniform(-3.5, -2.3), 10.0 ** chance.uniform(-3.5, -2)
    noise = Rotation.from_rotvec(chance.normal(0, attitude, (SAMPLES, 3)))
    bias = chance.normal(0, 0.05, 3) * (k // 4 % 2)
    arrays["q"] = (Rotation.from_quat(arrays["q"], scalar_first=True) * noise).as_quat(
        scalar_first=True
    )
    arrays["omega"] = arrays["omega"] + bias + chance.normal(0, rate, (SAMPLES, 3))
    turned = q * Rotation.from_rotvec(chance.normal(0, OFF[1], 3))
    scene = scene_of(guess(tensor, chance), turned, omega + chance.normal(0, OFF[2], 3))
    fit = judged_motion(scene, Recording(Path("log.csv"), arrays, {})).measured
    # A free body's is found up to a factor.
    return kind, fit, tensor[AT] * np.trace(scene.inertia) / np.trace(tensor), bias


def cells(deviations: list[np.ndarray]) -> str:
    """How many numbers there are, how many of them are where they should be, and the worst."""
    if not deviations:
        return "0 | – | –"
    z = np.abs(np.concatenate(deviations))
    return f"{len(z)} | {100 * np.mean(z < NORMAL_95):.1f} % | {z.max():.1f}"


def deviations(k: int) -> tuple[str, dict[str, np.ndarray], bool]:
    """Log k's kind, what is off in standard errors, and whether what is named is wrong."""
    kind, fit, tensor, bias = measured(k)
    if fit is None:
        raise ValueError(f"log {k} is not seen as measured")
    entries, errors = fit.tensor_entries()
    z, found, names = {"tensor": (entries - tensor) / errors}, fit.fit, []
    for change in found.changes:
        others = fit.alternatives(change) if change in SENSORS else []
        names.append(" or ".join([change.kind, *(other.kind for _, other, _ in others)]))
        # What is named as well is not named wrongly.
        found = next((instead for _, other, instead in others if other.kind == "bias"), found)
    for change in found.changes:
        if change.kind == "bias":
            rows = found.columns(change)
            z["bias"] = (found.parameters[rows] - bias) / found.errors[rows]
    is_right = {"start", "tensor, up to a factor", *(["bias"] if bias.any() else [])}
    is_wrong = not is_right.issuperset(one.kind for one in found.changes)
    if is_wrong or np.abs(z["tensor"]).max() > FAR:
        print(k, kind, names, np.round(z["tensor"], 1), fit.verdict)
    return kind, z, is_wrong


def main(count: int, first: int) -> None:
    """Print a row for each kind, and one of all, after every fifty logs."""
    z: dict[tuple[str, str], list[np.ndarray]] = defaultdict(list)
    wrongly: Counter[str] = Counter()
    for done in range(1, count + 1):
        kind, off, is_wrong = deviations(first + done - 1)
        for row in (kind, ALL):
            wrongly[row] += is_wrong
            for of, numbers in off.items():
                z[row, of].append(numbers)
        if done % 50 and done < count:
            continue
        print(f"{done} logs from {first} on:")
        print(f"| {' | '.join(HEADINGS)} |")
        for row in (*KINDS, ALL):
            of_tensor, of_bias = cells(z[row, "tensor"]), cells(z[row, "bias"])
            print(f"| {row} | {of_tensor} | {of_bias} | {wrongly[row]} |", flush=True)


if __name__ == "__main__":
    main(*map(int, [*sys.argv[1:], *["1000", "0"][len(sys.argv) - 1 :]]))
