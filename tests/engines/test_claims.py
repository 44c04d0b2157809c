"""Which effects methods say they simulate: an effect that is new is simulated by none of them."""

import subprocess
import sys

#: Every method of every engine here that claims an effect which the format got after it.
PLANT = """
from spincheck.scenarios.effects import EFFECTS, Effect, EffectTable
EFFECTS["spring"] = Effect("spring", "spring", EffectTable)
from spincheck.engines import engines
claims = [(e.name, m.name, sorted(m.effects)) for e in engines().values() for m in e.methods]
assert len({name for name, *_ in claims}) >= 4, claims
assert {"gravity"} <= {effect for *_, effects in claims for effect in effects}
print(*(claim for claim in claims if "spring" in claim[2]), sep="\\n", end="")
"""


def test_no_adapter_claims_an_effect_that_it_does_not_name() -> None:
    command = [sys.executable, "-c", PLANT]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("", 0), done.stderr
