"""What the command `reference` does: the exact motion, its uncertainty, invariants and facts."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ....reference import IntegrationError, drifts, facts, solve
from ....reference.euler_angles import euler_zyz_from_quaternion, rates_from_omega_body
from ....scenarios import SIGNALS, Misfit, Scenario, angular_momentum_world, check_scales, energy
from ..executing import compile_first
from ..terminal import BAD_INPUT, NOT_RUN, Complaint, as_complaint, table

#: Where a user names no times: the start, the end, and three between.
QUARTERS = 5


def describe(scenario: Scenario, at: Sequence[float]) -> dict[str, Any]:
    """States, uncertainty, conserved quantities and facts of a scene, SI units.

    Raises
    ------
    Complaint
        If a time is negative, not a number, or out of reach, or the motion cannot be solved.
    """
    for time in at:
        if not 0 <= time < float("inf"):
            raise Complaint(f"'--at' must be a time from 0 on, got {time:g}", BAD_INPUT)
    compile_first()
    wanted = np.array(sorted(set(at))) if at else np.linspace(0, scenario.window.duration, QUARTERS)
    with as_complaint(Misfit, before="'--at': "):
        check_scales(scenario, until=max(scenario.window.duration, float(wanted[-1])))
    with as_complaint(IntegrationError, before=f"{scenario.name}: ", exit_code=NOT_RUN):
        solution = solve(scenario, wanted)
    motion = solution.trajectory
    angles = euler_zyz_from_quaternion(motion.q_world_body_wxyz)
    columns = {
        "t": motion.t,
        "quaternion_wxyz": motion.q_world_body_wxyz,
        "euler_zyz_deg": np.degrees(angles),
        # NaN (null in JSON) where β is 0 or π: α and γ have no rates of their own there.
        "euler_zyz_rates": rates_from_omega_body(angles, motion.omega_body),
        "omega_body": motion.omega_body,
        "omega_world": motion.to_world(motion.omega_body),
        "com_world": motion.com_world,
        "L_world": angular_momentum_world(scenario, motion),
        "energy": energy(scenario, motion),
    }
    if motion.spins.size:
        columns["rotors_spin"] = motion.spins
    forces = {f"{effect.name}_force": effect.force for effect in scenario.acting}
    columns |= {name: force(scenario, motion) for name, force in forces.items() if force}
    return {
        "scenario": scenario.name,
        "method": solution.method,
        "uncertainty": asdict(solution.uncertainty),
        "conditioning": asdict(solution.conditioning),
        "horizon": solution.horizon,
        "ending": solution.ending,
        "states": [
            {name: np.asarray(values)[k].tolist() for name, values in columns.items()}
            for k in range(len(motion.t))
        ],
        "drifts": drifts(scenario, motion),
        "facts": [asdict(fact) for fact in facts(scenario)],
    }


def print_truth(truth: dict[str, Any]) -> None:
    """Print a description as tables."""
    print(f"{truth['scenario']}: {truth['method']}")
    for state in truth["states"]:
        print("\n".join(_state(state)))
    if truth["ending"]:
        print(f"The motion is known no longer: {truth['ending']}.\n")
    table([{"": what} | {s.label: truth[what][s.name] for s in SIGNALS} for what in _ERRORS])
    table([{"conserved": name, "drift": drift} for name, drift in truth["drifts"].items()])
    table([{**fact, "value": _shown(fact["value"])} for fact in truth["facts"]])


_ERRORS = ("uncertainty", "conditioning")


def _state(state: dict[str, Any]) -> Iterator[str]:
    """A line a quantity below the time; four components with exponents fit eighty columns."""
    yield f"\nt = {state['t']:.10g} s"
    for name, value in state.items():
        if name != "t":
            numbers = value if isinstance(value, list) else [value]
            yield f" {name:16} {'  '.join(f'{number:.8g}' for number in numbers)}"


def _shown(value: Any) -> str:
    """Numbers rounded for reading; `--json` has all digits."""
    if isinstance(value, list | tuple):
        return "  ".join(_shown(item) for item in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)
