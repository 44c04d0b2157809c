"""The cheapest method and timestep that are accurate enough on a scene.

A best choice is one of the runs; a candidate's timestep may lie between those of two runs.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from scipy.spatial.transform import Rotation

from ....scenarios import SIGNAL, Errors, errors_between
from ...harness.judging.ladder_end import GOAL
from ...results.records import Key, Row
from ...results.results import SceneResult
from .cost_to_reach import Barrier, How, reach
from .report_data import MethodRuns, SceneRuns
from .rounding_bias import rounding_bias
from .wording import rounded_down
from .work_precision import cost, curve_of

#: The largest error allowed in each signal, by its name: attitude in rad, others relative.
ErrorBounds = Mapping[str, float]


@dataclass(frozen=True)
class Candidate:
    """A method, with the timestep and cost that it needs to stay within every error bound.

    Attributes
    ----------
    key : scene, engine and method
    word, reason : how timestep and cost are known, or why a bound is out of reach, in one word and
        in a sentence
    decided_by : the signal whose bound needs the smallest timestep, or cannot be reached
    largest_stable : the longest timestep of the ladder, s, such that runs at that and at all
        shorter timesteps ended `ok`; None if the finest run did not
    finest_useful : timestep below which the error in the signal `decided_by` grows by rounding, s;
        None if no run shows that
    bias : bias of the rounding, ulp of single precision a step; None if no bias is shown
    timestep : s; None if a bound is out of reach or no step was timed
    cost : CPU seconds for a simulated second at that timestep
    spread : largest minus least of the repeated timings of a step, relative to the least
    """

    key: Key
    word: How | Barrier
    reason: str
    decided_by: str
    largest_stable: float | None
    finest_useful: float | None = None
    bias: float | None = None
    timestep: float | None = None
    cost: float | None = None
    spread: float = 0.0

    @property
    def label(self) -> str:
        """Engine and method as users type them."""
        return self.key.label


def candidates(scene: SceneRuns, bounds: ErrorBounds) -> list[Candidate]:
    """Return the timestep and cost with which each method stays within all error bounds.

    The cheapest method comes first. Methods for which a bound is out of reach, or whose steps were
    not timed, come last. Two kinds of methods are left out: those as shipped, since they may
    simulate something else than the scene, and those that load users' model files. The scene must
    have been solved.

    Parameters
    ----------
    bounds : the largest error allowed in each signal: attitude in rad, others relative
    """
    offered = [runs for runs in scene.methods if runs.is_recommendable]
    offers = [_candidate(scene, runs, bounds) for runs in offered]
    return sorted(offers, key=lambda candidate: candidate.cost or math.inf)


def as_cheap(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the other candidates that cost no more than the first plus the spread of its timings.

    The list is empty if the first has no cost.

    Parameters
    ----------
    candidates : at least one, the cheapest first
    """
    best, *others = candidates
    if best.cost is None:
        return []
    limit = best.cost * (1 + best.spread)
    return [other for other in others if other.cost is not None and other.cost <= limit]


def _candidate(scene: SceneRuns, runs: MethodRuns, bounds: ErrorBounds) -> Candidate:
    """Return a method with the longest timestep at which it stays within every bound, and its cost.

    Timestep and cost are None if a bound is out of reach or no step was timed.
    """
    curves = {signal: curve_of(scene, runs, signal) for signal in bounds}
    reached = {signal: reach(curves[signal], bound) for signal, bound in bounds.items()}
    timesteps = {
        signal: reach_there.timestep if reach_there.timestep is not None else 0.0
        for signal, reach_there in reached.items()
    }
    signal = min(timesteps, key=lambda name: timesteps[name])
    curve, reach_there = curves[signal], reached[signal]
    key = Key(scene.name, runs.engine, runs.method)
    stable = curve.stable[0].timestep if curve.stable else None
    finest, bias, reason = curve.finest_useful, rounding_bias(runs), reach_there.reason
    if reach_there.word == "round-off" and bias is not None:
        reason += f"; its rounding is biased by {bias:.2g} ulp a step"
    candidate = Candidate(key, reach_there.word, reason, signal, stable, finest, bias)
    if not timesteps[signal] or curve.seconds_per_step is None:
        return candidate
    spread = next((row.seconds_spread for row in reversed(runs.rows) if row.seconds_spread), 0.0)
    return replace(
        candidate,
        timestep=timesteps[signal],
        cost=reach_there.cost,
        spread=spread / curve.seconds_per_step,
    )


