"""Judges a recorded motion: its errors against the exact motion, and what explains them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import pi
from typing import Any

import numpy as np

from ....reference import Solution, drifts
from ....scenarios import (
    SIGNAL,
    ErrorSeries,
    FloatArray,
    Scenario,
    error_series,
)
from ...results.records import Defect
from ..comparison.defects import defects
from .case import Case
from .explained import explained
from .files.exact_at import exact_at
from .files.motion import RecordedMotion, reading_of, recorded_motion
from .files.recording import Recording, RecordingError
from .fits.measured import Measured
from .samples.spins import other_spins
from .samples.translation import mistakes_of_translation, other_translation

EPS = float(np.finfo(float).eps)
#: Error of the attitude, rad: the time at which it is first exceeded is always reported.
DEGREE = pi / 180
#: Relative tolerance with which a timestep may exceed the time between samples: times are rounded.
TIME_TOLERANCE = 1e-2
#: Quantities that have no error if they were not recorded, unless the body turns about a pivot.
OPTIONAL = ("com", "velocity")


@dataclass(frozen=True, eq=False)
class JudgedMotion:
    """A recorded motion, compared with the exact one.

    Attributes
    ----------
    recorded : the motion as it was read
    solution : the exact motion at the recorded times
    timestep : timestep with which the motion was computed, s; None if neither file nor user states
        it
    verdict : a sentence on whether the motion's errors are within noise, or within the errors of a
        method with the given order and timestep
    is_beyond : whether the motion's errors are larger than noise, or than those of such a method
    errors : the largest error of each signal, by name; of the attitude in rad, else relative. It is
        None for a quantity that was not recorded, except for com and velocity of a body on a pivot,
        which follow from attitude and ω
    series : the errors of each sample
    drifts : the largest relative change of each conserved quantity, by name
    defects : defects of the intervals between samples, by signal; empty if the body turns too far
        in the whole motion, or if the exact flow cannot be computed from a sample
    explained_by : sentences on the mistakes in recording, or the other physics, that explain why
        the motion is not the exact one
    made_by : the known integrator that computed the motion, in words; empty if none is recognised
    measured : the fit of the exact motion to all samples if the motion has noise, else None; to the
        corrected samples if a mistake in recording is found
    remarks : sentences on how the file was read
    ignored : headings of the file that name no known quantity
    is_single : whether the motion was computed in single precision
    resolution : the relative resolution with which the file's numbers are printed
    """

    recorded: RecordedMotion
    solution: Solution
    timestep: float | None
    verdict: str
    is_beyond: bool
    errors: dict[str, float | None]
    series: ErrorSeries
    drifts: dict[str, float]
    defects: dict[str, Defect]
    explained_by: tuple[str, ...]
    made_by: str
    measured: Measured | None
    remarks: tuple[str, ...]
    ignored: tuple[str, ...]
    is_single: bool
    resolution: float

    @property
    def is_another(self) -> bool:
        """Whether the motion is another than the scene's: `is_beyond`, or something explains it."""
        return self.is_beyond or bool(self.explained_by)

    def as_record(self) -> dict[str, Any]:
        """Return the results by name, as `spincheck judge --json` prints them for a file.

        The names are those of the attributes, but: each of `errors` has an entry of its own, the
        verdict is `single_verdict`, and the defects are `defect`. `exceeds_1deg_at` is added;
        `recorded`, `solution`, `series`, `is_single` and `resolution` are left out.
        """
        return {
            "timestep": self.timestep,
            **{SIGNAL[signal].key: error for signal, error in self.errors.items()},
            "exceeds_1deg_at": self.exceeds_1deg_at,
            "drifts": self.drifts,
            "single_verdict": self.verdict,
            "is_beyond": self.is_beyond,
            "explained_by": list(self.explained_by),
            "made_by": self.made_by,
            "measured": self.measured.as_record() if self.measured else None,
            "remarks": list(self.remarks),
            "defect": {signal: asdict(defect) for signal, defect in self.defects.items()},
            "ignored": list(self.ignored),
        }

    @property
    def exceeds_1deg_at(self) -> float | None:
        """The first time at which the error of the attitude exceeds 1°, s; None if never."""
        return self._beyond_since("attitude", DEGREE)

    def beyond(self, bounds: Mapping[str, float]) -> list[str]:
        """Return a sentence for each bound that an error exceeds; empty if none is exceeded.

        Parameters
        ----------
        bounds : the largest errors allowed, by signal; of the attitude in rad, else relative

        Raises
        ------
        RecordingError
            If there is a bound for a signal that was not recorded.
        """
        if unrecorded := [name for name in bounds if self.errors[name] is None]:
            raise RecordingError(f"'{unrecorded[0]}' cannot be checked: it was not given")
        return [
            f"{SIGNAL[name].label} is off by {error:.3g} {SIGNAL[name].unit or '(relative)'}, "
            f"more than {bound:.3g} from t = {since:.4g} s on"
            for name, bound in bounds.items()
            if (error := self.errors[name]) is not None
            and (since := self._beyond_since(name, bound)) is not None
        ]

    def _beyond_since(self, name: str, bound: float) -> float | None:
        """Return the first time at which a signal's error exceeds a bound, s; None if never."""
        first = self.series.first_beyond(name, bound)
        return None if first is None else float(self.solution.trajectory.t[first])


