"""The MJCF has the scene's numbers, bit for bit, and the integrator that is asked for.

That the model of it holds what the scene says, moves by it and by nothing else: see the contract.
"""

import mujoco
import numpy as np
from case_loops import each_case
from spincheck.engines.models.mjcf import mjcf, start_coordinates, switched_off
from spincheck.suite.contract_scenes import SCENES

#: Models of rotors are read back by the contract.
RIGID = [name for name, scene in SCENES.items() if not scene.rotors]


@each_case("name", RIGID)
def test_numbers_are_read_back_bit_for_bit(name: str) -> None:
    scene = SCENES[name]
    model = mujoco.MjModel.from_xml_string(mjcf(scene, 0.1 / 3, "RK4"))
    qpos, qvel = start_coordinates(scene)
    assert model.opt.timestep == 0.1 / 3
    assert model.opt.gravity.tolist() == scene.gravity_world.tolist()
    assert model.body_mass[1] == scene.body.mass
    assert model.body_ipos[1].tolist() == scene.body.com.tolist()
    assert model.key(0).qvel.tolist() == qvel
    # The compiler normalises the quaternion once more.
    assert np.abs(model.key(0).qpos - qpos).max() <= np.finfo(float).eps
    # Of a gravity of zero the audit tells nothing.
    assert ("gravity" in switched_off(scene)) == ("gravity" not in scene.called_for)


@each_case("integrator", ["Euler", "implicit", "implicitfast", "RK4", "discrete"])
def test_the_integrator_is_the_one_asked_for(integrator: str) -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(SCENES["free"], 1e-3, integrator))
    enum = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator.upper()}"]
    assert model.opt.integrator == enum
