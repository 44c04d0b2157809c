"""Motions with the faults of public reports, and the words that an explanation of each must have.

They are computed along world axes, by rotation matrices, with nothing of what explains them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from library_scenes import library_scene
from planted_motions import cross
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from spincheck.reference.other_equations import equations_of
from spincheck.reports.harness.recorded.files.recording import Recording
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import Scenario, from_tables

Arrays = dict[str, np.ndarray]
#: Of R, body to world, and ω along world axes: ω' or the ω that the attitude follows.
Rate = Callable[[np.ndarray, np.ndarray], np.ndarray]
MASS, GRAVITY, COM = 2.0, np.array([0.0, 0.0, -9.81]), np.array([0.06, -0.1, 0.21])
#: kg m², about the com: moments of a box of 0.3 by 0.5 by 0.9 m in skew axes.
MOMENTS = MASS / 12 * np.array([0.5**2 + 0.9**2, 0.3**2 + 0.9**2, 0.3**2 + 0.5**2])
AXES = Rotation.from_euler("zyx", [35.0, -50.0, 20.0], degrees=True).as_matrix()
TENSOR = np.tril(AXES @ np.diag(MOMENTS) @ AXES.T)
TENSOR += np.tril(TENSOR, -1).T
PUSH, DRAG = np.array([0.12, -0.05, 0.08]), 0.03
START = Rotation.from_euler("xyz", [40.0, -25.0, 70.0], degrees=True)


def moved_tensor(tensor: np.ndarray, by: np.ndarray) -> np.ndarray:
    """A tensor about the com as it is about a point so far from it."""
    return tensor + MASS * (by @ by * np.eye(3) - np.outer(by, by))


ABOUT_PIVOT = moved_tensor(TENSOR, COM)


def scene(*effects: str, omega: tuple[float, float, float] = (1.9, -0.7, 1.2)) -> Scenario:
    """The body with some of gravity, pivot, drag and torque."""
    of_effect = {
        "gravity": {"acceleration": GRAVITY.tolist()},
        "pivot": {},
        "drag": {"rotational": DRAG},
        "torque": {"body": PUSH.tolist()},
    }
    tables = {
        "title": "Reported",
        "source": "public reports",
        "body": {"mass": MASS, "inertia": TENSOR.tolist(), "com": COM.tolist()},
        "start": {
            "quaternion_wxyz": START.as_quat(scalar_first=True).tolist(),
            "omega_body": list(omega),
        },
        "effects": {name: of_effect[name] for name in effects},
        "window": {"duration": 4.0, "samples": 201},
    }
    return from_tables(tables, "reported")


FREE, TOP, PUSHED, DRAGGED = scene(), scene("gravity", "pivot"), scene("torque"), scene("drag")
FAST = scene(omega=(6.0, -5.0, 4.0))
WHEEL = library_scene("satellite-and-its-wheel")


def turning(
    one: Scenario,
    accelerated: Rate,
    followed: Rate = lambda R, omega: omega,
    start: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, R and ω along world axes, (n,), (n, 3, 3) and (n, 3)."""
    R = Rotation.from_quat(one.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    omega = R @ np.array(one.start.omega_body if start is None else start)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        R, omega = y[:9].reshape(3, 3), y[9:]
        x, y, z = followed(R, omega).tolist()
        turned = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.concatenate([(turned @ R).ravel(), accelerated(R, omega)])

    times = one.times
    y = np.concatenate([R.ravel(), omega])
    span, rtol = (0.0, times[-1]), 1e-12
    found = solve_ivp(rates, span, y, "DOP853", times, rtol=rtol, atol=1e-12).y.T
    return times, found[:, :9].reshape(-1, 3, 3), found[:, 9:]


def euler(
    tensor: np.ndarray,
    torque: Rate = lambda R, omega: np.zeros(3),
    gyroscopic: np.ndarray | None = None,
) -> Rate:
    """Euler's equations along world axes; the torque is in body axes."""
    G = tensor if gyroscopic is None else gyroscopic

    def accelerated(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
        of_body = torque(R, omega) - R.T @ cross(omega, R @ G @ R.T @ omega)
        return np.asarray(R @ np.linalg.solve(tensor, of_body))

    return accelerated


def weight(R: np.ndarray, omega: np.ndarray, com: np.ndarray = COM) -> np.ndarray:
    """Gravity's torque about the pivot, body axes."""
    return cross(com, MASS * R.T @ GRAVITY)


def pushed(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
    return PUSH


def damped(rate: float, tensor: np.ndarray, torque: Rate | None = None) -> Rate:
    """A torque, and L slowed by a rate, 1/s, body axes."""

    def acting(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
        slowed = -rate * tensor @ R.T @ omega
        return slowed if torque is None else slowed + torque(R, omega)

    return acting


def recorded(t: np.ndarray, R: np.ndarray, omega: np.ndarray) -> Arrays:
    """A recording: q with its scalar first, and ω along body axes."""
    q = Rotation.from_matrix(R).as_quat(scalar_first=True)
    return {"t": t.copy(), "q": q, "omega": np.einsum("nji,nj->ni", R, omega)}


def right(one: Scenario) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The right motion of the free body, or of the top."""
    rates = euler(ABOUT_PIVOT, weight) if one is TOP else euler(TENSOR)
    return turning(one, rates)


@dataclass(frozen=True, eq=False)
class Fault:
    """A fault of a public report.

    Attributes
    ----------
    report : repository and number
    what : went wrong
    words : one of each that an explanation must have, in one of its sentences
    motion : its scene and what was recorded
    timestep : s, that its file states
    """

    report: str
    what: str
    words: tuple[str, ...]
    motion: Callable[[], tuple[Scenario, Arrays]]
    timestep: float = 1e-4

    def is_named(self, explained: list[str]) -> bool:
        """Whether every sentence that must be there is, and none besides."""
        named = all(any(words in one for one in explained) for words in self.words)
        return named and len(explained) == len(self.words)


def judged(one: Scenario, arrays: Arrays, timestep: float | None) -> JudgedMotion:
    """A motion of which its file states the timestep, s, or does not."""
    stated = {} if timestep is None else {"timestep": repr(timestep)}
    return judged_motion(one, Recording(Path("motion.csv"), arrays, stated))


def named(found: JudgedMotion) -> list[str]:
    """What is said of a motion: what explains it, and the integrator that made it."""
    return [*found.explained_by, *filter(None, [found.made_by])]


def _of(one: Scenario, accelerated: Rate, **how: Rate) -> Callable[[], tuple[Scenario, Arrays]]:
    return lambda: (one, recorded(*turning(one, accelerated, **how)))


def _on_the_other_side() -> tuple[Scenario, Arrays]:
    """ω q for q ω, of a gyroscope's ω: an attitude from the right ω along body axes."""

    def accelerated(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
        of_body = euler(TENSOR)(np.eye(3), R.T @ omega)
        return R @ of_body + np.cross(R.T @ omega, omega)

    return FREE, recorded(*turning(FREE, accelerated, followed=lambda R, omega: R.T @ omega))


def _wheels() -> tuple[Scenario, Arrays]:
    e = equations_of(WHEEL)
    inertia, h = np.array(e.inertia), np.array(e.kept)
    rates = euler(inertia, lambda R, omega: np.cross(R.T @ omega, h))
    return WHEEL, recorded(*turning(WHEEL, rates))


def _kept_length() -> tuple[Scenario, Arrays]:
    """A gyroscopic step that keeps the length of L, 1/60 s."""
    h = 1 / 60
    one = from_tables(
        {
            "title": "Reported",
            "source": "public reports",
            "body": {"mass": MASS, "inertia": TENSOR.tolist()},
            "start": {"quaternion_wxyz": [1.0, 0, 0, 0], "omega_body": [1.9, -0.7, 1.2]},
            "window": {"duration": 5.0, "samples": 301},
        },
        "reported",
    )
    R, w = np.eye(3), np.array(one.start.omega_body)
    rows = [(R, R @ w)]
    for _ in one.times[1:]:
        L = TENSOR @ w
        after = L + h * np.cross(L, w)
        w = np.linalg.solve(TENSOR, after * np.linalg.norm(L) / np.linalg.norm(after))
        R = R @ Rotation.from_rotvec(h * w).as_matrix()
        rows.append((R, R @ w))
    Rs, ws = (np.array(column) for column in zip(*rows, strict=True))
    return one, recorded(one.times, Rs, ws)


def _clamped() -> tuple[Scenario, Arrays]:
    """Steps of 2 ms, after each of which ‖ω‖ is at most 7 rad/s."""
    R = Rotation.from_quat(FAST.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    omega, h, rates = R @ np.array(FAST.start.omega_body), 0.002, euler(TENSOR)
    rows = [(R, omega)]
    for step in range(1, round(FAST.times[-1] / h) + 1):
        half = omega + h / 2 * rates(R, omega)
        middle = Rotation.from_rotvec(h / 2 * omega).as_matrix() @ R
        R, omega = Rotation.from_rotvec(h * half).as_matrix() @ R, omega + h * rates(middle, half)
        omega *= min(1.0, 7 / np.linalg.norm(omega))
        if step % round(FAST.times[1] / h) == 0:
            rows.append((R, omega))
    Rs, omegas = (np.array(column) for column in zip(*rows, strict=True))
    return FAST, recorded(FAST.times, Rs, omegas)


def _in_world(one: Scenario) -> tuple[Scenario, Arrays]:
    t, R, omega = right(one)
    return one, recorded(t, R, omega) | {"omega": omega}


def _a_step_older() -> tuple[Scenario, Arrays]:
    arrays = recorded(*right(FREE))
    arrays["omega"] = np.vstack([arrays["omega"][:1], arrays["omega"][:-1]])
    return FREE, arrays


def _euler_rates() -> tuple[Scenario, Arrays]:
    """Differences of roll, pitch and yaw."""
    t, R, omega = right(TOP)
    # Rz(yaw) Ry(pitch) Rx(roll); their rates by the usual matrix.
    yaw, pitch, _ = np.unwrap(Rotation.from_matrix(R).as_euler("ZYX"), axis=0).T
    yaw_rate = (np.cos(yaw) * omega[:, 0] + np.sin(yaw) * omega[:, 1]) * np.tan(pitch) + omega[:, 2]
    pitch_rate = np.cos(yaw) * omega[:, 1] - np.sin(yaw) * omega[:, 0]
    roll_rate = (np.cos(yaw) * omega[:, 0] + np.sin(yaw) * omega[:, 1]) / np.cos(pitch)
    rates = np.stack([roll_rate, pitch_rate, yaw_rate], axis=1)
    return TOP, recorded(t, R, omega) | {"omega": rates}


def _degrees() -> tuple[Scenario, Arrays]:
    arrays = recorded(*right(FREE))
    return FREE, arrays | {"omega": np.degrees(arrays["omega"])}


def _scalar_last(is_in_world: bool) -> tuple[Scenario, Arrays]:
    t, R, omega = right(TOP)
    arrays = recorded(t, R, omega)
    arrays["q"] = np.roll(arrays["q"], -1, axis=1)
    return TOP, arrays | ({"omega": omega} if is_in_world else {})


def _fixed_in_world(one: Scenario, torque: Rate, *, is_gyroscopic: bool) -> Rate:
    """A tensor along body axes that is used along world axes."""

    def accelerated(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
        turned = np.cross(omega, TENSOR @ omega) if is_gyroscopic else 0.0
        return np.linalg.solve(TENSOR, R @ torque(R, omega) - turned)

    return accelerated


#: m, another com.
HIGHER = COM + np.array([0.0, 0.0, 0.05])
#: The tensor of a box of 0.3 by 0.5 by 0.2 m.
BOX = MASS / 12 * np.diag([0.5**2 + 0.2**2, 0.3**2 + 0.2**2, 0.3**2 + 0.5**2])
ZERO: Rate = lambda R, omega: np.zeros(3)  # noqa: E731
NO_GYROSCOPIC = "there were no gyroscopic torque"
WITHOUT_HALF, WRONG_SIDE = "q' = q ω, without the ½", "the product is on the wrong side"
FAULTS = (
    Fault(
        *("google/brax#48", "no gyroscopic torque", (NO_GYROSCOPIC,)),
        _of(FREE, euler(TENSOR, gyroscopic=0 * TENSOR)),
    ),
    Fault(
        *("DanielChappuis/reactphysics3d#422", "no gyroscopic torque", (NO_GYROSCOPIC,)),
        _of(PUSHED, euler(TENSOR, pushed, gyroscopic=0 * TENSOR)),
    ),
    Fault(
        "mockingbirdnest/Principia#4580",
        "no gyroscopic torque, and L slowed",
        (NO_GYROSCOPIC, "L were slowed by 0.05 /s"),
        _of(FREE, euler(TENSOR, damped(0.05, TENSOR), gyroscopic=0 * TENSOR)),
    ),
    Fault(
        "avianphysics/avian#745",
        "gyroscopic torque of the diagonal",
        ("gyroscopic torque ω × Iω were of the tensor's diagonal alone",),
        _of(TOP, euler(ABOUT_PIVOT, weight, gyroscopic=np.diag(np.diag(ABOUT_PIVOT)))),
    ),
    Fault(
        "avianphysics/avian#993",
        "a gyroscopic step that keeps ‖L‖",
        ("semi-implicit Euler with ‖L‖ kept",),
        _kept_length,
        1 / 60,
    ),
    Fault(
        *("avianphysics/avian#747", "attitudes multiplied on the wrong side", (WRONG_SIDE,)),
        _of(TOP, euler(ABOUT_PIVOT, weight), followed=lambda R, omega: R @ omega),
    ),
    Fault(
        *("rsasaki0109/imu_estimator#1", "ω q for q ω", (WRONG_SIDE,)),
        _on_the_other_side,
    ),
    Fault(
        *("mit-aera/FlightGoggles#67", "q' without the ½", (WITHOUT_HALF,)),
        _of(PUSHED, euler(TENSOR, pushed), followed=lambda R, omega: 2 * omega),
    ),
    Fault(
        *("google/brax#62", "turned twice as fast", (WITHOUT_HALF,)),
        _of(TOP, euler(ABOUT_PIVOT, weight), followed=lambda R, omega: 2 * omega),
    ),
    Fault(
        *("w0rm/elm-physics#69", "half of the turn", ("q' = ¼ q ω, with the ½ twice",)),
        _of(DRAGGED, euler(TENSOR, lambda R, w: -DRAG * R.T @ w), followed=lambda R, w: w / 2),
    ),
    Fault(
        "fkanehiro/openhrp3#120",
        "q' = ½ q ω with ω along world axes",
        ("ω obeys Euler's equations, but the attitude does not follow ω",),
        _of(FREE, euler(TENSOR), followed=lambda R, omega: R @ omega),
    ),
    Fault(
        "sofa-framework/sofa#4936",
        "a tensor that does not turn with the body",
        ("the tensor were along world axes, and did not turn with the body",),
        _of(FREE, _fixed_in_world(FREE, ZERO, is_gyroscopic=True)),
    ),
    Fault(
        "gszauer/GamePhysicsCookbook#14",
        "the body's inverse tensor times a torque in world axes, no gyroscopic torque",
        (f"{NO_GYROSCOPIC}, and the tensor were along world axes, and did not turn with",),
        _of(PUSHED, _fixed_in_world(PUSHED, pushed, is_gyroscopic=False)),
    ),
    Fault(
        *("godotengine/godot#58270", "torque divided by the mass", ("the moments were [2, 2, 2]",)),
        _of(PUSHED, lambda R, omega: R @ PUSH / MASS),
    ),
    Fault(
        "dimforge/parry#334",
        "moved to the pivot with the wrong sign",
        ("Ixx, Iyy, Izz, Ixy, Ixz, Iyz",),
        _of(TOP, euler(TENSOR + MASS * (COM @ COM * np.eye(3) + np.outer(COM, COM)), weight)),
    ),
    Fault(
        *("IEAWindSystems/IEA-10.0-198-RWT#24", "not moved to the pivot", ("about the com were",)),
        _of(TOP, euler(TENSOR, weight)),
    ),
    Fault(
        *("utiasSTARS/pyb-sim-models#4", "tensor about the origin", ("about the origin",)),
        _of(FREE, euler(ABOUT_PIVOT)),
    ),
    Fault(
        *("mahaarbo/urdf2casadi#2", "products of the other sign", ("products of inertia had",)),
        _of(FREE, euler(2 * np.diag(np.diag(TENSOR)) - TENSOR)),
    ),
    Fault(
        *("newton-physics/urdf-usd-converter#118", "conjugated axes", ("about conjugated",)),
        _of(FREE, euler(AXES.T @ np.diag(MOMENTS) @ AXES)),
    ),
    Fault(
        *("google-deepmind/mujoco#3559", "rotation lost", ("without the tensor's rotation",)),
        _of(FREE, euler(np.diag(MOMENTS))),
    ),
    Fault(
        *("o3de/o3de#10342", "the inverse for the tensor", ("the tensor's inverse were taken",)),
        _of(PUSHED, euler(np.linalg.inv(TENSOR), pushed)),
    ),
    Fault(
        "Genesis-Embodied-AI/genesis-world#3183",
        "the tensor of the shape",
        ("that of a box along the body's axes",),
        _of(PUSHED, euler(BOX, pushed)),
    ),
    Fault(
        "learnsyslab/gym-pybullet-drones#56",
        "moments 2.7, 2.7 and 3.3 times as large",
        ("the moments were",),
        _of(PUSHED, euler(AXES @ np.diag([2.7, 2.7, 3.3] * MOMENTS) @ AXES.T, pushed)),
    ),
    Fault(
        *("ethz-asl/rotors_simulator#6", "a rotor's momentum reversed", ("had the other sign",)),
        _wheels,
    ),
    Fault(
        *("godotengine/godot#39085", "angular damping of 0.1 /s", ("L were slowed by 0.1 /s",)),
        _of(TOP, euler(ABOUT_PIVOT, damped(0.1, ABOUT_PIVOT, weight))),
    ),
    Fault(
        *("markusa380/PersistentRotation#20", "a largest ‖ω‖", ("‖ω‖ is clamped to 7 rad/s",)),
        _clamped,
        0.002,
    ),
    Fault(
        "bulletphysics/bullet3#1949",
        "a torque along world axes for one along the body's",
        ("the torque were constant along the other axes",),
        _of(PUSHED, euler(TENSOR, lambda R, omega: R.T @ PUSH)),
    ),
    Fault(
        *("youbot/youbot-ros-pkg#24", "com 5 cm too high", ("the com were at [0.06, -0.1, 0.26]",)),
        _of(
            TOP,
            euler(
                moved_tensor(TENSOR, HIGHER),
                lambda R, omega: weight(R, omega, HIGHER),
            ),
        ),
    ),
    Fault(
        *("bit-bots/wolfgang_robot#82", "ω along world axes", ("ω is in world axes",)),
        lambda: _in_world(FREE),
    ),
    Fault(
        *("google-deepmind/mujoco#2144", "ω a step old", ("one sample older than the attitude",)),
        _a_step_older,
    ),
    Fault(
        *("gazebosim/gz-sim#2347", "rates of roll, pitch, yaw", ("the rates of Euler angles",)),
        _euler_rates,
    ),
    Fault(
        *("stereolabs/zed-ros-wrapper#300", "ω in °/s", ("in degrees a second",)),
        _degrees,
    ),
    Fault(
        *("isaac-sim/IsaacLab#2197", "q in the order x y z w", ("order is x y z w",)),
        lambda: _scalar_last(False),
    ),
    Fault(
        "stepjam/PyRep#207",
        "q in the order x y z w, and ω along world axes",
        ("order is x y z w", "ω is in world axes"),
        lambda: _scalar_last(True),
    ),
)
