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
    """How the curves of a method are drawn; names of dash and marker are Plotly's.

    The colour is that of the method's name; dash and marker are of engine and method.
    """

    colour: str
    dash: str
    symbol: str


def trace_styles(pairs: Iterable[tuple[str, str]]) -> dict[tuple[str, str], TraceStyle]:
    """Return a style for every (engine, method); a method's name has one colour in every engine.

    Engines with all their defaults are methods with nothing in common but the name `default…`, so
    each has a colour of its own. No two of up to 40 methods have both the same dash and the same
    marker; further ones repeat them.
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
