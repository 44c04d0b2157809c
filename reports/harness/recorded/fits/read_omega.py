"""Finds out how a wrong ω was recorded, if the attitudes obey the equations of motion.

Only with one ω, the body's own, do the equations lead from an attitude to the next one. The
recorded ω may be the body's ω after a clamp, a linear filter or the errors of a sensor.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.special import fdtrc

from .....reference.following import follow
from .....reference.other_equations import OtherEquations
from .....scenarios import FloatArray, Trajectory
from .....scenarios.rotation import norms, rotation_vectors
from ...explaining.fit import Data
from ...explaining.hypothesis import Hypothesis, as_it_is
from ...explaining.search import LEFT, SAME, SIGNIFICANCE, Search
from ..samples.clamps import CLAMPS
from ..samples.intervals import NEAR
from ..samples.missing import is_attitude_off, turned_off
from ..samples.sensors import CROSS_AXIS, OF_LOGS, as_read
from .motion_changes import sentences
from .other_physics import Physics

#: Number of Newton steps with which the body's ω is found. Step of the finite differences for the
#: Jacobian, relative to the largest ‖ω‖.
STEPS, SMALL = 4, 1e-6
#: Largest numbers of earlier outputs, and of samples of the body's ω, that a filter adds up.
OUTPUTS, INPUTS = 2, 5
#: Number of samples of a filter's impulse response that are checked.
WEIGHTS = 200
#: Largest number of samples in a moving mean.
MOST_SMOOTHED = 60
#: Relative tolerance at which samples are evenly spaced.
EQUAL = 1e-6
OMEGA = "the attitudes obey the scene's equations, but the recorded ω is not that of the attitudes"


@dataclass(frozen=True, eq=False)
class ReadOmega(Data):
    """The recorded ω of n samples, to be explained as the body's ω with the errors of a sensor.

    Attributes
    ----------
    t : times of the n samples, s, (n,)
    body : q, scalar first, and the body's ω, rad/s, body axes, (n, 7)
    read : the recorded ω, rad/s, (n, 3)
    error : standard deviation of the error of the body's ω, rad/s
    """

    t: FloatArray
    body: FloatArray
    read: FloatArray
    error: float

    @property
    def omegas(self) -> tuple[FloatArray, FloatArray]:
        """The body's ω and the recorded ω, rad/s, (n, 3) each."""
        return self.body[:, 4:], self.read

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """Return what sensors read as ω with H hypotheses, less `read`, in units of `error`.

        The shape is (H, n, 3), for n samples.
        """
        computed = as_read(hypotheses, np.repeat(self.body[None], len(hypotheses), axis=0), self.t)
        return np.asarray((computed[..., 4:] - self.read) / self.error)


def omega_read(physics: Physics, *, is_explained: bool) -> list[str]:
    """Return sentences on how the recorded ω was computed from the ω that the attitudes imply.

    If no way is found, the sentence is `OMEGA`: it only says that ω is not that of the attitudes.

    Parameters
    ----------
    physics : the recorded motion, and the equations that its attitudes obey: those of
        `physics.base`, or the scene's if it is None
    is_explained : whether errors in reading ω explain the motion already. If so, only two ways are
        looked for that have fewer parameters: a clamp of ω, and differences of attitudes

    Returns
    -------
    The list is empty in any of these cases: the attitudes disobey the equations, are too far apart,
    or are those of other times; the recorded ω is that of the attitudes; `is_explained` is true,
    and ω was computed in neither of the two ways
    """
    motion = physics.motion
    turns = norms(physics.exact.omega_body)[:-1] * np.diff(motion.t)
    # Attitudes of other times obey the equations as well, but then ω is right.
    is_late = physics.base is None and is_attitude_off(motion, physics.exact)
    if is_late or turns.max() > NEAR:
        return []
    base = as_it_is(physics.scenario) if physics.base is None else physics.base
    states = np.hstack([motion.q_world_body_wxyz, motion.omega_body])
    actual_omega = _omega_between(base, states, np.diff(motion.t))
    if actual_omega is None or physics.intervals is None:
        return []
    read = motion.omega_body[:-1]
    # ω between two attitudes has the errors of both, divided by the time between them.
    attitude = np.hypot(physics.noise[0], physics.intervals.method[:, 0].max())
    # The attitudes' error is no larger than their deviation from the exact motion.
    deviation = turned_off(motion, physics.exact) if physics.base is None else 0.0
    attitude = min(attitude, max(physics.noise[0], deviation))
    error = physics.noise[1] + 2 * attitude / float(np.diff(motion.t).min())
    cut = motion.until(len(read))
    by_attitudes = replace(
        physics,
        motion=replace(cut, omega_body=actual_omega),
        exact=physics.exact.until(len(read)),
        noise=np.array([physics.noise[0], error]),
    )
    distances = norms(read - actual_omega)
    if by_attitudes.search is None or by_attitudes.is_beyond or np.max(distances) * LEFT < error:
        return []
    body = np.hstack([states[:-1, :4], actual_omega])
    simple = next(_clamped(body, read, error), []) or _differences(motion)
    # A filter or a sensor's error changes ω at most samples, and not at a few only.
    if simple or is_explained or np.mean(distances**2) <= error**2:
        return simple
    return (
        _sensor_error(ReadOmega(base, motion.t[:-1], body, read, error))
        or _smoothed_or_filtered(motion.t, actual_omega, read, error)
        or [OMEGA]
    )


