"""The contract as tests of pytest: one an engine, method and requirement."""

from collections.abc import Callable

from ..discovery import engines, missing
from ..engine import Engine, Method
from .checks import CHECKS, Check


def contract_tests(*names: str) -> Callable[..., None]:
    """A test function to be assigned to a name that pytest collects.

    Parameters
    ----------
    names : of engines; if none, every engine that can be used here, except those that load users'
        files

    Raises
    ------
    ValueError
        If there is no engine of that name, or it cannot be imported: with the reason.
    """
    import pytest

    generated = [name for name, engine in engines().items() if not engine.of_file]
    reasons = {absent.name: absent.reason for absent in missing()}
    for name in names:
        if name not in engines():
            why = reasons.get(name, f"must be one of {', '.join(engines())}")
            raise ValueError(f"'{name}': {why}")
    chosen = [engines()[name] for name in names or generated]
    cases = [
        pytest.param(check, engine, method, id=f"{engine.name}-{method.name}-{check.__name__}")
        for engine in chosen
        for method in engine.methods
        for check in CHECKS
    ]

    @pytest.mark.parametrize(("check", "engine", "method"), cases)
    def test_contract(check: Check, engine: Engine, method: Method) -> None:
        check(engine, method)

    return test_contract
