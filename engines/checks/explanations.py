"""Finds the one change of a scene that explains the equation residuals of an engine's first steps.

To first order a change of the model by θ adds B θ to what the states gain, B known from the scene.
θ is fitted to the gains from several starts at once, by least squares; a change explains them if
nothing but noise is left. Of several explanations, the one with the fewest numbers is reported.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...scenarios import FloatArray
from ...scenarios.rotation import cross, matrix
from .equations import Equations, Gain

#: Replaces a size of zero; its inverse can be squared.
NO_SIZE = 1e-100
#: Fraction that may be left unexplained: the fit is linear in θ, the model need not be.
LINEAR, LINEAR_AT_MOST = 1e-2, 0.2
#: A change of a factor this close to ±1, … is taken for it, as is one within its uncertainty.
WHOLE = 1e-2
#: A number with a smaller effect than this, relative to the others, is ignored.
RANK = 1e-6
#: A change that seven digits show to a tenth.
VISIBLE = 1e-5
#: Two changes are distinguished if what they leave unexplained differs by this factor.
ALIKE = 4.0


@dataclass(frozen=True, eq=False)
class _Change:
    """A change of the model.

    Attributes
    ----------
    effects : what each of its m numbers adds to the gains from n starts, (n, 4, 3, m)
    words : describes the numbers fitted, (m,); empty if they are impossible
    is_factor : whether its numbers are changes of a factor, of which whole ones have words
    """

    effects: FloatArray
    words: Callable[[FloatArray], str]
    is_factor: bool = False


def explanation(equations: Equations, gains: Sequence[Gain], noise: FloatArray) -> str:
    """The change of the model that explains the gains, in words; empty if no single one does.

    Parameters
    ----------
    noise : of the gains' excess, (n, 4)
    """
    excess = np.array([gain.excess for gain in gains])
    weights = 1 / np.maximum(noise, NO_SIZE)[..., None]
    seen = (weights * excess).ravel()
    candidates = []
    for change in _changes(equations, gains):
        matrix = (weights[..., None] * change.effects).reshape(len(seen), -1)
        # Numbers without an effect, such as the scale of a free body's tensor, are not changed.
        theta, _, count, _ = np.linalg.lstsq(matrix, seen, rcond=RANK)
        left = (seen - matrix @ theta).reshape(weights.shape[0], 4, 3)
        size = float(np.linalg.norm(excess / np.maximum(_sizes(gains), NO_SIZE)))
        slack = np.abs(seen).max() * min(max(LINEAR, size), LINEAR_AT_MOST)
        rest = float(np.abs(left).max())
        if change.is_factor:
            # What is left, or the noise, may be of any sign in every number seen.
            unsure = max(1.0, rest) * np.abs(np.linalg.pinv(matrix, RANK)).sum(axis=1)
            whole = np.round(theta)
            near = np.maximum(WHOLE * (whole != 0), unsure)
            theta = np.where(np.abs(theta - whole) <= near, whole, theta)
        if rest <= max(1.0, slack) and (words := change.words(theta)):
            candidates.append((count, rest, words))
    if not candidates:
        return ""
    fewest = [one for one in candidates if one[0] == min(candidates)[0]]
    # Some changes are equivalent; the first of them is reported.
    best = min(rest for _, rest, _ in fewest)
    return next(words for _, rest, words in fewest if rest <= max(1.0, ALIKE * best))


def _sizes(gains: Sequence[Gain]) -> FloatArray:
    """Sizes of the exact gains, (n, 4, 1)."""
    return np.array([np.linalg.norm(gain.wanted, axis=1) for gain in gains])[..., None]


def _changes(equations: Equations, gains: Sequence[Gain]) -> Iterator[_Change]:
    starts = [_Start(equations, gain) for gain in gains]

    def effect(*columns: Callable[["_Start"], FloatArray]) -> FloatArray:
        return np.stack([[column(start) for start in starts] for column in columns], axis=-1)

    # Of a body held by a constraint what is due to spin about the com may be left out alone.
    com = equations.scenario.body.inertia_com
    yield _Change(
        effect(lambda s: s.torque(cross(s.omega, com @ s.omega))),
        lambda theta: _gyroscopic(theta) if theta[0] == 1 else "",
        True,
    )
    yield _Change(effect(lambda s: s.torque(s.gyroscopic)), _gyroscopic, True)
    if equations.scenario.gravity_world.any():
        pull = equations.scenario.gravity_world
        yield _Change(effect(lambda s: s.gravity(pull)), _strength, True)
        axes = np.eye(3)
        yield _Change(
            effect(*(lambda s, axis=axis: s.gravity(axis) for axis in axes)),
            lambda theta: f"gravity were {_numbers(equations.scenario.gravity_world + theta)} m/s²",
        )
    yield _Change(effect(lambda s: s.torque(-s.omega)), _resistance)
    yield _Change(effect(lambda s: s.torque(-s.L)), _decay)
    yield _Change(
        effect(lambda s: s.torque(-s.L), lambda s: s.torque(-s.L * np.linalg.norm(s.omega))),
        _decays,
    )
    acting = equations.scenario.acting
    if words := next((one.wrong_momentum for one in acting if one.wrong_momentum), ""):
        yield _Change(
            effect(lambda s: s.torque(-cross(s.omega, s.kept))),
            lambda t: words.format(_factor(t[0])),
        )
    yield _Change(effect(lambda s: s.gain.wanted * s.is_rate), _step)
    yield _Change(
        effect(_Start.scaled_omega), lambda t: f"ω were read multiplied by {_factor(t[0])}"
    )
    yield _Change(
        effect(lambda s: s.scaled_velocity()),
        lambda t: f"the velocity were read multiplied by {_factor(t[0])}",
    )
    yield from _body_changes(equations, effect)


def _body_changes(equations: Equations, effect: Callable[..., FloatArray]) -> Iterator[_Change]:
    moments, axes = np.linalg.eigh(equations.inertia)
    tensors = [np.outer(axis, axis) for axis in axes.T]
    yield _Change(
        effect(*(lambda s, tensor=tensor: s.torque(s.of_tensor(tensor)) for tensor in tensors)),
        lambda theta: _moments(moments, theta),
    )
    if not equations.scenario.constraint.is_pivot:
        return
    com, mass = np.array(equations.scenario.body.com), equations.scenario.body.mass

    def moved(s: "_Start", axis: FloatArray) -> FloatArray:
        tensor = mass * (2 * (com @ axis) * np.eye(3) - np.outer(com, axis) - np.outer(axis, com))
        pull = mass * cross(axis, equations.scenario.gravity_world @ s.R)
        added = s.torque(pull + s.of_tensor(tensor))
        added[2], added[3] = s.R @ cross(s.omega, axis), s.R @ axis
        return added

    yield _Change(
        effect(*(lambda s, axis=axis: moved(s, axis) for axis in np.eye(3))),
        lambda theta: f"the com were at {_numbers(com + theta)} m",
    )


class _Start:
    """The contributions of changes of a model to a gain, each (4, 3)."""

    def __init__(self, equations: Equations, gain: Gain) -> None:
        self.equations, self.gain = equations, gain
        middle = equations.after(gain.before, gain.span / 2)
        self.R = matrix(middle.q_world_body_wxyz)
        self.omega = middle.omega_body
        self.kept = equations.kept_body(middle)
        self.L = equations.inertia @ self.omega + self.kept
        self.gyroscopic = cross(self.omega, self.L)
        self.omega_rate = equations.inverse @ equations.torque_body(self.R, self.omega, self.kept)
        pivot = equations.scenario.constraint.is_pivot
        self.is_rate = np.array([1, 1, not pivot, not pivot], dtype=float)[:, None]

    def torque(self, torque_body: FloatArray) -> FloatArray:
        """The change of the gain by an additional torque."""
        return self._answered(torque_body, np.zeros(3))

    def _answered(self, torque_body: FloatArray, pull_world: FloatArray) -> FloatArray:
        """The change by a torque and an acceleration, and by what a constraint does about them."""
        scenario, up_body = self.equations.scenario, self.R[2]
        if scenario.answer is not None:
            added = up_body, np.zeros(3), torque_body, pull_world
            torque_body, pull_world = scenario.answer(scenario, *added)
        return np.array([np.zeros(3), torque_body, pull_world, np.zeros(3)])

    def of_tensor(self, tensor: FloatArray) -> FloatArray:
        """The torque that an additional tensor causes."""
        return -tensor @ self.omega_rate - cross(self.omega, tensor @ self.omega)

    def gravity(self, gravity_world: FloatArray) -> FloatArray:
        """The change of the gain by additional gravity."""
        if not self.equations.scenario.constraint.is_pivot:
            return self._answered(np.zeros(3), gravity_world)
        body = self.equations.scenario.body
        return self.torque(body.mass * cross(body.com, gravity_world @ self.R))

    def scaled_omega(self) -> FloatArray:
        """The effect of a reading of ω too large: a larger gain, and the body turns less."""
        outer = self.equations.outer_body(self.R, np.zeros(3))
        added = self.torque(outer + self.gyroscopic)
        added[0] = -self.omega
        if self.equations.scenario.constraint.is_pivot:
            added[2] = -self.gain.wanted[2]
        return added

    def scaled_velocity(self) -> FloatArray:
        """The effect of a reading of the com's velocity that is too large."""
        added = np.zeros((4, 3))
        if self.equations.scenario.constraint.is_pivot:
            added[2] = self.gain.wanted[2]
        else:
            added[2], added[3] = self.gain.wanted[2], -self.gain.wanted[3]
        return added