def judged_motion(scenario: Scenario, recording: Recording, order: int = 1) -> JudgedMotion:
    """Compare a recorded motion with the exact one at the same times, and explain its errors.

    Parameters
    ----------
    recording : the recorded motion, whose settings may state a timestep, and how to read it
    order : order of accuracy that the motion's method has or claims

    Raises
    ------
    RecordingError
        In any of these cases: the timestep is not positive, or is longer than the longest time
        between two samples; the exact motion is not known up to the last time; the times are so
        late that they must be in another unit than s; ω was not recorded and the attitudes are too
        far apart to compute it; the number of spins is not that of the scene's rotors.
    """
    stated = recording.settings.get("timestep")
    timestep = None if stated is None else float(stated)
    _check_timestep(timestep, recording.arrays["t"])
    solution = exact_at(scenario, recording.arrays["t"])
    exact, reading = solution.trajectory, reading_of(recording)
    recorded = recorded_motion(scenario, recording, reading, exact)
    case = Case(scenario, recording, reading, exact, recorded, timestep, order)
    series = error_series(scenario, recorded.trajectory, exact)
    lacks = [name for name in OPTIONAL if name not in recording.arrays]
    absent = lacks if not scenario.constraint.is_pivot else []
    absent += ["omega"] * (not recorded.has_omega) + ["spins"] * (not recorded.has_spins)
    errors = dict(series.worst()) | dict.fromkeys(absent)
    of_steps = defects(scenario, recorded.trajectory, exact)
    explanation = explained(case)
    of_places = mistakes_of_translation(scenario, exact, recording, recorded.trajectory)
    if not (of_places or explanation.explained_by or explanation.is_beyond):
        of_motion = scenario, exact, recording, recorded.trajectory, timestep
        of_places = other_translation(*of_motion) + other_spins(*of_motion)
    return JudgedMotion(
        recorded,
        solution,
        timestep,
        explanation.verdict,
        explanation.is_beyond,
        errors=errors,
        series=series,
        drifts=_drifts(scenario, recorded),
        defects=of_steps.summary(len(exact.t) - 1, EPS) if of_steps else {},
        explained_by=(*explanation.explained_by, *of_places),
        made_by=explanation.made_by,
        measured=explanation.measured,
        remarks=tuple(filter(None, [recording.drift_off_the_sphere])),
        ignored=recording.ignored,
        is_single=recording.is_single,
        resolution=recording.resolution,
    )


def _drifts(scenario: Scenario, recorded: RecordedMotion) -> dict[str, float]:
    """Return the largest relative drift of each conserved quantity, by its name.

    The drift of the rotors' momenta is left out if spins were not recorded, as these were computed
    from constant momenta.
    """
    found = drifts(scenario, recorded.trajectory)
    if not recorded.has_spins:
        found.pop("rotors_momentum", None)
    return found


def _check_timestep(timestep: float | None, times: FloatArray) -> None:
    """Check that a stated timestep is possible with the times of samples.

    Parameters
    ----------
    timestep : s; if None, there is nothing to check
    times : times of the n samples, s, (n,)

    Raises
    ------
    RecordingError
        If the timestep is not positive, or longer than the longest time between two samples.
    """
    if timestep is not None and not timestep > 0:
        raise RecordingError(f"'timestep' must be a positive number of seconds, got {timestep:g}")
    distance = float(np.diff(times).max())
    if timestep is not None and timestep > (1 + TIME_TOLERANCE) * distance:
        raise RecordingError(
            f"its timestep is stated as {timestep:g} s, but no two samples are more than "
            f"{distance:g} s apart; state that of its steps, or leave out samples in between"
        )
