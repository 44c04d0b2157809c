"""Writes the sentences of verdicts from the numbers of their evidence."""

import math
from collections.abc import Sequence

from .evidence import (
    CONSISTENT,
    SEEN,
    ReplayEvidence,
    StepEvidence,
    StepFault,
)
from .verdict_words import VerdictWord

#: Number of significant digits that are printed; more where two numbers would look the same.
DIGITS = 3
#: Name of the rate of change of each quantity, with its unit.
RATES = {
    "attitude": "dR/dt, rad/s in body axes,",
    "angular momentum": "I dω/dt, N m in body axes,",
    "velocity": "the com's velocity or its rate, m/s or m/s² in world axes,",
    "place": "the com or its rate, m or m/s in world axes,",
    "parts": "the angular momentum that turning parts keep",
}
#: Name and unit of each quantity that can leap, and the factor from the SI unit to that unit.
LEAPING = {
    "attitude": ("attitude", "°", math.degrees(1.0)),
    "angular momentum": ("I ω", " N m s", 1.0),
    "velocity": ("the com's velocity", " m/s", 1.0),
    "place": ("com", " m", 1.0),
    "parts": (RATES["parts"], " N m s", 1.0),
}


def reason_in_words(
    word: VerdictWord,
    quoted: str,
    steps: StepEvidence | None,
    own_steps: StepEvidence | None,
    replays: Sequence[ReplayEvidence],
) -> str:
    """Return the reason of a verdict; what decides the verdict comes first.

    Parameters
    ----------
    word : the verdict
    quoted : what a run, the engine or the scene's file states as the reason; may be empty
    steps, own_steps : evidence from steps from exact states, and from states of the method's runs;
        None if there is none
    replays : evidence from replays of the method's runs
    """
    parts: list[str] = []
    if word == "disagrees":
        parts += [fault_in_words(one.fault) for one in (steps, own_steps) if one and one.fault]
        # Replays of several timesteps may show the same.
        parts += dict.fromkeys(_replay(one) for one in replays if one.is_wrong)
        if steps and steps.is_of_low_order:
            orders = f"order {steps.order}, though {steps.declared} is declared"
            parts.append(f"what steps gain vanishes with the timestep at {orders}")
    if word == "unresolved" and steps and not steps.is_known:
        parts.append(_open(steps))
    if quoted:
        # A run's own reason may mention the fault of its steps already.
        parts = [*(one for one in parts if one not in quoted), quoted]
    if word == "converges" and steps:
        parts.append(_consistent(steps, replays))
    return "; ".join(parts)


def ground_in_words(steps: StepEvidence, replays: Sequence[ReplayEvidence]) -> str:
    """Return, in words, how many states and intervals a verdict `converges` rests on."""
    intervals = sum(one.intervals for one in replays)
    return f"in steps from {steps.states} states, and {intervals} intervals of runs"


def _consistent(steps: StepEvidence, replays: Sequence[ReplayEvidence]) -> str:
    """Return the reason of a verdict `converges`: what the evidence shows, and how accurately."""
    known = f"to {steps.known_to:.1e} of the largest terms"
    if steps.of_an_effect > steps.known_to:
        known += f" and {steps.of_an_effect:.1e} of the weakest effect"
    of_order = f", at order {steps.order}" if steps.order else ""
    settled = (
        f", after {steps.settled} steps in which a constraint settled" if steps.settled else ""
    )
    parts = [
        f"steps from {steps.states} states are consistent with the equations of motion {known}"
        f"{of_order}{settled}"
    ]
    if replays:
        runs = ", ".join(f"{one.timestep:.3g}" for one in replays)
        off = max(one.off for one in replays)
        to = f"{off:.1e} a radian" if off else "the last bit"
        parts.append(f"each interval of runs at {runs} s is the same from its own start, to {to}")
    if order := max((one.order for one in replays), default=0):
        parts[-1] += f", which vanishes with the timestep at order {order}"
    if steps.changes_below:
        parts.append(
            f"with timesteps below {steps.changes_below:.3g} s what steps gain is another "
            "function of the timestep, which vanishes as well"
        )
    if steps.beyond_from:
        parts.append(
            f"with timesteps of {steps.beyond_from:.3g} s and longer, steps from some states gain "
            "what the series of shorter ones does not predict: that timestep is beyond its radius "
            "of convergence, or what acts depends on the timestep"
        )
    return "; ".join(parts)


