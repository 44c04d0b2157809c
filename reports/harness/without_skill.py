"""Runs that come to their end, finite and calm, and have nothing to do with the scene's motion.

Energy and norms tell nothing of them: an implicit rule at too large a step, a clamp, a joint motor,
a model with another body in it go on for ever. The truth tells. How far off is too far is no matter
of taste if a third motion is put beside run and truth, the one that never begins: a body that does
not turn, or stays where it was. A run is lost where it is no nearer to the truth than one of the
two is to rest: where rest would have been the better guess (a forecast is called without skill by
the same comparison: A. H. Murphy, Mon. Wea. Rev. 116 (1988) 2417), or the run is more like rest
than like the truth.

Distances are root mean squares over the second half of the window, sizes over all of it: errors
grow, so what is lost is lost in the end, while a single sample of a motion that flips a little
early is off by twice its size. L, which only a torque can change, does not flip: it is lost where
it is off by more than its size once, as the table of errors has it.

Such a run is *ok*, and lost: no step blew up, and there is no time at which it stopped. A ladder
takes it for what it is, an error that is not small yet; who asks whether it survived is told no
(`Row.survived`).
"""

from collections.abc import Iterator

import numpy as np

from ...scenarios import FloatArray, Scenario, Trajectory, angular_momentum_world


def lost(scenario: Scenario, motion: Trajectory, truth: Trajectory) -> str:
    """Say in what a run is lost, by how much and since when; empty if it is not.

    Parameters
    ----------
    truth : at the run's own sample times
    """
    said = list(_said(scenario, motion, truth))
    return f"lost: {'; '.join(said)}" if said else ""


def _said(scenario: Scenario, motion: Trajectory, truth: Trajectory) -> Iterator[str]:
    yield from _of_path("ω", motion.omega_body, truth.omega_body, truth.t)
    L_true = _norms(angular_momentum_world(scenario, truth))
    off = _norms(angular_momentum_world(scenario, motion) - angular_momentum_world(scenario, truth))
    if 0 < L_true.max() <= off.max():
        since = truth.t[np.argmax(off >= L_true.max())]
        yield _words("L", off.max() / L_true.max(), since)
    if not scenario.has_pivot:
        start = truth.com_world[0]
        yield from _of_path("com", motion.com_world - start, truth.com_world - start, truth.t)


def _of_path(name: str, run: FloatArray, truth: FloatArray, times: FloatArray) -> Iterator[str]:
    """What there is to say of vectors that are zero at rest, (n, 3) each."""
    if not truth.any():
        # Anything is off by more than the size of nothing, round-off too.
        return
    size = min(_rms(run), _rms(truth))
    error = run - truth
    if _rms(error[len(error) // 2 :]) >= size:
        since = times[np.argmax(_norms(error) >= size)]
        yield _words(name, _rms(error[len(error) // 2 :]) / _rms(truth), since)


def _words(name: str, off: float, since: float) -> str:
    return f"{name} is off by {off:.2g} times its size, from t = {since:.3g} s on"


def _norms(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
