"""What a reader came for, in three sentences: how wrong the defaults are, what to use, and why."""

import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from statistics import median, median_high

from ..results.records import Pair, Row
from .analysis.report_data import ReportData, SceneRuns
from .analysis.timesteps import as_shipped, row_at, stock_timesteps
from .analysis.wording import duration, plural, readable
from .analysis.work_precision import cost

#: A method is offered instead of a default if it can do so many of the scenes that any can.
COVERING = 0.9
#: What is said of a default is so on at least so many of the scenes that it gets wrong.
COMMON = 0.1
_ACTIVE = "active though the scene does not call for it: "


@dataclass(frozen=True)
class Sentence:
    """A heading of a few words, and the answer."""

    heading: str
    text: str


@dataclass(frozen=True, eq=False)
class _AtStock:
    """One method's runs at its engine's stock timestep, by scene; those that were made."""

    pair: Pair
    timestep: float
    rows: dict[str, Row]

    @property
    def attitudes(self) -> dict[str, float]:
        """The error in degrees by scene; infinite where the run did not end ok."""
        return {
            name: math.degrees(row.errors.attitude) if row.errors else math.inf
            for name, row in self.rows.items()
        }

    @property
    def size(self) -> tuple[float, float]:
        """Median and worst; of two middle ones the worse, so that infinity is no mean."""
        off = self.attitudes.values()
        return median_high(off), max(off)

    def __str__(self) -> str:
        """How far off it is, in median and on the worst scene."""
        off = self.attitudes
        middle, _ = self.size
        ended = {name: error for name, error in off.items() if error < math.inf}
        lost = len(off) - len(ended)
        if math.isinf(middle):
            return f"does not come to the end of {lost} of {plural(len(off), 'scene')}"
        worst = max(ended, key=lambda name: ended[name])
        text = (
            f"is {_degrees(middle)} off in attitude, at worst {_degrees(ended[worst])} on {worst}"
        )
        return text + (f", and {plural(lost, 'run')} blew up" if lost else "")


def answer(gathered: ReportData, harmless: Collection[str] = frozenset()) -> tuple[Sentence, ...]:
    """The sentences, from the plain scenes alone; none where nothing was run at stock timesteps.

    Parameters
    ----------
    harmless : what changes no motion, measured: no reason for a wrong one
    """
    plain = gathered.plain
    steps = stock_timesteps(plain)
    tried = [_at_stock(plain, pair, steps[pair[0]]) for pair in plain.pairs if pair[0] in steps]
    there = {one.pair: one for one in tried if one.rows}
    # Of an engine the first: what else is as shipped tells its defaults apart.
    first = {pair[0]: there[pair] for pair in reversed(as_shipped(plain)) if pair in there}
    shipped = [first[engine] for engine in sorted(first)]
    clean = [one for pair, one in there.items() if pair not in as_shipped(plain)]
    if not shipped:
        return ()
    most = max(len(one.rows) for one in shipped)
    wrong = [f"{_named(one)} {one}" for one in shipped]
    instead = [said for one in shipped if (said := _instead(one, clean))]
    found = [
        Sentence(f"What defaults get wrong (median of {plural(most, 'scene')})", _sentences(wrong)),
        Sentence("What to use instead", _sentences(instead)),
        Sentence("Why", _sentences([_why(one, plain.scenes, harmless) for one in shipped])),
    ]
    return tuple(sentence for sentence in found if sentence.text)


def _at_stock(gathered: ReportData, pair: Pair, timestep: float) -> _AtStock:
    rows = {
        scene.name: row
        for scene in gathered.scenes
        for runs in scene.methods
        if (runs.engine, runs.method) == pair
        and (row := row_at(runs, "stock", timestep)) is not None
        and row.made
    }
    return _AtStock(pair, timestep, rows)


def _instead(shipped: _AtStock, clean: Sequence[_AtStock]) -> str:
    """The most accurate method of the same engine at the same timestep, and its price."""
    own = [one for one in clean if one.pair[0] == shipped.pair[0]]
    most = max((len(one.rows) for one in own), default=0)
    offered = [one for one in own if len(one.rows) >= COVERING * most]
    best = min(offered, key=lambda one: one.size, default=None)
    if best is None or best.size >= shipped.size:
        return ""
    engine, method = best.pair
    text = f"{engine} {method} at the same {duration(best.timestep)} {best}"
    prices = [
        dear / cheap
        for name in best.rows.keys() & shipped.rows.keys()
        if (dear := cost(best.rows[name])) and (cheap := cost(shipped.rows[name]))
    ]
    return text + (f", for {readable(median(prices))} times the CPU time" if prices else "")


def _why(shipped: _AtStock, scenes: Sequence[SceneRuns], harmless: Collection[str]) -> str:
    """Whether it is the timestep, or what the engine does besides."""
    verdicts = {
        scene.name: runs.verdict.verdict
        for scene in scenes
        for runs in scene.methods
        if (runs.engine, runs.method) == shipped.pair and runs.verdict
    }
    wrong = [name for name, word in verdicts.items() if word in ("disagrees", "diverges", "failed")]
    name = " ".join(shipped.pair)
    good = sum(word == "converges" for word in verdicts.values())
    if not wrong:
        open_ = len(verdicts) - good
        left = f" (on {open_} its timesteps were too coarse to tell)" if open_ else ""
        return (
            f"{name} goes to the exact motion on {good} of {plural(len(verdicts), 'scene')} as its "
            f"timestep shrinks{left}: its errors are its integrator's"
        )
    rows = [shipped.rows[name] for name in wrong if name in shipped.rows]
    counted = Counter(cause for row in rows for cause in dict.fromkeys(_causes(row)))
    causes = [
        f"{cause} ({amount})"
        for cause, amount in counted.most_common()
        if amount > COMMON * len(rows) and cause.removeprefix("a ") not in harmless
    ]
    text = f"{name} does not, at any timestep, on {len(wrong)} of {plural(len(verdicts), 'scene')}"
    return text + (f": {', '.join(causes)}" if causes else "")


def _causes(row: Row) -> Iterator[str]:
    """What an engine as shipped did besides the scene, in the words of its own report."""
    if "'inertia_com' reads back" in row.reason:
        yield "an inertia that is not the file's"
    if row.cause == "clamp":
        yield "velocity clamp"
    for part in row.reason.split("; "):
        if part.startswith(_ACTIVE):
            names = part.removeprefix(_ACTIVE).split(", ")
            # Sizes that were measured differ from scene to scene; what has a name does not.
            yield from (name for name in names if not any(map(str.isdigit, name)))


def _named(one: _AtStock) -> str:
    return f"{' '.join(one.pair)} at its stock {duration(one.timestep)}"


def _degrees(error: float) -> str:
    return f"{readable(error)}°"


def _sentences(parts: Sequence[str]) -> str:
    return " ".join(f"{part}." for part in parts)
