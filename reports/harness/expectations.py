"""Whether what scenes promise is about engines and methods that there are."""

from collections.abc import Iterable, Iterator

from ...engines import engines, missing
from ...scenarios import Scenario, printable
from ...scenarios.locate import line_of


def unknown_expectations(scenarios: Iterable[Scenario]) -> list[str]:
    """Complaints about promises that nothing would ever be held to; none if all is well."""
    return [complaint for scenario in scenarios for complaint in _unknown(scenario)]


def _unknown(scenario: Scenario) -> Iterator[str]:
    methods = {name: [m.name for m in engine.methods] for name, engine in engines().items()}
    absent = [engine.name for engine in missing()]
    for table in ("expect", "known"):
        for index, promise in enumerate(getattr(scenario, table)):
            if promise.engine in methods and promise.method not in methods[promise.engine]:
                yield _told(scenario, table, index, "method", methods[promise.engine])
            elif promise.engine not in methods and promise.engine not in absent:
                yield _told(scenario, table, index, "engine", [*methods, *absent])


def _told(scenario: Scenario, table: str, index: int, key: str, there: Iterable[str]) -> str:
    line = line_of(scenario.text, (table, index, key))
    where = printable(str(scenario.path or scenario.name))
    got = getattr(getattr(scenario, table)[index], key)
    return (
        f"{where}:{line}: [[{table}]] number {index + 1} {key}: "
        f"must be one of {', '.join(there)}, got '{got}'"
    )
