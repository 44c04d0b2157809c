"""How each method is drawn: the same colour, dash and marker on every page.

No two methods share both dash and marker, so colour is never the only difference.
"""

from collections.abc import Iterable
from dataclasses import dataclass

#: Of middling lightness, so that all stand out by 3 : 1 on white and on near-black alike.
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
    """Colour by method; dash and marker by both; names as Plotly has them."""

    colour: str
    dash: str
    symbol: str


def trace_styles(pairs: Iterable[tuple[str, str]]) -> dict[tuple[str, str], TraceStyle]:
    """A style for every (engine, method); one method's name has one colour in every engine.

    Defaults have little in common but the name: each has a colour of its own. Dash and marker
    together are of one pair alone, up to as many as there are of both.
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
