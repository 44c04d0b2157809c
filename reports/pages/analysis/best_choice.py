"""The cheapest that is accurate enough: of a scene's runs, and of the timesteps between them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from scipy.spatial.transform import Rotation

from ....scenarios import SIGNAL, Errors, errors_between
from ...results.records import Key, Row
from ...results.results import SceneResult
from .cost_to_reach import Barrier, How, reach
from .report_data import MethodRuns, SceneRuns
from .wording import number, rounded_down
from .work_precision import Curve, cost, curve_of

ErrorBounds = Mapping[str, float]


@dataclass(frozen=True)
class Candidate:
    """One method, and the timestep and cost it needs to stay within every bound.

    Attributes
    ----------
    word, reason : how that is known, or why it is out of reach, for the deciding bound
    decided_by : the error whose bound needs the smallest timestep, or cannot be reached
    largest_stable : s, the coarsest timestep from which all finer ones ended well
    finest_useful : s, below which errors of some bound grow, as rounding makes them; None where
        no run shows that
    timestep : s; None where out of reach
    cost : CPU seconds a simulated second at that timestep
    spread : of the timings of a step, relative
    """

    key: Key
    word: How | Barrier
    reason: str
    decided_by: str
    largest_stable: float | None
    finest_useful: float | None = None
    timestep: float | None = None
    cost: float | None = None
    spread: float = 0.0

    @property
    def label(self) -> str:
        """As users type it."""
        return self.key.label


def candidates(scene: SceneRuns, bounds: ErrorBounds) -> list[Candidate]:
    """Timestep and cost of each method for staying within all bounds, the cheapest first.

    Engines as shipped are left out, since they may simulate something else than the scene, and so
    are other readers of models.
    """
    offered = [runs for runs in scene.methods if runs.is_recommendable]
    offers = [_candidate(scene, runs, bounds) for runs in offered]
    return sorted(offers, key=lambda candidate: candidate.cost or math.inf)


def as_cheap(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The candidates whose cost differs from the first's by less than the spread of the timings."""
    best, *others = candidates
    if best.cost is None:
        return []
    limit = best.cost * (1 + best.spread)
    return [other for other in others if other.cost is not None and other.cost <= limit]


def _candidate(scene: SceneRuns, runs: MethodRuns, bounds: ErrorBounds) -> Candidate:
    """The smallest of the timesteps that the bounds ask for, or the first bound out of reach."""
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
    finest = _finest(curves.values())
    candidate = Candidate(key, reach_there.word, reach_there.reason, signal, stable, finest)
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
    """The timestep, s, below which errors of attitude or ω grow; None where no run shows that."""
    if scene.solved is None:
        return None
    return _finest(curve_of(scene, runs, signal) for signal in BOUNDS)


def _finest(curves: Iterable[Curve]) -> float | None:
    return max((one.least.timestep for one in curves if one.least), default=None)


#: Bounds of a best choice: attitude in rad; ω, relative to its largest.
ATTITUDE_WITHIN, OMEGA_WITHIN = math.radians(0.1), 1e-3
#: A motion tells methods apart if turning on at a constant rate misses a bound by this factor.
TELLING = 10.0
BOUNDS: ErrorBounds = {"attitude": ATTITUDE_WITHIN, "omega": OMEGA_WITHIN}


@dataclass(frozen=True, eq=False)
class BestChoice:
    """The cheapest run of a scene that is accurate enough.

    Attributes
    ----------
    cost : CPU seconds a simulated second; None where nothing was timed
    within : whether it is accurate enough; if not, it is the most accurate run
    """

    runs: MethodRuns
    row: Row
    cost: float | None
    within: bool

    @property
    def timestep(self) -> float:
        """What to type, s: that of the run, or a little less; stock timesteps are as they are."""
        return self.row.timestep if self.row.stock else rounded_down(self.row.timestep)

    @property
    def setup(self) -> str:
        """As of `MethodRuns`."""
        return self.runs.setup(self.timestep)


def best_choice(scene: SceneRuns) -> BestChoice | None:
    """The first of `best_choices`; None if there is none."""
    return next(iter(best_choices(scene)), None)


def best_choices(scene: SceneRuns) -> list[BestChoice]:
    """The best choice of each engine, the best of all first; none where the motion is `steady`.

    That is the cheapest run within `BOUNDS`, of methods that converge, or if there is none the most
    accurate run. Engines as shipped, and other readers of models, are left out; so are untimed runs
    if any run was timed.
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
    return list(first.values())


def steady(solved: SceneResult, bounds: ErrorBounds) -> str:
    """Why a scene tells nothing about methods; empty if it does.

    That is where a body that went on turning as at the start, at a constant rate about an axis that
    stays, would be within `TELLING` times the bounds of attitude and ω, or `BOUNDS` if these have
    none: a trivial forecast with little less skill (A. H. Murphy, Mon. Wea. Rev. 116 (1988) 2417).
    """
    errors = _errors_of_uniform_rotation(solved)
    if any(errors[name] > TELLING * bounds.get(name, bound) for name, bound in BOUNDS.items()):
        return ""
    off = number(math.degrees(errors.attitude), 2)
    return (
        "a body that went on turning as at the start, at a constant rate about an axis that stays, "
        f"would be {off}° off at worst, so that the motion does not tell methods apart"
    )


def nothing_because(scene: SceneRuns) -> str:
    """Why nothing is recommended on a scene, in a sentence."""
    reason = steady(scene.solved, BOUNDS) if scene.solved else "its exact motion is not known"
    return f"Nothing is recommended: {reason or 'no method converges on this scene'}."


def within_in_words(bounds: ErrorBounds) -> str:
    """Bounds as users read them: 0.1° in attitude and 10⁻³ in ω."""
    parts = []
    for name, bound in bounds.items():
        size = f"{math.degrees(bound):.3g}°" if SIGNAL[name].unit else f"{bound:g}"
        parts.append(f"{size} in {SIGNAL[name].label}")
    return " and ".join(parts)


def _errors_of_uniform_rotation(solved: SceneResult) -> Errors:
    exact = solved.solution.trajectory
    omega = exact.omega_body[:1].repeat(len(exact.t), axis=0)
    attitudes = exact.R_world_body[0] * Rotation.from_rotvec(omega * exact.t[:, None])
    q = attitudes.as_quat(scalar_first=True)
    uniform = replace(exact, q_world_body_wxyz=q, omega_body=omega)
    return errors_between(solved.scenario, uniform, exact)


def _rank(one: BestChoice) -> tuple[bool, float, float]:
    """The key to sort candidates by: those within the bounds by cost, then the others by error."""
    assert one.row.errors is not None, "only a run with errors is chosen"
    if one.within:
        return False, one.cost or 0.0, -one.row.timestep
    return True, one.row.errors.attitude, 0.0


def _within(scene: SceneRuns, row: Row) -> bool:
    assert row.errors is not None, "only a run with errors is chosen"
    limits = scene.uncertainty(row)
    return all(max(row.errors[name], limits[name]) <= bound for name, bound in BOUNDS.items())
