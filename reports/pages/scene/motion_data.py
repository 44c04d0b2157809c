"""The motions of a scene in the compact form in which its page carries them.

The page's player shows them, and its figures of β(t) and ω(t). Attitudes and rates are rounded to
what a picture shows. Errors are computed here, from the unrounded numbers of the result file, and
carried as logarithms.
"""

import math
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray, Trajectory
from ...results.records import Row
from ...results.results import SceneResult
from ..analysis.report_data import Compared, SceneRuns
from ..analysis.wording import duration
from ..figures.drawn_body import drawn_body
from ..figures.plot import claimed, thinned
from ..page_data import Differences, differenced

#: Largest number of samples of the exact motion, and of a run, that a page carries: its size grows
#: with each.
EXACT_SAMPLES, RUN_SAMPLES = 600, 200
#: Largest number of samples of all runs of a page together.
PAGE_SAMPLES = 4400
#: Numbers of samples for each turn at the fastest rate, of the exact motion and of runs, with which
#: the lines that the page's script draws look smooth.
EXACT_A_TURN, RUN_A_TURN = 16, 6
#: Least number of samples, for a motion of few turns.
LEAST_SAMPLES = 60
#: Number of turns, from the start on, that paths in space show if the whole motion would need more
#: than `EXACT_SAMPLES` samples.
FIRST_TURNS = 20
#: Attitude error up to which a run looks like the exact motion, and is drawn as that, rad.
INVISIBLE = 1e-3
#: Attitude error beyond which a run is noticeably off, rad.
NOTICEABLE = math.radians(1.0)
#: Steps to which components of quaternions are rounded, for the exact motion and for runs. In a
#: figure whose axis spans one degree, the rounding of runs moves a line by about a pixel.
EXACT_STEP, RUN_STEP = 2.0**-16, 2.0**-13
#: Steps to which components of ω are rounded, in units of the exact motion's fastest rate.
EXACT_OMEGA_STEP, RUN_OMEGA_STEP = 2.0**-15, 2.0**-12
#: Step to which common logarithms of errors are rounded, which changes errors by 1.2 % at most; and
#: the least logarithm that is carried.
DECADES_STEP, LOWEST_DECADE = 0.01, -20.0


def motion_data(scene: SceneRuns) -> dict[str, Any] | None:
    """Return the data from which the page's script draws a scene's motions.

    They are the `body`; the end of the exact motion, s, as `duration`; its largest ‖ω‖, rad/s, as
    `fastest`; the `noticeable` attitude error, degrees; the `exact` motion, and for a long one its
    `beginning` with more samples a turn; the `runs`, and the index of the one played `first`. None
    is returned if the scene could not be solved.
    """
    solved = scene.solved
    if solved is None:
        return None
    end, turns = scene.end, scene.turns
    exact = scene.outline(end, _samples_for(scene, EXACT_SAMPLES, EXACT_A_TURN))
    fastest = float(np.linalg.norm(exact.omega_body, axis=1).max()) or 1.0
    data = {
        "body": _body(solved),
        "duration": end,
        "fastest": fastest,
        "noticeable": math.degrees(NOTICEABLE),
        "exact": _exact_states(exact, fastest),
        "runs": [_run(run, scene, fastest) for run in scene.compared],
        "first": _first(scene),
    }
    if turns * EXACT_A_TURN > EXACT_SAMPLES:
        first = scene.outline(end * FIRST_TURNS / turns, FIRST_TURNS * EXACT_A_TURN + 1)
        data["beginning"] = _exact_states(first, fastest)
    return data


def _first(scene: SceneRuns) -> int:
    """Return the index, in `scene.compared`, of the run that the page plays first.

    Among the runs of engines as shipped, each at its longest stock timestep that is drawn, it is
    the one with the least attitude error. The index is 0 if there is no such run.
    """
    shipped = [
        (float(run.series["attitude"].max()), k)
        for k, run in enumerate(scene.compared)
        if run.runs.as_shipped and run.row is run.runs.drawn[0]
    ]
    return min(shipped, default=(0.0, 0))[1]


def noticeable_from(run: Compared) -> float | None:
    """Return when, s, a run's attitude error first exceeds `NOTICEABLE`; None if it never does."""
    beyond = np.flatnonzero(run.series["attitude"] > NOTICEABLE)
    return float(run.motion.t[beyond[0]]) if len(beyond) else None


def run_name(row: Row) -> str:
    """Return engine, method and timestep of a run in words."""
    return f"{row.key.label} at {duration(row.timestep)}"


def _body(solved: SceneResult) -> dict[str, Any]:
    """Return the body for the page's script: the attributes of `DrawnBody`, com, inertia, rotors.

    `com` is in body axes, m, and zero without a `pivot`; `inertia` is that of the `Scenario`; and
    `kept` is the rotors' constant angular momentum at t = 0, body axes, kg m²/s.
    """
    scenario, drawn = solved.scenario, drawn_body(solved)
    return {
        "shape": drawn.shape,
        "half_sides": drawn.half_sides.tolist(),
        "R_body_axes": drawn.R_body_axes.tolist(),
        "axis": drawn.axis_body.tolist(),
        "up": drawn.up_world.tolist(),
        "up_means": drawn.up_means,
        "com": scenario.body.com.tolist() if scenario.constraint.is_pivot else [0.0, 0.0, 0.0],
        "inertia": scenario.inertia.tolist(),
        "kept": scenario.kept_body(scenario.kept_at_start).tolist(),
        "pivot": scenario.constraint.is_pivot,
    }


