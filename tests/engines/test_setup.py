"""What users are told to type into an engine gives the method and timestep that it promises."""

from textwrap import dedent

import mujoco
import pytest
from case_loops import each_case
from spincheck.engines import engines
from spincheck.scenarios import find, load

TIMESTEP = 0.003
METHODS = [
    (engine, method)
    for engine in engines().values()
    for method in engine.methods
    if engine.name in ("mujoco", "pybullet") and method.is_recommendable
]


def test_every_method_that_is_recommended_says_what_to_type() -> None:
    assert len(METHODS) > 5
    assert all("TIMESTEP" in method.setup for _, method in METHODS)


@each_case(("engine", "method"), [pair for pair in METHODS if pair[0].name == "mujoco"])
def test_in_mujoco_the_option_and_the_calls_set_the_same_integrator(engine, method) -> None:
    option, _, calls = method.setup.replace("TIMESTEP", repr(TIMESTEP)).partition("\n\n")
    plain = "<mujoco>{}<worldbody/></mujoco>"
    by_option = mujoco.MjModel.from_xml_string(plain.format(option))
    model = mujoco.MjModel.from_xml_string(plain.format(""))
    exec(calls, {"model": model, "mujoco": mujoco})
    integrator = method.name.removeprefix("contact-").upper()
    expected = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    for made in (by_option, model):
        assert (made.opt.integrator, made.opt.timestep) == (expected, TIMESTEP)


@pytest.mark.needs_pybullet
@each_case(("engine", "method"), [pair for pair in METHODS if pair[0].name == "pybullet"])
def test_in_pybullet_the_calls_are_those_of_the_script_that_reproduces_a_run(engine, method):
    (path,) = find(["gliding-top" if "table" in method.requires else "fast-top"])
    script = dedent(engine.script(load(path), method, TIMESTEP))
    timestep, loading, *others = method.setup.splitlines()
    assert timestep in script
    assert ("useMaximalCoordinates=True" in loading) == ("useMaximalCoordinates=True" in script)
    assert "flags=p.URDF_USE_INERTIA_FROM_FILE" in loading
    for line in others:
        assert line.startswith("# ") or line in script, line
