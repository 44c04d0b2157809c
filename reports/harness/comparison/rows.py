"""Compares one run with the exact motion and with the scene's expectations of the run."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ....engines import Engine, Run
from ....reference import Solution, drifts
from ....scenarios import (
    SIGNAL,
    ErrorSeries,
    Expect,
    FloatArray,
    Scenario,
    Trajectory,
    error_series,
)
from ...results.evidence import StepEvidence
from ...results.reasons import fault_in_words
from ...results.records import Key, Row
from ..executors import Answer, CallFailed
from ..timesteps.ladder import Rung
from ..timesteps.stock import stock_timesteps
from .defects import turns_made

#: Relative error of the energy above which a run has blown up.
ABSURD_ENERGY = 10.0
#: Turns are counted until the attitude error exceeds this angle, rad.
DEGREE = np.pi / 180


def row_of(
    scenario: Scenario,
    key: Key,
    version: str,
    rung: Rung,
    result: Run | CallFailed,
    solution: Solution,
) -> Row:
    """Return the row of a run, compared with the exact motion at the run's own sample times.

    The outcome is `failed` if the call failed, `diverged` if the energy error exceeds
    `ABSURD_ENERGY`, else the run's own. Errors are given only for an `ok` run; without samples
    nothing is compared. An `ok` run that is no better than no motion is marked
    (`Row.without_skill`), and gets the cause `lost` unless it has another cause.

    Parameters
    ----------
    key : names of scene, engine and method
    version : the engine's version, which the row states if the call failed
    rung : the timestep and samples of the run
    result : the run, or why the call that should make it failed
    solution : the exact motion at the samples of the rung
    """
    if isinstance(result, CallFailed):
        return Row(key, version, rung.timestep, "failed", result.reason, result.cause)
    row = Row(
        key,
        result.engine_version,
        rung.timestep,
        result.outcome,
        result.reason,
        result.cause,
        result.stopped_at,
        reference_uncertainty=solution.uncertainty.omega,
        steps=result.steps,
        unasked=tuple(sorted(result.active - scenario.called_for)),
    )
    motion = result.trajectory
    if motion is None or not len(motion.t):
        return row
    exact = solution.trajectory.until(len(motion.t))
    series = error_series(scenario, motion, exact)
    # An energy that is NaN, from terms too large for a double, has blown up as well.
    absurd = series.first_beyond("energy", ABSURD_ENERGY)
    if absurd is not None:
        # The run's own reason is added, since it may tell the cause.
        reasons = (f"the energy exceeds {ABSURD_ENERGY:g} times its base", row.reason)
        reason = "; ".join(filter(None, reasons))
        stopped_at = float(motion.t[absurd])
        row = replace(row, outcome="diverged", reason=reason, cause="energy", stopped_at=stopped_at)
    elif row.outcome == "ok" and (no_skill := no_better_than_rest(scenario, motion, exact, series)):
        reason = "; ".join(filter(None, (row.reason, no_skill)))
        row = replace(row, cause=row.cause or "lost", reason=reason, without_skill=True)
    turned = np.concatenate([[0.0], np.cumsum(turns_made(exact))])
    beyond = series.first_beyond("attitude", DEGREE)
    return replace(
        row,
        # A run that stopped early has no errors: those up to that time may be arbitrarily small.
        errors=series.worst() if row.outcome == "ok" else None,
        drifts=drifts(scenario, motion),
        motion=motion,
        turns=float(turned[-1]),
        turns_within_1deg=None if beyond is None else float(turned[beyond]),
    )


def compared(
    scenario: Scenario,
    engine: Engine,
    key: Key,
    rung: Rung,
    answer: Answer[Run],
    solution: Solution,
    steps: StepEvidence | None,
) -> Row:
    """Return the row of a study's run, compared with the exact motion.

    It also states a fault of the method's single steps, what the engine printed, and whether the
    timestep is a stock timestep.

    Parameters
    ----------
    key : names of scene, engine and method
    rung : the timestep and samples of the run
    answer : the run, or why its call failed, and what the engine printed
    solution : the exact motion at the samples of the rung
    steps : the evidence from single steps; None if there is none, or if their faults are expected,
        as those of an engine as shipped are
    """
    run = _of_other_law(answer.value, steps)
    row = row_of(scenario, key, engine.version, rung, run, solution)
    return replace(row, printed=answer.printed, stock=rung.timestep in stock_timesteps(engine))


def _of_other_law(run: Run | CallFailed, steps: StepEvidence | None) -> Run | CallFailed:
    """Return a run whose reason also states the fault that the method's single steps show.

    The run's cause becomes `law` unless it has another. A failed call is returned unchanged, and so
    is a run if single steps show no fault, or if `steps`, the evidence from them, is None.
    """
    if isinstance(run, CallFailed) or not (steps and steps.fault):
        return run
    reason = "; ".join(filter(None, (run.reason, fault_in_words(steps.fault))))
    return replace(run, cause=run.cause or "law", reason=reason)


def unmet_expectations(
    scenario: Scenario, expected: Expect, row: Row, exact: Trajectory
) -> list[str]:
    """Return in words each part of an expectation that a run does not meet; empty if it meets all.

    There is one sentence for each signal whose error exceeds its bound. If a run did not diverge as
    expected, or has no errors to compare, there is one sentence on its outcome.

    Parameters
    ----------
    expected : an expectation of the scene for this run
    row : the run's row
    exact : the exact motion at the run's own sample times
    """
    at = f"at {row.timestep:g} s"
    ended = f"{row.outcome}{f', {row.reason}' if row.reason else ''}"
    if expected.outcome == "diverges":
        return [] if row.outcome == "diverged" else [f"outcome {at}: {ended}; expected: diverges"]
    if row.errors is None:
        bounds = (
            f"{SIGNAL[name].label} error at most {_in_unit(name, bound)}"
            for name, bound in expected.bounds().items()
        )
        return [f"outcome {at}: {ended}; expected: {', '.join(bounds)}"]
    series = error_series(scenario, row.motion, exact) if row.motion else None
    return [
        f"{SIGNAL[name].label} error {at}: {_in_unit(name, error)} exceeds the expected "
        f"{_in_unit(name, bound)}{_since(exact, series, name, bound)}"
        for name, bound in expected.bounds().items()
        if not (error := row.errors[name]) <= bound
    ]


def _since(exact: Trajectory, series: ErrorSeries | None, name: str, bound: float) -> str:
    """Return in words the first time at which the error of the signal `name` exceeds a bound.

    It is empty if `series`, the errors at the times of `exact`, is None or never exceeds the bound.
    """
    first = series.first_beyond(name, bound) if series else None
    return "" if first is None else f" from t = {exact.t[first]:.4g} s on"


def _in_unit(name: str, size: float) -> str:
    """Return the error `size` of a signal `name` as text.

    It is like `0.705° (0.0123 rad)` if the error is an angle, else like `1e-06`.
    """
    if SIGNAL[name].unit == "rad":
        return f"{size * SIGNAL[name].shown:.3g}° ({size:.3g} rad)"
    return f"{size:.3g}"


def no_better_than_rest(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, series: ErrorSeries
) -> str:
    """Return in words the signals in which a run is no better than no motion; empty if none.

    Bounds on energy and norms do not find such runs: a run stays bounded even with an implicit
    integrator at too large a step, a clamp, a joint motor or another body in the model. It is
    compared with rest instead, a body that neither turns nor moves, as a forecast without skill is
    found by comparison with a trivial forecast (A. H. Murphy, Mon. Wea. Rev. 116 (1988) 2417). A
    run is `lost` in a signal if its distance from the exact motion is at least the size of the run
    or the size of the exact motion, whichever is smaller.

    The distance is a root mean square over the second half of the window, for two reasons: errors
    grow, and at a single sample a motion that flips a little early has an error of twice its size.
    The sizes are root mean squares over the whole window. L does not flip, as only a torque can
    change it: its largest error at any sample is compared with the largest |L|.

    The outcome of such a run stays `ok`, and on a ladder its error counts like that of any other
    run, but `Row.survived` is false.

    Parameters
    ----------
    motion : the run
    exact : the exact motion at the run's own sample times
    series : the run's errors
    """
    signals = list(_signals(scenario, motion, exact, series))
    return f"lost: {'; '.join(signals)}" if signals else ""


def _signals(
    scenario: Scenario, motion: Trajectory, exact: Trajectory, series: ErrorSeries
) -> Iterator[str]:
    """Yield, in words, each signal in which a run is no better than no motion.

    Parameters
    ----------
    motion : the run
    exact : the exact motion at the run's own sample times
    series : the run's errors
    """
    yield from _of_path("ω", motion.omega_body, exact.omega_body, exact.t)
    L_errors = series["angular_momentum"]
    # Errors relative to an exact value of zero are infinite.
    if 1 <= (worst := float(L_errors.max())) < np.inf:
        yield _words("L", worst, exact.t[np.argmax(L_errors >= 1)])
    start, is_flying = exact.com_world[0], ~np.array(scenario.constraint.is_held)
    flown, exactly = ((one.com_world - start) * is_flying for one in (motion, exact))
    yield from _of_path("com", flown, exactly, exact.t)


def _of_path(name: str, run: FloatArray, exact: FloatArray, times: FloatArray) -> Iterator[str]:
    """Yield a complaint if a run is no better than no motion in a signal that is zero at rest.

    There is none if the exact signal is zero throughout.

    Parameters
    ----------
    name : name of the signal
    run, exact : n values of the signal in the run and in the exact motion, (n, 3) each
    times : times of the values, s, (n,)
    """
    if not exact.any():
        # Relative to a size of zero, even round-off would be infinite.
        return
    size = min(_rms(run), _rms(exact))
    error = run - exact
    if _rms(error[len(error) // 2 :]) >= size:
        since = times[np.argmax(_norms(error) >= size)]
        yield _words(name, _rms(error[len(error) // 2 :]) / _rms(exact), since)


def _words(name: str, ratio: float, since: float) -> str:
    """Return a complaint that a run is no better than no motion in a signal.

    Parameters
    ----------
    name : name of the signal
    ratio : the signal's error, relative to the size of the exact signal
    since : the first time at which the error is as large as the signal in the run or in the exact
        motion, whichever is smaller, s
    """
    return f"{name} is off by {ratio:.2g} times its size, from t = {since:.3g} s on"


def _norms(vectors: FloatArray) -> FloatArray:
    """Return the norms, (n,), of n vectors, (n, 3)."""
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _rms(vectors: FloatArray) -> float:
    """Return the root mean square of the norms of n vectors, (n, 3)."""
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
