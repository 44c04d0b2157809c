"""How each method is drawn: the same colour, dash and marker on every page."""

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
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross")


@dataclass(frozen=True)
class TraceStyle:
    """Colour by method, dash and marker by engine; names as Plotly has them."""

    colour: str
    dash: str
    symbol: str


def looks(pairs: Iterable[tuple[str, str]]) -> dict[tuple[str, str], TraceStyle]:
    """A look for every (engine, method); one method's name has one colour in every engine."""
    pairs = list(pairs)
    engines = list(dict.fromkeys(engine for engine, _ in pairs))
    methods = list(dict.fromkeys(method for _, method in pairs))
    return {
        (engine, method): TraceStyle(
            COLOURS[methods.index(method) % len(COLOURS)],
            DASHES[engines.index(engine) % len(DASHES)],
            SYMBOLS[engines.index(engine) % len(SYMBOLS)],
        )
        for engine, method in pairs
    }
