"""Measures what `judge` makes of motions with reported and invented faults, and of honest ones.

``make recorded-motions`` writes docs/measured/recorded-motions.md.
"""

import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from honest_library import honest_recordings
from honest_motions import honest_motions
from invented_faults import INVENTED
from reported_faults import FAULTS, Fault, judged, named
from spincheck.reports.harness.recorded.judged import JudgedMotion

PAGE = Path(__file__).parents[4] / "docs/measured/recorded-motions.md"
#: Honest motions.
HONEST = 300
HEAD = """# What `judge` says of motions with faults, and of honest ones

Made by `make recorded-motions`. Each motion is computed with a fault, by code
that shares nothing with what explains it, and judged by `spincheck judge` with its timestep stated.

## Faults of public reports

{reported_right} of {reported_count} are named rightly.

| report | fault | what is said | right |
|---|---|---|---|
{reported}

## Faults invented

By somebody who had not written what explains them: {invented_right} of {invented_count} are named
rightly. What was not named at first led to what names it now, so that this is no blind test any
more.

| by whom | fault | what is said | right |
|---|---|---|---|
{invented}

## Honest motions

{honest} motions with nothing wrong: bodies slender, flat, nearly spherical, symmetric and any,
free, heavy, dragged, pushed and with rotors; turns of 0.2 to 50 rad with 0.01 to 0.4 rad between
samples, 1 to 128 steps a sample; numbers in full, in single precision or of 5 to 9 digits, ω along
world axes or left out, spins left out; two thirds state their timestep, and a fifth begin later
than the scene. Measured motions have noise of 0.01° to 1°, which half of them state. Explained by
other physics or by a mistake in recording: {accused}. Said to be beyond what their method, or their
noise, makes: {beyond}.

| made by | motions | explained | beyond |
|---|---|---|---|
{by_source}

## Honest recordings of the library

{of_library} recordings of the library's scenes, hard ones among them: the exact motion as it is
printed, the exact motion with normal noise of 10⁻⁴ and 10⁻², and runs of order 1, 2 and 4 with
steps of 0.02 and 0.1 rad. Explained by other physics or by a mistake in recording:
{library_accused}. Said to be beyond what their method, or their noise, makes: {library_beyond}.

| made by | motions | explained | beyond |
|---|---|---|---|
{by_source_of_library}
"""


def rows_of(faults: Iterable[Fault]) -> list[tuple[str, bool]]:
    """The rows of a table, and which are right."""
    rows = []
    for fault in faults:
        said = named(judged(*fault.motion(), fault.timestep))
        repository, _, number = fault.report.partition("#")
        link = f"[{fault.report}](https://github.com/{repository}/issues/{number})"
        is_right = fault.is_named(said)
        cells = (
            link if number else fault.report,
            fault.what,
            "; ".join(said) or "nothing",
            "yes" if is_right else "no",
        )
        rows.append((f"| {' | '.join(cells)} |", is_right))
        print(*cells, flush=True)
    return rows


def table_of(recordings: Iterable[tuple[str, str, JudgedMotion]]) -> tuple[str, list[str]]:
    """A table by what made recordings, and how many there are, are explained, and are beyond.

    Each recording has what made it, its name, and what is said of it.
    """
    counts: dict[str, Counter[str]] = {what: Counter() for what in ("motions", "said", "beyond")}
    for source, name, found in recordings:
        counts["motions"][source] += 1
        counts["said"][source] += bool(found.explained_by)
        counts["beyond"][source] += found.is_beyond
        if found.is_another:
            print(source, name, found.verdict, *named(found), flush=True)
    rows = [
        f"| {source} | {' | '.join(str(counts[what][source] or '–') for what in counts)} |"
        for source in sorted(counts["motions"])
    ]
    return "\n".join(rows), [str(count.total() or "none") for count in counts.values()]


def main() -> None:
    """Write the page."""
    warnings.simplefilter("ignore")
    motions = ((one.source, one.body, one.judged()) for _, one in honest_motions(HONEST))
    by_source, (_, accused, beyond) = table_of(motions)
    every = ((one.source, one.scenario.name, one.judged()) for one in honest_recordings())
    by_source_of_library, (count, library_accused, library_beyond) = table_of(every)
    tables = {}
    for name, faults in (("reported", FAULTS), ("invented", INVENTED)):
        rows = rows_of(faults)
        tables[name] = "\n".join(row for row, _ in rows)
        tables[f"{name}_right"] = str(sum(is_right for _, is_right in rows))
        tables[f"{name}_count"] = str(len(rows))
    page = HEAD.format(
        **tables,
        honest=HONEST,
        accused=accused,
        beyond=beyond,
        by_source=by_source,
        of_library=count,
        library_accused=library_accused,
        library_beyond=library_beyond,
        by_source_of_library=by_source_of_library,
    )
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
