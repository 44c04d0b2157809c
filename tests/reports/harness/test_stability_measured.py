"""What theory says of a step's stability, measured on the engines themselves."""

import math

import numpy as np
import pytest
from case_loops import each_case
from spincheck.engines import engines
from spincheck.reference.stability import body_cone_rate
from spincheck.scenarios import Scenario
from top_scenes import scene

EPS = float(np.finfo(float).eps)
STEPS = 12
#: Of ω; small enough for linear equations, whose next terms are of the order of its square.
NUDGE = 1e-6
#: ω across the axis after a step is known to an ulp of the spin; the nudge is that much smaller,
#: and damping makes it smaller still, up to 2⁻¹² of it here.
ROUNDED = 4 * EPS / NUDGE * 2**STEPS / STEPS + NUDGE**2
DISC, ROD = "[1.0, 1.0, 2.0]", "[1.0, 1.0, 0.1]"
FREE, PIVOT, WINDOW = "", "[effects.pivot]", "duration = 1.0\nsamples = 2"
EXPLICIT = [
    ("mujoco", "Euler", FREE),
    ("mujoco", "Euler", PIVOT),
    ("mujoco", "implicitfast", PIVOT),
    ("mujoco", "discrete", PIVOT),
    ("pybullet", "multibody", FREE),
    ("pybullet", "multibody", PIVOT),
    ("pybullet", "multibody-p2p", PIVOT),
]
IMPLICIT = [
    ("mujoco", "implicit", FREE),
    ("mujoco", "implicit", PIVOT),
    ("mujoco", "implicitfast", FREE),
    ("mujoco", "discrete", FREE),
    ("pybullet", "maximal", FREE),
    ("pybullet", "maximal", PIVOT),
]
#: λ h up to which |R(iλh)| of classical Runge–Kutta is at most 1 (Hairer & Wanner II, §IV.2).
RK4_LIMIT = 2 * math.sqrt(2)
#: Rate × h up to which semi-implicit Euler and leapfrog keep an oscillation bounded (Hairer, Lubich
#: & Wanner, Geometric Numerical Integration, ch. XIII).
LEAPFROG_LIMIT = 2.0
#: λ h; PyBullet takes no turn beyond π/4.
COARSE = (0.05, 0.5, 0.75)


def rk4_log_amplification(y: float) -> float:
    """ln |R(iy)| of the classical Runge–Kutta method (Hairer & Wanner II, §IV.2)."""
    return math.log1p(y**8 / 576 - y**6 / 72) / 2


def euler_log_amplification(y: float) -> float:
    """ln |R(iy)| of explicit Euler, R(z) = 1 + z; of implicit Euler, 1/(1 − z), with a minus."""
    return math.log1p(y**2) / 2


def spinning(inertia: str, effects: str, omega: str = f"[{NUDGE}, 0.0, 1.0]") -> Scenario:
    return scene(
        f"mass = 1.0\ninertia = {inertia}\ncom = [0.0, 0.0, 0.0]",
        f"euler_zyz_deg = [0.0, 0.0, 0.0]\nomega_body = {omega}",
        *(effects, WINDOW),
    )


def hanging() -> Scenario:
    """I1 = 2 kg m², M g l = 20 N m."""
    return scene(
        "mass = 1.0\ninertia = [1.0, 1.0, 1.0]\ncom = [0.0, 0.0, 1.0]",
        f"euler_zyz_deg = [0, 180, 0]\nomega_body = [{NUDGE}, 0, 0]",
        *("[effects.gravity]\nacceleration = [0.0, 0.0, -20.0]\n[effects.pivot]", WINDOW),
    )


def across(body: Scenario, engine: str, method: str, timestep: float, steps: int) -> np.ndarray:
    """ω across the axis at every step, rad/s, up to where the run ended."""
    tested = engines()[engine]
    run = tested.run(body, tested.method(method), timestep, np.arange(steps + 1, dtype=np.int64))
    assert run.trajectory is not None, run.reason
    return np.hypot(*run.trajectory.omega_body[:, :2].T)


def log_amplification(body: Scenario, engine: str, method: str, y: float) -> float:
    """ln of what a step multiplies the nudge by, at λ h = y."""
    across_axis, _, along_axis = np.diag(body.body.inertia_com)
    timestep = y / abs(body_cone_rate(across_axis, along_axis, 1.0))
    sweep = across(body, engine, method, timestep, STEPS)
    assert len(sweep) == STEPS + 1
    return math.log(sweep[-1] / sweep[0]) / STEPS


