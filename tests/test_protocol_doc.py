"""The exchange on the page about the protocol is the one that its engine has."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from library_scenes import library_scene
from spincheck.engines.scene_record import scene_record

pytestmark = pytest.mark.processes

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/reference/engine-protocol.md").read_text(encoding="utf-8")
CALLS, ANSWERS = (
    [json.loads(line) for line in re.findall(rf"^{arrow} (.*)$", PAGE, re.MULTILINE)]
    for arrow in "→←"
)


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_the_exchange_is_that_of_the_toy() -> None:
    reads, writes = os.pipe()
    done = subprocess.run(
        ["node", "tests/engines/interface_1/toy.mjs"],
        cwd=ROOT,
        input="".join(f"{json.dumps(call)}\n" for call in CALLS).encode(),
        env=os.environ | {"SPINCHECK_ANSWERS": str(writes)},
        pass_fds=(writes,),
        timeout=60,
        check=True,
    )
    os.close(writes)
    with os.fdopen(reads) as answers:
        assert [json.loads(line) for line in answers] == ANSWERS
    assert done.stdout is None


#: The keys of scenes that engines for version 1 were written for.
OF_VERSION_1 = {
    *("mass", "moments", "axes", "arm", "gravity", "drag", "torque_body", "torque_world"),
    *("q", "omega", "com", "velocity"),
}


def test_it_opens_a_scene_with_every_key() -> None:
    (opened,) = [call for call in CALLS if call["do"] == "open"]
    assert opened["scene"].keys() == OF_VERSION_1


def test_a_scene_has_no_key_of_an_effect_that_it_does_not_call_for() -> None:
    assert scene_record(library_scene("fast-top")).keys() == OF_VERSION_1
