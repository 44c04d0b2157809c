"""Derivatives of every engine that is installed, on ten scenes and three that are hard to steer.

Written to docs/how-to/gradients.md, between its marks, with a picture of gradients on a heavy top.
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

import matplotlib.pyplot as plt
from library_scenes import library_scene
from scenes_of_derivatives import SCENES
from spincheck.engines import engines
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.gradients.study import OURS, GradientRow, gradients_by

#: The middle axis, the sleeping top at its threshold, and chaos.
STEERED = ("middle-axis-exactly", "asleep-at-the-threshold", "chaos-beyond-the-horizon")
STEERED_BY = {"mujoco": ("Euler", "RK4"), "mjx": ("RK4",)}
#: Engines with derivatives of their own, and one of those whose steps we difference.
NAMES = ("mujoco", "mjx", "drake", "pin", "exudyn")
DOCS = Path(__file__).parents[3] / "docs"
PAGE, PICTURE = DOCS / "how-to/gradients.md", DOCS / "gallery/images/gradients.png"
#: What the picture is of: a scene, timesteps, s, and derivatives, which each method has one of.
DRAWN, TIMESTEPS = "fast-top", (4e-3, 2e-3, 1e-3, 5e-4)
DRAWN_BY = {
    ("mujoco", "Euler"): "mjd_transitionFD, centred",
    ("mujoco", "RK4"): OURS,
    ("drake", "discrete"): "AutoDiff of the discrete update",
}
#: Steps with the longest timestep, after which timesteps are compared.
COMPARED = 64


def rows_of(executor: LocalWorkers, name: str, scenes: Sequence[str]) -> Iterator[GradientRow]:
    """Of all clean methods of an engine that need no contact."""
    engine = engines()[name]
    for scene in map(library_scene, scenes):
        for method in engine.methods_for(scene):
            if not method.as_shipped and "contact" not in method.name:
                print(name, scene.name, method.name, file=sys.stderr, flush=True)
                yield from gradients_by(executor, scene, engine, method.name, None)


def table(rows: Sequence[GradientRow]) -> Iterator[str]:
    """A line for each derivative of a method, over all scenes."""
    yield (
        "| engine | method | derivative | converges, of scenes | order | off its own step "
        "| cost, steps | gradient's error | refused |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    for key in dict.fromkeys((row.engine, row.method, row.derivative) for row in rows):
        alike = [row for row in rows if (row.engine, row.method, row.derivative) == key]
        right = [row for row in alike if row.judged.verdict == "converges"]
        refused = {row.judged.reason for row in alike if row.judged.verdict != "converges"}
        orders = sorted({row.judged.order for row in right})
        own = max(
            (row.judged.off_own for row in right if row.judged.off_own is not None), default=None
        )
        costs = [row.cost for row in alike if row.cost is not None]
        errors = sorted(row.window[-1].error for row in right if row.window)
        yield (
            "| "
            + " | ".join(
                [
                    *key,
                    f"{len(right)} of {len(alike)}",
                    ", ".join(map(str, orders)) or "–",
                    "–" if own is None else f"{own:.0e}",
                    f"{median(costs):.0f}" if costs else "–",
                    f"{errors[0]:.0e} to {errors[-1]:.0e}" if errors else "–",
                    "; ".join(sorted(refused)) or "–",
                ]
            )
            + " |"
        )


def steered(rows: Sequence[GradientRow]) -> Iterator[str]:
    """The gradient of each derivative as time goes on."""
    yield "| scene | method, derivative | " + "time, s: error (conditioning) |"
    yield "|---|---|---|"
    for row in rows:
        if row.window:
            along = ", ".join(
                f"{one.t:.2g}: {one.error:.0e} ({one.conditioning:.0e})" for one in row.window[3::2]
            )
            yield f"| {row.scene} | {row.engine} {row.method}, {row.derivative} | {along} |"


def drawn(executor: LocalWorkers) -> Iterator[tuple[float, GradientRow]]:
    """Rows of the picture, by the timestep of their windows."""
    for (name, method), derivative in DRAWN_BY.items():
        for h in TIMESTEPS:
            rows = gradients_by(executor, library_scene(DRAWN), engines()[name], method, h)
            yield from ((h, row) for row in rows if row.derivative == derivative)


def picture(rows: Sequence[tuple[float, GradientRow]]) -> None:
    """Draw the error of gradients against the timestep, and against the time of the window."""
    figure, (by_timestep, by_time) = plt.subplots(
        1, 2, figsize=(9, 4), sharey=True, layout="constrained"
    )
    end = COMPARED * TIMESTEPS[0]
    for name, method in DRAWN_BY:
        alike = [one for one in rows if (one[1].engine, one[1].method) == (name, method)]
        label = f"{name} {method}, {DRAWN_BY[name, method]}"
        at_end = {
            h: along.error for h, row in alike for along in row.window if abs(along.t - end) < h / 2
        }
        by_timestep.loglog(at_end.keys(), at_end.values(), "o-")
        (window,) = (row.window for h, row in alike if h == TIMESTEPS[2])
        by_time.loglog([one.t for one in window], [one.error for one in window], "o-", label=label)
    by_timestep.set(
        xlabel=f"timestep, s, at T = {end:.2g} s", ylabel="error of the gradient, relative"
    )
    by_timestep.set_xticks(TIMESTEPS, [f"{h:g}" for h in TIMESTEPS])
    by_timestep.minorticks_off()
    by_time.set(xlabel=f"T, s, with a timestep of {TIMESTEPS[2]:g} s")
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    figure.savefig(PICTURE, dpi=150)


def main() -> None:
    """Write the tables into the page."""
    with LocalWorkers(1, time_limit=600.0) as executor:
        found = [row for name in NAMES for row in rows_of(executor, name, SCENES)]
        hard = [
            row
            for name, methods in STEERED_BY.items()
            for scene in STEERED
            for method in methods
            for row in gradients_by(executor, library_scene(scene), engines()[name], method, None)
            if row.window and (row.derivative != OURS or method == "RK4")
        ]
        picture(list(drawn(executor)))
    text = PAGE.read_text(encoding="utf-8")
    for name, lines in {"measured": table(found), "steered": steered(hard)}.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        text = before + begin + "\n".join(lines) + "\n" + end + rest.partition(end)[2]
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
