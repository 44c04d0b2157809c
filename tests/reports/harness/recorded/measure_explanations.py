"""Measures what `judge` makes of motions with faults, and of honest ones.

``python tests/reports/harness/recorded/measure_explanations.py faults|honest [N]`` prints what
it finds of each, and a line of figures at the end.
"""

import sys
from pathlib import Path

import numpy as np
from planted_motions import Case, case, exactly, product, rates_of, stepped
from scipy.spatial.transform import Rotation
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.recording import Recording

Fault = tuple[str, dict[str, object]]


def judged(one: Case, arrays: dict[str, np.ndarray], **stated: object) -> JudgedMotion:
    """A motion with what a file would state of it."""
    settings = {name: str(value) for name, value in stated.items()}
    return judged_motion(one.scenario, Recording(Path("motion.csv"), arrays, settings))


def faults(one: Case, seed: int) -> list[Fault]:
    """Faults with a word that an explanation must have."""
    chance = np.random.default_rng(seed)
    I = one.inertia  # noqa: E741
    moments, axes = np.linalg.eigh(I)
    size, d = float(moments.mean()), np.diag(np.diag(I))
    com = one.com
    steiner = 1.5 * (com @ com * np.eye(3) - np.outer(com, com))
    Q = Rotation.from_rotvec(chance.normal(0, 0.3, 3)).as_matrix()

    def turned(apply: object) -> dict[str, object]:
        return {"turning": lambda q, w: product(q, np.array([0, *apply(w)])) / 2}

    def left(q: np.ndarray, w: np.ndarray) -> np.ndarray:
        return product(np.array([0, *w]), q) / 2

    sheared = I + 0.1 * size * np.array([[0.5, 0.3, -0.2], [0.3, -0.4, 0.6], [-0.2, 0.6, 0.2]])
    return [
        ("no gyroscopic torque", {"gyroscopic": 0 * I}),
        ("gyroscopic torque ω × Iω were -1 times", {"gyroscopic": -I}),
        ("gyroscopic torque ω × Iω were 2 times", {"gyroscopic": 2 * I}),
        ("gyroscopic torque ω × Iω were of the tensor's diagonal", {"gyroscopic": d}),
        ("products of inertia had the other sign", {"inertia": 2 * d - I}),
        ("no products of inertia", {"inertia": d}),
        ("Ixy had the other sign", {"inertia": _flipped(I)}),
        ("principal moments were permuted", {"inertia": (axes * moments[[1, 0, 2]]) @ axes.T}),
        ("along the body's axes, without", {"inertia": np.diag(moments[[2, 0, 1]])}),
        ("about conjugated principal axes", {"inertia": axes.T @ np.diag(moments) @ axes}),
        ("about the origin instead", {"inertia": I + steiner}),
        ("turned by", {"inertia": Q @ I @ Q.T}),
        ("the moments were", {"inertia": (axes * (moments * [1, 0.93, 1])) @ axes.T}),
        ("Ixx, Iyy, Izz", {"inertia": sheared}),
        ("box along the body's axes", {"inertia": d * np.diag([1.0, 1.1, 0.93])}),
        ("ω' were of the tensor's diagonal", {"inverse": np.diag(1 / np.diag(I))}),
        ("L were slowed by 0.07", {"torque": lambda w: -0.07 * I @ w}),
        ("slowed by 0.03 N m s", {"torque": lambda w: -0.03 * w}),
        ("sped up by 0.02 N m s", {"torque": lambda w: 0.02 * w}),
        ("0.04 + 0.04 ‖ω‖", {"torque": lambda w: -(0.04 + 0.04 * np.linalg.norm(w)) * I @ w}),
        ("a torque of", {"torque": lambda w: np.array([0.02, -0.05, 0.03])}),
        ("wrong side", {"turning": left}),
        ("without the ½", turned(lambda w: 2 * w)),
        ("with the other sign", turned(lambda w: -w)),
        ("1.1 times as fast", turned(lambda w: 1.1 * w)),
        ("[ωy, ωx, ωz]", turned(lambda w: w[[1, 0, 2]])),
        ("[ωx, ωy, −ωz]", turned(lambda w: w * [1, 1, -1])),
        ("axes turned by", turned(lambda w: Q @ w)),
        ("slowed by 0.06 /s", {"gyroscopic": 0 * I, "torque": lambda w: -0.06 * I @ w}),
        (
            "gyroscopic torque ω × Iω were of the tensor's diagonal",
            {"gyroscopic": d, "torque": lambda w: -0.05 * w},
        ),
    ]


def _flipped(tensor: np.ndarray) -> np.ndarray:
    flipped = tensor.copy()
    flipped[0, 1] = flipped[1, 0] = -tensor[0, 1]
    return flipped


def measure_faults(count: int) -> None:
    """Print which faults are named rightly."""
    rightly = 0
    for k in range(count):
        one = case(100 + k)
        word, changes = faults(one, k)[k % 30]
        arrays = exactly(one, rates_of(one, **changes))
        found = judged(one, arrays, timestep=1e-4).explained_by
        is_right = any(word in words for words in found)
        rightly += is_right
        print("right" if is_right else "WRONG", f"'{word}':", *found, flush=True)
    print(f"{rightly} of {count} faults are named rightly")


def measure_honest(count: int) -> None:
    """Print which honest motions are explained by physics."""
    accused, beyond = 0, 0
    for k in range(count):
        one, order = case(500 + k, is_pivoted=bool(k % 2)), 1 + k // 2 % 4
        timestep = 0.02 / 2 ** (k // 8 % 4)
        arrays = stepped(one, rates_of(one), order, timestep, np.random.default_rng(k))
        stated = {"timestep": timestep} if k % 3 else {}
        found = judged(one, arrays, **stated)
        accused += bool(found.explained_by)
        beyond += found.is_beyond
        if found.is_another or found.made_by:
            print(
                k,
                order,
                timestep,
                stated,
                found.verdict,
                found.explained_by,
                found.made_by,
                flush=True,
            )
    print(f"of {count} honest motions {accused} are explained by faults, {beyond} are beyond")


if __name__ == "__main__":
    what = {"faults": measure_faults, "honest": measure_honest}
    what[sys.argv[1]](int(sys.argv[2]))
