"""A small engine that is right but for one planted fault, and a catalogue of faults.

Written by somebody who did not write the checks: what real engines get wrong, from 0.1 to 1e-9 of
the largest terms. `tests/reports/harness/measure_power.py` draws from it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.linalg import norm
from spincheck.engine import BodyReading, EngineError, Scenario, Session, State, start_state
from spincheck.scenarios.rotation import matrix

TABLEAUS = {
    2: ([[], [0.5]], [0, 1]),
    4: ([[], [0.5], [0, 0.5], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6]),
}


def cross(a: Any, b: Any) -> Any:
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def product(p: Any, q: Any) -> Any:
    (a, b, c, d), (w, x, y, z) = p.tolist(), q.tolist()
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def turn(v: Any) -> Any:
    """Quaternion of a rotation vector."""
    angle = float(np.sqrt(v @ v))
    return np.array([np.cos(angle / 2), *(np.sinc(angle / 2 / np.pi) / 2 * v)])


def f32(value: Any) -> Any:
    return np.asarray(value).astype(np.float32).astype(float)


class Top(Session):
    """Integrates what a scene asks for, but for a fault; y is q, ω, com and its velocity."""

    can_restart = True

    def __init__(self, scenario: Scenario, order: int, single: bool, h: float, p: Any) -> None:
        self.scenario, self.order, self.single, self.h = scenario, order, single, h
        self.fault, self.e, self.u, self.r, self.unit = p.fault, p.size, p.axis, p.part, p.unit
        self.span, self.top, self.least_h = scenario.window.duration, p.speeds[1], p.speeds[0]
        self.stock, self.rng = p.stock, np.random.default_rng()
        self.m, self.com, self.g = (
            scenario.body.mass,
            scenario.constraint.lever,
            scenario.gravity_world,
        )
        self.I, self.pivot = np.array(scenario.inertia), scenario.constraint.is_pivot
        self.inv, pushed = np.linalg.inv(self.I), scenario.pushed
        self.c, self.tb, self.tw = pushed["drag"], pushed["torque_body"], pushed["torque_world"]
        self.tableau, self.lasting = TABLEAUS.get(order), 0
        self.restart(start_state(scenario))
        self.fault.setup(self)
        self.heaviest = self.m * norm(self.com) * norm(self.g)
        self.one = (np.arange(3) == int(3 * self.r)).astype(float)
        if self.fault.start:
            self.fault.start(self)

    def restart(self, state: State, timestep: float | None = None) -> None:
        self.h, self.n, self.t, self.store = timestep or self.h, 0, 0.0, {}
        parts = state.q_world_body_wxyz, state.omega_body, state.com_world, state.velocity_world
        self.y = np.concatenate(parts)
        self.kept = self.scenario.kept(state.omega_body, state.spins)
        self.K = self.scenario.kept_body(self.kept)
        if self.single:
            self.y = f32(self.y)

    def pull(self, R: Any) -> Any:
        return self.m * cross(self.com, self.g @ R) if self.pivot else np.zeros(3)

    def gyro(self, w: Any) -> Any:
        return cross(self.I @ w, w)

    def torque(self, R: Any, w: Any) -> Any:
        honest = self.honest(R, w)
        return honest + self.fault.torque(self, R, w) if self.fault.torque else honest

    def honest(self, R: Any, w: Any) -> Any:
        return self.pull(R) - self.c * w + self.tb + self.tw @ R + cross(self.I @ w + self.K, w)

    def now(self) -> Any:
        return self.honest(matrix(self.y[:4]), self.y[4:7])

    def size(self) -> float:
        """m, of the body: of its arm, or a radius of gyration."""
        arm = float(norm(self.com)) if self.pivot else 0.0
        return arm or float(np.sqrt(np.trace(self.I) / 3 / self.m))

    def slope(self, y: Any) -> Any:
        q, w = y[:4], y[4:7]
        R, out = matrix(q), np.empty(13)
        out[4:7] = self.inv @ self.torque(R, w)
        turning = w + self.fault.turn(self, R, w) if self.fault.turn else w
        out[:4] = product(q, np.array([0.0, *(turning / 2)]))
        out[7:10], out[10:] = y[10:], 0.0 if self.pivot else self.g
        if self.fault.fall:
            out[10:] += self.fault.fall(self)
        return out

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            h = self.h
            if self.tableau:
                slopes: list[Any] = []
                for row in self.tableau[0]:
                    at = sum((h * a * k for a, k in zip(row, slopes, strict=True)), self.y)
                    slopes.append(self.slope(at))
                self.y = self.y + h * sum(
                    b * k for b, k in zip(self.tableau[1], slopes, strict=True)
                )
            else:
                first = self.slope(self.y)
                y = self.y + h * first
                R = matrix(self.y[:4])
                w = y[4:7] + (self.fault.turn(self, R, y[4:7]) if self.fault.turn else 0.0)
                y[:4] = product(self.y[:4], turn(h * w))
                y[7:10] = self.y[7:10] + h * y[10:]
                self.y = y
            self.n, self.t = self.n + 1, self.t + h
            if self.fault.end:
                self.fault.end(self)
            self.y[:4] /= np.sqrt(self.y[:4] @ self.y[:4])
            if self.single:
                self.y = f32(self.y)

    def read_body(self) -> BodyReading:
        body = self.scenario.body
        return BodyReading(body.mass, body.com, body.inertia_com, self.scenario.rotors.axial_body)

    def read_state(self) -> State:
        q, w, x, v = np.split(self.y.copy(), [4, 7, 10])
        if self.pivot:
            R = matrix(q)
            x, v = R @ self.com, R @ cross(w, self.com)
        state = State(q, w, x, v, self.scenario.spins(w, self.kept))
        return self.fault.seen(self, state) if self.fault.seen else state

    def check(self) -> None:
        if not np.isfinite(self.y).all():
            raise EngineError("a number is not finite", "not-finite")

    def active(self) -> frozenset[str]:
        return self.scenario.called_for

    def close(self) -> None:
        pass


@dataclass(frozen=True)
class Fault:
    """A kind: what it needs of a scene, how it is named rightly, and what is done.

    Attributes
    ----------
    needs : letters: g gravity's torque, d drag, t torque, r rotors, f free, p pivot, w weight of a
        free body, n no single precision, and of wrapped engines m MuJoCo, b any
    words : a pattern of the reason that names it; a group must be 1 + size
    torque, turn, fall : N m, rad/s and m/s² besides
    start, end, seen : when it is loaded, after a step, of a reading
    vanishes : with the timestep, at this order; 0 where it does not: a fault
    nominal : the relative effect where it is not that of what is besides
    """

    name: str
    needs: str = ""
    words: str = ""
    torque: Callable[..., Any] | None = None
    turn: Callable[..., Any] | None = None
    fall: Callable[..., Any] | None = None
    end: Callable[..., Any] | None = None
    seen: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    setup: Callable[..., Any] = lambda s: None
    vanishes: int = 0
    nominal: float = 0.0


Q, W, X, V = slice(0, 4), slice(4, 7), slice(7, 10), slice(10, 13)
F = Fault
DW, DR, MORE = r"I dω/dt|I ω", r"dR/dt|attitude", "depends on more than the state"
SWAP = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
TENSOR, AGAIN = (
    "moments were|tensor were|I(?:xx|yy|zz|xy|xz|yz) were",
    "more than the state|not deterministic",
)


def add(s: Top, at: slice, change: Any) -> None:
    s.y = s.y.copy()
    s.y[at] += change


def spin(s: Top, rotation: Any) -> None:
    s.y = np.concatenate([product(s.y[Q], turn(rotation)), s.y[4:]])


def push(s: Top, share: float = 1.0) -> Any:
    """A torque of the planted size, N m."""
    return s.e * share * s.unit * s.u


def kick(s: Top, share: float = 1.0) -> None:
    add(s, W, s.e * share * s.top * s.u)


def last(s: Top, name: str, value: Any) -> Any:
    """What was kept under a name; keeps another."""
    before = s.store.get(name, value)
    s.store[name] = value
    return before


def relaxed(s: Top, name: str, value: Any, steps: float) -> Any:
    """A value behind a low-pass filter."""
    old = s.store.get(name, value)
    s.store[name] = old + (value - old) / steps
    return s.store[name]


def read(s: Any, x: State, **other: Any) -> State:
    return replace(x, **other)


def scaled_entry(s: Top) -> Any:
    return np.diag([s.e, 0.0, 0.0]) @ s.I @ np.diag([1.0, 0.0, 0.0])


def other_tensor(s: Top, R: Any, w: Any, more: Any) -> Any:
    honest = s.honest(R, w)
    return s.I @ np.linalg.solve(s.I + more, honest + cross(more @ w, w)) - honest


def stale(s: Top, R: Any, w: Any) -> Any:
    """The gyroscopic torque of the tensor as it was in the world's axes, less that of it now."""
    M = s.store.setdefault("R", R).T @ R
    return cross(M.T @ s.I @ M @ w, w) - s.gyro(w)


