"""The figures of a scene, in reading order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from ..analysis.report_data import SceneRuns
from .axis_path import axis_path
from .drawn_body import drawn_body
from .ladder_figures import convergence, work_precision
from .plot import Figure
from .polhode import polhode
from .potential import potential
from .signal_figures import defect_figure, omega_figures, tilt_figure


@dataclass(frozen=True, eq=False)
class Titled:
    """A figure with the words around it.

    Attributes
    ----------
    name : for links and tests
    title : one line above
    caption : what is drawn and what to look for
    beside : further figures, side by side with the first if there is room
    """

    name: str
    title: str
    caption: str
    figure: Figure
    beside: tuple[Figure, ...] = ()

    @property
    def parts(self) -> tuple[Figure, ...]:
        """The figure and those beside it, in reading order."""
        return (self.figure, *self.beside)


def figures(scene: SceneRuns) -> dict[Literal["signals", "ladder", "geometry"], list[Titled]]:
    """Every figure that the scene has data for, by the section of the page it stands in."""
    if scene.solved is None:
        return {"signals": [], "ladder": [], "geometry": []}
    return {
        "signals": list(_signals(scene)),
        "ladder": list(_ladder(scene)),
        "geometry": list(_geometry(scene)),
    }


def _signals(scene: SceneRuns) -> Iterator[Titled]:
    up = drawn_body(scene.exact).up_means
    yield Titled(
        "tilt",
        "β(t), and where it goes wrong",
        f"Above: the tilt of the body's axis from {up}. Below: the angle between the attitude of "
        "each run and the exact one; a dot marks where it first exceeds 1°. Grey: the "
        "reference's uncertainty, below which nothing is claimed.",
        tilt_figure(scene),
    )
    yield _titled(
        "omega",
        "ω(t)",
        "In body axes. The exact solution is the thick line.",
        omega_figures(scene),
    )
    yield Titled(
        "defect",
        "Defect: which intervals go wrong",
        "What a run does from one of its samples to the next, beside the exact motion from the "
        "same sample: the largest over all signals, in their errors' norms. What went wrong "
        "before does not count. Grey: round-off.",
        defect_figure(scene),
    )


def _ladder(scene: SceneRuns) -> Iterator[Titled]:
    rows = [row for runs in scene.methods for row in runs.rows]
    if any(row.errors for row in rows):
        yield _titled(
            "convergence",
            "Convergence: error against timestep",
            "Every run. Rings: stock timesteps. Dotted: the slopes of the declared orders of "
            "accuracy. The strip below holds the runs that have no error: × diverged, ▽ failed. "
            "Grey: the reference's uncertainty.",
            convergence(scene),
        )
    if any(row.errors and row.seconds_per_step for row in rows):
        yield _titled(
            "cost",
            "Work–precision: error against cost",
            "The same runs by what they cost: CPU seconds of native stepping a simulated second. "
            "Further down and further left is better; compare methods along a horizontal line. "
            "Rings: stock timesteps. Light steps: the Pareto front, the runs more accurate than "
            "all cheaper ones.",
            work_precision(scene),
        )


def _geometry(scene: SceneRuns) -> Iterator[Titled]:
    if not scene.exact.scenario.constraint.is_free:
        yield _titled(
            "axis",
            "Path of the axis",
            "Where the body's axis points, as a path on the unit sphere (to be turned), from "
            "above, and unrolled into azimuth and tilt, where nutation shows as waves, cusps or "
            "loops. A dot marks the start. Framed on the exact path; a double click shows all.",
            axis_path(scene),
        )
    traced = polhode(scene)
    if traced:
        yield _titled(
            "polhode",
            "Polhode and herpolhode",
            "Left: the tip of ω in the body's principal axes, on Poinsot's ellipsoid of the "
            "largest rotational energy. Right: the same tip in space, seen along the initial "
            "angular momentum. Of a free body the polhode is closed; a run that leaves it has the "
            "wrong energy or angular momentum. A dot marks the start.",
            traced,
        )
    well = potential(scene.exact.scenario)
    if well is not None:
        yield Titled(
            "potential",
            "Effective potential",
            "What is left of the motion once p_α and p_γ are constant: the tilt β moves in the "
            "well V_eff at the height E′ = E − p_γ²/2 I₃, between the two turning points.",
            well,
        )


def _titled(name: str, title: str, caption: str, parts: Sequence[Figure]) -> Titled:
    first, *others = parts
    return Titled(name, title, caption, first, tuple(others))
