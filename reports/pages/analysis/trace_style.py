"""Assigns each method a colour, dash and marker, the same on every page.

Up to 40 methods differ in dash or marker, so that colour is never the only difference.
"""

from collections.abc import Iterable
from dataclasses import dataclass

#: Colours of medium lightness, so that all contrast by 3 : 1 with white and with near-black.
COLOURS = (
    "#2f7ed8",
    "#d9660d",
    "#199a5a",
    "#b04fc4",
    "#d63f4c",
    "#0c95a3",
    "#d6529b",
    "#9a6b3f",
    "#868b14",
    "#7d8794",
)
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")
SYMBOLS = (
    "circle",
    "square",
    "diamond",
    "triangle-up",
    "cross",
    "star",
    "pentagon",
    "triangle-left",
)


@dataclass(frozen=True)
class TraceStyle:
    """How the curves of a method are drawn: colour, and Plotly's names of dash and marker.

    Methods of the same name, unless they are as shipped, share a colour in all engines; dash and
    marker tell them apart.
    """

    colour: str
    dash: str
    symbol: str


def trace_styles(pairs: Iterable[tuple[str, str]]) -> dict[tuple[str, str], TraceStyle]:
    """Return a style for each pair of engine and method.

    Methods of the same name have the same colour in every engine. Methods as shipped, whose names
    begin with "default", have nothing in common but that name; each has a colour of its own. Among
    the first 40 pairs, no two have both the same dash and the same marker.
    """
    pairs = list(pairs)
    named = {pair: pair if pair[1].startswith("default") else pair[1] for pair in pairs}
    colours = list(dict.fromkeys(named.values()))
    return {
        pair: TraceStyle(
            COLOURS[colours.index(named[pair]) % len(COLOURS)],
            DASHES[(rank + rank // len(SYMBOLS)) % len(DASHES)],
            SYMBOLS[rank % len(SYMBOLS)],
        )
        for rank, pair in enumerate(pairs)
    }