def late(s: Any, x: State) -> State:
    """One step old."""
    now = s.store.get("now", (-1, x, x))
    if now[0] != s.n:
        s.store["now"] = (s.n, x, now[1])
    return s.store["now"][2]


def slowed(s: Top, share: float) -> None:
    """Rotors lose a share of what they keep."""
    s.K, s.kept = s.K * (1 - share), s.kept * (1 - share)


def delayed(s: Top, R: Any, w: Any) -> Any:
    """The torque of a twentieth of the window ago, less that of now."""
    now = s.store.setdefault(s.n, s.honest(R, w))
    return s.store.get(s.n - int(0.05 * s.span / s.h), now) - s.honest(R, w)


def of_another_point(s: Any, x: State) -> State:
    beside = cross(x.omega_body, s.e * s.u * s.size())
    return read(s, x, velocity_world=x.velocity_world + matrix(x.q_world_body_wxyz) @ beside)


def anew(s: Any, _: Any = None) -> None:
    """MuJoCo's constants follow what was changed in the model."""
    import mujoco

    mujoco.mj_setConst(s.model, s.inner.data)
    s.restart(start_state(s.scenario))


def damped(s: Any) -> None:
    import mujoco

    s.model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_DAMPER)
    s.model.dof_damping[-3:] += s.e * s.unit / s.top


