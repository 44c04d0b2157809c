"""Digests change when something changes that results depend on, and only then."""

from pathlib import Path

from spincheck.engines.adapters.mujoco import MuJoCo
from spincheck.engines.contract.scenes import SCENES
from spincheck.engines.versions.engine import VersionedEngine
from spincheck.engines.versions.folders import folder_of
from spincheck.reports.results.fingerprints import digests

NAME = "mujoco@3.3.0"


def digest(site: Path) -> str:
    engine = VersionedEngine("mujoco", "3.3.0", MuJoCo.methods, site)
    return digests(SCENES["free"], [engine])[NAME]


def test_one_version_under_two_pythons_is_two_engines() -> None:
    assert digest(folder_of(NAME, "cp311")) != digest(folder_of(NAME, "cp312"))


def test_one_version_in_two_caches_is_one_engine() -> None:
    folder = folder_of(NAME, "cp312")
    assert digest(folder) == digest(Path("another-cache") / folder.name)
