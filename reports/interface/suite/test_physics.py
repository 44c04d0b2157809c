"""Tests of motions: each is about one thing that engines are known to get wrong.

The scene of a test is one in which that thing matters, and other things matter as little as
possible. A method passes if its motions at halved timesteps converge to the exact motion. Methods
as shipped are judged like any other.
"""

from typing import Any

from spincheck.suite.failure_means import failure_means


@failure_means(
    "The torque ω × Iω of a free body is missing, or wrong.",
    "jrouwe/JoltPhysics#803",
    "godotengine/godot#80703",
    "godotengine/godot#74738",
    "google/brax#48",
    "avianphysics/avian#420",
    "bulletphysics/bullet3#4636",
    "newton-physics/newton#2530",
)
def test_free_asymmetric_gyroscopic_torque(spincheck_subject: Any) -> None:
    """A free body of three different moments tumbles as Euler's equations say."""
    spincheck_subject.follows("free-asymmetric")


@failure_means(
    "A body spun about its middle axis does not flip, or at another time.",
    "google/brax#156",
    "avianphysics/avian#993",
    "mockingbirdnest/Principia#2519",
)
def test_flip_about_the_middle_axis(spincheck_subject: Any) -> None:
    """A body spun about its middle axis flips when it should: the tennis racket."""
    spincheck_subject.follows("middle-axis")


@failure_means(
    "Products of inertia are dropped, or the tensor is turned the wrong way.",
    "avianphysics/avian#745",
    "isaac-sim/IsaacLab#4161",
    "isaac-sim/urdf-importer-extension#2",
    "newton-physics/urdf-usd-converter#118",
    "google-deepmind/mujoco#3559",
    "o3de/o3de#20016",
    "DanielChappuis/reactphysics3d#422",
)
def test_off_diagonal_inertia(spincheck_subject: Any) -> None:
    """A body moves by its whole tensor of inertia, in axes that are not its principal ones."""
    spincheck_subject.follows("off-diagonal-inertia")


@failure_means(
    "L of a free body is lost or gained, at however small a timestep.",
    "dartsim/dart#424",
    "gazebosim/gazebo-classic#1487",
)
def test_angular_momentum_is_conserved(spincheck_subject: Any) -> None:
    """L of a free tumbling body is constant in the limit of vanishing timesteps."""
    spincheck_subject.follows("free-asymmetric")


@failure_means(
    "Energy of a free body is lost or gained, at however small a timestep.",
    "dimforge/rapier#100",
    "Genesis-Embodied-AI/genesis-world#3074",
    "bulletphysics/bullet3#346",
    "avianphysics/avian#993",
)
def test_energy_is_conserved(spincheck_subject: Any) -> None:
    """The energy of a free tumbling body is constant in the limit of vanishing timesteps."""
    spincheck_subject.follows("free-asymmetric")


@failure_means(
    "The attitude does not turn by ω: a missing factor ½, a wrong product of quaternions.",
    "mit-aera/FlightGoggles#67",
    "sofa-framework/sofa#172",
    "avianphysics/avian#488",
    "RobotLocomotion/drake#14800",
)
def test_attitude_follows_omega(spincheck_subject: Any) -> None:
    """A free sphere turns about a skew axis by the angle ω t."""
    spincheck_subject.follows("sphere")


@failure_means(
    "Something slows a free body that nothing slows: damping that is on by default.",
    "mockingbirdnest/Principia#4166",
)
def test_no_hidden_damping(spincheck_subject: Any) -> None:
    """A free sphere keeps its ω for ten seconds."""
    spincheck_subject.follows("sphere")


@failure_means(
    "Velocities are clamped, or the rotation of a step is.",
    "bulletphysics/bullet3#1890",
    "isaac-sim/IsaacLab#2307",
    "godotengine/godot#120724",
)
def test_no_velocity_clamp(spincheck_subject: Any) -> None:
    """A free sphere keeps 500 rad/s."""
    spincheck_subject.follows("fast-sphere")


@failure_means(
    "A body that turns slowly is put to sleep, or friction has a floor.", "mas-bandwidth/fixed3d#41"
)
def test_slow_rotation_goes_on(spincheck_subject: Any) -> None:
    """A free sphere keeps a degree a second for twenty seconds."""
    spincheck_subject.follows("slow-sphere")


@failure_means(
    "Damping is no torque: it does not depend on the inertia, or ends above zero.",
    "mockingbirdnest/Principia#4166",
    "mas-bandwidth/fixed3d#41",
)
def test_drag_is_a_torque(spincheck_subject: Any) -> None:
    """The torque −c ω slows a sphere at the rate c/I, to a thousandth and further."""
    spincheck_subject.follows("slowing-sphere")


@failure_means(
    "A torque given in body axes is applied in others, or as an angular acceleration.",
    "isaac-sim/IsaacLab#6927",
    "bulletphysics/bullet3#1949",
    "duburcqa/jiminy#150",
    "ArduPilot/ardupilot#26972",
)
def test_torque_in_body_axes(spincheck_subject: Any) -> None:
    """A torque that is constant in body axes turns with the body."""
    spincheck_subject.follows("torque-in-body-axes")


@failure_means(
    "A torque given in world axes is applied in others, or depends on the attitude.",
    "bulletphysics/bullet3#1949",
    "duburcqa/jiminy#150",
    "jrouwe/JoltPhysics#852",
)
def test_torque_in_world_axes(spincheck_subject: Any) -> None:
    """A torque that is constant in world axes does not turn with the body."""
    spincheck_subject.follows("torque-in-world-axes")


@failure_means(
    "A body turns about its origin, or drifts, where its centre of mass is elsewhere.",
    "newton-physics/newton#1366",
    "avianphysics/avian#246",
    "avianphysics/avian#389",
)
def test_offset_com(spincheck_subject: Any) -> None:
    """The centre of mass of a thrown body flies straight, and the body turns about it."""
    spincheck_subject.follows("offset-com")


@failure_means(
    "A ball joint has friction, a motor or damping that nobody switched on, or loses momentum.",
    "dartsim/dart#846",
    "bulletphysics/bullet3#4689",
    "dimforge/rapier#208",
    "AVSLab/basilisk#1484",
)
def test_frictionless_pivot(spincheck_subject: Any) -> None:
    """A body on a ball joint, without gravity, keeps its ω for ten seconds."""
    spincheck_subject.follows("pivot")


@failure_means(
    "The weight's torque, the gyroscopic one or the joint's force is wrong.",
    "gazebosim/gazebo-classic#743",
    "newton-physics/newton#2530",
)
def test_heavy_top(spincheck_subject: Any) -> None:
    """A spinning top on a pivot precesses and nutates as in Lagrange's solution."""
    spincheck_subject.follows("heavy-top")


@failure_means(
    "A number of fixed size, as a threshold or a regularisation, is not small for small bodies.",
    "google-deepmind/mujoco#989",
)
def test_small_body(spincheck_subject: Any) -> None:
    """A top of a tenth of a gram moves as a larger one, only faster."""
    spincheck_subject.follows("small-top")
