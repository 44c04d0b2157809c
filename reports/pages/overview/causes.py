"""Why defaults are wrong: the timestep, settings that alter the motion, a term left out.

Without ω × I ω the angular velocity of a free body keeps its direction in space, however the body
tumbles. A damping shortens ω but does not turn it either.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from ....scenarios import Trajectory
from ...results.records import Pair, Row
from ...results.verdict_words import VERDICT
from ..analysis.report_data import ReportData, SceneRuns
from ..analysis.wording import plural

#: rad; a scene is used if its exact ω turns by more in space.
TELLING = 0.2
#: A run lacks the torque if its ω turns by less than this fraction of that.
STEADY = 0.02


def without_gyroscopic_torque(gathered: ReportData) -> tuple[dict[str, dict[str, float]], int]:
    """The engines as shipped that lack it on every scene used, and the number of engines.

    Of each the largest relative error of ω, by scene: ω keeps its direction, the exact ω does not.
    """
    lacking: dict[Pair, dict[str, float]] = {}
    has_it: set[Pair] = set()
    for scene in gathered.scenes:
        if scene.solved is None or scene.solved.scenario.called_for - {"gravity"}:
            continue
        for run in scene.compared:
            shipped = run.runs.declared is not None and run.runs.declared.as_shipped
            if not shipped or turned_in_space(run.exact) < TELLING:
                continue
            if turned_in_space(run.motion) < STEADY * turned_in_space(run.exact):
                lacking.setdefault(run.runs.pair, {})[scene.name] = float(run.series["omega"].max())
            else:
                has_it.add(run.runs.pair)
    engines = {engine for engine, _ in {*lacking, *has_it}}
    first = {pair[0]: errors for pair, errors in lacking.items() if pair not in has_it}
    return dict(sorted(first.items())), len(engines)


def turned_in_space(motion: Trajectory) -> float:
    """The largest angle between ω and ω at the start, in space, rad; 0 for a body at rest."""
    omega_world = motion.to_world(motion.omega_body)
    start = omega_world[0]
    across = np.linalg.norm(np.cross(omega_world, start), axis=1)
    return float(np.arctan2(across, omega_world @ start).max())


#: A cause is given for a default if it holds on at least this fraction of the scenes it gets wrong.
COMMON = 0.1


def why(
    pair: Pair, rows: Mapping[str, Row], scenes: Sequence[SceneRuns], harmless: Collection[str]
) -> str:
    """The reason of the errors: the timestep, or defaults of the engine; empty if none is known."""
    verdicts = {
        scene.name: runs.verdict.verdict
        for scene in scenes
        if (runs := scene.by_pair.get(pair)) and runs.verdict
        if (kind := VERDICT[runs.verdict.verdict]).needs_reason or kind.word == "converges"
    }
    wrong = [
        name
        for name, word in verdicts.items()
        if VERDICT[word].needs_reason and word != "unresolved"
    ]
    if not verdicts:
        return ""
    name = " ".join(pair)
    good = sum(word == "converges" for word in verdicts.values())
    if not wrong and not good:
        return f"{name} was run at timesteps too long for a verdict on all its scenes"
    if not wrong:
        open_ = len(verdicts) - good
        left = f" (on {open_} its timesteps were too long for a verdict)" if open_ else ""
        scenes_tried = plural(len(verdicts), "scene")
        return (
            f"{name} converges to the exact motion on {good} of {scenes_tried} as its "
            f"timestep shrinks{left}: its errors are those of its integrator"
        )
    scenes_tried = plural(len(verdicts), "scene")
    text = f"{name} does not converge on {len(wrong)} of {scenes_tried}, however short the timestep"
    wrong_scenes = [scene for scene in scenes if scene.name in wrong]
    causes = _by_each_default(pair, wrong_scenes) or _acting(rows, wrong, harmless)
    return text + (f": {causes}" if causes else "")


def _by_each_default(pair: Pair, scenes: Sequence[SceneRuns]) -> str:
    """The number of scenes on which each default alone causes an error of ω, if measured."""
    measured = [one for scene in scenes for one in scene.defaults if one.key.pair == pair]
    counted = Counter(one.name for effects in measured for one in effects.each if one.acts)
    listed = ", ".join(f"its {name} on {amount}" for name, amount in counted.most_common())
    return f"the equations of motion are altered by {listed}, each alone" if listed else ""


def _acting(rows: Mapping[str, Row], wrong: Sequence[str], harmless: Collection[str]) -> str:
    """What acted though not called for, as reported by the engine, and on how many scenes."""
    of_wrong = [rows[name] for name in wrong if name in rows]
    counted = Counter(cause for row in of_wrong for cause in dict.fromkeys(_unasked(row)))
    return ", ".join(
        f"{cause} ({amount})"
        for cause, amount in counted.most_common()
        if amount > COMMON * len(of_wrong) and cause.removeprefix("a ") not in harmless
    )


def _unasked(row: Row) -> Iterator[str]:
    # Measured sizes differ between scenes; names do not, so only names are counted.
    yield from (name for name in row.unasked if not any(map(str.isdigit, name)))
    if row.cause == "clamp":
        yield "a velocity clamp"


def no_gyroscopic_torque(gathered: ReportData) -> list[str]:
    """The engines that leave out the gyroscopic torque, and the effect; empty if none does."""
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