def _omega_between(
    equations: OtherEquations, states: FloatArray, spans: FloatArray
) -> FloatArray | None:
    """Return the ω with which equations lead from each of n attitudes to the next one, (n - 1, 3).

    It is in rad/s, body axes, and is found by Newton's method, which starts from the mean rate
    between the two attitudes.

    Parameters
    ----------
    states : q, scalar first, and an ω that is not used, (n, 7)
    spans : times between successive states, s, (n - 1,)

    Returns
    -------
    None if the iteration does not converge
    """
    q, ends = states[:-1, :4], states[1:, :4]
    omega = rotation_vectors(q, ends) / spans[:, None]
    size = float(norms(omega).max()) or 1.0

    def deviation(omega: FloatArray) -> FloatArray:
        computed = follow(equations, np.hstack([q, omega]), spans[:, None])[:, 0, :4]
        return np.nan_to_num(rotation_vectors(computed, ends), nan=np.inf)

    for _ in range(STEPS):
        residual = deviation(omega)
        if not np.isfinite(residual).all():
            return None
        step = SMALL * size
        jacobians = np.stack(
            [(deviation(omega + step * one) - residual) / step for one in np.eye(3)], axis=2
        )
        if not np.isfinite(jacobians).all() or (np.abs(np.linalg.det(jacobians)) == 0).any():
            return None
        omega = omega - np.linalg.solve(jacobians, residual[..., None])[..., 0]
    return omega if norms(deviation(omega)).max() < SMALL else None


def _clamped(body: FloatArray, read: FloatArray, error: float) -> Iterator[list[str]]:
    """Yield a list of one sentence for each clamp that turns the body's ω into the recorded ω.

    A clamp limits ‖ω‖, or each component of ω, to a bound.

    Parameters
    ----------
    body : q, scalar first, and the body's ω, rad/s, body axes, (n, 7)
    read : the recorded ω, rad/s, (n, 3)
    error : standard deviation of the error of the body's ω, rad/s
    """
    for words, size_of, limited in CLAMPS:
        bound = float(size_of(np.hstack([body[:, :4], read])).max())
        computed = limited(body, bound)[:, 4:]
        deviation, changed = (float(norms(one - computed).max()) for one in (read, body[:, 4:]))
        # If the bound is exceeded at all samples, a scale factor explains the recorded ω as well.
        is_clamp = size_of(body).min() < bound and changed > error / LEFT
        if is_clamp and deviation <= max(error, LEFT**2 * changed):
            yield [f"{words} is clamped to {bound:.4g} rad/s"]


