"""The first page: its headline, and tables of methods, of complaints and of hard scenes."""

import math
from collections.abc import Callable

from ....engines import Method
from ....scenarios import EFFECTS
from ...results.records import Pair
from ...results.verdict_words import LISTED, VerdictKind
from ...results.verdicts import Verdict
from ..analysis.questions import ask, verdict_counts
from ..analysis.report_data import MethodRuns, ReportData, SceneRuns
from ..analysis.wording import NOTHING, number, plural
from ..tables import Cell, Table, figure, method_anchor, named, records, scene_page, verdict_cell

#: Attitude error, rad, up to which a run counts as close.
CLOSE = math.radians(1.0)
WORDS = tuple(kind.word for kind in LISTED)
#: Groups of scenes by their effects, in the order of the page. Scenes whose body is held by a
#: constraint come first.
FREE, NOT_SOLVED = "Free", "Not solved"
_OF_HELD = [one.group for one in EFFECTS.values() if one.group and one.constraint]
_OF_OTHERS = [one.group for one in EFFECTS.values() if one.group and not one.constraint]
GROUPS = tuple(dict.fromkeys([*_OF_HELD, FREE, *_OF_OTHERS, NOT_SOLVED]))


def headline(gathered: ReportData) -> str:
    """Return, in sentences, how many verdicts of each kind there are on plain scenes.

    Verdicts on methods as shipped are counted apart. Hard scenes are only counted.
    """
    plain = gathered.plain
    counts, shipped = (verdict_counts(plain, as_shipped=which) for which in (False, True))
    parts = [
        f"{counts[kind.word]} {kind.phrases[counts[kind.word] > 1]}"
        for kind in LISTED
        if kind.word in counts
    ]
    ((methods, unmet),) = ask(
        plain,
        "SELECT count(DISTINCT engine || ' ' || method), sum(unmet) FROM tried "
        "WHERE NOT judged_as_shipped",
    )
    text = f"{plural(len(plain.scenes), 'scene')} × {plural(methods, 'method')}."
    if counts:
        pairs = plural(sum(counts.values()), "pair")
        text += f" Of {pairs} of a scene and a method, {_listed(parts)}."
    if unmet:
        text += f" {plural(unmet, 'method')} missed an expectation of the scene's file."
    if shipped:
        good, all_of_them = shipped.get("converges", 0), sum(shipped.values())
        text += f" With their defaults (as shipped), {good} of {all_of_them} pairs converge."
    if hard := len(gathered.scenes) - len(plain.scenes):
        text += f" Hard scenes ({hard}) are counted separately, below."
    return text


def at_stock(gathered: ReportData) -> str:
    """Return in words how many runs keep the attitude to within 1° at their stock timestep.

    Only runs of clean methods with the verdict `converges` are counted: that verdict says nothing
    about the errors at a given timestep. The text is empty if there are no such runs.
    """
    ((runs, close),) = ask(
        gathered,
        "SELECT count(*), sum(attitude <= ?) FROM usual "
        "WHERE verdict = 'converges' AND NOT judged_as_shipped",
        CLOSE,
    )
    if not runs:
        return ""
    return (
        "Where a method converges, the model is right, and a short enough timestep gives the exact "
        f"motion. Stock timesteps are often too long: at them {close} of these {runs} runs "
        f"{'keeps' if close == 1 else 'keep'} the attitude within 1°."
    )


def group_of(scene: SceneRuns) -> str:
    """Return the group of a scene, one of `GROUPS`, which depends on its effects."""
    if scene.solved is None:
        return NOT_SOLVED
    groups = [effect.group for effect in scene.solved.scenario.acting if effect.group]
    return groups[-1] if groups else FREE


def methods_table(gathered: ReportData) -> Table:
    """Return a table of the methods, with the number of scenes on which each has each verdict."""
    declared = {runs.pair: runs.declared for scene in gathered.scenes for runs in scene.methods}
    versions: dict[Pair, list[str]] = {}
    for *pair, version in ask(
        gathered, "SELECT DISTINCT engine, method, version FROM run ORDER BY 3"
    ):
        versions.setdefault((pair[0], pair[1]), []).append(version)
    words = ", ".join(f"sum(coalesce(verdict = '{word}', FALSE))" for word in WORDS)
    lines = ask(
        gathered,
        f"SELECT engine, method, median(seconds), {words} FROM tried GROUP BY 1, 2 ORDER BY place",
    )
    return records(
        {
            "engine": Cell(engine, "name"),
            "version": ", ".join(versions.get((engine, method), ())),
            "method": Cell(method, "name", known.summary if known else ""),
            "declared order": figure(_declared_orders(known)),
            **{
                word: Cell(str(count), f"number {word if count else 'none'}")
                for word, count in zip(WORDS, counts, strict=True)
            },
            "CPU a step, µs (median)": figure(number(1e6 * seconds if seconds else None)),
        }
        for engine, method, seconds, *counts in lines
        for known in [declared[engine, method]]
    )


