"""The report's sections on the cost of accuracy: on the first page, and on each scene's."""

from dataclasses import dataclass

from ...scenarios import SIGNALS
from .analysis.profiles import profile
from .analysis.report_data import ReportData, SceneRuns
from .analysis.trace_style import TraceStyle, trace_styles
from .analysis.work_precision import curves
from .cost_tables import median_table, ratio_table, reach_table, reached_table
from .figures.figures import Titled
from .figures.profile_figure import profile_figures
from .tables import Table

#: The error by which methods are compared over all scenes; every scene's page has all.
COMPARED = "omega"
#: Errors with a profile each: for everyday use, and beyond what first-order methods reach.
PROFILED = (1e-3, 1e-6)
#: Explanation of the costs in the tables.
LEGEND = (
    "CPU seconds of native stepping that one simulated second takes. No mark: interpolated "
    "between two runs. ≤: the ladder's coarsest run is within it already. ≈: extrapolated below "
    "the finest run by the order found, where rounding leaves room. A word: why it is out of reach."
)


@dataclass(frozen=True, eq=False)
class CostSection:
    """The first page's section.

    Attributes
    ----------
    scenes : how many were solved, reached or not
    methods : label and style of every method, for the figure's key
    profiles : None where nothing was timed
    """

    scenes: int
    methods: tuple[tuple[str, TraceStyle], ...]
    profiles: Titled | None
    reached: Table
    medians: Table
    ratios: Table


def cost_section(gathered: ReportData) -> CostSection:
    """The cost of accuracy, over all scenes that were solved."""
    scenes = [curves(scene, COMPARED) for scene in gathered.scenes if scene.solved]
    drawn = trace_styles(gathered.pairs)
    timed = any(curve.seconds_per_step is not None for tried in scenes for curve in tried)
    profiles = [profile(scenes, COMPARED, level) for level in PROFILED]
    first, *others = profile_figures(profiles, drawn)
    titled = Titled(
        "profiles",
        "Performance profiles",
        "Fraction of scenes on which a method stays within the error at no more than τ times the "
        "cost of the cheapest method there (Dolan & Moré 2002). Higher is better; the right end "
        "is the fraction within reach at all. Extrapolated costs count; at τ near 1, methods "
        "closer than the spread of the timings change places by chance.",
        first,
        tuple(others),
    )
    return CostSection(
        len(scenes),
        tuple((" ".join(pair), style) for pair, style in drawn.items()),
        titled if timed else None,
        reached_table(gathered, scenes),
        median_table(gathered, scenes),
        ratio_table(scenes),
    )


def scene_costs(scene: SceneRuns) -> list[tuple[str, Table]]:
    """A table for the errors of each signal, with its name."""
    return [(str(signal), reach_table(scene, signal.name)) for signal in SIGNALS]
