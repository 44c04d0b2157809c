"""A measured motion: its noise, and the start, tensor and mistakes of a gyroscope that fit it best.

The exact motion is fitted to all samples at once by maximum likelihood: their noise is taken to be
normal and independent. A number is added if the sum of squares falls by more than noise makes it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from ....reference.other_equations import OtherEquations, equations_of, follow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms, rotation_vectors
from .changes import ENTRIES, Change, com, fitted_tensor, resistance
from .fits import EVALUATIONS, LEVEL, NOWHERE, RANK, SMALL

#: rad that the body turns in the samples that are fitted first, and how many these are at least;
#: then twice as many, until it is all.
BEGINNING, FEWEST = 2.0, 12
#: Changes that are looked for at once, at most.
MOST = 3
#: Third and fourth differences of noise have a variance of so many times its own: Σ (m over k)².
OF_DIFFERENCES = {3: 20.0, 4: 70.0}
#: The latter's size over that of the former, √3.5 of noise alone; of what is smooth it is less than
#: the angle between two samples, which must be less than this.
ALTERNATES, NEAR = 1.4, 0.7
#: Noise that is not that of printed numbers is larger by this factor.
PRINTED = 50.0


@dataclass(frozen=True, eq=False)
class GyroscopeError:
    """A mistake of a gyroscope.

    Attributes
    ----------
    words : of numbers and their standard errors
    apply : what it makes of ω (n, 3) at times (n,), with its numbers
    count : of numbers, which are 0 where there is none
    """

    words: Callable[[FloatArray, FloatArray], str]
    apply: Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
    count: int


def plus_minus(numbers: FloatArray, errors: FloatArray, factor: float = 1.0) -> str:
    """Numbers with their standard errors."""
    numbers, errors = np.atleast_1d(numbers) * factor, np.atleast_1d(errors) * factor
    each = [f"{n:.5g} ± {e:.2g}" for n, e in zip(numbers, errors, strict=True)]
    return each[0] if len(each) == 1 else f"[{', '.join(each)}]"


GYROSCOPE = (
    GyroscopeError(
        lambda n, e: f"the gyroscope has a bias of {plus_minus(n, e)} rad/s",
        lambda omega, _, n: omega + n,
        3,
    ),
    GyroscopeError(
        lambda n, e: f"the gyroscope's axes read {plus_minus(1 + n, e)} times ω",
        lambda omega, _, n: omega * (1 + n),
        3,
    ),
    GyroscopeError(
        lambda n, e: (
            "the gyroscope's axes are turned against the body's by "
            f"{plus_minus(n, e, 180 / np.pi)}°"
        ),
        lambda omega, _, n: omega @ Rotation.from_rotvec(n).as_matrix(),
        3,
    ),
    GyroscopeError(
        lambda n, e: f"ω lags the attitude by {plus_minus(n, e)} s",
        lambda omega, t, n: omega - n * np.gradient(omega, t, axis=0),
        1,
    ),
)


@dataclass(frozen=True, eq=False)
class MeasuredFit:
    """What fits a measured motion best.

    Attributes
    ----------
    numbers, errors : of the start (6), then of each change, and their standard errors
    covariance : of all numbers
    left : what is left of each sample, in units of the noise, (n, 6)
    """

    added: tuple[Change | GyroscopeError, ...]
    numbers: FloatArray
    covariance: FloatArray
    left: FloatArray

    @property
    def errors(self) -> FloatArray:
        """(k,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def squares(self) -> float:
        """χ²."""
        return float(np.sum(self.left**2))


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured motion, and the noise that its numbers have.

    Attributes
    ----------
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    is_stated : whether the noise is, or was estimated
    has_omega : else only attitudes are fitted
    """

    scenario: Scenario
    motion: Trajectory
    exact: Trajectory
    noise: FloatArray
    is_stated: bool
    has_omega: bool

    @cached_property
    def equations(self) -> OtherEquations:
        """The scene's."""
        return equations_of(self.scenario)

    @cached_property
    def tensor(self) -> Change:
        """The scene's tensor with other numbers."""
        return fitted_tensor(self.equations)

    @cached_property
    def best(self) -> "tuple[Measured, MeasuredFit]":
        """The fit with all changes that the samples call for, and the noise that it is by."""
        measured, fit = self, self._fit(())
        if not self.is_stated:
            measured = self._with_noise_of(fit)
            fit = measured._fit((), fit.numbers)
        while len(fit.added) < MOST:
            better = measured._better(fit)
            if better is None:
                break
            fit = better
            if not self.is_stated:
                measured = measured._with_noise_of(fit)
                fit = measured._fit(fit.added, fit.numbers)
        return measured, fit

    @cached_property
    def with_tensor(self) -> MeasuredFit:
        """The best fit, with the tensor besides if that was not called for."""
        measured, fit = self.best
        if self.tensor in fit.added:
            return fit
        return measured._fit((*fit.added, measured.tensor), fit.numbers)

    @cached_property
    def freedom(self) -> int:
        """Numbers that were measured, less those that were fitted."""
        _, fit = self.best
        return (6 if self.has_omega else 3) * len(self.motion.t) - len(fit.numbers)

    @property
    def is_beyond(self) -> bool:
        """Whether more is left than the noise that is stated makes."""
        _, fit = self.best
        return self.is_stated and float(chi2.sf(fit.squares, self.freedom)) < LEVEL

    @property
    def verdict(self) -> str:
        """Whether what is left is noise, in a sentence."""
        measured, fit = self.best
        of, in_omega = np.degrees(measured.noise[0]), measured.noise[1]
        noise = f"a noise of {of:.3g}° in attitude"
        noise += f" and {in_omega:.3g} rad/s in ω" if self.has_omega else ""
        known = "stated" if self.is_stated else "estimated"
        ends = "beyond" if self.is_beyond else "within"
        return (
            f"{ends} {noise}, which is {known}: χ² is {fit.squares:.0f}, of {self.freedom} degrees "
            "of freedom"
        )

    def tensor_in_words(self) -> str:
        """The tensor that fits best, with standard errors, in a sentence."""
        free = "" if len(self.tensor.none) == len(ENTRIES) else ", up to a factor"
        entries = plus_minus(*self.tensor_entries())
        return f"The tensor Ixx, Iyy, Izz, Ixy, Ixz, Iyz that fits best is {entries} kg m²{free}."

    def as_record(self) -> dict[str, object]:
        """Noise, χ² and tensor, as JSON has them."""
        measured, fit = self.best
        entries, errors = self.tensor_entries()
        return {
            "noise": {"attitude": float(measured.noise[0]), "omega": float(measured.noise[1])},
            "noise_is_stated": self.is_stated,
            "chi2": fit.squares,
            "degrees_of_freedom": self.freedom,
            "tensor": entries.tolist(),
            "tensor_standard_error": errors.tolist(),
        }

    def explained(self) -> list[str]:
        """What the samples call for, in words."""
        measured, fit = self.best
        sentences, at = [], 6
        for one in fit.added:
            numbers, errors = _slice(fit.numbers, at, one), _slice(fit.errors, at, one)
            at += _count(one)
            if isinstance(one, GyroscopeError):
                sentences.append(one.words(numbers, errors))
            else:
                numbers, errors = one.none + one.sizes * numbers, one.sizes * errors
                sentences.append(f"it moves as if {one.words(numbers)} (± {_list(errors)})")
        off = fit.numbers[:6] - measured._scene_start()
        start = fit.covariance[:6, :6]
        if float(off @ np.linalg.pinv(start) @ off) > chi2.isf(LEVEL, 6):
            turned, faster = np.degrees(norms(off[None, :3])[0]), norms(off[None, 3:])[0]
            sentences.append(
                f"it started elsewhere: at t = {self.motion.t[0]:g} s the attitude is off by "
                f"{turned:.3g}° and ω by {faster:.3g} rad/s"
            )
        return sentences

    def tensor_entries(self) -> tuple[FloatArray, FloatArray]:
        """The tensor's entries Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg m², and their standard errors."""
        fit, tensor = self.with_tensor, self.best[0].tensor
        at = 6
        for one in fit.added:
            if one is tensor:
                break
            at += _count(one)
        x = _slice(fit.numbers, at, tensor)
        covariance = fit.covariance[at : at + len(x), at : at + len(x)]

        def entries(x: FloatArray) -> FloatArray:
            inertia = tensor.apply(self.equations, tensor.none + tensor.sizes * x).inertia
            return np.array([inertia[i, j] for i, j in ENTRIES])

        slopes = np.array([(entries(x + d) - entries(x)) / SMALL for d in SMALL * np.eye(len(x))]).T
        return entries(x), np.sqrt(np.diag(slopes @ covariance @ slopes.T))

    def _better(self, fit: MeasuredFit) -> MeasuredFit | None:
        """The fit with one more change that is least likely to fit as well by chance."""
        candidates = [one for one in self.candidates if one not in fit.added]
        found: tuple[float, MeasuredFit] | None = None
        for one in candidates:
            # Taken as linear first, which takes a tenth of the time.
            by_chance = float(chi2.isf(LEVEL / len(candidates), _count(one)))
            if self._falls_if_linear(fit, one) < by_chance / 2:
                continue
            other = self._fit((*fit.added, one), fit.numbers)
            beyond = fit.squares - other.squares - by_chance
            if beyond > (found[0] if found else 0.0):
                found = beyond, other
        return found and found[1]

    @cached_property
    def candidates(self) -> list[Change | GyroscopeError]:
        """Every change that is looked for."""
        found: list[Change | GyroscopeError] = [
            self.tensor,
            resistance(self.scenario, self.equations),
        ]
        found += com(self.scenario, self.equations)
        return found + list(GYROSCOPE if self.has_omega else ())

    def _falls_if_linear(self, fit: MeasuredFit, one: Change | GyroscopeError) -> float:
        added = (*fit.added, one)
        x = np.concatenate([fit.numbers, np.zeros(_count(one))])
        at = self._left(x, added, len(self.motion.t))
        J = np.array(
            [
                (self._left(x + d, added, len(self.motion.t)) - at) / SMALL
                for d in SMALL * np.eye(len(x))
            ]
        ).T
        best = np.linalg.lstsq(J, -at, rcond=RANK)[0]
        return float(at @ at - np.sum((at + J @ best) ** 2))

    def _with_noise_of(self, fit: MeasuredFit) -> "Measured":
        """The same with the noise that a fit leaves."""
        rows = fit.left * np.repeat(self.noise, 3)
        # Half of the numbers are taken by each.
        share = 1 - len(fit.numbers) / (fit.left.size if self.has_omega else fit.left.size / 2)
        found = np.sqrt(np.array([np.mean(part**2) for part in np.split(rows, 2, axis=1)]) / share)
        if not self.has_omega:
            found[1] = self.noise[1]
        kind = replace(self, noise=found)
        # What was added is told from what may be by being the same object.
        vars(kind).update(tensor=self.tensor, candidates=self.candidates)
        return kind

    def _scene_start(self) -> FloatArray:
        """The exact start, as numbers of a start."""
        q = [one.q_world_body_wxyz[:1] for one in (self.motion, self.exact)]
        turn = rotation_vectors(q[0], q[1])[0]
        return np.concatenate([turn, self.exact.omega_body[0] - self.motion.omega_body[0]])

    def _fit(
        self, added: Sequence[Change | GyroscopeError], x: FloatArray | None = None
    ) -> MeasuredFit:
        """Fit the start and the numbers of changes: from numbers, or from the beginning."""
        count = 6 + sum(map(_count, added))
        n = len(self.motion.t)
        lengths = [n]
        if x is None:
            x = np.zeros(0)
            turned = np.cumsum(norms(self.motion.omega_body)[1:] * np.diff(self.motion.t))
            length = max(FEWEST, int(np.searchsorted(turned, BEGINNING)))
            lengths = []
            while length < n:
                lengths.append(length)
                length *= 2
            lengths.append(n)
        x = np.concatenate([x, np.zeros(count - len(x))])
        for length in lengths:
            found = least_squares(
                self._left, x, args=(tuple(added), length), xtol=1e-10, max_nfev=EVALUATIONS
            )
            x = found.x
        J = np.asarray(found.jac)
        covariance = np.linalg.pinv(J.T @ J, RANK**2, hermitian=True)
        return MeasuredFit(tuple(added), x, covariance, found.fun.reshape(n, 6))

    def _left(
        self, x: FloatArray, added: Sequence[Change | GyroscopeError], length: int
    ) -> FloatArray:
        """What numbers leave of the first samples, in units of the noise, (6 length,)."""
        motion, equations, at = self.motion, self.equations, 6
        errors = []
        for one in added:
            numbers = _slice(x, at, one)
            at += _count(one)
            if isinstance(one, GyroscopeError):
                errors.append((one, numbers))
            else:
                equations = one.apply(equations, one.none + one.sizes * numbers)
        q = Rotation.from_quat(motion.q_world_body_wxyz[0], scalar_first=True)
        turned = (q * Rotation.from_rotvec(x[:3])).as_quat(scalar_first=True)
        start = np.concatenate([turned, motion.omega_body[0] + x[3:6]])[None]
        t = motion.t[:length]
        made = follow(equations, start, np.diff(t, prepend=t[0])[None])[0]
        omega = made[:, 4:]
        for error, numbers in errors:
            omega = error.apply(omega, t, numbers)
        off = np.zeros((length, 6))
        off[:, :3] = (
            rotation_vectors(made[:, :4], motion.q_world_body_wxyz[:length]) / self.noise[0]
        )
        if self.has_omega:
            off[:, 3:] = (motion.omega_body[:length] - omega) / self.noise[1]
        return np.clip(np.nan_to_num(off, nan=NOWHERE), -NOWHERE, NOWHERE).ravel()


def _count(one: Change | GyroscopeError) -> int:
    return one.count if isinstance(one, GyroscopeError) else len(one.none)


def _slice(x: FloatArray, at: int, one: Change | GyroscopeError) -> FloatArray:
    return x[at : at + _count(one)]


def _list(errors: FloatArray) -> str:
    return ", ".join(f"{error:.2g}" for error in errors)


def estimated_noise(
    scenario: Scenario, motion: Trajectory, floor: FloatArray, has_omega: bool
) -> FloatArray | None:
    """The noise of attitude, rad, and ω, rad/s, (2,); None where there is none to be seen.

    What samples gain beyond the exact flow from the sample before is smooth along a motion that was
    computed, whatever is wrong with it, and alternates along one that was measured.

    Parameters
    ----------
    floor : noise of the printed numbers, likewise
    """
    near = norms(motion.omega_body).max() * np.median(np.diff(motion.t)) < NEAR
    if len(motion.t) < FEWEST or not near:
        return None
    states = np.hstack([motion.q_world_body_wxyz, motion.omega_body])
    made = follow(equations_of(scenario), states[:-1], np.diff(motion.t)[:, None])[:, 0]
    gained = np.hstack(
        [rotation_vectors(made[:, :4], states[1:, :4]), states[1:, 4:] - made[:, 4:]]
    )
    # A difference already, of the noise of two samples.
    third, fourth = (
        np.sqrt([np.mean(part**2) for part in np.split(np.diff(gained, m - 1, axis=0), 2, axis=1)])
        for m in OF_DIFFERENCES
    )
    noise = fourth / np.sqrt(OF_DIFFERENCES[4])
    is_noise = (fourth > ALTERNATES * third) & (noise > PRINTED * floor)
    seen = is_noise.all() if has_omega else is_noise[0]
    return np.maximum(noise, floor) if seen else None
