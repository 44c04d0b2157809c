"""Which effects methods say they simulate: an effect that is new is simulated by none of them."""

import subprocess
import sys

import pytest

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
