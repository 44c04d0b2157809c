"""Faults planted in an honest engine's steps, each by its own trigger, and what is no fault.

Sizes are relative to spin and moments: a torque of `size` changes ω by that fraction in a radian.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from spincheck.engines import State
from spincheck.scenarios.rotation import times
from stepped import GRAVITY, LEVER, Stepped, with_omega

#: A torque acts about this axis of the body, askew to all.
ASKEW = np.array([0.62, 0.55, 0.56])
#: h times the rate of the start, rad: of steps that are looked at none is below the first, and half
#: are below the second; one is below the third, four are above the fourth, two above the last.
TINY, FINE, SHORT, LONG, LONGEST = 3e-5, 1e-2, 3e-4, 0.0125, 0.05
SEED = 20
#: Draws that differ from run to run, and are the same in each test: see `begin`.
CHANCE = np.random.default_rng(SEED)


def begin() -> None:
    """Begin chance and count anew, so that no test depends on those before it."""
    CHANCE.bit_generator.state = np.random.default_rng(SEED).bit_generator.state
    WrongWhenOpenedTwice.opened = 0


class Pushed(Stepped):
    """A torque acts whenever the fault is on."""

    def is_on(self) -> bool:
        return True

    def torque(self):
        return self.size * self.unit_torque * ASKEW if self.is_on() else None

    @property
    def turn(self) -> float:
        """rad a step, at the speed of the start."""
        return self.rate * self.timestep

    @property
    def share(self) -> float:
        """Of the window that is over."""
        return self.time / self.scenario.window.duration


def _pushed(name: str, is_on: Callable[[Pushed], bool]) -> type[Pushed]:
    """A torque that acts whenever something holds."""
    return type(name, (Pushed,), {"is_on": is_on})


# At every timestep but tiny ones; in the finer half of them.
ButForTinySteps = _pushed("ButForTinySteps", lambda one: one.turn > TINY)
AtFineSteps = _pushed("AtFineSteps", lambda one: TINY < one.turn < FINE)
# In short steps, however short: their limit is another motion; in those of one length alone.
InShortSteps = _pushed("InShortSteps", lambda one: one.turn < SHORT)
InStepsBelowTwiceThat = _pushed("InStepsBelowTwiceThat", lambda one: one.turn < 2 * SHORT)
InStepsBelowSevenTimesThat = _pushed("InStepsBelowSevenTimesThat", lambda one: one.turn < 7 * SHORT)
InOneShortStep = _pushed("InOneShortStep", lambda one: SHORT / 2 < one.turn < SHORT)
InAnotherShortStep = _pushed("InAnotherShortStep", lambda one: SHORT < one.turn < 2 * SHORT)
# At the nearest rung of a ladder to 2 ms; at 2 ms, which is on no ladder.
AtTwoMilliseconds = _pushed(
    "AtTwoMilliseconds", lambda one: 2e-3 / 2**0.5 < one.timestep <= 2e-3 * 2**0.5
)
AtExactlyTwoMilliseconds = _pushed("AtExactlyTwoMilliseconds", lambda one: one.timestep == 2e-3)
InLongSteps = _pushed("InLongSteps", lambda one: one.turn > LONG)
InTheLongestSteps = _pushed("InTheLongestSteps", lambda one: one.turn > LONGEST)
FromHalfway = _pushed("FromHalfway", lambda one: one.share > 0.5)
InTheLastTenth = _pushed("InTheLastTenth", lambda one: one.share > 0.9)
# Between two samples of four hundred.
InOneInterval = _pushed("InOneInterval", lambda one: 0.37 < one.share <= 0.37 + 1 / 400)
# From the hundredth step on, whichever the timestep: no check of few steps sees it.
AfterAHundredSteps = _pushed("AfterAHundredSteps", lambda one: one.taken >= 100)
# While ω is in an octant of the body; while the body spins faster than at its start.
InAnOctantOfOmega = _pushed("InAnOctantOfOmega", lambda one: bool((one.omega > 0).all()))
AboveASpeed = _pushed(
    "AboveASpeed", lambda one: float(np.linalg.norm(one.omega)) > 1.001 * one.rate
)


class InAnOctant(Pushed):
    """While the body's third axis points into an octant of the world."""

    def is_on(self):
        w, x, y, z = self.y[:4]
        return x * z + w * y > 0 and y * z - w * x > 0 and w * w + z * z > 0.5