def finest_useful(scene: SceneRuns, runs: MethodRuns) -> float | None:
    """Return the timestep, s, below which a method's errors of attitude or ω grow by rounding.

    The longer of the timesteps for attitude and for ω is returned. It is None if no run shows
    growing errors, if these stay below `GOAL`, or if the scene could not be solved.
    """
    if scene.solved is None:
        return None
    curves = [curve_of(scene, runs, signal) for signal in BOUNDS]
    grown = (one for one in curves if one.points and one.points[-1].error > GOAL)
    return max(filter(None, (one.finest_useful for one in grown)), default=None)


#: Bounds on the errors of a best choice: of attitude, rad; of ω, relative to its largest value.
ATTITUDE_WITHIN, OMEGA_WITHIN = math.radians(0.1), 1e-3
#: A motion tells good methods from bad ones if a body that rotates uniformly from the same start
#: has an error that is larger than a bound by this factor.
TELLING = 10.0
BOUNDS: ErrorBounds = {"attitude": ATTITUDE_WITHIN, "omega": OMEGA_WITHIN}


@dataclass(frozen=True, eq=False)
class BestChoice:
    """The cheapest run on a scene whose errors are within `BOUNDS`, or else the most accurate run.

    Attributes
    ----------
    runs : all runs of the method
    row : the run itself
    cost : CPU seconds for a simulated second; None if nothing was timed
    within : whether the run's errors are within `BOUNDS`
    finest_useful : timestep below which the method's errors grow by rounding, s; None if no run
        shows that
    """

    runs: MethodRuns
    row: Row
    cost: float | None
    within: bool
    finest_useful: float | None = None

    @property
    def timestep(self) -> float:
        """The run's timestep, s, as users type it: `to_type` rounds it unless it is a stock one."""
        timestep = self.row.timestep
        return timestep if self.row.stock else to_type(timestep, self.finest_useful)

    @property
    def setup(self) -> str:
        """What users write to set method and timestep; empty if the adapter does not state it."""
        return self.runs.setup(self.timestep)


def best_choice(scene: SceneRuns) -> BestChoice | None:
    """Return the best run on a scene, the first of `best_choices`; None if there is none."""
    return next(iter(best_choices(scene)), None)


def best_choices(scene: SceneRuns) -> list[BestChoice]:
    """Return the best choice of each engine, the best of all first.

    A best choice is the cheapest run within `BOUNDS` by a method that converges. If an engine has
    no such run, it is the most accurate run by such a method. There are no best choices if the
    scene could not be solved, or if its motion does not tell methods apart (`steady`).

    Methods as shipped, methods that load users' model files, and runs that are no better than no
    motion are left out. Runs that were not timed are left out if any run was timed.
    """
    if scene.solved is None or steady(scene.solved, BOUNDS):
        return []
    tried = [
        BestChoice(runs, row, cost(row), _within(scene, row))
        for runs in scene.methods
        if runs.verdict and runs.verdict.verdict == "converges" and runs.is_recommendable
        for row in runs.rows
        if row.survived and row.errors
    ]
    tried = [one for one in tried if one.cost is not None] or tried
    first: dict[str, BestChoice] = {}
    for one in sorted(tried, key=_rank):
        first.setdefault(one.runs.engine, one)
    return [replace(one, finest_useful=finest_useful(scene, one.runs)) for one in first.values()]