def _differences(motion: Trajectory) -> list[str]:
    """Return a list of the sentence that the recorded ω is the mean rate between two attitudes.

    The sentence says which attitudes. The list is empty if ω is no such rate.
    """
    t, q, omega = motion.t, motion.q_world_body_wxyz, motion.omega_body
    rates = rotation_vectors(q[:-1], q[1:]) / np.diff(t)[:, None]
    least = LEFT**2 * float(norms(np.diff(rates, axis=0)).max())
    over_two = rotation_vectors(q[:-2], q[2:]) / (t[2:] - t[:-2])[:, None]
    for words, computed, read in (
        ("since the sample before, which is half a sample late", rates, omega[1:]),
        ("until the next sample, which is half a sample early", rates, omega[:-1]),
        ("from the sample before to the next one", over_two, omega[1:-1]),
    ):
        if norms(read - computed).max() < least:
            return [f"ω is the mean rate of the recorded attitudes {words}"]
    return []


def _sensor_error(data: ReadOmega) -> list[str]:
    """Return sentences on the gyroscope's error that explains the recorded ω; empty if none."""
    found = Search(data, (*OF_LOGS, CROSS_AXIS), part=LEFT**2).one()
    return sentences(found) if found else []


def _smoothed_or_filtered(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> list[str]:
    """Return a sentence on the moving mean or linear filter of the body's ω that was recorded.

    A mean is simpler. A filter is preferred only if its residuals are far smaller, and those of the
    mean are larger than rounding.

    Parameters
    ----------
    t : times of the n samples, s, (n,)
    body, read : the body's ω and the recorded one, rad/s, (n, 3)
    error : standard deviation of the error of the body's ω, rad/s

    Returns
    -------
    A list of one sentence; empty if neither explains the recorded ω
    """
    deviation = float(np.mean((read - body) ** 2))
    mean, filter_ = (f(t, body, read, error) for f in (_smoothed, _filtered))
    if mean and filter_ and max(filter_[0] / LEFT**2, SAME**2 * deviation) < mean[0]:
        mean = None
    found = mean or filter_
    return [found[1]] if found else []


def _smoothed(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> tuple[float, str] | None:
    """Return the moving mean of the body's ω over the fewest samples that explains the recorded ω.

    Parameters
    ----------
    t : times of the n samples, s, (n,)
    body, read : the body's ω and the recorded one, rad/s, (n, 3)
    error : standard deviation of the error of the body's ω, rad/s

    Returns
    -------
    The mean square of the residuals, (rad/s)², and a sentence on the mean; None if none explains ω
    """
    deviation = float(np.mean((read - body) ** 2))
    for samples in range(2, min(MOST_SMOOTHED, len(read) // 2)):
        means = np.apply_along_axis(np.convolve, 0, body, np.ones(samples) / samples, "valid")
        for offset, words in (((samples - 1) // 2, "around each"), (samples - 1, "up to each")):
            residual = float(np.mean((read[offset : offset + len(means)] - means) ** 2))
            is_even = words == "around each" and samples % 2 == 0
            explains = residual <= min(max(error**2, LEFT**4 * deviation), LEFT**2 * deviation)
            if not is_even and explains:
                over = (samples - 1) * (t[-1] - t[0]) / (len(t) - 1)
                return residual, f"ω is the mean over {samples} samples, {over:.4g} s, {words}"
    return None


@dataclass(frozen=True, eq=False)
class Filter:
    """A linear filter: read(k) = Σ outputs[i] read(k - 1 - i) + Σ inputs[j] body(k - j).

    Here read(k) is its output at sample k, and body(k) the body's ω.

    Attributes
    ----------
    outputs, inputs : weights of earlier outputs, (k,), and of the body's ω, (m,)
    residual : mean square of the recorded ω less the filter's output, (rad/s)²
    """

    outputs: FloatArray
    inputs: FloatArray
    residual: float

    @property
    def delay(self) -> float:
        """The group delay at frequency zero: by how many samples slow changes of ω are delayed."""
        ages = np.arange(len(self.inputs)) @ self.inputs / self.inputs.sum()
        own = np.arange(1, len(self.outputs) + 1) @ self.outputs / (1 - self.outputs.sum())
        return float(ages + own)

    @property
    def is_causal(self) -> bool:
        """Whether a sensor may have such a filter.

        It must be stable and delay its input, and the sum of `outputs` must not be negative. Its
        impulse response must be positive, but may fall somewhat below zero, as that of a filter
        that overshoots does.
        """
        poles = np.roots([1.0, *-self.outputs])
        if not (self.delay > 0 and self.outputs.sum() >= 0 and (np.abs(poles) < 1).all()):
            return False
        weights: list[float] = []
        for n in range(WEIGHTS):
            direct = float(self.inputs[n]) if n < len(self.inputs) else 0.0
            before = zip(self.outputs, reversed(weights), strict=False)
            weights.append(direct + sum(a * weight for a, weight in before))
        return min(weights) >= -LEFT * max(weights)

    @property
    def words(self) -> str:
        """The formula of the filter's output, in words."""
        before = ["", " a sample before", *(f" {j} samples before" for j in range(2, INPUTS))]
        parts = [(a, f"of itself{when}") for a, when in zip(self.outputs, before[1:], strict=False)]
        parts += [(b, f"of the body's{when}") for b, when in zip(self.inputs, before, strict=False)]
        return ", ".join(f"{factor:.4g} {what}" for factor, what in parts)


def _filtered(
    t: FloatArray, body: FloatArray, read: FloatArray, error: float
) -> tuple[float, str] | None:
    """Return the linear filter with the fewest weights that turns the body's ω into the recorded.

    Parameters
    ----------
    t : times of the n samples, s, (n,)
    body, read : the body's ω and the recorded one, rad/s, (n, 3)
    error : standard deviation of the error of the body's ω, rad/s

    Returns
    -------
    The mean square of the residuals, (rad/s)², and a sentence on the filter; None if no filter
    explains ω, or if samples are not evenly spaced
    """
    spans = np.diff(t)
    if np.ptp(spans) > EQUAL * spans.mean():
        return None
    deviation = float(np.mean((read - body) ** 2))
    filters = (
        _filter(body, read, outputs, inputs)
        for outputs, inputs in sorted(product(range(OUTPUTS + 1), range(1, INPUTS + 1)), key=sum)
    )
    for one in filters:
        count, parameters = 3 * len(read), len(one.outputs) + len(one.inputs)
        F = (
            (deviation - one.residual)
            / max(one.residual, error**2)
            * (count - parameters)
            / parameters
        )
        enough = min(max(error**2, LEFT**4 * deviation), LEFT**2 * deviation)
        explains = one.residual <= enough and one.is_causal
        if (
            explains
            and fdtrc(parameters, count - parameters, F) < SIGNIFICANCE / (OUTPUTS + 1) / INPUTS
        ):
            delay = one.delay * spans.mean()
            words = f"ω is filtered, which delays it by {delay:.4g} s: it is {one.words}"
            return one.residual, words
    return None


def _filter(body: FloatArray, read: FloatArray, outputs: int, inputs: int) -> Filter:
    """Fit the weights of a filter by least squares, at all samples with enough samples before them.

    Parameters
    ----------
    body, read : the body's ω and the recorded one at n samples, rad/s, (n, 3)
    outputs, inputs : the numbers of weights of earlier outputs, and of samples of the body's ω
    """
    first = max(outputs, inputs - 1)
    rows = np.arange(first, len(read))
    columns = [read[rows - 1 - i].ravel() for i in range(outputs)]
    columns += [body[rows - j].ravel() for j in range(inputs)]
    A, target = np.array(columns).T, read[rows].ravel()
    parameters: FloatArray = np.linalg.lstsq(A, target, rcond=None)[0].astype(float)
    a, b = parameters[:outputs], parameters[outputs:]
    # From recorded outputs a filter predicts anything smooth. So the residuals are computed with
    # the filter's own earlier outputs.
    computed = [*read[:first]]
    # The outputs of an unstable filter may overflow.
    with np.errstate(over="ignore", invalid="ignore"):
        for k in rows:
            before = sum((w * computed[k - 1 - i] for i, w in enumerate(a)), np.zeros(3))
            computed.append(before + b @ body[k - np.arange(inputs)])
        residual = float(np.mean((read - np.array(computed))[first:] ** 2))
    return Filter(a, b, residual if np.isfinite(residual) else np.inf)
