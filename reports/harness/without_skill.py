"""Finds runs that end finite and calm, but are no better than no motion (cause `lost`).

Bounds on energy and norms do not find them: with an implicit rule at too large a step, a clamp, a
joint motor or another body in the model, a run stays bounded. They are found by comparison with
rest, a body that does not turn or stays where it was, as a forecast without skill is by comparison
with a trivial one (A. H. Murphy, Mon. Wea. Rev. 116 (1988) 2417). A run is `lost` where its
distance from the exact motion is at least the distance of either of the two from rest.

Distances are root mean squares over the second half of the window, since errors grow and a single
sample of a motion that flips a little early is off by twice its size; sizes are root mean squares
over all of the window. L, which only a torque can change, does not flip: there the largest error
of any sample counts, against the largest |L|.

The outcome of such a run is `ok`, with no time at which it stopped, and on a ladder its error
counts like any other. `Row.survived` is false.
"""

from collections.abc import Iterator

import numpy as np

from ...scenarios import ErrorSeries, FloatArray, Scenario, Trajectory


def no_better_than_rest(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, series: ErrorSeries
) -> str:
    """The signals in which a run is no better than no motion, in words; empty if there is none.

    Parameters
    ----------
    exact : the exact motion at the run's own sample times
    series : the run's errors
    """
    signals = list(_signals(scenario, motion, exact, series))
    return f"lost: {'; '.join(signals)}" if signals else ""


def _signals(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, series: ErrorSeries
) -> Iterator[str]:
    yield from _of_path("ω", motion.omega_body, exact.omega_body, exact.t)
    L_errors = series["angular_momentum"]
    # Over an exact value of zero they are infinite.
    if 1 <= (worst := float(L_errors.max())) < np.inf:
        yield _words("L", worst, exact.t[np.argmax(L_errors >= 1)])
    start, is_flying = exact.com_world[0], ~np.array(scenario.constraint.is_held)
    flown, exactly = ((one.com_world - start) * is_flying for one in (motion, exact))
    yield from _of_path("com", flown, exactly, exact.t)


def _of_path(name: str, run: FloatArray, exact: FloatArray, times: FloatArray) -> Iterator[str]:
    """Whether a signal that is zero at rest is no better than rest; vectors are (n, 3)."""
    if not exact.any():
        # Relative to an exact value of zero, round-off alone would be infinite.
        return
    size = min(_rms(run), _rms(exact))
    error = run - exact
    if _rms(error[len(error) // 2 :]) >= size:
        since = times[np.argmax(_norms(error) >= size)]
        yield _words(name, _rms(error[len(error) // 2 :]) / _rms(exact), since)


def _words(name: str, ratio: float, since: float) -> str:
    return f"{name} is off by {ratio:.2g} times its size, from t = {since:.3g} s on"


def _norms(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
