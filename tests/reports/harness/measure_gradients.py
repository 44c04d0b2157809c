"""Derivatives of engines, on ten scenes and three that are hard to steer.

Of methods that are named as ENGINE/METHOD, or of all methods of engines, or of all engines. Their
lines of the tables in docs/how-to/gradients.md are written anew, others stay; the picture beside
them is drawn with MuJoCo. It needs matplotlib.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median

import matplotlib.pyplot as plt
import numpy as np
from library_scenes import library_scene
from scenes_of_derivatives import SCENES
from spincheck.engines import engines
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.gradients.study import OURS, GradientRow, gradients_by, gradients_of

#: The middle axis, the sleeping top at its threshold, and chaos.
STEERED = ("middle-axis-exactly", "asleep-at-the-threshold", "chaos-beyond-the-horizon")
STEERED_BY = {"mujoco": ("Euler", "RK4"), "mjx": ("RK4",)}
#: Engines with derivatives of their own, and one of those whose steps we difference.
NAMES = ("mujoco", "mjx", "brax", "newton", "drake", "pin", "exudyn")
PAGE = Path(__file__).parents[3] / "docs/how-to/gradients.md"
PICTURE = PAGE.parents[1] / "gallery/images/gradients.png"
#: What is drawn: engine, method, derivative, on a scene, with timesteps, s.
DRAWN = (
    ("mujoco", "Euler", "mjd_transitionFD, centred"),
    ("mujoco", "RK4", OURS),
    ("pybullet", "multibody", OURS),
)
DRAWN_ON, TIMESTEPS = "fast-top", 2e-3 / 2.0 ** np.arange(6)


def rows_of(executor: LocalWorkers, named: str, scenes: Sequence[str]) -> Iterator[GradientRow]:
    """Of one method, or of all clean ones of an engine that need no contact."""
    name, _, wanted = named.partition("/")
    engine = engines()[name]
    for scene in map(library_scene, scenes):
        for method in engine.methods_for(scene):
            is_plain = not method.as_shipped and "contact" not in method.name
            if method.name == wanted or (is_plain and not wanted):
                print(name, scene.name, method.name, file=sys.stderr, flush=True)
                yield from gradients_by(executor, scene, engine, method.name, None)


def table(rows: Sequence[GradientRow]) -> Iterator[str]:
    """A line for each derivative of a method, over all scenes."""
    for key in dict.fromkeys((row.engine, row.method, row.derivative) for row in rows):
        alike = [row for row in rows if (row.engine, row.method, row.derivative) == key]
        right = [row.judged for row in alike if row.judged.verdict == "converges"]
        others = {
            f"{row.judged.verdict}: {row.judged.reason}" for row in alike if row.judged.reason
        }
        orders = sorted({one.order for one in right})
        own = max((one.off_own for one in right if one.off_own is not None), default=None)
        costs = [row.cost for row in alike if row.cost is not None]
        errors = sorted(row.window[-1].error for row in alike if row.window)
        yield (
            "| "
            + " | ".join(
                [
                    *key,
                    f"{len(right)} of {len(alike)}",
                    ", ".join(map(str, orders)) or "–",
                    "–" if own is None else f"{own:.0e}",
                    f"{errors[0]:.0e} to {errors[-1]:.0e}" if errors else "–",
                    f"{median(costs):.0f}" if costs else "–",
                    "; ".join(sorted(others)) or "–",
                ]
            )
            + " |"
        )


def steered(rows: Sequence[GradientRow]) -> Iterator[str]:
    """The gradient of each derivative as time goes on."""
    for row in rows:
        if row.window:
            along = ", ".join(
                f"{one.t:.2g}: {one.error:.0e} ({one.conditioning:.0e})" for one in row.window[3::2]
            )
            yield f"| {row.engine} | {row.method} | {row.derivative} | {row.scene} | {along} |"


def picture() -> None:
    """Draw the error of the gradient against the timestep, and against the time."""
    scene = library_scene(DRAWN_ON)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5), sharey=True, layout="constrained")
    for name, method, derivative in DRAWN:
        errors: list[float] = []
        for n, h in enumerate(map(float, TIMESTEPS)):
            rows = gradients_of(scene, engines()[name], method, h)
            (window,) = [row.window for row in rows if row.derivative == derivative]
            # The same time with each timestep.
            errors.append(window[4 + n].error)
            if not n:
                times = [one.t for one in window]
                right.loglog(times, [one.error for one in window], "o-", label=f"{name} {method}")
        left.loglog(TIMESTEPS, errors, "o-", label=f"{name} {method}")
    span = 2**4 * float(TIMESTEPS[0])
    left.set(xlabel="timestep, s", ylabel="error of the gradient", title=f"after {span:.3g} s")
    right.set(xlabel="T, s", title=f"with {float(TIMESTEPS[0]):.3g} s")
    left.legend()
    figure.savefig(PICTURE, dpi=100)


def renewed(table: str, lines: Sequence[str]) -> str:
    """A table of the page with new lines instead of those of the same methods."""

    def method(line: str) -> tuple[str, ...]:
        return tuple(cell.strip() for cell in line.split("|")[1:3])

    title, rule, *old = table.splitlines()
    fresh = set(map(method, lines))
    kept = [line for line in old if method(line) not in fresh]
    ordered = sorted([*kept, *lines], key=lambda line: NAMES.index(method(line)[0]))
    return "\n".join([title, rule, *ordered]) + "\n"


def write(tables: Mapping[str, Sequence[str]]) -> None:
    """Write lines into tables of the page."""
    text = PAGE.read_text(encoding="utf-8")
    for name, lines in tables.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        old, _, after = rest.partition(end)
        text = before + begin + renewed(old, lines) + end + after
    PAGE.write_text(text, encoding="utf-8")


def main(names: Sequence[str]) -> None:
    """Measure one after the other."""
    with LocalWorkers(1, time_limit=3600.0) as executor:
        for named in names:
            found = list(rows_of(executor, named, SCENES))
            name, _, wanted = named.partition("/")
            hard = [
                row
                for scene in STEERED
                for method in STEERED_BY.get(name, ())
                if wanted in ("", method)
                for row in rows_of(executor, f"{name}/{method}", [scene])
                if row.window and (row.derivative != OURS or method == "RK4")
            ]
            write({"measured": list(table(found)), "steered": list(steered(hard))})
    if "mujoco" in names:
        picture()


if __name__ == "__main__":
    main(sys.argv[1:] or NAMES)
