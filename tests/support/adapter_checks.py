"""The tests of `spincheck.suite.test_adapter` as functions of an engine and a method."""

from collections.abc import Callable

from spincheck.engines import Engine, Method
from spincheck.suite import test_adapter

Check = Callable[[Engine, Method], None]

CHECKS: list[Check] = [f for name, f in vars(test_adapter).items() if name.startswith("test_")]
