"""Hypotheses of which equations were integrated in place of a scene's, and of how states were read.

A change makes a hypothesis of another one, at first of the scene's own equations.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ....reference.other_equations import OtherEquations, equations_of
from ....reference.rows import Entry
from ....scenarios import FloatArray, Scenario
from ...results.evidence import Explanation

#: Step of finite differences of a parameter, in units of its scale (`Change.scales`).
SMALL = 1e-5


class Hypothesis(OtherEquations):
    """Equations that may have been integrated, and how states of their motion were read.

    One object holds one hypothesis, or H of them: then each shape below has a further first axis.

    Attributes
    ----------
    start : deviation of the first state from the scene's: a rotation vector, rad, and a difference
        of ω, rad/s, body axes, (6,)
    read, bias, drift, lag : the ω that is read at a time t, s, is `read` @ ω(t − `lag`) + `bias` +
        t `drift`, along body axes. `read` is (3, 3), `bias` rad/s, (3,), `drift` rad/s², (3,), and
        `lag` s
    low_pass : time constant, s, of a low-pass filter of first order that ω has passed
    is_begun : 1 if the output of that filter is equal to ω at the first sample; 0 if the filter has
        been running since long before
    turned, delay : the attitude that is read at a time t is q(t − `delay`), delay in s, turned in
        the body by the rotation vector `turned`, rad, body axes, (3,)
    step : ratio of the time by which the motion advances in a step to the timestep; for a recorded
        motion, ratio of the true time to the recorded time
    velocity : ratio of the com's velocity that is read to the actual velocity
    braking : rate at which the velocity of the com of a body without a pivot decays, 1/s
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
    """Return the hypothesis of the scene's own equations, and of states read without mistakes."""
    numbers = np.zeros(Hypothesis.count)
    numbers[: OtherEquations.count] = equations_of(scenario).numbers
    return Hypothesis(numbers).of(read=np.eye(3), step=1.0, velocity=1.0)


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the equations of motion, or of how states are read, with k parameters.

    Attributes
    ----------
    kind : name of the kind of change, by which the change is stored and its words are found
    apply : returns H hypotheses with the change made in them, given the hypotheses and the values
        of the parameters in each, (H, k); values of zero change nothing
    scales : typical sizes of the parameters, with which the change is neither small nor large, (k,)
    shown : returns the numbers that the words of the change state, given the parameters, (k,)
    is_possible : returns whether a mistake can have led to a hypothesis with given parameters,
        (k,). If not, a fit that ends there only mimics the data
    guess : returns the parameters from which a fit starts, (k,), given ω as attitudes turn and ω as
        it was recorded, rad/s, body axes, (n, 3) each; None if fits start from zero
    """

    kind: str
    apply: Callable[[Hypothesis, FloatArray], Hypothesis]
    scales: FloatArray
    shown: Callable[[FloatArray], Sequence[float] | FloatArray] = np.asarray
    is_possible: Callable[[Hypothesis, FloatArray], bool] = lambda _, __: True
    guess: Callable[[FloatArray, FloatArray], FloatArray] | None = None

    @property
    def form(self) -> tuple[str, int]:
        """The kind and the number of parameters.

        Changes of the same form differ only in their numbers.
        """
        return self.kind, len(self.scales)

    def around(self, hypothesis: Hypothesis, parameters: FloatArray) -> Hypothesis:
        """Return k + 1 changed hypotheses: with given parameters, then with one at a time changed.

        Parameters
        ----------
        hypothesis : the one hypothesis that is changed
        parameters : (k,)
        """
        return self.apply(hypothesis.repeated(len(self._steps)), parameters + self._steps)

    @cached_property
    def _steps(self) -> FloatArray:
        """Small changes of parameters in k + 1 hypotheses: none, then of one at a time.

        The shape is (k + 1, k).
        """
        return np.vstack([np.zeros_like(self.scales), SMALL * np.diag(self.scales)])

    def explanation(self, parameters: FloatArray) -> Explanation:
        """Return the change in the form in which it is stored and put in words.

        Parameters
        ----------
        parameters : the k fitted parameters of the change, (k,)
        """
        return Explanation(self.kind, tuple(map(float, self.shown(parameters))))


def set_to(kind: str, shown: Sequence[float] = (), **terms: Any) -> Change:
    """Return a change without parameters, which sets terms of the equations to given values.

    Parameters
    ----------
    kind : name of the kind of change
    shown : the numbers that the words of the change state
    terms : the values, by the names of terms in `Hypothesis`
    """
    return Change(kind, lambda h, _: h.of(**terms), np.empty(0), lambda _: shown)


def fitted(
    kind: str,
    nominal: FloatArray,
    scale: float | FloatArray,
    apply: Callable[[Hypothesis, FloatArray], Hypothesis],
    is_possible: Callable[[Hypothesis, FloatArray], bool] = lambda _, __: True,
) -> Change:
    """Return a change in which k numbers of the equations are fitted.

    Its parameters are the deviations of the numbers from nominal values.

    Parameters
    ----------
    kind : name of the kind of change
    nominal : the numbers without the change, (k,)
    scale : typical size of the deviations, in the unit of the numbers
    apply : returns H hypotheses in which the numbers are replaced by given ones, (H, k)
    is_possible : returns whether a mistake can have led to a hypothesis with given parameters
    """
    scales = np.broadcast_to(scale, nominal.shape).astype(float)

    def numbers(n: FloatArray) -> FloatArray:
        return np.asarray(nominal + n)

    return Change(kind, lambda h, n: apply(h, numbers(n)), scales, numbers, is_possible)


def factors(kind: str, *wholes: float, sign: float = 1.0, **terms: FloatArray) -> Iterator[Change]:
    """Yield changes that multiply terms by a factor.

    The first changes have the given factors. In the last one the factor is fitted.

    Parameters
    ----------
    kind : name of the kind of the changes
    wholes : the given factors
    sign : 1 if the words of the change state the factor less 1, −1 if they state 1 less the factor
    terms : the values without a change, by the names of terms in `Hypothesis`
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
    """Return a term of the equations, multiplied by each of H factors, (H, ...).

    Parameters
    ----------
    factors : the factors, (H, 1)
    term : the value of the term, of any shape, (...)
    """
    return np.asarray(np.multiply.outer(factors[:, 0], term))
