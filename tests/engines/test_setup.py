"""What methods say of themselves: how to set them up in an engine, and what they simulate.

An effect that is new is simulated by none of them.
"""

import re
import subprocess
import sys
from functools import partial
from typing import Any

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


def noted(calls, name, real, *args, **settings):
    calls.append((name, settings))
    return real(*args, **settings)


@pytest.mark.needs_pybullet
@each_case(("engine", "method"), [pair for pair in METHODS if pair[0].name == "pybullet"])
def test_in_pybullet_the_calls_are_among_those_of_the_adapter(engine, method) -> None:
    import pybullet as p

    (path,) = find(["gliding-top" if "table" in method.requires else "fast-top"])
    names = set(re.findall(r"p\.([a-z]\w+)\(", method.setup)) - {"setTimeStep"}

    def calls_of(run, is_real: bool) -> list[tuple[str, dict[str, Any]]]:
        calls = []
        with pytest.MonkeyPatch.context() as patched:
            for name in names:
                real = getattr(p, name) if is_real else lambda *_, **__: None
                patched.setattr(p, name, partial(noted, calls, name, real))
            run()
        return calls

    made = calls_of(lambda: engine.open(load(path), method, TIMESTEP).close(), is_real=True)
    text = method.setup.replace("p.setTimeStep(TIMESTEP)", "")
    typed = calls_of(lambda: exec(text, dict.fromkeys(("plane", "tie"), 1) | {"p": p}), False)
    assert {name for name, _ in typed} == names
    for name, settings in typed:
        assert any(name == one and settings.items() <= its.items() for one, its in made), settings


#: Methods of engines here that would take a scene with an effect that the format got after them.
PLANT = """
from spincheck.scenarios.effects import EFFECTS, Effect, EffectTable
EFFECTS["spring"] = Effect("spring", table="gravity", model=EffectTable)
from spincheck.engines import engines
from spincheck.scenarios import find, load
(top,) = map(load, find(["fast-top"]))
assert top.called_for == {"gravity", "pivot", "spring"}
answers = [(e.name, m.name, e.unsupported(top, m)) for e in engines().values() for m in e.methods]
assert len({name for name, *_ in answers}) >= 4, answers
print(*(one for one in answers if "spring" not in one[2]), sep="\\n", end="")
"""


@pytest.mark.processes
def test_no_adapter_claims_an_effect_that_it_does_not_name() -> None:
    command = [sys.executable, "-c", PLANT]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("", 0), done.stderr