def _open(steps: StepEvidence) -> str:
    """Return the reason of a verdict `unresolved`: the limit of gains is not known well enough."""
    if steps.known_to > CONSISTENT:
        what, known, needed = "largest terms", steps.known_to, CONSISTENT
    else:
        what, known, needed = "weakest effect", steps.of_an_effect, SEEN
    return (
        f"the limit of what steps gain is known to {known:.2g} of the {what} only, and {needed:g} "
        "is needed"
    )


def fault_in_words(fault: StepFault) -> str:
    """Return a fault of single steps in words: what explains it, if known, and what is wrong."""
    as_if = " and ".join(change.words for change in fault.changes)
    return f"behaves as if {as_if}: {_shown(fault)}" if as_if else _shown(fault)


def _shown(fault: StepFault) -> str:
    """Return, in words, how steps differ from those of a method that converges."""
    when = _when(fault)
    if fault.kind == "misread":
        omega, turn, spins = fault.got
        of_spins = f", by {spins:.2g} in the spins of parts" if spins else ""
        return (
            f"a state that is set reads back otherwise, {when}: off by {omega:.2g} in ω, relative, "
            f"and {math.degrees(turn):.2g}° in attitude{of_spins}"
        )
    if fault.kind == "leap":
        what, unit, factor = LEAPING[fault.quantity]
        return (
            f"{what} is off by {factor * math.hypot(*fault.got):.2g}{unit} after a step, however "
            f"short it is, down to {fault.timestep:.2g} s"
        )
    if fault.kind == "random":
        return (
            "the engine is not deterministic, or a step depends on more than the state: of two "
            f"steps of {fault.timestep:.3g} s from one state, {when}, {RATES[fault.quantity]} "
            f"differs by {math.hypot(*fault.got):.2g}"
        )
    what = _gained(fault)
    if fault.kind == "limit":
        return what
    where = {
        "timestep": "alone, of all lengths of steps",
        "shorter": "and shorter ones, though not with longer ones",
    }[fault.kind]
    return (
        f"with a timestep of {fault.timestep:.3g} s {where}, {what}: what acts depends on the "
        "timestep"
    )


def _when(fault: StepFault) -> str:
    """Return, in words, the state from which steps are wrong: its time, or how it was made."""
    if fault.time is None:
        return "at the start with ω along a skew axis"
    return f"at t = {fault.time:.3g} s"


def _gained(fault: StepFault) -> str:
    """Return, in words, the rate at which a quantity changes, and the rate at which it should."""
    if fault.quantity == "parts":
        off = math.hypot(*fault.got)
        return f"{RATES['parts']} changes at a rate of {off:.{DIGITS}g} N m {_when(fault)}, not 0"
    size = max(map(abs, fault.wanted)) or 1.0
    part = max(abs(a - b) for a, b in zip(fault.got, fault.wanted, strict=True)) / size
    digits = DIGITS + max(0, math.ceil(-math.log10(min(part, 1.0) or 1.0)) - 1)
    got, wanted = (
        f"[{', '.join(f'{value:.{digits}g}' for value in one)}]"
        for one in (fault.got, fault.wanted)
    )
    return f"{RATES[fault.quantity]} is {got} {_when(fault)}, not {wanted}"


def _replay(replay: ReplayEvidence) -> str:
    """Return, in words, how the replays of a run differ from the run."""
    at = f"at a timestep of {replay.timestep:.3g} s"
    if replay.spread:
        return (
            "the engine is not deterministic, or depends on how many steps are asked for at once: "
            f"two runs of one interval {at} differ by {replay.spread:.2g} a radian of turn"
        )
    if replay.order:
        return (
            f"a step depends on more than the state, which vanishes with the timestep at order "
            f"{replay.order}, though {replay.declared} is declared"
        )
    since = "" if replay.since is None else f" from t = {replay.since:.4g} s on"
    return (
        f"a step depends on more than the state: {at} a run goes on otherwise than from its own "
        f"states{since}, by up to {replay.off:.2g} a radian of turn"
    )