@pytest.mark.needs_pybullet
@each_case("y", COARSE)
@each_case(("engine", "method", "effects"), [*EXPLICIT, *IMPLICIT])
def test_these_are_explicit_or_implicit_euler_in_free_precession(engine, method, effects, y):
    measured = log_amplification(spinning(DISC, effects), engine, method, y)
    explicit = euler_log_amplification(y)
    wanted = explicit if (engine, method, effects) in EXPLICIT else -explicit
    assert measured == pytest.approx(wanted, abs=ROUNDED)
    assert measured != pytest.approx(-wanted, abs=ROUNDED)


@each_case("y", [0.5, 2.0, 0.99 * RK4_LIMIT, 1.01 * RK4_LIMIT, 3.2])
@each_case("inertia", [DISC, ROD])
@each_case("effects", [FREE, PIVOT])
def test_mujoco_s_runge_kutta_has_the_classical_stability_function(effects, inertia, y):
    """Which divides decay from growth at its limit."""
    assert (rk4_log_amplification(y) > ROUNDED) == (y > RK4_LIMIT)
    measured = log_amplification(spinning(inertia, effects), "mujoco", "RK4", y)
    assert measured == pytest.approx(rk4_log_amplification(y), abs=ROUNDED)
    # The rate is that of ω in the body: the rod's nutation in space is nine times slower.
    assert measured != pytest.approx(rk4_log_amplification(y / 9), abs=ROUNDED)


@pytest.mark.needs_pybullet
@pytest.mark.parametrize(
    ("engine", "method", "limit"),
    [
        ("mujoco", "Euler", LEAPFROG_LIMIT),
        ("mujoco", "implicit", LEAPFROG_LIMIT),
        ("mujoco", "RK4", RK4_LIMIT),
        ("pybullet", "multibody", LEAPFROG_LIMIT),
        ("pybullet", "maximal", LEAPFROG_LIMIT),
    ],
)
def test_swings_stay_small_up_to_the_limit_and_grow_beyond(engine, method, limit):
    body, steps, beside = hanging(), 200, 0.005
    rate = math.sqrt(20.0 / 2.0)
    below = across(body, engine, method, (1 - beside) * limit / rate, steps)
    above = across(body, engine, method, (1 + beside) * limit / rate, steps)
    # Semi-implicit Euler from θ = 0: ω_n = ω_0 cos((n − ½)φ)/cos ½φ with sin ½φ = ½ λh.
    bounded = (1 + NUDGE) / math.cos(math.asin(1 - beside))
    assert below.max() / NUDGE < bounded
    assert above.max() / NUDGE > bounded


def test_a_flipping_body_blows_up_within_a_fifth_of_runge_kutta_s_limit():
    """The rate is that of small deviations, and flips are large: measured at 0.80 of the limit."""
    flipping = spinning("[1.0, 2.0, 3.0]", FREE, "[0.01, 10.0, 0.01]")
    # λ² = [(I3 − I2)(L² − 2 T I1) + (I2 − I1)(2 T I3 − L²)]/(I1 I2 I3) where ω crosses the plane of
    # the extreme axes (Landau & Lifshitz, Mechanics, §37).
    moments, omega = np.array([1.0, 2.0, 3.0]), np.array([0.01, 10.0, 0.01])
    above_low = np.sum(moments * (moments - 1.0) * omega**2)
    below_high = np.sum(moments * (3.0 - moments) * omega**2)
    rate, steps = math.sqrt((above_low + below_high) / 6.0), 3000

    def faster(part: float) -> float:
        """How many times over ω has grown."""
        timestep = part * RK4_LIMIT / rate
        method = engines()["mujoco"].method("RK4")
        counted = np.arange(0, steps + 1, 10, dtype=np.int64)
        run = engines()["mujoco"].run(flipping, method, timestep, counted)
        assert run.trajectory is not None
        speeds = np.linalg.norm(run.trajectory.omega_body, axis=1)
        return float(speeds.max() / speeds[0]) if run.outcome == "ok" else math.inf

    assert faster(0.75) < math.sqrt(10)  # ten times the energy is a blow-up
    assert faster(0.85) > math.sqrt(10)
