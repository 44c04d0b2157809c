"""No scene needs a kernel that is not compiled ahead."""

from pathlib import Path

import pytest
from library_scenes import library_scene
from spincheck.reference import compiled, solve

#: One of each way in which motions are found: every closed form, and the ODE under every effect.
SCENES = ["hammer", "earth-wobble", "fast-top", "book-with-drag", "kovalevskaya", "spacecraft"]


def machine_code() -> set[Path]:
    assert compiled.FOLDER is not None, "without a place for it nothing is kept"
    return set(compiled.FOLDER.rglob("*.nbc"))


def test_scenes_find_their_kernels_compiled() -> None:
    compiled.compile_kernels()
    assert compiled.is_compiled()
    before = machine_code()
    for name in SCENES:
        scenario = library_scene(name)
        solve(scenario, scenario.times[:3])
    assert machine_code() == before


@pytest.mark.parametrize("folder", [None, Path("nowhere")])
def test_what_is_not_kept_is_not_said_to_be(monkeypatch, folder: Path | None) -> None:
    monkeypatch.setattr(compiled, "FOLDER", folder)
    assert not compiled.is_compiled()