def complaints(
    gathered: ReportData, is_listed: Callable[[VerdictKind], bool], *, as_shipped: bool = False
) -> Table:
    """Return a table of verdicts with their reasons.

    It has all verdicts of the kinds that `is_listed` selects, and all with unmet expectations.

    Parameters
    ----------
    is_listed : function that tells whether verdicts of a kind are in the table
    as_shipped : True for a table of methods as shipped, False for one of clean methods
    """
    rows = []
    for kind in LISTED:
        for scene in gathered.scenes:
            for runs in scene.methods:
                verdict = runs.verdict
                if not verdict or verdict.as_shipped != as_shipped or verdict.verdict != kind.word:
                    continue
                if is_listed(kind) or verdict.unmet:
                    rows.append(_complaint(scene, runs, verdict))
    return records(rows)


def _declared_orders(declared: Method | None) -> str:
    """Return the declared orders of ω and attitude as text; one number if both are the same.

    The text is `NOTHING` if the declaration is not known.
    """
    if declared is None:
        return NOTHING
    if declared.order == declared.attitude_order:
        return str(declared.order)
    return f"ω {declared.order}, attitude {declared.attitude_order}"


def _complaint(scene: SceneRuns, runs: MethodRuns, verdict: Verdict) -> dict[str, Cell | str]:
    """Return a table row, by headings: scene, engine, method, verdict, and the verdict's reason."""
    page = scene_page(scene.name)
    link = f"{page}#{method_anchor(runs.engine, runs.method)}"
    unmet = "expectation unmet" if verdict.unmet else ""
    return {
        "scene": Cell(scene.name, "scene", "", page),
        **named(runs.pair),
        "verdict": verdict_cell(verdict.verdict, unmet, link),
        "reason": reason_of(verdict),
    }


def reason_of(verdict: Verdict) -> str:
    """Return the reason of a verdict, followed by its unmet expectations, as one text."""
    return "; ".join([verdict.reason, *(f"expectation unmet: {line}" for line in verdict.unmet)])


def _listed(parts: list[str]) -> str:
    """Return parts of a sentence as a list in words, with "and" before the last."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


#: Turns in a step at which the survival of methods is compared, rad.
TURNS = (0.01, 0.1, 1.0)


def hard_scenes(gathered: ReportData) -> tuple[SceneRuns, ...]:
    """Return the scenes that are tagged as hard."""
    return tuple(scene for scene in gathered.scenes if scene.solved and scene.solved.scenario.hard)


def survivors_table(gathered: ReportData) -> Table:
    """Return a table of how many hard scenes each method survives, at several turns in a step.

    The turn in a step is the timestep times the scene's fastest rate, rad. Its median leaves out
    scenes whose rate is zero.
    """
    reached = ", ".join(f"count(*) FILTER (WHERE at_least OR turn >= {turn})" for turn in TURNS)
    question = f"""
        WITH can AS (SELECT * FROM tried WHERE hard AND at_least IS NOT NULL)
        SELECT every.engine, every.method,
            median(iif(scene IS NULL OR turn = 0, NULL, coalesce(turn, 0))),
            count(scene), count(*) FILTER (WHERE verdict = 'converges'), count(survives), {reached}
        FROM (SELECT DISTINCT engine, method, place FROM tried) AS every
            LEFT JOIN can USING (engine, method) GROUP BY 1, 2 ORDER BY every.place"""
    headings = (
        "hard scenes it was run on",
        "converges",
        "survives at its finest timestep",
        *(f"survives at {turn:g} rad a step" for turn in TURNS),
    )
    return records(
        named((engine, method))
        | {what: figure(str(count)) for what, count in zip(headings, counts, strict=True)}
        | {"largest turn a step it survives, rad (median)": figure(number(middle))}
        for engine, method, middle, *counts in ask(gathered, question)
    )