def bump(s: Top, value: float, width: float) -> float:
    return float(np.exp(-((value / width) ** 2)))


# fmt: off
FAULTS = (
    # Weight.
    F("gravity 1 + e", "g", r"gravity were (\S+) times", lambda s, R, w: s.e * s.pull(R)),
    F("gravity tilted", "g", r"gravity were \[", lambda s, R, w: s.m * cross(s.com, cross(s.e * s.u,
      s.g) @ R)),
    F("gravity on another point", "g", "com were at", lambda s, R, w: s.e * norm(s.com) * s.m *
      cross(s.u, s.g @ R)),
    F("part of a component of gravity's torque", "g", "", lambda s, R, w: -s.e * s.pull(R) * s.one),
    F("gravity's torque in float32", "gn", "", lambda s, R, w: f32(s.pull(R)) - s.pull(R)),
    F("gravity's torque cut off where small", "g", "", lambda s, R, w: (-s.pull(R) *
      (norm(s.pull(R)) < s.e * s.heaviest))),
    F("gravity's torque from a fine table", "g", "", lambda s, R, w: s.e * s.pull(R) * np.sin(60 *
      R[2, 2])),
    F("gravity's torque from rounded attitudes", "g", "", lambda s, R, w: s.m * cross(s.com, s.g @
      (np.round(R / s.e) * s.e - R))),
    F("gravity's torque clamped near its largest", "g", "", lambda s, R, w: (-s.pull(R) * max(0.0, 1
      - (1 - s.e) * s.heaviest / (1e-300 + norm(s.pull(R)))))),
    F("sin x ≈ x - e x³", "g", "", lambda s, R, w: -s.e * s.pull(R) * (1 - R[2, 2] ** 2)),
    F("weight 1 + e", "w", r"gravity were (\S+) times", fall=lambda s: s.e * s.g),
    F("weight tilted", "w", r"gravity were \[", fall=lambda s: cross(s.e * s.u, s.g)),
    F("weight less with height", "w", "gravity", fall=lambda s: -s.e * s.g * s.y[9] / (1 +
      abs(s.y[9]))),
    # Gyroscopic torque and tensor.
    F("gyroscopic torque 1 + e", "", r"gyroscopic torque.* were (\S+) times|G:", lambda s, R, w: s.e
      * s.gyro(w)),
    F("part of a component of it", "", "", lambda s, R, w: -s.e * s.gyro(w) * s.one),
    F("gyroscopic with another moment", "", "G:", lambda s, R, w: cross(scaled_entry(s) @ w, w)),
    F("tensor partly stale", "", "", lambda s, R, w: s.e * stale(s, R, w)),
    F("a moment 1 + e", "", TENSOR, lambda s, R, w: other_tensor(s, R, w, scaled_entry(s))),
    F("a product of inertia in the inverse", "", "", lambda s, R, w: s.e * SWAP @ s.honest(R, w)),
    F("gyroscopic torque about turned axes", "", "G:", lambda s, R, w: cross(cross(s.e * s.u, s.I @
      w) - s.I @ cross(s.e * s.u, w), w)),
    F("gyroscopic torque cut off at low rates", "", "", lambda s, R, w: -s.gyro(w) *
      (norm(s.gyro(w)) < s.e * s.unit)),
    F("gyroscopic torque with ω clamped", "", "", lambda s, R, w: (s.gyro(w) * (min(1.0, 0.95 *
      s.top / (1e-300 + norm(w))) ** 2 - 1) * s.e)),
    # Drag.
    F("drag 1 + e", "d", r"drag were (\S+) times|slowed|sped", lambda s, R, w: -s.e * s.c * w),
    F("drag quadratic besides", "", "slowed|decay", lambda s, R, w: -s.e * s.unit * w * norm(w) /
      s.top**2),
    F("damping of ω", "", "slowed|drag", lambda s, R, w: -s.e * s.I @ w * s.top),
    F("damping about one axis", "", "", lambda s, R, w: -s.e * s.unit / s.top * s.u * (s.u @ w)),
    F("dry friction", "", "", lambda s, R, w: -s.e * s.unit * w / (1e-300 + norm(w))),
    F("drag ends below a speed", "d", "", lambda s, R, w: s.c * w * (norm(w) < s.top * min(0.9, 3 *
      s.e))),
    F("lift: a torque along ω × u", "", "", lambda s, R, w: s.e * s.unit / s.top * cross(w, s.u)),
    F("ω shrinks by e each step", "", "I ω is off|ω", end=lambda s: add(s, W, -s.e * s.y[W])),
    # Torques.
    F("torque 1 + e", "t", r"torque were (\S+) times", lambda s, R, w: s.e * (s.tb + s.tw @ R)),
    F("torque along turned axes", "t", "torque of", lambda s, R, w: cross(s.e * s.u, s.tb + s.tw @
      R)),
    F("torque besides, in body axes", "", "body axes|com were at", lambda s, R, w: push(s)),
    F("torque besides, in world axes", "", "world axes", lambda s, R, w: push(s) @ R),
    F("torque that oscillates with attitude", "", "torque of", lambda s, R, w: push(s, np.sin(20 *
      R[0, 0]))),
    # Kinematics.
    F("turns 1 + e times as fast", "", r"turns (\S+) times", turn=lambda s, R, w: s.e * w),
    F("turns about turned axes", "", "axes turned|matrix", turn=lambda s, R, w: cross(s.e * s.u,
      w)),
    F("turns with one component off", "", "matrix", turn=lambda s, R, w: s.e * w * s.one),
    F("world turns", "", "", turn=lambda s, R, w: s.e * s.top * s.u @ R),
    F("turning by a series in ω², cut", "", "", turn=lambda s, R, w: -s.e * w * (w @ w) / s.top**2),
    F("attitude turns by e each step", "", "attitude is off", end=lambda s: spin(s, s.e * s.u)),
    F("renormalised with one component off", "", "attitude", end=lambda s: add(s, Q, s.e * s.y[0] *
      np.array([0, 1.0, 0, 0]))),
    # Time and memory.
    F("torque after half of the window", "", MORE, lambda s, R, w: push(s, s.t > s.span / 2)),
    F("torque up to a time", "", "torque of", lambda s, R, w: push(s, s.t < s.r * s.span / 2)),
    F("torque after N steps", "", MORE, lambda s, R, w: push(s, s.n > 20 + 30 * s.r)),
    F("torque that oscillates with time", "", "torque of", lambda s, R, w: push(s, np.sin(2 * np.pi
      * s.t / s.span))),
    F("one kick", "", MORE, end=lambda s: kick(s, s.n == int(5 + 40 * s.r)), nominal=1),
    F("a kick each 16 steps", "", MORE, end=lambda s: kick(s, s.n % 16 == 0), nominal=1),
    F("a kick each 100 steps", "", MORE, end=lambda s: kick(s, s.n % 100 == 0), nominal=1),
    F("put to sleep after 30 slow steps", "", MORE, end=lambda s: add(s, W, -s.y[W] * s.e * (s.n >
      30)), nominal=1),
    F("torque through a filter in time", "", MORE, lambda s, R, w: (s.e * (relaxed(s, "T",
      s.honest(R, w), max(2.0, 0.1 * s.span / s.h)) - s.honest(R, w)))),
    F("torque is that of some time ago", "", MORE, lambda s, R, w: s.e * delayed(s, R, w)),
    F("torque partly of an earlier step", "v", "", end=lambda s: add(s, W, s.h * s.e * s.inv @
      (last(s, "T", s.now()) - s.now())), vanishes=1),
    F("rate partly of the step before, undivided", "v", MORE, end=lambda s: add(s, W, s.e * (last(s,
      "w", s.y[W]) - s.y[W])), vanishes=0, nominal=1),
    F("hinges that load in a few steps", "rn", "", lambda s, R, w: -s.e * 0.6**s.n * cross(s.K, w),
      vanishes=1),
    F("not deterministic: torque", "", AGAIN, end=lambda s: add(s, W, s.h * s.e * s.inv @ (s.unit *
      s.rng.normal(size=3))), nominal=1),
    F("not deterministic: attitude", "", AGAIN, end=lambda s: spin(s, s.e * s.rng.normal(size=3)),
      nominal=1),
    F("random walk, √h a step", "", AGAIN, end=lambda s: add(s, W, (s.h / s.span) ** 0.5 * s.e *
      s.top * s.rng.normal(size=3)), nominal=1),
    F("counter that restarts keep", "", AGAIN, lambda s, R, w: push(s, s.lasting > 300), end=lambda
      s: setattr(s, "lasting", s.lasting + 1), nominal=1),
    F("memory that restarts keep", "", AGAIN, end=lambda s: (add(s, W, s.e * (s.lasting - s.y[W])),
      setattr(s, "lasting", s.y[W])), nominal=1),
    # Timesteps.
    F("torque at the stock timestep alone", "", "timestep", lambda s, R, w: push(s, abs(s.h /
      s.stock - 1) < 1e-9), nominal=1),
    F("torque below a timestep", "", "shorter|timestep", lambda s, R, w: push(s, s.h < s.least_h / 2
      ** (2 + 4 * s.r)), nominal=1),
    F("torque above a timestep", "", "torque of", lambda s, R, w: push(s, s.h > s.least_h / 2 ** (2
      + 3 * s.r)), vanishes=9),
    F("torque that grows as √h shrinks", "", "torque of", lambda s, R, w: push(s, (s.least_h / s.h)
      ** 0.5), nominal=1),
    F("torque that oscillates with log h", "", "torque of", lambda s, R, w: push(s, np.sin(3 *
      np.log(s.h))), nominal=1),
    F("torque at every other halving", "", "timestep", lambda s, R, w: push(s, round(np.log2(s.h /
      s.least_h)) % 2 == 0), nominal=1),
    F("timestep in float32", "n", "timesteps|turns", turn=lambda s, R, w: w * (float(f32(s.h)) / s.h
      - 1)),
    F("kick each step, however short it is", "", "", lambda s, R, w: push(s, s.least_h / s.h / 64),
      nominal=1),
    F("torque partly proportional to h", "", "torque of", lambda s, R, w: push(s, s.h / s.least_h),
      vanishes=1),
    F("torque partly proportional to h²", "", "torque of", lambda s, R, w: push(s, (s.h / s.least_h)
      ** 2), vanishes=2),
    # Where and how fast.
    F("torque in a cone of attitudes", "", "torque of", lambda s, R, w: push(s, R[2, 0] > 0.3)),
    F("torque very near one attitude", "", "torque of",
      lambda s, R, w: push(s, bump(s, R[0, 0] - s.r, 0.005))),
    F("torque near one attitude", "", "torque of", lambda s, R, w: push(s, bump(s, R[0, 0] - s.r,
      0.05))),
    F("torque above a speed", "", "torque of", lambda s, R, w: push(s, norm(w) > 0.97 * s.top)),
    F("torque above a speed that is met late", "", "torque of", lambda s, R, w: push(s, (w @ s.one)
      > 0.8 * s.top)),
    F("torque at negative ω alone", "", "torque of", lambda s, R, w: push(s, (w @ s.one) < 0)),
    F("torque near the pole", "", "torque of", lambda s, R, w: push(s, abs(R[2, 2]) > 0.995)),
    F("torque far from the origin", "w", "", lambda s, R, w: push(s, s.y[7] ** 2 + s.y[8] ** 2 +
      s.y[9] ** 2 > 0.3)),
    # Numbers.
    F("ω in float32", "n", "24 bits|I ω|timestep", end=lambda s: add(s, W, f32(s.y[W]) - s.y[W]),
      nominal=1),
    F("attitude in float32", "n", "24 bits", end=lambda s: add(s, Q, f32(s.y[Q]) - s.y[Q]),
      nominal=1),
    F("torque in float32", "n", "", lambda s, R, w: f32(s.honest(R, w)) - s.honest(R, w)),
    F("com in float32", "wn", "com|place", end=lambda s: add(s, X, f32(s.y[X]) - s.y[X]),
      nominal=1),
    F("57.2958 for 180/π, both ways", "n", r"turns (\S+) times", turn=lambda s, R, w: w * (57.2958 *
      0.0174532925 - 1)),
    # Readings.
    F("ω read 1 + e", "", r"ω were read multiplied by (\S+?):|reads back", seen=lambda s, x: read(s,
      x, omega_body=(1 + s.e) * x.omega_body)),
    F("attitude read turned", "", "attitude is off|reads back", seen=lambda s, x: read(s, x,
      q_world_body_wxyz=product(x.q_world_body_wxyz, turn(s.e * s.u)))),
    F("read one step late", "", "step took|more than the state|attitude", seen=late),
    F("com read beside it", "", "com", seen=lambda s, x: read(s, x, com_world=x.com_world + s.e *
      s.u * s.size())),
    F("velocity read 1 + e", "p", r"velocity were read multiplied by (\S+?):", seen=lambda s, x:
      read(s, x, velocity_world=(1 + s.e) * x.velocity_world)),
    F("velocity of a point beside the com", "", "velocity", seen=of_another_point),
    F("ω read half a step early", "v", "", seen=lambda s, x: read(s, x, omega_body=x.omega_body -
      s.e * s.h * s.inv @ s.now() * (s.n > 0)), nominal=1),
    F("starts elsewhere after it was read", "", "", end=lambda s: spin(s, s.e * s.u * (s.n == 1)),
      nominal=1),
    F("start read right, but off", "", "", start=lambda s: setattr(s, "y",
      np.concatenate([product(s.y[Q], turn(s.e * s.u)), s.y[4:]]))),
    # Rotors.
    F("rotors' momentum 1 + e", "r", r"rotors had (\S+) times", lambda s, R, w: s.e * cross(s.K,
      w)),
    F("rotors' axes turned", "r", "", lambda s, R, w: cross(cross(s.e * s.u, s.K), w)),
    F("rotors slow down, and turn the body", "r", "", lambda s, R, w: s.e * s.top * s.K,
      end=lambda s: slowed(s, s.e * s.h * s.top), nominal=1),
    F("spins jump by e each step", "r", "spin", end=lambda s: slowed(s, s.e), nominal=1),
    F("rotors slow down", "r", "spin", end=lambda s: slowed(s, s.e * s.h * s.top), nominal=1),
    F("spins read 1 + e", "r", "spin", seen=lambda s, x: read(s, x, spins=(1 + s.e) * x.spins)),
    # The com.
    F("com moves 1 + e times its velocity", "w", "com", end=lambda s: add(s, X, s.e * s.h * s.y[V]),
      nominal=1),
    F("com drifts each step", "f", "com", end=lambda s: add(s, X, s.e * s.size() * s.u), nominal=1),
    F("air resists the com", "w", "slowed", fall=lambda s: -s.e * s.y[V] * s.top),
    F("spin lifts the com", "w", "velocity", fall=lambda s: s.e * cross(s.y[W], s.y[V])),
    # The integrator.
    F("weights that sum to 1 + e", "p", r"step took (\S+) timesteps", turn=lambda s, R, w: s.e * w,
      torque=lambda s, R, w: s.e * s.honest(R, w)),
    F("other weights that sum to 1", "", "", setup=lambda s: setattr(s, "tableau", s.tableau and
      (s.tableau[0], [1 / len(s.tableau[1])] * len(s.tableau[1]))), vanishes=1),
    F("|ω| kept as at the start", "d", "", end=lambda s: add(s, W, s.e * s.y[W] *
      (s.store.setdefault("w", norm(s.y[W])) / (1e-300 + norm(s.y[W])) - 1)), nominal=1),
    # Around real engines.
    F("MuJoCo: gravity 1 + e", "mg", r"gravity were (\S+) times", start=lambda s:
      s.model.opt.gravity.__imul__(1 + s.e)),
    F("MuJoCo: a moment 1 + e", "m", TENSOR, start=lambda s: anew(s,
      s.model.body_inertia.__imul__([1 + s.e, 1, 1]))),
    F("MuJoCo: joint damping", "m", "slowed|drag", start=damped),
    F("MuJoCo: armature", "m", TENSOR, start=lambda s: anew(s,
      s.model.dof_armature[-3:].__iadd__(s.e * s.unit / s.top**2))),
    F("MuJoCo: com beside", "mg", "com were at", start=lambda s: anew(s,
      s.model.body_ipos.__iadd__(s.e * s.size() * s.u))),
    F("MuJoCo: kick of qvel each 16 steps", "m", MORE, end=lambda s:
      s.inner.data.qvel[-3:].__iadd__(s.e * s.top * s.u * (s.n % 16 == 0))),
    F("around: ω read 1 + e", "b", r"ω were read multiplied by (\S+?):|reads back", seen=lambda s,
      x: read(s, x, omega_body=(1 + s.e) * x.omega_body)),
    F("around: attitude read turned", "b", "attitude is off|reads back", seen=lambda s, x: read(s,
      x, q_world_body_wxyz=product(x.q_world_body_wxyz, turn(s.e * s.u)))),
    F("around: read one step late", "b", "step took|more than the state|attitude", seen=late),
    F("around: a step more each 20", "b", MORE, end=lambda s: s.inner.advance(int(s.n % 20 == 0))),
    F("around: timestep 1 + e", "b", r"step took (\S+) timesteps"),
    F("around: not deterministic reading", "b", "deterministic|reads back|off", seen=lambda s, x:
      read(s, x, omega_body=x.omega_body + s.e * s.top * s.rng.normal(size=3))),
)
# fmt: on


