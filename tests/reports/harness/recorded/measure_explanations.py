"""Measures what `judge` makes of motions with reported faults, and of honest ones.

``make recorded-motions`` writes docs/measured/recorded-motions.md.
"""

from pathlib import Path

import numpy as np
from planted_motions import case, rates_of, stepped
from reported_faults import FAULTS, judged, named

PAGE = Path(__file__).parents[4] / "docs/measured/recorded-motions.md"
#: Honest motions.
HONEST = 100
HEAD = """# What `judge` says of motions with reported faults

Made by `make recorded-motions`. Each motion is computed with the fault of a public report, by code
that shares nothing with what explains it, and judged by `spincheck judge` with its timestep stated.
{right} of {count} are named rightly.

| report | fault | what is said | right |
|---|---|---|---|
{rows}

Of {honest} motions that methods of orders 1 to 4 made without a fault, at 20, 10, 5 and 2.5 ms, of
which two thirds state their timestep, {accused} are explained by a fault, and {beyond} are said to
be beyond what their method makes.
"""


def of_faults() -> list[tuple[str, bool]]:
    """The rows of the table, and which are right."""
    rows = []
    for fault in FAULTS:
        said = named(judged(*fault.motion(), fault.timestep))
        repository, number = fault.report.split("#")
        link = f"[{fault.report}](https://github.com/{repository}/issues/{number})"
        is_right = fault.is_named(said)
        cells = link, fault.what, "; ".join(said) or "nothing", "yes" if is_right else "no"
        rows.append((f"| {' | '.join(cells)} |", is_right))
        print(*cells, flush=True)
    return rows


def of_honest() -> tuple[int, int]:
    """How many honest motions are explained by a fault, and how many are beyond their method."""
    accused, beyond = 0, 0
    for k in range(HONEST):
        one, order = case(500 + k, is_pivoted=bool(k % 2)), 1 + k // 2 % 4
        timestep = 0.02 / 2 ** (k // 8 % 4)
        arrays = stepped(one, rates_of(one), order, timestep, np.random.default_rng(k))
        found = judged(one.scenario, arrays, timestep if k % 3 else None)
        accused += bool(found.explained_by)
        beyond += found.is_beyond
        if found.is_another:
            print(k, order, timestep, found.verdict, *named(found), flush=True)
    return accused, beyond


def main() -> None:
    """Write the page."""
    rows, (accused, beyond) = of_faults(), of_honest()
    page = HEAD.format(
        right=sum(is_right for _, is_right in rows),
        count=len(rows),
        rows="\n".join(row for row, _ in rows),
        honest=HONEST,
        accused=accused or "none",
        beyond=beyond or "none",
    )
    PAGE.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