class AtOneAttitude(Pushed):
    """Near the attitude that it has at 0.61 of the window, and only there."""

    there = None

    def is_on(self):
        if self.there is None and self.share > 0.61:
            self.there = self.y[:4].copy()
        return self.there is not None and abs(self.there @ self.y[:4]) > 0.995


class EveryThousandthStep(Pushed):
    """In each thousandth step, a thousand times as strong."""

    def torque(self):
        return 1e3 * super().torque() if self.taken % 1000 == 999 else None


class InLongStrides(Pushed):
    """Where it is asked for 16 steps at once, or more."""

    stride = 1

    def advance(self, steps):
        self.stride = steps
        super().advance(steps)

    def is_on(self):
        return self.stride >= 16


class ByChanceARun(Pushed):
    """Of a random size, and direction, a run."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.size *= CHANCE.uniform(-1, 1)


class Slowed(Pushed):
    """The spin is damped from a third of the window on."""

    def torque(self):
        return -self.size * self.rate * (self.inertia @ self.omega) if self.share > 1 / 3 else None


class SmoothlyLater(Pushed):
    """It grows as the eighth power of the time: nothing at first, and no jump."""

    def torque(self):
        return super().torque() * self.share**8


class LeavesOneGyroscopicTermOut(Pushed):
    """One component of the gyroscopic torque is short by its size."""

    def torque(self):
        gyroscopic = np.cross(self.inertia @ self.omega, self.omega)
        return -self.size * gyroscopic * [0, 1, 0]


class LagsAStep(Pushed):
    """The gyroscopic torque is that of the step before: of first order, whatever is declared."""

    before = None

    def torque(self):
        now = np.cross(self.inertia @ self.omega, self.omega)
        push = None if self.before is None else self.size * (self.before - now)
        self.before = now
        return push

    def set(self, state):
        super().set(state)
        self.before = None


class Remembers(Pushed):
    """A share of the last step's gain in ω is gained again: as if the body were lighter."""

    last = None

    def after_step(self):
        gain = 0 if self.last is None else self.size * (self.omega - self.last)
        self.last = self.omega.copy()
        self.omega[:] += gain

    def torque(self):
        return None

    def set(self, state):
        super().set(state)
        self.last = None


class Jumps(Stepped):
    """ω jumps by its size at step 3 000."""

    def after_step(self):
        if self.taken == 3000:
            self.omega[:] *= 1 + self.size


class JumpsInTheLastStep(Stepped):
    """ω jumps by its size in the step to the last sample."""

    def after_step(self):
        if self.time > self.scenario.window.duration - 1.5 * self.timestep:
            self.omega[:] *= 1 + self.size


