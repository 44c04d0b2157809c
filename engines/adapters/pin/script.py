"""A Pinocchio model and its steps as Python that needs `pinocchio` and numpy alone."""

from collections.abc import Iterator

from ....scenarios import Scenario
from ...models.text import python_list
from .start import start_of

_START = """\
import pinocchio

model = pinocchio.Model()
upright = pinocchio.SE3.Identity()
joint = model.addJoint(0, pinocchio.JointModel{joint}(), upright, "top")
# m, body axes, from the joint; kg m^2, about the com.
com = np.array({com})
inertia = np.array({inertia})
model.appendBodyToJoint(joint, pinocchio.Inertia({mass!r}, com, inertia), upright)  # kg
model.gravity.linear = np.array({gravity})  # m/s^2
data = model.createData()
# {coordinates}
q = np.array({q})
v = np.array({v})


def acceleration(q, v):
    torque = np.zeros(len(v))
{pushes}    return pinocchio.aba(model, data, q, v, torque)


"""
_SEMI_IMPLICIT = """\
def step(count):
    global q, v
    for _ in range(count):
        v = v + TIMESTEP * acceleration(q, v)
        q = pinocchio.integrate(model, q, TIMESTEP * v)
"""
_RUNGE_KUTTA = """\
def rates(q, v):
    \"\"\"Of the coordinates, the quaternion's as plain numbers, and of the velocities.\"\"\"
    x, y, z, w = q[-4:]
    turning = product(np.array([w, x, y, z]), np.array([0.0, *v[-3:]])) / 2
    moving = pinocchio.Quaternion(q[-4:]).matrix() @ v[:-3] if len(v) > 3 else []
    return np.array([*moving, *turning[1:], turning[0]]), acceleration(q, v)


def normalised(q):
    q[-4:] /= np.linalg.norm(q[-4:])
    return q


def step(count):
    \"\"\"The classical Runge-Kutta rule.\"\"\"
    global q, v
    for _ in range(count):
        q_rate, v_rate, q_sum, v_sum = 0 * q, 0 * v, 0 * q, 0 * v
        for at, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
            h = at * TIMESTEP
            q_rate, v_rate = rates(normalised(q + h * q_rate), v + h * v_rate)
            q_sum, v_sum = q_sum + weight * q_rate, v_sum + weight * v_rate
        q, v = normalised(q + TIMESTEP / 6 * q_sum), v + TIMESTEP / 6 * v_sum
"""
_STATE = """

def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    x, y, z, w = q[-4:]
    return np.array([w, x, y, z]), v[-3:]
"""
_HELD = "Attitude, x y z w; angular velocity, rad/s, body axes."
_FREE = "Position of the origin, m, attitude, x y z w; velocity, m/s and rad/s, body axes."


def script(scenario: Scenario, method: str) -> str:
    """The model, and its steps with the scene's torques at each evaluation."""
    body, (q, v) = scenario.body, start_of(scenario)
    start = _START.format(
        joint="Spherical" if scenario.has_pivot else "FreeFlyer",
        com=python_list(body.com),
        inertia=python_list(body.inertia_com),
        mass=float(body.mass),
        gravity=python_list(scenario.gravity_world),
        coordinates=_HELD if scenario.has_pivot else _FREE,
        q=python_list(q),
        v=python_list(v),
        pushes="".join(f"    {line}\n" for line in _pushes(scenario)),
    )
    return start + (_RUNGE_KUTTA if method == "RK4" else _SEMI_IMPLICIT) + _STATE


def _pushes(scenario: Scenario) -> Iterator[str]:
    """Torques, N m, in body axes."""
    if scenario.drag:
        yield f"torque[-3:] -= {scenario.drag!r} * v[-3:]  # N m"
    if scenario.torque_body.any():
        yield f"torque[-3:] += {python_list(scenario.torque_body)}  # N m, body axes"
    if scenario.torque_world.any():
        torque = python_list(scenario.torque_world)
        yield f"torque_world = np.array({torque})  # N m"
        yield "torque[-3:] += pinocchio.Quaternion(q[-4:]).matrix().T @ torque_world"
