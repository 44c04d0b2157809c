"""An Exudyn system and its steps as Python that needs `exudyn` and numpy alone."""

from collections.abc import Iterator

from ...models.text import python_list
from .held import R_BODY_NODE, Held
from .solvers import main_solver, solver_settings

_START = """\
import exudyn
import exudyn.itemInterface as items

container = exudyn.SystemContainer()
mbs = container.AddSystem()
# The node's axes are the body's y, z and x: where a node starts along the world's axes,
# Exudyn loses rotations of less than 1.5e-8 rad a step.
R_BODY_NODE = np.array({axes})
# Position, m, and rotation vector, rad; their rates, m/s, and rad/s in node axes.
place = {place}
velocity = {velocity}
node = mbs.AddNode(
    items.NodeRigidBodyRotVecLG(referenceCoordinates=place, initialVelocities=velocity)
)
# kg m^2 about the node: xx, yy, zz, yz, xz, xy.
inertia = {inertia}
body = mbs.AddObject(items.ObjectRigidBody(mass={mass!r}, inertia=inertia, nodeNumber=node))  # kg
place_of_com = {com}  # m, node axes
com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=place_of_com))
"""
_PIVOT = """\
# The node is the pivot: its position is held.
ground = mbs.AddNode(items.NodePointGround())
still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
for k in range(3):
    held = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
    mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, held]))
"""
_WEIGHT = """\
mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector={weight}))  # N
"""
_WHOLE = """\
whole = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
"""
_TORQUE = """\
torque = {torque}  # N m, {axes}
mbs.AddLoad(items.LoadTorqueVector(markerNumber=whole, loadVector=torque, bodyFixed={fixed}))
"""
_DRAG = """\
base = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=mbs.AddObject(items.ObjectGround())))
drag = np.diag({damping})  # N s/m, then N m s
mbs.AddObject(
    items.ObjectConnectorRigidBodySpringDamper(markerNumbers=[base, whole], damping=drag)
)
"""
_SETTINGS = """\
settings = exudyn.SimulationSettings()
settings.solution.file.write = False
integration = settings.timeIntegration
integration.numberOfSteps, integration.endTime = 1, TIMESTEP
{lines}
solver = exudyn.{solver}()
mbs.Assemble()
solver.InitializeSolver(mbs, settings)


def step(count):
    # Its clock starts at 0 in each call and sums up the steps.
    end = 0.0
    for _ in range(count):
        end += TIMESTEP
    solver.it.currentTime, solver.it.endTime = 0.0, end
    if not solver.SolveSteps(mbs, settings):
        raise SystemExit("Exudyn's solver gave up")


def quaternion(R):
    \"\"\"Of a rotation matrix, w x y z: the longest row of 4 q q^T.\"\"\"
    vector = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    rest = R + R.T + (1 - np.trace(R)) * np.eye(3)
    rows = np.block([[1 + np.trace(R), vector], [vector[:, None], rest]])
    row = rows[np.argmax(np.diag(rows))]
    return row / np.linalg.norm(row)


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    of = exudyn.OutputVariableType
    R_world_node = mbs.GetNodeOutput(node, of.RotationMatrix).reshape(3, 3)
    omega_node = mbs.GetNodeOutput(node, of.AngularVelocityLocal)
    return quaternion(R_world_node @ R_BODY_NODE.T), R_BODY_NODE @ omega_node
"""


def script(told: Held, has_pivot: bool, solver: str) -> str:
    """The system, its solver and its steps."""
    settings = {"solverType": f"exudyn.DynamicSolverType.{solver}"} | solver_settings(solver)
    lines = "\n".join(f"integration.{name} = {value}" for name, value in settings.items())
    return (
        _START.format(
            axes=python_list(R_BODY_NODE),
            place=python_list(told.place),
            velocity=python_list(told.velocity),
            mass=told.mass,
            inertia=python_list(told.inertia),
            com=python_list(told.com),
        )
        + "".join(_acting(told, has_pivot))
        + _SETTINGS.format(lines=lines, solver=main_solver(solver))
    )


def _acting(told: Held, has_pivot: bool) -> Iterator[str]:
    """What holds the body, and what acts on it."""
    if has_pivot:
        yield _PIVOT
    if told.weight.any():
        yield _WEIGHT.format(weight=python_list(told.weight))
    if told.torque_node.any() or told.torque_world.any() or told.damping.any():
        yield _WHOLE
    for torque, axes in ((told.torque_node, "node axes"), (told.torque_world, "world axes")):
        if torque.any():
            yield _TORQUE.format(torque=python_list(torque), axes=axes, fixed=axes == "node axes")
    if told.damping.any():
        yield _DRAG.format(damping=python_list(told.damping.diagonal()))
