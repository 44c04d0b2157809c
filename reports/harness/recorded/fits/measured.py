"""Puts the fit of a measured motion in words and in a record: noise, tensor and changes."""

import numpy as np

from .....scenarios import FloatArray
from .....scenarios.rotation import norms
from ....results.change_words import KINDS
from ...explaining.changes import is_scaled
from ...explaining.fit import Fit
from ...explaining.hypothesis import Change
from ..samples.missing import KINEMATICS
from ..samples.sensors import CROSS_AXIS, OF_LOGS, of_sensor, shortest
from .log_fit import START, LogFit
from .starts import started_elsewhere

#: What the verdict adds if samples were left out.
LEFT_OUT = (
    "; samples after t = {:.4g} s are left out, as a difference of the start by rounding has grown "
    "to the noise there"
)


class Measured(LogFit):
    """The fit of a measured motion, with its results in words and as a record for JSON."""

    @property
    def verdict(self) -> str:
        """A sentence on whether the residuals of the best fit are within noise."""
        of_attitude, in_omega = np.degrees(self.log.noise[0]), self.log.noise[1]
        noise = f"a noise of {of_attitude:.3g}° in attitude"
        noise += f" and {in_omega:.3g} rad/s in ω" if self.log.has_omega else ""
        known = "stated" if self.log.is_stated else "estimated"
        where = "beyond" if self.is_beyond else "within"
        left_out = LEFT_OUT.format(self.log.t[-1]) if self.log.dropped else ""
        return (
            f"{where} {noise}, which is {known}: χ² is {self.chi2:.0f}, of {self.freedom} degrees "
            f"of freedom{left_out}"
        )

    def tensor_in_words(self) -> str:
        """Return a sentence with the fitted tensor and its standard errors.

        If the samples do not determine the tensor, or if residuals far exceed noise, the sentence
        says that instead.
        """
        if self.is_far:
            return "No tensor is given: what is left is far beyond noise."
        if not self.shows_tensor:
            return "No tensor is given: the motion does not show it beside what explains it."
        free = "" if is_scaled(self.log.base) else ", up to a factor"
        entries = _plus_minus(*self.tensor_entries())
        return f"The tensor Ixx, Iyy, Izz, Ixy, Ixz, Iyz that fits best is {entries} kg m²{free}."

    def as_record(self) -> dict[str, object]:
        """Return the results by name, for JSON, in rad, rad/s and kg m².

        They are `noise` of `attitude` and `omega`, `noise_is_stated`, `chi2`, `degrees_of_freedom`,
        and six entries each of `tensor` and `tensor_standard_error`. These two are None if the
        samples do not determine the tensor, or if residuals far exceed noise.
        """
        is_given = not self.is_far and self.shows_tensor
        of_tensor = [one.tolist() for one in self.tensor_entries()] if is_given else [None, None]
        attitude, omega = map(float, self.log.noise)
        return {
            "noise": {"attitude": attitude, "omega": omega},
            "noise_is_stated": self.log.is_stated,
            "chi2": self.chi2,
            "degrees_of_freedom": self.freedom,
            "tensor": of_tensor[0],
            "tensor_standard_error": of_tensor[1],
        }

    def explained(self, but: Change | None = None) -> list[str]:
        """Return sentences on the changes that the samples require, or on which part is exact.

        If the residuals exceed noise, and the attitudes alone, ω alone, or all but the times agree
        with the exact motion, the only sentence says so. If noise is not stated and all but the
        times agrees, the only sentence says so even if the residuals are within noise. If the
        residuals far exceed noise and no part agrees, the list is empty.

        Parameters
        ----------
        but : a change on which no sentence is returned; None for sentences on all
        """
        if self.is_far or (self.is_beyond and self.right_by_itself):
            return self.right_by_itself
        if not self.given.is_stated and self.uneven_times:
            return self.uneven_times
        required = [one for one in self.fit.changes if one is not but and self.is_required(one)]
        # Changes of the equations are named before mistakes of sensors, specific ones first.
        of_sensors = [*OF_LOGS, CROSS_AXIS]
        required.sort(
            key=lambda one: (
                (1, of_sensors.index(one)) if one in of_sensors else (0, len(one.scales))
            )
        )
        return [self._in_words(change) for change in required]

    def _in_words(self, change: Change) -> str:
        """Return a sentence on a change, with its fitted parameters and their standard errors."""
        indices = self.fit.columns(change)
        values, errors = self.fit.parameters[indices], self.fit.errors[indices] * self.inflation
        if change in (*OF_LOGS, CROSS_AXIS):
            others = (
                f", or {self._of_sensor(other, fit)} ({likely:.2g} times as likely)"
                for likely, other, fit in self.alternatives(change)
            )
            return self._of_sensor(change, self.fit) + "".join(others)
        if change is START:
            return started_elsewhere(self.log.t[0], norms(values.reshape(2, 3)))
        if change is self.late:
            when = "before" if values[0] > 0 else "after"
            late = _plus_minus(np.abs(values), errors)
            return f"each state is that of {late} s {when} its time"
        if change.kind == "tilt":
            return f"{self.fit.explanation(change).words} (± {np.degrees(errors.max()):.2g}°)"
        if change is self.axes:
            turn = _plus_minus(np.degrees(shortest(values)), np.degrees(errors))
            return f"attitude and ω are those of axes that are turned by {turn}° in the body"
        if change.kind == self.by_attitude.kind:
            # A dipole also has parameters that are angles, not torques, and have another scale.
            of_torque = errors[change.scales == change.scales[0]]
            listed = f"{norms(of_torque[None])[0]:.2g} N m"
        else:
            listed = ", ".join(f"{error:.2g}" for error in errors)
        listed = f" (± {listed})" if listed else ""
        before = "" if KINDS[change.kind].is_kinematic else "it moves as if "
        if change not in self.general and not before:
            before = f"{KINEMATICS}: "
        return f"{before}{self.fit.explanation(change).words}{listed}"

    def _of_sensor(self, change: Change, fit: Fit) -> str:
        """Return a sentence on a sensor's error, with its parameters in a fit and their errors."""
        indices = fit.columns(change)
        values, errors = fit.parameters[indices], fit.errors[indices] * self.inflation
        return of_sensor(change, values, lambda n, unit: _plus_minus(n, unit * errors))


def _plus_minus(values: FloatArray, errors: FloatArray) -> str:
    """Return k values with their standard errors, both (k,), as text."""
    each = [f"{n:.5g} ± {e:.2g}" for n, e in zip(values, errors, strict=True)]
    return each[0] if len(each) == 1 else f"[{', '.join(each)}]"
