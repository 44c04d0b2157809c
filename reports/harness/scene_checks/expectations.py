"""Checks that expectations and expected failures of scenes name engines and methods that exist."""

from collections.abc import Iterable, Iterator

from ....engines import engines, missing
from ....scenarios import Scenario, did_you_mean, printable
from ....scenarios.locate import line_of


def unknown_expectations(scenarios: Iterable[Scenario]) -> list[str]:
    """Return a sentence for each expectation or expected failure of an unknown engine or method."""
    return [complaint for scenario in scenarios for complaint in _unknown(scenario)]


def _unknown(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence for each unknown engine or method that a scene's file names.

    Expectations (`[[expect]]`) and expected failures (`[[known]]`) are checked. Supported engines
    that are not installed count as known, but their methods are not checked.
    """
    if not (scenario.document.expect or scenario.document.known):
        # Looking up the engines would import them, which takes long.
        return
    methods = {name: [m.name for m in engine.methods] for name, engine in engines().items()}
    absent = [engine.name for engine in missing()]
    for table in ("expect", "known"):
        for index, expected in enumerate(getattr(scenario.document, table)):
            if expected.engine in methods and expected.method not in methods[expected.engine]:
                yield _complaint(scenario, table, index, "method", methods[expected.engine])
            elif expected.engine not in methods and expected.engine not in absent:
                yield _complaint(scenario, table, index, "engine", [*methods, *absent])


def _complaint(scenario: Scenario, table: str, index: int, key: str, names: list[str]) -> str:
    """Return the message that a scene's file names an unknown engine or method.

    Parameters
    ----------
    table : name of the array of tables, `expect` or `known`
    index : index of the table in the array, from 0
    key : the key with the unknown name, `engine` or `method`
    names : the names that the key may have
    """
    line = line_of(scenario.text, (table, index, key))
    where = printable(str(scenario.path or scenario.name))
    got = getattr(getattr(scenario.document, table)[index], key)
    return (
        f"{where}:{line}: [[{table}]] number {index + 1} {key}: "
        f"must be one of {', '.join(names)}, got '{got}'{did_you_mean(got, names)}"
    )
