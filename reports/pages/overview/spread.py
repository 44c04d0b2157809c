"""How errors at stock timesteps are distributed over starts and bodies: a curve an engine."""

from dataclasses import dataclass

from ....scenarios import SIGNAL
from ...results.store import Results
from ...results.sweep_records import EnsembleResult
from ..analysis.ensemble_numbers import QUANTILES, Members, members_of
from ..analysis.trace_style import TraceStyle, trace_styles
from ..analysis.wording import count, duration, readable
from ..figures.ensemble_figure import LOW, distribution
from ..figures.figures import Titled
from ..links import ensemble_page
from ..sweeps.sweep_pages import methods_of, numbered
from ..tables import Cell, Table, figure, table

SHOWN = SIGNAL["attitude"]


@dataclass(frozen=True, eq=False)
class Spread:
    """The largest ensemble at stock timesteps: of each engine its default, and its best method.

    Attributes
    ----------
    link : the ensemble's page, with all methods and signals
    styles : how each row of the table is drawn in the figure
    """

    heading: str
    text: str
    link: str
    table: Table
    styles: tuple[TraceStyle, ...]
    figure: Titled


def spread(results: Results) -> Spread | None:
    """The first screen's distribution; None without an ensemble at stock timesteps."""
    at_stock = [(name, one) for name, one in numbered(results.ensembles) if not one.sweep.timestep]
    if not at_stock:
        return None
    name, ensemble = max(at_stock, key=lambda pair: pair[1].sweep.members)
    shown = _shown(ensemble, results)
    drawn = trace_styles(methods_of(ensemble.points, results))
    if not any((one.errors(SHOWN.name) > 0).any() for one in shown):
        return None
    members, scene = count(ensemble.sweep.members), ensemble.scenario.name
    return Spread(
        f"Over {members} starts and bodies like {scene}",
        f"{SHOWN.error_title}, at stock timesteps; ∞ where a run did not finish.",
        ensemble_page(name),
        table(("", *QUANTILES), [_row(one) for one in shown]),
        tuple(drawn[one.pair] for one in shown),
        Titled("spread", "", "", distribution(shown, drawn, SHOWN, LOW)),
    )


def _shown(ensemble: EnsembleResult, results: Results) -> list[Members]:
    """The members of each engine's first method as shipped, and of the best of the others."""
    declared = methods_of(ensemble.points, results)
    chosen: dict[tuple[str, bool], Members] = {}
    members = members_of(ensemble.points, list(declared))
    for one in sorted(members, key=lambda one: one.quantiles(SHOWN.name) or (float("inf"),)):
        method = declared[one.pair]
        if one.points and (method is None or method.as_shipped or not method.reader):
            chosen.setdefault((one.pair[0], bool(method and method.as_shipped)), one)
    return sorted(chosen.values(), key=lambda one: list(declared).index(one.pair))


def _row(one: Members) -> list[Cell | str]:
    values = one.quantiles(SHOWN.name)
    assert values is not None, "only methods that were run are shown"
    label = f"{' '.join(one.pair)}, {duration(one.points[0].timestep)}"
    return [Cell(label, "name"), *(figure(readable(v * SHOWN.shown)) for v in values)]
