"""The motions of a scene as its page carries them: compact, for the player and for θ(t), ω(t).

Attitudes and rates of runs are 16-bit integers: a picture needs no more. Errors are not read off
those: they are computed here from the doubles of the result file, and carried as logarithms.
"""

import base64
import math
from html import escape
from typing import Any

import numpy as np

from ...reference import ExactMotion
from ...scenarios import FloatArray, Trajectory
from ..results.records import Row
from ..results.store import SceneResult
from .analysis.report_data import Compared, SceneRuns
from .analysis.wording import duration
from .figures.drawn_body import drawn_body
from .figures.plot import claimed, peaks, thinned

#: Of the exact motion on a page, and of a run; a page grows with every one.
EXACT_SAMPLES, RUN_SAMPLES = 600, 200
#: Of all runs of a page together.
PAGE_SAMPLES = 4400
#: Samples a turn of the fastest rate, through which the page's script draws smooth lines.
EXACT_A_TURN, RUN_A_TURN = 10, 6
#: A motion of a few turns is not drawn with fewer.
LEAST_SAMPLES = 60
#: rad; a run that is never further off looks like the exact motion, and is drawn as that.
INVISIBLE = 1e-3
#: rad; from where on a run is told to be off.
NOTICEABLE = math.radians(1.0)
#: Integers of 16 bits, from −FULL to FULL.
FULL = 32767
#: Decades of errors, and into how many steps they are cut: 2 % each. The last number is a gap.
LOWEST_DECADE, HIGHEST_DECADE, GAP = -20.0, 10.0, 4095
DECADES_A_STEP = (HIGHEST_DECADE - LOWEST_DECADE) / (GAP - 1)


def motion_data(scene: SceneRuns) -> dict[str, Any] | None:
    """What the page's script draws motions from; None where the scene could not be solved."""
    solved = scene.solved
    if solved is None:
        return None
    samples = _samples_for(scene, EXACT_SAMPLES, EXACT_A_TURN)
    times = np.linspace(0.0, float(solved.solution.trajectory.t[-1]), samples)
    exact = ExactMotion(solved.scenario).outline(times)
    fastest = float(np.linalg.norm(exact.omega_body, axis=1).max())
    bases = _TimeBases()
    runs = [_run(run, scene, bases) for run in scene.compared]
    return {
        "body": _body(solved),
        "duration": float(times[-1]),
        "fastest": fastest,
        "noticeable": math.degrees(NOTICEABLE),
        "exact": {
            "t": bases.index(exact.t),
            "q": _base64(exact.q_world_body_wxyz.astype("<f4")),
            "omega_body": _base64((exact.omega_body / (fastest or 1.0)).astype("<f4")),
            "largest": fastest or 1.0,
        },
        "runs": runs,
        "first": _first(scene),
        "times": bases.packed,
    }


def _first(scene: SceneRuns) -> int:
    """Which run is played first: of engines as shipped at their own timesteps the least wrong."""
    shipped = [
        (float(run.series.attitude.max()), k)
        for k, run in enumerate(scene.compared)
        if run.runs.declared and run.runs.declared.as_shipped and run.row is run.runs.drawn[0]
    ]
    return min(shipped, default=(0.0, 0))[1]


def noticeable_from(run: Compared) -> float | None:
    """When a run's attitude is first off by more than `NOTICEABLE`, s; None if it never is."""
    beyond = np.flatnonzero(run.series.attitude > NOTICEABLE)
    return float(run.motion.t[beyond[0]]) if len(beyond) else None


def run_name(row: Row) -> str:
    """Engine, method and timestep, as one says them."""
    return f"{row.key.engine} {row.key.method} at {duration(row.timestep)}"


class _TimeBases:
    """Sample times, each kind once: runs of one timestep share them."""

    def __init__(self) -> None:
        self.packed: list[str] = []

    def index(self, times: FloatArray) -> int:
        packed = _base64(np.asarray(times, dtype="<f4"))
        if packed not in self.packed:
            self.packed.append(packed)
        return self.packed.index(packed)


def _body(solved: SceneResult) -> dict[str, Any]:
    scenario, drawn = solved.scenario, drawn_body(solved)
    inertia = scenario.body.inertia_origin if scenario.has_pivot else scenario.body.inertia_com
    return {
        "shape": drawn.shape,
        "half_sides": drawn.half_sides.tolist(),
        "R_body_axes": drawn.R_body_axes.tolist(),
        "axis": drawn.axis_body.tolist(),
        "up": drawn.up_world.tolist(),
        "up_means": drawn.up_means,
        "com": scenario.body.com.tolist() if scenario.has_pivot else [0.0, 0.0, 0.0],
        "inertia": inertia.tolist(),
        "pivot": scenario.has_pivot,
    }


def _run(run: Compared, scene: SceneRuns, bases: _TimeBases) -> dict[str, Any]:
    assert scene.solved is not None, "a run is compared with an exact motion"
    fair = PAGE_SAMPLES // len(scene.compared)
    kept = thinned(len(run.motion.t), min(fair, _samples_for(scene, RUN_SAMPLES, RUN_A_TURN)))
    series, uncertainty = run.series, scene.solved.solution.uncertainty
    style = run.runs.style
    data: dict[str, Any] = {
        "label": run.runs.label,
        "name": run_name(run.row),
        # Plotly takes some HTML for markup.
        "hover": escape(run_name(run.row), quote=False),
        "outcome": run.row.outcome,
        "stopped_at": run.row.stopped_at,
        "look": [style.colour, style.dash],
        "noticed": noticeable_from(run),
        "t": bases.index(run.motion.t[kept]),
        "attitude": _decades(claimed(peaks(series.attitude, kept), uncertainty.attitude)),
        "omega": _decades(claimed(peaks(series.omega, kept), uncertainty.omega)),
    }
    if series.attitude.max() > INVISIBLE or run.row.outcome != "ok":
        data |= _states(run.motion, kept)
    return data


def _samples_for(scene: SceneRuns, most: int, a_turn: int) -> int:
    """As many as the turns in the window take."""
    assert scene.solved is not None, "a scene that was solved has a fastest rate"
    turns = scene.fastest_rate * float(scene.solved.solution.trajectory.t[-1]) / (2 * math.pi)
    return int(min(most, max(LEAST_SAMPLES, math.ceil(a_turn * turns))))


def _states(motion: Trajectory, kept: Any = slice(None)) -> dict[str, Any]:
    """Quaternions, and ω in parts of its largest component, rad/s."""
    omega = motion.omega_body[kept]
    largest = float(np.abs(omega).max()) or 1.0
    return {
        "q": _base64(np.rint(FULL * motion.q_world_body_wxyz[kept]).astype("<i2")),
        "omega_body": _base64(np.rint(FULL * (omega / largest)).astype("<i2")),
        "largest": largest,
    }


def _decades(errors: FloatArray) -> str:
    """Logarithms of errors, 0 where there is none to speak of."""
    with np.errstate(divide="ignore"):
        decades = np.clip(np.log10(errors), LOWEST_DECADE, HIGHEST_DECADE) - LOWEST_DECADE
    steps = np.where(np.isnan(errors), GAP, np.rint(np.nan_to_num(decades) / DECADES_A_STEP))
    return _base64(steps.astype("<u2"))


def _base64(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
