"""Derivatives of engines, on ten scenes and three that are hard to steer.

Of methods that are named as ENGINE/METHOD, or of all methods of engines, or of all engines. Their
lines of the tables in docs/measured/gradients.md are written anew, others stay; the pictures beside
them are drawn with MuJoCo. It needs matplotlib.
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from library_scenes import library_scene
from scenes_of_derivatives import SCENES
from spincheck.engines import engines
from spincheck.reports.cli.engines.gradients import median_and_quartiles, useless
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.gradients.compared import OURS, TAPED, THROUGH, GradientRow
from spincheck.reports.harness.gradients.study import gradient_by, gradients_of, offered_by

#: The middle axis, the sleeping top at its threshold, and chaos.
STEERED = ("middle-axis-exactly", "asleep-at-the-threshold", "chaos-beyond-the-horizon")
STEERED_BY = {"mujoco": ("Euler", "RK4"), "mjx": ("RK4",)}
#: Engines with derivatives of their own, and one of those whose steps we difference.
NAMES = ("mujoco", "mjx", "brax", "newton", "drake", "pin", "exudyn")
PAGE = Path(__file__).parents[3] / "docs/measured/gradients.md"
PICTURE = PAGE.parents[1] / "gallery/images/gradients.png"
#: What is drawn: engine, method, derivative, on a scene, with timesteps, s.
DRAWN = (
    ("mujoco", "Euler", "mjd_transitionFD, centred"),
    ("mujoco", "RK4", OURS),
    ("pybullet", "multibody", OURS),
)
DRAWN_ON, TIMESTEPS = "fast-top", 2e-3 / 2.0 ** np.arange(6)


def rows_of(
    executor: LocalWorkers, named: str, scenes: Sequence[str], whole: bool = False
) -> Iterator[GradientRow]:
    """Of one method, or of all clean ones of an engine that need no contact.

    Windows are of the usual number of steps, or the whole ones of the scenes, which would take
    engines hours whose derivative of a step costs milliseconds.
    """
    name, _, wanted = named.partition("/")
    engine = engines()[name]
    for scene in map(library_scene, scenes):
        for method in engine.methods_for(scene):
            is_plain = not method.as_shipped and "contact" not in method.name
            if method.name == wanted or (is_plain and not wanted):
                of = executor, scene, engine, method.name
                for derivative in offered_by(*of):
                    print(scene.name, name, method.name, derivative, file=sys.stderr, flush=True)
                    window = scene.window.duration if whole else None
                    yield gradient_by(*of, derivative, None, window)


def table(rows: Sequence[GradientRow]) -> Iterator[str]:
    """A line for each derivative of a method, over all scenes."""
    for key in dict.fromkeys((row.engine, row.method, row.derivative) for row in rows):
        alike = [row for row in rows if (row.engine, row.method, row.derivative) == key]
        right = [
            row.judged
            for row in alike
            if row.judged.verdict == "converges" and row.judged.is_own is not False
        ]
        others = {
            f"{row.judged.verdict}: {row.judged.reason}" for row in alike if row.judged.reason
        }
        orders = sorted({one.order for one in right})
        own = max((one.off_own for one in right if one.off_own is not None), default=None)
        costs = [cost for row in alike for cost in row.costs]
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
                    median_and_quartiles(costs) or "–",
                    "; ".join(sorted(others)) or "–",
                ]
            )
            + " |"
        )


def steered(rows: Sequence[GradientRow]) -> Iterator[str]:
    """The gradient of each derivative as time goes on, and from when on it is as wrong as none."""
    for row in rows:
        along = [
            f"{one.t:.2g}: {one.error:.0e} ({one.conditioning:.0e})"
            for one in [*row.window[3:-1:2], row.window[-1]]
        ]
        cells = row.engine, row.method, row.derivative, row.scene, useless(row) or "–"
        yield "| " + " | ".join([*cells, ", ".join(along)]) + " |"


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


def picture_of_steered() -> None:
    """Draw the error of the gradient and the conditioning of the scenes that are hard to steer."""
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.5), sharey=True, layout="constrained")
    for ax, scene in zip(axes, map(library_scene, STEERED), strict=True):
        for method, derivative in (("Euler", DRAWN[0][2]), ("RK4", OURS)):
            of = scene, engines()["mujoco"], method, None, scene.window.duration, derivative
            ((window),) = [row.window for row in gradients_of(*of)]
            times = [one.t for one in window]
            ax.loglog(times, [one.error for one in window], "o-", label=f"error, mujoco {method}")
        ax.loglog(times, [one.conditioning for one in window], "k:", label="conditioning")
        ax.axhline(1.0, color="0.7", label="as wrong as none")
        ax.set(xlabel="T, s", title=scene.name)
    axes[0].legend(fontsize="small")
    figure.savefig(PICTURE.with_stem("gradients-steered"), dpi=100)


def summary(lines: Sequence[str]) -> Iterator[str]:
    """A line for each engine, from the lines of its methods.

    Of differences by spincheck it has only what they are alone with.
    """
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    for engine in dict.fromkeys(row[0] for row in cells):
        own = [row for row in cells if row[0] == engine and row[2] != OURS]
        rows = own or [row for row in cells if row[0] == engine]
        derivatives = dict.fromkeys(row[2].removesuffix(THROUGH) for row in rows)
        right: dict[str, list[str]] = {}
        for method in dict.fromkeys(row[1] for row in rows):
            shares = [row[3] for row in rows if row[1] == method]
            right.setdefault(min(shares, key=lambda share: int(share.split()[0])), []).append(
                method
            )
        single = [row for row in rows if not row[2].endswith(THROUGH)]
        off = max((row[5] for row in single if row[5] != "–"), key=float, default="–")
        # A method's own name is left out, so that methods say the same.
        words = [row[8].replace(f"{engine} {row[1]} ", "") for row in rows if row[8] != "–"]
        told = dict.fromkeys(one for said in words for one in said.split("; "))
        line = [
            engine,
            "; ".join(derivatives),
            "; ".join(f"{', '.join(methods)}: {share}" for share, methods in right.items()),
            off,
            extent([row[7] for row in single]),
            "; ".join(told) or "–",
        ]
        yield "| " + " | ".join(line) + " |"


def extent(costs: Sequence[str]) -> str:
    """The least and the largest of medians, which quartiles follow."""
    medians = [cost.split()[0] for cost in costs if cost != "–"]
    ends = dict.fromkeys(f(medians, key=float) for f in (min, max)) if medians else ["–"]
    return " to ".join(ends)


def renewed(old: Sequence[str], lines: Sequence[str]) -> list[str]:
    """Lines of a table, new ones instead of those of the same methods."""

    def method(line: str) -> tuple[str, ...]:
        return tuple(cell.strip() for cell in line.split("|")[1:3])

    fresh = set(map(method, lines))
    kept = [line for line in old if method(line) not in fresh]
    return sorted([*kept, *lines], key=lambda line: NAMES.index(method(line)[0]))


def write(tables: Mapping[str, Sequence[str]]) -> None:
    """Write lines into tables of the page, and the summary of the first of them."""
    text = PAGE.read_text(encoding="utf-8")
    for name, lines in tables.items():
        text = with_table(text, name, lambda old, lines=lines: renewed(old, lines))
    (measured, _) = table_of(text, "measured")
    text = with_table(text, "summary", lambda _: summary(measured[2:]))
    PAGE.write_text(text, encoding="utf-8")


def with_table(text: str, name: str, change: Callable[[list[str]], Iterable[str]]) -> str:
    """The page with other lines of a table, below its headings."""
    found, (begin, end) = table_of(text, name)
    return text[:begin] + "\n".join([*found[:2], *change(found[2:])]) + "\n" + text[end:]


def table_of(text: str, name: str) -> tuple[list[str], tuple[int, int]]:
    """A table of the page between its marks, by lines, and where it begins and ends."""
    begin = text.index(f"<!-- {name} -->\n") + len(f"<!-- {name} -->\n")
    end = text.index(f"<!-- end of {name} -->")
    return text[begin:end].splitlines(), (begin, end)


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
                for row in rows_of(executor, f"{name}/{method}", [scene], whole=name == "mujoco")
                if len(row.window) > len(TAPED)
                if row.derivative != OURS or (name == "mujoco" and method == "RK4")
            ]
            write({"measured": list(table(found)), "steered": list(steered(hard))})
    if "mujoco" in names:
        picture()
        picture_of_steered()


if __name__ == "__main__":
    main(sys.argv[1:] or NAMES)
