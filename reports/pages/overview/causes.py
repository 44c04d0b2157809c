"""Why engines' defaults are wrong: the timestep, settings that alter the motion, a missing term.

If an engine leaves out the term ω × I ω, the angular velocity of a free body keeps its direction in
space. Damping makes ω smaller, but does not turn it either.
"""

from collections.abc import Collection

import numpy as np

from ....scenarios import Trajectory
from ...results.records import Pair
from ...results.verdict_words import VERDICTS, VerdictKind
from ..analysis.questions import Usual, ask
from ..analysis.report_data import ReportData
from ..analysis.wording import plural

#: Least angle by which the exact ω turns in space on a scene that is used, rad.
TELLING = 0.2
#: A run whose ω turns in space by less than this fraction of the exact angle lacks the gyroscopic
#: torque.
STEADY = 0.02


def without_gyroscopic_torque(gathered: ReportData) -> tuple[dict[str, dict[str, float]], int]:
    """Return the engines as shipped that lack the gyroscopic torque, and how many were examined.

    An engine lacks it if ω keeps its direction in space on every scene on which the exact ω turns.
    Only scenes without effects, or with gravity alone, are used.

    Returns
    -------
    For each engine that lacks the torque, the largest relative error of ω, by scene; and the number
    of engines that were examined.
    """
    lacking: dict[Pair, dict[str, float]] = {}
    has_it: set[Pair] = set()
    for scene in gathered.scenes:
        if scene.solved is None or scene.solved.scenario.called_for - {"gravity"}:
            continue
        for run in scene.compared:
            if not run.runs.as_shipped or turned_in_space(run.exact) < TELLING:
                continue
            if turned_in_space(run.motion) < STEADY * turned_in_space(run.exact):
                lacking.setdefault(run.runs.pair, {})[scene.name] = float(run.series["omega"].max())
            else:
                has_it.add(run.runs.pair)
    engines = {engine for engine, _ in {*lacking, *has_it}}
    first = {pair[0]: errors for pair, errors in lacking.items() if pair not in has_it}
    return dict(sorted(first.items())), len(engines)


def turned_in_space(motion: Trajectory) -> float:
    """Return the largest angle, rad, between the directions in space of ω and of ω at the start.

    It is 0 for a body that is at rest at the start.
    """
    omega_world = motion.to_world(motion.omega_body)
    start = omega_world[0]
    across = np.linalg.norm(np.cross(omega_world, start), axis=1)
    return float(np.arctan2(across, omega_world @ start).max())


#: A cause is named if it acted on more than this fraction of the scenes on which the engine
#: disagrees.
COMMON = 0.1


def why(gathered: ReportData, one: Usual, harmless: Collection[str]) -> str:
    """Return, in words, on how many scenes an engine as shipped converges, and why not on others.

    If the engine disagrees with the equations of motion on any scene, the text says what it alters
    or adds by default on those scenes, if that is known. Scenes on which it diverges are only
    counted, as its integrator alone may be the reason. If the engine disagrees on no scene and
    converges on some, the text says that its errors are those of its integrator. The text is empty
    if all verdicts are "unsupported".

    Parameters
    ----------
    one : the runs of the engine as shipped at its stock timestep
    harmless : names of what engines do by default that changes no motion; they are no reasons
    """
    counts = dict(ask(gathered, f"SELECT verdict, count(*) {_OF_METHOD} GROUP BY 1", *one.pair))
    tried = sum(counts[kind.word] for kind in VERDICTS if kind.word in counts and _counts(kind))
    wrong, good = counts.get("disagrees", 0), counts.get("converges", 0)
    besides = ", ".join(
        f"{kind.phrases[0]} on {counts[kind.word]}"
        for kind in VERDICTS
        if kind.needs_reason and kind.word in counts and kind.word != "disagrees"
    )
    if not tried:
        return ""
    left, scenes = f" (it {besides})" if besides else "", plural(tried, "scene")
    if wrong:
        text = f"{one.label} does not converge on {wrong} of {scenes}, however short the timestep"
        causes = _by_each_default(gathered, one) or _acting(gathered, one, wrong, harmless)
        return text + left + (f": {causes}" if causes else "")
    if good:
        return (
            f"{one.label} converges to the exact motion on {good} of {scenes} as its timestep "
            f"shrinks{left}: its errors are those of its integrator"
        )
    return f"{one.label} {besides} of {scenes}"


_OF_METHOD = "FROM tried WHERE engine = ? AND method = ? AND verdict IS NOT NULL"


def _counts(kind: VerdictKind) -> bool:
    """Whether a scene with a verdict of this kind counts as tried: all but "unsupported"."""
    return kind.needs_reason or kind.word == "converges"


def _by_each_default(gathered: ReportData, one: Usual) -> str:
    """Return, in words, which defaults alter the motion by themselves, and on how many scenes.

    Only scenes on which the method disagrees are counted. The text is empty if no default alters
    the motion there, or if the defaults were not measured one by one. `one` has the runs of an
    engine as shipped, whose defaults are meant.
    """
    counted = ask(
        gathered,
        "SELECT name, count(*) FROM altered JOIN tried USING (scene, engine, method) "
        "WHERE engine = ? AND method = ? AND verdict = 'disagrees' "
        "GROUP BY 1 ORDER BY 2 DESC, min(altered.rowid)",
        *one.pair,
    )
    listed = ", ".join(f"its {name} on {amount}" for name, amount in counted)
    return f"the equations of motion are altered by {listed}, each alone" if listed else ""


def _acting(gathered: ReportData, one: Usual, wrong: int, harmless: Collection[str]) -> str:
    """Return, in words, what acted though scenes do not call for it, and on how many scenes.

    Only scenes on which the method disagrees are counted. What acted on no more than the fraction
    `COMMON` of them is left out. Names are those by which the engine reports what acts. The text
    is empty if nothing is left.

    Parameters
    ----------
    one : the runs of an engine as shipped at its stock timestep
    wrong : the number of scenes on which the method disagrees
    harmless : names of what changes no motion, which are left out
    """
    counted = ask(
        gathered,
        "SELECT name, count(*) FROM unasked JOIN usual USING (scene, engine, method, timestep) "
        "WHERE engine = ? AND method = ? AND verdict = 'disagrees' "
        "GROUP BY 1 HAVING count(*) > ? ORDER BY 2 DESC, min(unasked.rowid)",
        *one.pair,
        COMMON * wrong,
    )
    return ", ".join(
        f"{cause} ({amount})"
        for cause, amount in counted
        if cause.removeprefix("a ") not in harmless
    )


def no_gyroscopic_torque(gathered: ReportData) -> list[str]:
    """Return a list with a sentence on the engines as shipped that lack the gyroscopic torque.

    The list is empty if no engine lacks it.
    """
    lacking, tried = without_gyroscopic_torque(gathered)
    if not lacking:
        return []
    errors = {(engine, scene): e for engine in lacking for scene, e in lacking[engine].items()}
    worst, on = max(errors, key=lambda one: errors[one])
    leave = "leaves" if len(lacking) == 1 else "leave"
    return [
        f"{len(lacking)} of {plural(tried, 'engine')} {leave} out the gyroscopic torque as shipped "
        f"({', '.join(lacking)}): no free body tumbles, and ω is up to "
        f"{errors[worst, on]:.0%} off, with {worst} on {on}"
    ]
