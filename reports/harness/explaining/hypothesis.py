"""Hypotheses of what was computed instead of a scene's exact motion, and changes that make them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ....reference.other_equations import OtherEquations, equations_of
from ....reference.rows import Entry
from ....scenarios import FloatArray, Scenario
from ...results.evidence import Explanation

#: The step of a scaled parameter for a finite difference.
SMALL = 1e-5


class Hypothesis(OtherEquations):
    """Equations that may have been integrated, and how the states of that motion are read.

    One object holds one hypothesis, or H of them: then each shape below has a further first axis.

    Attributes
    ----------
    start : deviation of the first state from the scene's: a rotation vector, rad, and a difference
        of ω, rad/s, body axes, (6,)
    read, bias, drift, lag : at a time t, s, `read` @ ω(t − `lag`) + `bias` + t `drift` is read,
        along body axes; (3, 3), rad/s (3,), rad/s² (3,) and s
    low_pass : time constant, s, of a low-pass filter of first order that ω has passed
    is_begun : 1 if that filter begins at the first sample, with ω as it is there, else 0
    turned, delay : the attitude that is read at a time t is q(t − `delay`), delay in s, turned in
        the body by the rotation vector `turned`, rad, body axes, (3,)
    step : ratio of the time by which the motion advances to the timestep, or to the recorded time
    velocity : ratio of the com's velocity that is read to the actual velocity
    braking : rate at which the com of a body without a pivot is slowed, 1/s
    """

    start = Entry(6)
    read = Entry(3, 3)
    bias = Entry(3)
    drift = Entry(3)
    turned = Entry(3)
    lag = Entry()
    low_pass = Entry()
    is_begun = Entry()
    delay = Entry()
    step = Entry()
    velocity = Entry()
    braking = Entry()


def as_it_is(scenario: Scenario) -> Hypothesis:
    """The scene's equations, with states that are read as they are."""
    numbers = np.zeros(Hypothesis.count)
    numbers[: OtherEquations.count] = equations_of(scenario).numbers
    return Hypothesis(numbers).of(read=np.eye(3), step=1.0, velocity=1.0)


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the equations of motion, or of how states are read, with k parameters.

    Attributes
    ----------
    kind : name of the kind of change, by which it is stored and put in words
    apply : makes the change in H hypotheses, with parameters, (H, k); zeros change nothing
    scales : values of the parameters with which the change is neither small nor large, (k,)
    shown : computes the numbers that the words of the change state from the parameters
    is_possible : whether given parameters, (k,), and the hypothesis that they lead to, may be those
        of a motion that was computed; with others a fit only mimics the data
    """

    kind: str
    apply: Callable[[Hypothesis, FloatArray], Hypothesis]
    scales: FloatArray
    shown: Callable[[FloatArray], Sequence[float] | FloatArray] = np.asarray
    is_possible: Callable[[Hypothesis, FloatArray], bool] = lambda _, __: True

    @property
    def form(self) -> tuple[str, int]:
        """The kind and the number of parameters: changes that agree in them differ in numbers."""
        return self.kind, len(self.scales)

    def around(self, hypothesis: Hypothesis) -> Hypothesis:
        """The k + 1 hypotheses with parameters of zero, and with a small step in each of them."""
        return self.apply(hypothesis.repeated(len(self._steps)), self._steps)

    @cached_property
    def _steps(self) -> FloatArray:
        """Parameters of zero, and with a small step in each of them, (k + 1, k)."""
        return np.vstack([np.zeros_like(self.scales), SMALL * np.diag(self.scales)])

    def explanation(self, parameters: FloatArray) -> Explanation:
        """The change with fitted parameters, as it is stored and put in words."""
        return Explanation(self.kind, tuple(map(float, self.shown(parameters))))


def set_to(kind: str, shown: Sequence[float] = (), **terms: Any) -> Change:
    """A change without parameters, which sets terms of the equations to given values.

    Parameters
    ----------
    shown : the numbers that the words of the change state
    terms : the values, by the names of the terms
    kind : as in `Change`
    """
    return Change(kind, lambda h, _: h.of(**terms), np.empty(0), lambda _: shown)


def fitted(
    kind: str,
    nominal: FloatArray,
    scale: float | FloatArray,
    apply: Callable[[Hypothesis, FloatArray], Hypothesis],
    is_possible: Callable[[Hypothesis, FloatArray], bool] = lambda _, __: True,
) -> Change:
    """A change of k numbers of the equations; its parameters are deviations from nominal values.

    Parameters
    ----------
    nominal : the numbers without the change, (k,)
    scale : scale of the deviations, in the unit of the numbers
    apply : puts changed numbers, (H, k), into H hypotheses
    kind, is_possible : as in `Change`
    """
    scales = np.broadcast_to(scale, nominal.shape).astype(float)

    def numbers(n: FloatArray) -> FloatArray:
        return np.asarray(nominal + n)

    return Change(kind, lambda h, n: apply(h, numbers(n)), scales, numbers, is_possible)


def factors(kind: str, *wholes: float, sign: float = 1.0, **terms: FloatArray) -> Iterator[Change]:
    """Changes that multiply terms by a factor: first by each given factor, then by a fitted one.

    Parameters
    ----------
    wholes : the given factors
    sign : sign of the number in the change's words if the factor is larger than one
    terms : the nominal values, by the names of the terms
    kind : as in `Change`
    """
    for whole in wholes:
        multiplied: Any = {name: whole * term for name, term in terms.items()}
        yield set_to(kind, (sign * (whole - 1),), **multiplied)
    yield Change(
        kind,
        lambda h, n: h.of(**{name: scaled(1 + n, term) for name, term in terms.items()}),
        np.ones(1),
        lambda n: sign * n,
    )


def scaled(factors: FloatArray, term: FloatArray) -> FloatArray:
    """Return a term, (...), times each of H factors, (H, 1): (H, ...)."""
    return np.asarray(np.multiply.outer(factors[:, 0], term))
