"""Engines that are always there, and optional ones: what a test asks of both, or of one kind."""

import pytest
from spincheck.engines import Engine, engines, missing
from spincheck.engines.child import ChildEngine

#: Optional engines of which a name stands in a test; each is run where it is there.
OPTIONAL = (
    "brax",
    "cannon-es",
    "dartpy",
    "drake",
    "exudyn",
    "genesis",
    "havok",
    "jolt",
    "mjx",
    "mjx-float32",
    "mujoco-warp",
    "newton",
    "physx",
    "pin",
    "pybox3d",
    "rapier3d",
    "rapier3d-js",
)


def required_engines() -> list[Engine]:
    """Those whose packages spincheck depends on, which load the scene's own models."""
    return [
        engine
        for engine in engines().values()
        if not (engine.package or engine.of_file or isinstance(engine, ChildEngine))
    ]


def why_missing(name: str) -> str:
    """Why an optional engine is not there, with how to get it; empty if it is."""
    return next((absent.reason for absent in missing() if absent.name == name), "")


def installed(name: str) -> Engine:
    """An optional engine; the test is skipped where it is not there, with the reason."""
    if reason := why_missing(name):
        pytest.skip(reason)
    return engines()[name]
