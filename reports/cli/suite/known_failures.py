"""The file of known failures that an adopter of the suite keeps."""

import tomllib
from pathlib import Path

import pytest
from spincheck.suite import test_adapter, test_physics

from ....scenarios import did_you_mean

TESTS = [name for name in [*vars(test_adapter), *vars(test_physics)] if name.startswith("test_")]


def known_failures(path: Path) -> dict[str, str]:
    """Return the reasons by the names of tests: ``test_heavy_top``, or with ``[engine-method]``.

    The file is TOML, a line ``"test_heavy_top[my-engine-RK4]" = "reason"`` for each.

    Raises
    ------
    pytest.UsageError
        If it cannot be read, or names a test that there is not, or one without a reason.
    """
    where = f"'--spincheck-xfails' {path}"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise pytest.UsageError(f"{where}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise pytest.UsageError(f"{where}: must be TOML in UTF-8: {error}") from None
    for name, reason in table.items():
        test = name.partition("[")[0]
        if test not in TESTS:
            hint = did_you_mean(test, TESTS)
            raise pytest.UsageError(f"{where}: '{test}' is no test of the suite{hint}")
        if not (isinstance(reason, str) and reason.strip()):
            raise pytest.UsageError(
                f"{where}: '{name}' must have its reason as a text, got {reason!r}"
            )
    return table