def _gyroscopic(theta: FloatArray) -> str:
    if theta[0] == 1:
        return "there were no gyroscopic torque"
    strength = f"the gyroscopic torque ω × Iω were {_factor(-theta[0])} times as strong"
    return strength if theta[0] else ""


def _strength(theta: FloatArray) -> str:
    if theta[0] == -2:
        return "gravity were turned round"
    if theta[0] == -1:
        return "there were no gravity"
    return f"gravity were {_factor(theta[0])} times as strong" if theta[0] else ""


def _resistance(theta: FloatArray) -> str:
    return f"it were {'slowed' if theta[0] > 0 else 'sped up'} by {abs(theta[0]):.3g} N m s"


def _decay(theta: FloatArray) -> str:
    return f"L were {'slowed' if theta[0] > 0 else 'sped up'} by {abs(theta[0]):.3g} /s"


def _decays(theta: FloatArray) -> str:
    sign = "-" if theta[1] < 0 else "+"
    return f"L were slowed by {theta[0]:.3g} {sign} {abs(theta[1]):.3g} ‖ω‖ /s"


def _step(theta: FloatArray) -> str:
    return f"a step took {_factor(theta[0])} timesteps"


def _moments(moments: FloatArray, theta: FloatArray) -> str:
    other = moments + theta
    return f"the moments were {_numbers(other)} kg m²" if (other > 0).all() else ""


def _factor(change: float) -> str:
    """One and a change, with as many digits as show it."""
    return f"{1 + change:.{7 if abs(change) > VISIBLE else 11}g}"


def _numbers(vector: FloatArray) -> str:
    return f"[{', '.join(f'{value:.7g}' for value in vector)}]"