def to_type(timestep: float, finest: float | None) -> float:
    """Return a timestep, s, rounded down to two digits, as users type it.

    If the timestep is at least `finest` but the rounded one is below that, `finest` is returned.

    Parameters
    ----------
    finest : timestep below which errors grow by rounding, s; None if that is not known
    """
    shorter = rounded_down(timestep)
    return finest if finest is not None and shorter < finest <= timestep else shorter


def steady(solved: SceneResult, bounds: ErrorBounds) -> str:
    """Return why a scene's motion does not tell good methods from bad ones; empty if it does.

    It does not if a trivial forecast has errors of at most `TELLING` times the bounds. In the
    forecast, the body keeps the ω and the velocity that it has at the start. Its errors are
    compared with the bounds on attitude and ω; a bound that is not given is taken from `BOUNDS`. If
    bounds are given only for the com, its velocity or both, the errors in these are compared
    instead. On skill relative to a trivial forecast see A. H. Murphy, Mon. Wea. Rev. 116 (1988)
    2417.

    Parameters
    ----------
    bounds : the largest error allowed in each signal: attitude in rad, others relative
    """
    errors = _errors_of_uniform_motion(solved)
    if bounds and bounds.keys() <= {"com", "velocity"}:
        limits, forecast = bounds, "com that went on at its velocity at the start"
    else:
        limits = {name: bounds.get(name, bound) for name, bound in BOUNDS.items()}
        forecast = "body that went on turning as at the start, at a constant rate about an axis "
        forecast += "that stays,"
    worst = max(limits, key=lambda name: errors[name] / limits[name])
    if errors[worst] > TELLING * limits[worst]:
        return ""
    off = within_in_words({worst: errors[worst]})
    return (
        f"a {forecast} would be off by {off} at worst, so that the motion does not tell methods "
        "apart"
    )


def nothing_because(scene: SceneRuns) -> str:
    """Return a sentence on why nothing is recommended on a scene that has no best choice."""
    reason = steady(scene.solved, BOUNDS) if scene.solved else "its exact motion is not known"
    return f"Nothing is recommended: {reason or 'no method converges on this scene'}."


def within_in_words(bounds: ErrorBounds) -> str:
    """Return bounds or errors as text for users, such as "0.1° in attitude and 0.001 in ω"."""
    parts = []
    for name, bound in bounds.items():
        size = f"{math.degrees(bound):.3g}°" if SIGNAL[name].unit else f"{bound:.3g}"
        parts.append(f"{size} in {SIGNAL[name].label}")
    return " and ".join(parts)


def _errors_of_uniform_motion(solved: SceneResult) -> Errors:
    """Return the errors of a body that keeps the ω and the velocity that it has at the start."""
    exact = solved.solution.trajectory
    omega, velocity = (
        one[:1].repeat(len(exact.t), axis=0) for one in (exact.omega_body, exact.velocity_world)
    )
    attitudes = exact.R_world_body[0] * Rotation.from_rotvec(omega * exact.t[:, None])
    uniform = replace(
        exact,
        q_world_body_wxyz=attitudes.as_quat(scalar_first=True),
        omega_body=omega,
        com_world=exact.com_world[0] + velocity * exact.t[:, None],
        velocity_world=velocity,
    )
    return errors_between(solved.scenario, uniform, exact)


def _rank(one: BestChoice) -> tuple[bool, float, float]:
    """Return a sort key, by which choices within the bounds come first.

    Those are sorted by cost, and at equal cost by timestep, the longest first; the others are
    sorted by attitude error.
    """
    assert one.row.errors is not None, "only a run with errors is chosen"
    if one.within:
        return False, one.cost or 0.0, -one.row.timestep
    return True, one.row.errors.attitude, 0.0


def _within(scene: SceneRuns, row: Row) -> bool:
    """Whether a run's errors are within `BOUNDS`.

    Errors below the uncertainty of the reference are taken to be as large as the uncertainty.
    """
    assert row.errors is not None, "only a run with errors is chosen"
    limits = scene.uncertainty(row)
    return all(max(row.errors[name], limits[name]) <= bound for name, bound in BOUNDS.items())
