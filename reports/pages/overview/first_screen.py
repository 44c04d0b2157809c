"""The report's answer in three sentences: how wrong the defaults are, what to use, and why."""

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median, median_high

import numpy as np

from ...results.cost_records import EffectsCost
from ...results.records import Key, Pair, Row
from ...results.verdict_words import VERDICT
from ..analysis.gyroscopic import without_gyroscopic_torque
from ..analysis.report_data import ReportData, SceneRuns
from ..analysis.timesteps import as_shipped, row_at, stock_timesteps
from ..analysis.wording import duration, plural, readable

#: A method is recommended instead of a default if it can simulate this fraction of the scenes.
COVERING = 0.9
#: A cause is given for a default if it holds on at least this fraction of the scenes it gets wrong.
COMMON = 0.1
#: Number of engines whose defaults are described one by one, smallest errors first.
LISTED = 2
#: How a method's steps are compared with the default's.
SWITCHED = "if only the method is changed"
PRUNED = "with what the scene does not call for left out"


@dataclass(frozen=True)
class Sentence:
    """A heading of a few words, and the answer."""

    heading: str
    text: str


@dataclass(frozen=True, eq=False)
class _AtStock:
    """One method's runs at its engine's stock timestep, by scene, as far as they were made."""

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
        """Median and worst error; of two middle ones the larger, as errors may be infinite."""
        errors = self.attitudes.values()
        return median_high(errors), max(errors)

    def __str__(self) -> str:
        """The errors in words: median, and worst with its scene."""
        errors = self.attitudes
        middle, _ = self.size
        ended = {name: error for name, error in errors.items() if error < math.inf}
        unfinished = len(errors) - len(ended)
        if math.isinf(middle):
            return f"does not come to the end of {unfinished} of {plural(len(errors), 'scene')}"
        worst = max(ended, key=lambda name: ended[name])
        text = (
            f"{self._by_turns}is {_degrees(middle)} off in attitude at the end, at worst "
            f"{_degrees(ended[worst])} on {worst}"
        )
        return text + (f", and {plural(unfinished, 'run')} blew up" if unfinished else "")

    @property
    def _by_turns(self) -> str:
        """Medians, in words, of measures that do not depend on the windows' lengths."""
        within = [
            math.inf if row.turns_within_1deg is None else row.turns_within_1deg
            for row in self.rows.values()
            if row.turns is not None
        ]
        added = [a for row in self.rows.values() if (a := row.attitude_a_turn) is not None]
        a_turn = f"adds {_degrees(math.degrees(median(added)))} a turn and " if added else ""
        if not within or (turns := median_high(within)) == math.inf:
            return a_turn
        return f"is 1° off after {readable(turns)} turns, {a_turn}"


def answer(gathered: ReportData, left_out: Collection[EffectsCost] = ()) -> tuple[Sentence, ...]:
    """The sentences, from the plain scenes alone; none where nothing was run at stock timesteps.

    Parameters
    ----------
    left_out : the cost of what changes no motion, and so is no reason for a wrong one
    """
    plain = gathered.plain
    steps = stock_timesteps(plain)
    tried = [_at_stock(plain, pair, steps[pair[0]]) for pair in plain.pairs if pair[0] in steps]
    there = {one.pair: one for one in tried if one.rows}
    # The first of each engine: further methods as shipped lack some of the defaults.
    first = {pair[0]: there[pair] for pair in reversed(as_shipped(plain)) if pair in there}
    shipped = sorted(first.values(), key=lambda one: one.size)
    clean = [one for pair, one in there.items() if pair not in as_shipped(plain)]
    if not shipped:
        return ()
    listed, others = shipped[:LISTED], shipped[LISTED:]
    most = max(len(one.rows) for one in shipped)
    wrong = [f"{_named(one)} {one}" for one in listed] + _others(others)
    instead = [text for one in listed if (text := _instead(one, clean, left_out))]
    harmless = {name for cost in left_out for name in cost.left_out}
    measured = {one.key.engine for scene in plain.scenes for one in scene.defaults}
    explained = [one for one in shipped if one in listed or one.pair[0] in measured]
    why = [_why(one, plain.scenes, harmless) for one in explained] + _no_gyroscopic_torque(plain)
    sentences = [
        Sentence(f"What defaults get wrong (median of {plural(most, 'scene')})", _sentences(wrong)),
        Sentence("What to use instead", _sentences(instead)),
        Sentence("Why", _sentences(why)),
    ]
    return tuple(sentence for sentence in sentences if sentence.text)


def _others(shipped: Sequence[_AtStock]) -> list[str]:
    """The other defaults in short: the range of their medians, and which mostly blow up."""
    ended = [one for one in shipped if one.size[0] < math.inf]
    unfinished = [one.pair[0] for one in shipped if one not in ended]
    sentences = []
    if ended:
        low, high = (_degrees(one.size[0]) for one in (ended[0], ended[-1]))
        names = ", ".join(one.pair[0] for one in ended)
        ranged = low if low == high else f"{low} to {high}"
        sentences.append(f"The defaults of {names} are {ranged} off")
    if unfinished:
        sentences.append(f"Those of {', '.join(unfinished)} do not come to the end of most scenes")
    return sentences


def _no_gyroscopic_torque(gathered: ReportData) -> list[str]:
    """The engines that leave out the gyroscopic torque, and the effect; empty if none does."""
    lacking, tried = without_gyroscopic_torque(gathered)
    if not lacking:
        return []
    worst = max(lacking, key=lambda one: one.omega_error)
    names = ", ".join(one.engine for one in lacking)
    leave = "leaves" if len(lacking) == 1 else "leave"
    return [
        f"{len(lacking)} of {plural(tried, 'engine')} {leave} out the gyroscopic torque as shipped "
        f"({names}): no free body tumbles, and ω is up to {worst.omega_error:.0%} off, "
        f"with {worst.engine} on {worst.worst_scene}"
    ]