def _run(run: Compared, scene: SceneRuns, fastest: float) -> dict[str, Any]:
    """Return a run's motion and errors for the page's script.

    They are names and style; how and when the run ended; when it was `noticed` to be wrong; and, at
    the samples that the page carries, times, errors and defects as `Differences`. The motion is
    left out if the run is `ok` and its attitude errors are at most `INVISIBLE`.

    Parameters
    ----------
    fastest : the largest ‖ω‖ of the exact motion, rad/s
    """
    uncertainty, style = scene.exact.solution.uncertainty, run.runs.style
    attitude = claimed(run.series["attitude"], uncertainty.attitude)
    omega = claimed(run.series["omega"], uncertainty.omega)
    fair = PAGE_SAMPLES // len(scene.compared)
    most = min(fair, _samples_for(scene, RUN_SAMPLES, RUN_A_TURN))
    kept = _kept(run, most, attitude, omega)
    data: dict[str, Any] = {
        "label": run.runs.label,
        "name": run_name(run.row),
        # Plotly interprets some HTML, so names are escaped.
        "hover": escape(run_name(run.row), quote=False),
        "outcome": run.row.outcome,
        "stopped_at": run.row.stopped_at,
        "look": [style.colour, style.dash],
        "noticed": noticeable_from(run),
        # Samples are at whole numbers of steps, so that times follow from step counts.
        "t": differenced(run.motion.t[kept], run.row.timestep),
        "attitude": _decades(attitude[kept]),
        "omega": _decades(omega[kept]),
        "defect": _decades(claimed(_largest_since(run.defect, kept), 0.0)),
        # Nothing smaller than the uncertainty is claimed.
        "uncertainty": uncertainty.attitude,
    }
    if run.series["attitude"].max() > INVISIBLE or run.row.outcome != "ok":
        data |= _states(run.motion, kept, RUN_STEP, RUN_OMEGA_STEP * fastest)
    return data


def _kept(run: Compared, most: int, attitude: FloatArray, omega: FloatArray) -> NDArray[np.intp]:
    """Return the indices of the samples of a run that the page carries.

    They are evenly spread; in addition there are the samples with the largest errors of attitude
    and of ω, and the first sample with a noticeable attitude error.

    Parameters
    ----------
    most : largest number of evenly spread samples
    attitude, omega : errors at the samples, (n,)
    """
    kept = set(thinned(len(run.motion.t), most).tolist())
    kept |= {
        int(np.nanargmax(errors)) for errors in (attitude, omega) if not np.isnan(errors).all()
    }
    kept |= set(np.flatnonzero(run.series["attitude"] > NOTICEABLE)[:1].tolist())
    return np.array(sorted(kept), dtype=np.intp)


def _largest_since(values: FloatArray, kept: NDArray[np.intp]) -> FloatArray:
    """Return, for each kept sample, the largest value from after the previous one up to it, (m,).

    The first is NaN, as no kept sample comes before it.

    Parameters
    ----------
    values : values at all samples, (n,)
    kept : indices of the kept samples, ascending, (m,)
    """
    largest = np.fmax.reduceat(values, kept[:-1] + 1) if len(kept) > 1 else values[:0]
    return np.append(np.nan, largest)


def _samples_for(scene: SceneRuns, most: int, a_turn: int) -> int:
    """Return the number of samples that a motion needs, which grows with its number of turns.

    Parameters
    ----------
    most : largest number of samples that is returned
    a_turn : number of samples for each turn at the fastest rate
    """
    return int(min(most, max(LEAST_SAMPLES, math.ceil(a_turn * scene.turns))))


def _exact_states(motion: Trajectory, fastest: float) -> dict[str, Any]:
    """Return the exact motion for the page's script; `fastest` is its largest ‖ω‖, rad/s.

    The entries are `q`, `omega_body` (see `_states`) and the times `t`, s, as `Differences`.
    """
    samples = np.arange(len(motion.t))
    states = _states(motion, samples, EXACT_STEP, EXACT_OMEGA_STEP * fastest)
    # The times are evenly spread, so that their differences take almost no space.
    return states | {"t": differenced(motion.t, float(motion.t[-1]) / samples[-1])}


def _states(
    motion: Trajectory, kept: NDArray[np.intp], step: float, omega_step: float
) -> dict[str, Any]:
    """Return the components of attitude, `q`, w x y z, and of ω, `omega_body`, rad/s, body axes.

    Each component is a `Differences` of m numbers.

    Parameters
    ----------
    kept : indices of the samples that are returned, (m,)
    step, omega_step : steps to which components of quaternions, and of ω, rad/s, are rounded
    """
    q = _continuous(motion.q_world_body_wxyz[kept])
    return {
        "q": [differenced(component, step) for component in q.T],
        "omega_body": [differenced(part, omega_step) for part in motion.omega_body[kept].T],
    }


def _continuous(q: FloatArray) -> FloatArray:
    """Return quaternions, (n, 4), with their signs chosen so that each is close to the previous."""
    flips = np.cumsum(np.einsum("ij,ij->i", q[1:], q[:-1]) < 0)
    return np.asarray(q * np.where(np.append(0, flips) % 2, -1.0, 1.0)[:, None])


def _decades(errors: FloatArray) -> Differences:
    """Return common logarithms of errors, (n,), none below `LOWEST_DECADE`, as `Differences`."""
    with np.errstate(divide="ignore"):
        return differenced(np.maximum(np.log10(errors), LOWEST_DECADE), DECADES_STEP)