class JumpsOnceByChance(Stepped):
    """ω jumps at a random time of the window."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.when = int(CHANCE.uniform(0.1, 0.9) * self.scenario.window.duration / self.timestep)

    def after_step(self):
        if self.taken == self.when:
            self.omega[:] *= 1 + self.size


class Clamped(Stepped):
    """No component of ω may exceed the speed of the start by more than its size."""

    def after_step(self):
        most = (1 + self.size) * self.rate
        np.clip(self.omega, -most, most, out=self.omega)


class FallsAsleep(Stepped):
    """Once slow, it stands still for good."""

    def after_step(self):
        if float(np.linalg.norm(self.omega)) < self.size * self.rate:
            self.omega[:] = 0


class AnotherMoment(Stepped):
    """A moment is another, by its size times a factor of the timestep."""

    def factor(self) -> float:
        return 1.0

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.mistake()

    def mistake(self):
        moments = np.array(self.inertia)
        moments[0, 0] *= 1 + self.size * self.factor()
        self.constants = self.constants_with(moments)

    def restart(self, state, timestep=None):
        super().restart(state, timestep)
        self.mistake()


class AMomentBySignOfTheRung(AnotherMoment):
    """A moment too large or too small, from rung to rung in turn."""

    def factor(self):
        return 1 - 2 * (int(np.floor(np.log2(self.timestep))) % 2)


class AMomentByChance(AnotherMoment):
    """A moment off by chance, drawn a run."""

    def factor(self):
        return CHANCE.uniform(-1, 1)


class AMomentAtFineSteps(AnotherMoment):
    """A moment off at the finest rungs only."""

    def factor(self):
        return float(TINY < self.rate * self.timestep < FINE)


class GravityInclined(Stepped):
    """Gravity is inclined by its size, rad, from a third of the window on."""

    share = Pushed.share

    def after_step(self):
        x, y, z = self.scenario.gravity_world
        size = self.size * (self.share > 1 / 3)
        self.constants[GRAVITY] = [x - size * z, y, z + size * x]


class TurnsTooFar(Stepped):
    """The attitude turns by a little more than ω says."""

    def after_step(self):
        self.turn(self.size * self.timestep * self.omega)


class SkipsSteps(Stepped):
    """Every so often a step of the clock is none of the body."""

    def advance(self, steps):
        for _ in range(steps):
            if self.taken % round(1 / self.size) == 50:
                self.taken += 1
            else:
                self.take(1)


class EulerLater(Stepped):
    """From half of the window on a step is of first order."""

    share = Pushed.share

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.declared = self.order

    def after_step(self):
        self.order = 1 if self.share > 0.5 else self.declared


class HalfAnOrder(Pushed):
    """A torque that vanishes with the root of the timestep."""

    def torque(self):
        return super().torque() * self.turn**0.5


def _reads(name: str, reading: Callable[[Stepped, State], State]) -> type[Stepped]:
    """What is read is another state."""
    return type(name, (Stepped,), {"reading": reading})


# The attitude is that of the world as seen from the body; it is given scalar last.
ReadsConjugated = _reads(
    "ReadsConjugated",
    lambda one, s: replace(s, q_world_body_wxyz=s.q_world_body_wxyz * [1, -1, -1, -1]),
)
ReadsPermuted = _reads(
    "ReadsPermuted", lambda one, s: replace(s, q_world_body_wxyz=np.roll(s.q_world_body_wxyz, -1))
)
# ω scatters; it is off; it drifts off in the course of the window.
ReadsScattered = _reads(
    "ReadsScattered",
    lambda one, s: with_omega(s, s.omega_body + one.size * one.rate * CHANCE.normal(size=3)),
)
ReadsOmegaOff = _reads("ReadsOmegaOff", lambda one, s: with_omega(s, (1 + one.size) * s.omega_body))
ReadsOmegaDrifting = _reads(
    "ReadsOmegaDrifting",
    lambda one, s: with_omega(
        s, (1 + one.size * one.time / one.scenario.window.duration) * s.omega_body
    ),
)


class ReadsTurned(Stepped):
    """What is read of the attitude is turned by its size, rad, about an axis of the body."""

    def reading(self, state):
        about_z = np.array([np.cos(self.size / 2), 0.0, 0.0, np.sin(self.size / 2)])
        return replace(state, q_world_body_wxyz=state.q_world_body_wxyz @ times(about_z))


class ComJumps(Stepped):
    """The centre of mass is read a little aside from half of the window on."""

    def reading(self, state):
        late = self.time > self.scenario.window.duration / 2
        return replace(state, com_world=state.com_world + late * self.size)


class Single(Pushed):
    """The state is held in 24 bits, and a torque of its size acts."""

    def after_step(self):
        self.y[:] = self.y.astype(np.float32)


class AnotherLever(AnotherMoment):
    """The com is another, by its size."""

    def mistake(self):
        self.constants = self.constants_with(self.inertia)
        self.constants[LEVER] *= 1 + self.size


class AnotherClock(Stepped):
    """A step is longer than a timestep, by its size."""

    def take(self, steps, *push):
        honest = self.timestep
        self.timestep *= 1 + self.size
        super().take(steps, *push)
        self.timestep = honest


def in_single(kind):
    """A fault in an engine whose state is held in 24 bits."""

    class InSingle(kind):
        def after_step(self):
            super().after_step()
            self.y[:] = self.y.astype(np.float32)

    InSingle.__name__ = f"{kind.__name__}InSingle"
    return InSingle


class WrongWhenOpenedTwice(Pushed):
    """Every second session that is opened has the fault."""

    opened = 0

    def __init__(self, *arguments):
        super().__init__(*arguments)
        type(self).opened += 1
        self.size *= self.opened % 2


class Overflows(Stepped):
    """ω is not finite after a step, as where single precision ends."""

    def after_step(self):
        self.y[4:7] *= np.inf


# No faults: these must never be called wrong.


class TurnsByATruncatedSeries(Stepped):
    """The attitude of a step that turns by less than a thousandth is off by a third of its square.

    DART 6.19 does that.
    """

    def after_step(self):
        turn = self.timestep * float(np.linalg.norm(self.omega))
        if turn < 1e-3:
            half = turn**2 / 6 * self.timestep * self.omega
            w, v = self.y[0], self.y[1:4].copy()
            self.y[0] -= v @ half
            self.y[1:4] += w * half + np.cross(v, half)


class Noisy(Stepped):
    """Noise of its size, relative, is added to ω in each step: honest as rounding is."""

    def after_step(self):
        self.omega[:] += self.size * self.rate * CHANCE.normal(size=3)


class TruncatesSmallTurns(Stepped):
    """Turns of less than its size, rad, are by the first terms of a series: off by a 24th of θ³."""

    def after_step(self):
        turn = float(np.linalg.norm(self.omega)) * self.timestep
        if turn < self.size:
            half = ASKEW * turn**3 / 48
            self.y[:4] = self.y[:4] @ times(np.append(1.0, half))


class HonestSingle(Stepped):
    """The state is held in 24 bits, as is declared."""

    def after_step(self):
        self.y[:] = self.y.astype(np.float32)


class HeldByImpulses(HonestSingle):
    """A restart rounds the pivot's place, by `size` ulp, and a constraint turns the body back.

    It does so within a step, as in Rapier.
    """

    def restart(self, state, timestep=None):
        super().restart(state, timestep)
        ulp = self.size * np.finfo(np.float32).eps
        self.omega[:] += ulp / self.timestep * CHANCE.normal(size=3)


class RoundedGyroscopic(HonestSingle):
    """Each component of the gyroscopic torque is rounded to 24 bits of the largest product in it.

    Where a restart changes a state by an ulp, its rounding is another one.
    """

    def after_step(self):
        product = np.linalg.norm(self.omega) * np.linalg.norm(self.inertia @ self.omega)
        rounded = np.finfo(np.float32).eps * product * CHANCE.normal(size=3)
        self.omega[:] += self.timestep * np.linalg.solve(self.inertia, rounded)
        super().after_step()


class BiasedSingle(HonestSingle):
    """Rounding makes ω longer in each step, by `size` ulp, as in Rapier and Newton."""

    def after_step(self):
        self.omega[:] *= 1 + self.size * np.finfo(np.float32).eps
        super().after_step()


class ForgetsWithTheTimestep(Remembers):
    """A memory that vanishes with the timestep: of first order, as Euler's own error."""

    def after_step(self):
        gain = 0 if self.last is None else self.turn_share * (self.omega - self.last)
        self.last = self.omega.copy()
        self.omega[:] += gain

    @property
    def turn_share(self) -> float:
        return self.size * self.turn


class ByChance(Stepped):
    """Each step changes ω by chance, each time otherwise."""

    def take(self, steps, *push):
        super().take(steps, *push)
        self.y[4:7] += self.size * CHANCE.normal(size=3)
