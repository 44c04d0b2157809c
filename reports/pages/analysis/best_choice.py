"""The cheapest run of a scene that is accurate enough, of all engines and of each."""

import math
from dataclasses import dataclass, replace

from scipy.spatial.transform import Rotation

from ....scenarios import SIGNAL, Errors, errors_between
from ...results.records import Row
from ...results.store import SceneResult
from .candidates import ErrorBounds
from .report_data import MethodRuns, SceneRuns
from .wording import number, rounded_down
from .work_precision import cost

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
    """Those within the bounds first, by cost and the longest timestep; the others by error."""
    assert one.row.errors is not None, "only a run with errors is chosen"
    if one.within:
        return False, one.cost or 0.0, -one.row.timestep
    return True, one.row.errors.attitude, 0.0


def _within(scene: SceneRuns, row: Row) -> bool:
    assert row.errors is not None, "only a run with errors is chosen"
    limits = scene.uncertainty(row)
    return all(max(row.errors[name], limits[name]) <= bound for name, bound in BOUNDS.items())