def _at_stock(gathered: ReportData, pair: Pair, timestep: float) -> _AtStock:
    rows = {
        scene.name: row
        for scene in gathered.scenes
        for runs in scene.methods
        if (runs.engine, runs.method) == pair
        and (row := row_at(runs, "stock", timestep)) is not None
        and row.simulated
    }
    return _AtStock(pair, timestep, rows)


def _instead(
    shipped: _AtStock, clean: Sequence[_AtStock], left_out: Collection[EffectsCost]
) -> str:
    """The most accurate method of the same engine at the same timestep, and its price.

    The price is that of the default with another method, as most readers take it, and of what is
    left besides where nothing runs that the scene does not call for.
    """
    own = [one for one in clean if one.pair[0] == shipped.pair[0]]
    most = max((len(one.rows) for one in own), default=0)
    offered = [one for one in own if len(one.rows) >= COVERING * most]
    best = min(offered, key=lambda one: one.size, default=None)
    if best is None or best.size >= shipped.size:
        return ""
    engine, method = best.pair
    text = f"{engine} {method} at the same {duration(best.timestep)} {best}"
    cheap = {name: row.seconds_per_step for name, row in shipped.rows.items()}
    pruned = {name: row.seconds_per_step for name, row in best.rows.items()}
    whole = {one.key.scenario: one.unpruned for one in left_out if _pair(one.key) == best.pair}
    prices = [
        price
        for seconds, words in ((whole, SWITCHED), (pruned, PRUNED))
        if (price := _price(seconds, cheap, words))
    ]
    return text + (f"; a step takes {', and '.join(prices)}" if prices else "")


def _price(seconds: Mapping[str, float | None], cheap: Mapping[str, float | None], how: str) -> str:
    """The median ratio of the times of a step by scene, and its quartiles; empty without any."""
    ratios = [dear / base for name, dear in seconds.items() if dear and (base := cheap.get(name))]
    if not ratios:
        return ""
    low, middle, high = np.percentile(ratios, [25, 50, 75])
    spread = f"{readable(float(low))} to {readable(float(high))}"
    return f"{readable(float(middle))} ({spread}) times the default's CPU time {how}"


def _pair(key: Key) -> Pair:
    return key.engine, key.method


def _why(shipped: _AtStock, scenes: Sequence[SceneRuns], harmless: Collection[str]) -> str:
    """The reason of the errors: the timestep, or defaults of the engine."""
    verdicts = {
        scene.name: runs.verdict.verdict
        for scene in scenes
        for runs in scene.methods
        if (runs.engine, runs.method) == shipped.pair and runs.verdict
    }
    wrong = [
        name
        for name, word in verdicts.items()
        if VERDICT[word].needs_reason and word != "unresolved"
    ]
    name = " ".join(shipped.pair)
    good = sum(word == "converges" for word in verdicts.values())
    if not wrong and not good:
        return f"The timesteps of {name} were too coarse to tell on all its scenes"
    if not wrong:
        open_ = len(verdicts) - good
        left = f" (on {open_} its timesteps were too coarse to tell)" if open_ else ""
        scenes_tried = plural(len(verdicts), "scene")
        return (
            f"{name} converges to the exact motion on {good} of {scenes_tried} as its "
            f"timestep shrinks{left}: its errors are its integrator's"
        )
    text = f"{name} does not, at any timestep, on {len(wrong)} of {plural(len(verdicts), 'scene')}"
    wrong_scenes = [scene for scene in scenes if scene.name in wrong]
    causes = _by_each_default(shipped.pair, wrong_scenes) or _acting(shipped, wrong, harmless)
    return text + (f": {causes}" if causes else "")


def _by_each_default(pair: Pair, scenes: Sequence[SceneRuns]) -> str:
    """The number of scenes on which each default alone causes an error of ω, if measured."""
    measured = [
        one
        for scene in scenes
        for one in scene.defaults
        if (one.key.engine, one.key.method) == pair
    ]
    counted = Counter(one.name for effects in measured for one in effects.each if one.acts)
    listed = ", ".join(f"its {name} on {amount}" for name, amount in counted.most_common())
    return f"the equations of motion are altered by {listed}, each alone" if listed else ""


def _acting(shipped: _AtStock, wrong: Sequence[str], harmless: Collection[str]) -> str:
    """What acted though not called for, as reported by the engine, and on how many scenes."""
    rows = [shipped.rows[name] for name in wrong if name in shipped.rows]
    counted = Counter(cause for row in rows for cause in dict.fromkeys(_unasked(row)))
    return ", ".join(
        f"{cause} ({amount})"
        for cause, amount in counted.most_common()
        if amount > COMMON * len(rows) and cause.removeprefix("a ") not in harmless
    )


def _unasked(row: Row) -> Iterator[str]:
    # Measured sizes differ between scenes; names do not, so only names are counted.
    yield from (name for name in row.unasked if not any(map(str.isdigit, name)))
    if row.cause == "clamp":
        yield "a velocity clamp"


def _named(one: _AtStock) -> str:
    return f"{' '.join(one.pair)} at its stock {duration(one.timestep)}"


def _degrees(error: float) -> str:
    return f"{readable(error)}°"


def _sentences(parts: Sequence[str]) -> str:
    return " ".join(f"{part}." for part in parts)
