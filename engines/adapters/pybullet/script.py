"""Python code of a PyBullet world and its steps, which needs `pybullet` and numpy alone."""

from pathlib import Path

from spincheck.engine import Scenario

from ...models.text import python_text
from ...world_session import run_script
from .load import BodyRepresentation, scenes_own
from .session import PyBulletSession
from .world import FILE, FRICTIONLESS

_MADE = """\
{urdf}
SCENE = {{
{scene}
}}
world = World(SCENE, p.connect(p.DIRECT), {{FILE: URDF.encode()}})
world.set_up(TIMESTEP)"""
_STATE = """\
_, (x, y, z, w), _, omega_world = world.motion()
q = product(np.array([w, x, y, z]), conjugate(np.array(SCENE["axes"])))
return q, turned(conjugate(q), np.array(omega_world))"""
CONTACT = f"""\
# on a plane, of both bodies:
p.setPhysicsEngineParameter(contactSlop=0)
for one in (plane, body):
    p.changeDynamics(one, -1, **{FRICTIONLESS!r})"""
JOINT = """\
# on a spherical joint:
p.setJointMotorControlMultiDof(body, 0, p.POSITION_CONTROL, targetPosition=(0, 0, 0, 1), \
positionGain=0, velocityGain=0, force=[0, 0, 0])"""
TIE = """\
# tied to a point:
p.setPhysicsEngineParameter(constraintSolverType=p.CONSTRAINT_SOLVER_LCP_DANTZIG)
p.changeConstraint(tie, maxForce=1e100)"""


def setup(representation: BodyRepresentation) -> str:
    """Return lines of Python by which users load their own URDF as a method loads a scene's.

    `representation` says how the method represents the body and holds it.
    """
    maximal = ", useMaximalCoordinates=True" if representation.maximal else ""
    holding = CONTACT if representation.by_contact else JOINT if representation.hung else TIE
    return f"""\
p.setTimeStep(TIMESTEP)
body = p.loadURDF("body.urdf", flags=p.URDF_USE_INERTIA_FROM_FILE{maximal})
p.changeDynamics(body, -1, linearDamping=0, angularDamping=0)
p.changeDynamics(body, -1, maxJointVelocity=1e100)
{holding}"""


def script(scenario: Scenario, representation: BodyRepresentation, timestep: float) -> str:
    """Return a Python script of a run, with the record that `World` takes.

    `representation` says how the body is represented and held. A session is opened to complete the
    record, because PyBullet itself finds the principal axes. `EngineError` is raised if PyBullet
    cannot load the scene.
    """
    with PyBulletSession(scenario, representation, timestep) as session:
        entries = [f'    "{key}": {value!r},' for key, value in session.world.scene.items()]
    world = Path(__file__).with_name("world.py")
    text = python_text("URDF", scenes_own(scenario, representation)[FILE].decode())
    made = _MADE.format(urdf=text, scene="\n".join(entries))
    return run_script(world, made, _STATE)