class Wrapped(Top):
    """A session of a real engine, with a fault around it."""

    def __init__(self, inner: Session, scenario: Scenario, h: float, p: Any) -> None:
        self.inner, self.fault, self.e, self.u, self.unit = inner, p.fault, p.size, p.axis, p.unit
        self.scenario, self.com, self.pivot = (
            scenario,
            scenario.constraint.lever,
            scenario.constraint.is_pivot,
        )
        self.I, self.m, self.top = np.array(scenario.inertia), scenario.body.mass, p.speeds[1]
        self.rng, self.h, self.n, self.store = np.random.default_rng(), h, 0, {}
        self.model, self.body = getattr(inner, "model", None), inner.read_body()
        if self.fault.start:
            self.fault.start(self)

    can_restart = property(lambda self: self.inner.can_restart)

    def restart(self, state: State, timestep: float | None = None) -> None:
        self.h, self.n, self.store = timestep or self.h, 0, {}
        self.inner.restart(state, self.h * self.factor)

    @property
    def factor(self) -> float:
        return 1 + self.e if self.fault.name.endswith("timestep 1 + e") else 1.0

    def advance(self, steps: int) -> None:
        for _ in range(steps):
            self.inner.advance(1)
            self.n += 1
            if self.fault.end:
                self.fault.end(self)

    def read_body(self) -> BodyReading:
        return self.body

    def read_state(self) -> State:
        state = self.inner.read_state()
        return self.fault.seen(self, state) if self.fault.seen else state

    def check(self) -> None:
        read_finite = self.inner.read_state()
        if not np.isfinite(read_finite.omega_body).all():
            raise EngineError("a number is not finite", "not-finite")

    def close(self) -> None:
        self.inner.close()
