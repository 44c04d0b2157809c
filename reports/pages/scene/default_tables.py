"""Tables on a scene's page that show what each default of an engine does to the motion."""

import math

from ....scenarios import Errors
from ...results.default_records import DefaultEffects
from ..analysis.report_data import SceneRuns
from ..analysis.wording import NOTHING, duration, limited_errors
from ..tables import Captioned, Cell, Table, figure, table

#: A default alters ω if the error of ω with this default alone exceeds this multiple of the error
#: without any default, and also this relative error.
NOTICED, NEGLIGIBLE = 1.5, 1e-6


def default_tables(scene: SceneRuns) -> list[Captioned]:
    """Return a table of errors for each method as shipped whose defaults were tried one by one.

    A row shows the errors with one default alone, and those with all others.
    """
    return [
        Captioned(
            f"{measured.key.label} at {duration(measured.timestep)}",
            _sentence(measured),
            _table(scene, measured),
        )
        for measured in scene.defaults
    ]


def _table(scene: SceneRuns, measured: DefaultEffects) -> Table:
    """Return a table of the errors with each default alone, and with all defaults but that one.

    The last row has the errors with no default, and with all.
    """
    headings = [
        f"{error} {which}"
        for which in ("with it alone", "with all others")
        for error in ("attitude, °,", "ω, relative,", "energy, relative,")
    ]
    pairs = [(one.name, one.alone, one.without) for one in measured.each]
    rows = [
        [Cell(name, "name"), *_errors(scene, alone), *_errors(scene, without)]
        for name, alone, without in [*pairs, ("no default, and all", measured.none, measured.all)]
    ]
    return table(("default", *headings), rows)


def _sentence(measured: DefaultEffects) -> str:
    """Return, in words, which defaults alter ω by themselves, the worst first."""
    if measured.none is None:
        return "The run does not come to its end without any of them."
    least = max(NOTICED * measured.none.omega, NEGLIGIBLE)
    sizes = {one.name: _size(one.alone) for one in measured.each}
    effective = sorted((name for name in sizes if sizes[name] > least), key=lambda n: -sizes[n])
    if not effective:
        return "None of them alone alters the motion by more than the timestep does."
    idle = [name for name in sizes if name not in effective]
    text = f"The {effective[0]} alters ω most"
    if len(effective) > 1:
        text += f", then the {' and the '.join(effective[1:])}"
    if idle:
        text += f"; the {' and the '.join(idle)} by no more than the timestep does"
    return f"{text}."


def _size(errors: Errors | None) -> float:
    """Return the error of ω; inf if `errors` is None, as for a run that did not finish."""
    return math.inf if errors is None else errors.omega


def _errors(scene: SceneRuns, errors: Errors | None) -> list[Cell]:
    """Return three cells with the errors of attitude, ω and energy.

    An error that does not exceed the uncertainty is shown as "≤" and the uncertainty. If `errors`
    is None, the first cell says that the run diverged.
    """
    if errors is None:
        return [Cell("diverged", "diverged"), figure(NOTHING), figure(NOTHING)]
    uncertainty = scene.exact.solution.uncertainty
    return [*map(figure, limited_errors(errors, uncertainty, ("attitude", "omega", "energy")))]
