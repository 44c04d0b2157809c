"""Judges a scene's run in an encoding by comparing it with the run of the unchanged scene."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .....engines import Engine, Run
from .....engines.encodings import Encoding
from .....reference import Solution
from .....scenarios import SIGNAL, Errors, ErrorSeries, Scenario, Trajectory, errors_between
from .....scenarios.agreement import ErrorNorm
from ....results.encoding_records import Beside, EncodingWord
from .bounds import rounding_bounds

#: Most halvings of the timestep by which a coarser scheme is distinguished from another motion.
MOST_HALVINGS = 5
#: If halving the timestep reduces a difference below this share, it is a truncation error: errors
#: of first order fall to a half.
FALLS = 0.75


@dataclass(frozen=True, eq=False)
class Pair:
    """The runs of an encoding and of the unchanged scene, at one timestep."""

    encoded: Run
    plain: Run


@dataclass(frozen=True, eq=False)
class Judge:
    """What the encodings of one scene and method are judged by.

    Attributes
    ----------
    solution : the exact motion at the samples of all runs
    at_halved : returns the pair of runs in an encoding with the timestep halved a number of times
    plain_of : the runs of the unchanged scene, by method
    """

    scenario: Scenario
    solution: Solution
    method: str
    engine: Engine
    at_halved: Callable[[Encoding, int], Pair]
    plain_of: Mapping[str, Run]

    def judged(self, encoding: Encoding, pair: Pair) -> Beside:
        """Return the word on an encoding, with its reason."""
        run, plain = pair.encoded, pair.plain
        motion, own = run.trajectory, plain.trajectory
        assert own is not None, "a scene that gives nothing to compare with is not judged"
        if run.outcome == "unsupported":
            return Beside("left out", run.reason)
        if run.outcome != "ok" or motion is None:
            at = "" if run.stopped_at is None else f"at {run.stopped_at:.3g} s: "
            return Beside("ends early", f"{run.outcome} {at}{run.reason}")
        apart = self._apart(motion, own)
        if run.cause == "read-back":
            reason = f"{run.reason}; ω by {SIGNAL['omega'].words(apart.omega)}"
            return Beside("other body", reason, apart)
        beyond = self._beyond(encoding, apart, run.steps)
        if not beyond:
            return Beside("same", "", apart)
        moves_as = self._moves_as(encoding, run)
        found, reason = self._with_the_timestep(encoding, pair, beyond)
        reason += self._nearer(motion, pair, beyond)
        return Beside(found, reason, apart, moves_as)

    def _apart(self, motion: Trajectory, own: Trajectory) -> Errors:
        norm = ErrorNorm(self.scenario, self.solution.trajectory)
        distances = norm.distances(norm.table(motion), norm.table(own))
        return ErrorSeries(norm.signals, distances).worst()

    def _beyond(self, encoding: Encoding, apart: Errors, steps: int) -> list[str]:
        """Return the signals in which motions are farther apart than rounding explains."""
        bounds = self._bounds(encoding, steps)
        return [name for name, bound in bounds.items() if not apart[name] <= bound]

    def _bounds(self, encoding: Encoding, steps: int) -> dict[str, float]:
        return rounding_bounds(self.scenario, encoding, self.solution, steps, self.engine)

    def _moves_as(self, encoding: Encoding, run: Run) -> str:
        """Return another method whose unchanged scene has this motion, up to rounding, or ""."""
        assert run.trajectory is not None
        for method, other in self.plain_of.items():
            if method == self.method or other.outcome != "ok" or other.trajectory is None:
                continue
            apart = self._apart(run.trajectory, other.trajectory)
            if not self._beyond(encoding, apart, run.steps):
                return method
        return ""

    def _with_the_timestep(
        self, encoding: Encoding, pair: Pair, beyond: list[str]
    ) -> tuple[EncodingWord, str]:
        """Return whether the difference falls with the timestep as the method's own error does."""
        first = before = now = self._sizes(pair, beyond)
        worst = max(beyond, key=lambda name: first[name][0])
        size = f"{SIGNAL[worst].label} by {SIGNAL[worst].words(first[worst][0])}"
        for halvings in range(1, MOST_HALVINGS + 1):
            halved = self.at_halved(encoding, halvings)
            if halved.encoded.outcome != "ok" or halved.plain.outcome != "ok":
                ended = halved.encoded.reason or halved.plain.reason
                return "open", f"{size}; at a shorter timestep: {ended}"
            before, now = now, self._sizes(halved, beyond)
            left = (
                f"{size}, {SIGNAL[worst].words(now[worst][0])} at {halved.encoded.timestep:.3g} s"
            )
            rounding = self._bounds(encoding, halved.encoded.steps)
            if all(now[n][0] <= max(FALLS * before[n][0], rounding[n]) for n in beyond):
                return "coarser", left
        # It does not: does the method's own error for the unchanged scene?
        falls = all(now[name][1] <= FALLS * before[name][1] for name in beyond)
        return ("differs" if falls else "open"), left

    def _nearer(self, motion: Trajectory, pair: Pair, beyond: list[str]) -> str:
        """Return the sentence that the unchanged scene has larger errors throughout, or ""."""
        errors = errors_between(self.scenario, motion, self.solution.trajectory)
        own = {name: size for name, (_, size) in self._sizes(pair, beyond).items()}
        if not all(errors[name] < own[name] for name in beyond):
            return ""
        worst = SIGNAL[max(beyond, key=lambda name: own[name])]
        here, there = worst.words(errors[worst.name]), worst.words(own[worst.name])
        return (
            f"; this description is nearer to the exact motion: off by {here} in {worst.label}, "
            f"the scene's own by {there}"
        )

    def _sizes(self, pair: Pair, names: list[str]) -> dict[str, tuple[float, float]]:
        """Return by signal how far the motions are apart, and the error for the unchanged scene."""
        encoded, plain = pair.encoded.trajectory, pair.plain.trajectory
        assert encoded is not None
        assert plain is not None
        apart = self._apart(encoded, plain)
        own = errors_between(self.scenario, plain, self.solution.trajectory)
        return {name: (apart[name], own[name]) for name in names}
