"""Machine code is kept, but never longer than the sources it was made from."""

import errno
from pathlib import Path

import numba
import pytest
from numba.core import caching
from spincheck.reference.kernel import digest_of_kernels, kernel

KERNELS = "from .kernel import kernel\n"
CALLERS = "from .doubledouble import dd_add\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    (tmp_path / "arithmetic.py").write_text(KERNELS)
    (tmp_path / "callers.py").write_text(CALLERS)
    (tmp_path / "other.py").write_text("import math\n")
    return tmp_path


@pytest.mark.parametrize(("name", "text"), [("arithmetic.py", KERNELS), ("callers.py", CALLERS)])
def test_a_change_of_any_kernel_file_changes_the_digest(
    package: Path, name: str, text: str
) -> None:
    before = digest_of_kernels(package)
    (package / name).write_text(text + "x = 1\n")
    assert digest_of_kernels(package) != before
    (package / name).write_text(text)
    assert digest_of_kernels(package) == before


def test_a_change_of_another_file_does_not(package: Path) -> None:
    before = digest_of_kernels(package)
    (package / "other.py").write_text("import cmath\n")
    assert digest_of_kernels(package) == before


def test_other_users_of_numba_keep_their_cache_where_they_had_it() -> None:
    before = numba.config.CACHE_DIR
    assert kernel(abs_difference)(2.0, 5.0) == 3.0
    assert before == numba.config.CACHE_DIR


def abs_difference(a: float, b: float) -> float:
    return abs(a - b)


def test_a_full_disk_costs_the_kept_machine_code_and_no_result(monkeypatch) -> None:
    def no_room(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(caching.IndexDataCacheFile, "save", no_room)
    assert kernel(sum_of)(2.0, 5.0) == 7.0


def sum_of(a: float, b: float) -> float:
    return a + b
