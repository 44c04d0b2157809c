"""Machine code is cached, compiled ahead for every scene, and anew when a source changes."""

import inspect
from importlib import import_module
from pathlib import Path

import numba
import numpy as np
import pytest
from library_scenes import library_scene
from small_disks import small_disk
from spincheck.reference import compiled, following, solve
from spincheck.reference import kernel as kernel_module
from spincheck.reference.deviations import _fill, apart
from spincheck.reference.following import follow, rates
from spincheck.reference.kernel import digest_of_kernels, kernel
from spincheck.reference.other_equations import equations_of
from spincheck.reference.taylor_march import march
from spincheck.reference.theta_kernel import evaluate

KERNELS = "from .kernel import kernel\n"
CALLERS = "from .doubledouble import dd_add\n"
PLACES = "from .rows import Entry\n"
ROWS = "class Rows:\n    count = 0\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    (tmp_path / "arithmetic.py").write_text(KERNELS)
    (tmp_path / "callers.py").write_text(CALLERS)
    (tmp_path / "places.py").write_text(PLACES)
    (tmp_path / "rows.py").write_text(ROWS)
    (tmp_path / "other.py").write_text("import math\n")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "text"),
    [("arithmetic.py", KERNELS), ("callers.py", CALLERS), ("places.py", PLACES), ("rows.py", ROWS)],
)
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


def test_a_full_disk_costs_the_kept_machine_code_and_no_result(tmp_path, monkeypatch) -> None:
    """One that holds a folder, and no file."""
    with small_disk(tmp_path / "disk", "size=4k,nr_inodes=2") as disk:
        monkeypatch.setattr(kernel_module, "FOLDER", disk.folder)
        assert kernel(sum_of)(2.0, 5.0) == 7.0
        assert [path for path in disk.folder.rglob("*") if path.is_file()] == []


def test_machine_code_that_was_cut_is_made_anew(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(kernel_module, "FOLDER", tmp_path)
    kernel(sum_of)(2.0, 5.0)
    kept = {path: path.read_bytes() for path in tmp_path.rglob("*.nb?")}
    assert kept
    for path, content in kept.items():
        path.write_bytes(content[: len(content) // 2])
    assert kernel(sum_of)(2.0, 5.0) == 7.0
    assert all(len(path.read_bytes()) > len(content) // 2 for path, content in kept.items())


def sum_of(a: float, b: float) -> float:
    return a + b


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


@pytest.mark.parametrize("name", ["hammer", "kovalevskaya"])
def test_times_that_can_be_written_and_others_are_of_one_type_to_kernels(name: str) -> None:
    """Those of a scene cannot be written, and those of a recording can: each type is compiled."""
    times = library_scene(name).times[:3]
    assert not times.flags.writeable
    solve(library_scene(name), times)
    before = [list(one.signatures) for one in (march, evaluate)]
    solve(library_scene(name), times.copy())
    assert [list(one.signatures) for one in (march, evaluate)] == before


def test_arrays_of_any_layout_are_of_one_type_to_kernels() -> None:
    equations = equations_of(library_scene("fast-top"))
    states, spans = np.tile([1.0, 0, 0, 0, 0.1, 0.2, 0.3], (6, 1)), np.full((6, 2), 1e-3)

    def used(states: np.ndarray, spans: np.ndarray) -> list[list[object]]:
        apart(follow(equations, states, spans)[:, 1], states)
        rates(equations, states, states[:, 4:])
        return [list(one.signatures) for one in (following._follow, _fill, following._fill_rates)]

    before = used(states, spans)
    fixed = states.copy()
    fixed.flags.writeable = False
    assert used(fixed[::2], np.asfortranarray(spans)[::2]) == before


@pytest.mark.parametrize("folder", [None, Path("nowhere")])
def test_what_is_not_kept_is_not_said_to_be(monkeypatch, folder: Path | None) -> None:
    monkeypatch.setattr(compiled, "FOLDER", folder)
    assert not compiled.is_compiled()


def test_only_kernels_that_make_arrays_count_references_to_them() -> None:
    """Counting takes longer than all else in a step of an integrator."""
    counting, making = set(), set()
    for name in ("flow", "following", "tangent_march", "taylor_march", "theta_kernel"):
        for one in vars(import_module(f"spincheck.reference.{name}")).values():
            if options := getattr(one, "targetoptions", None):
                counting |= {one.py_func} if options["_nrt"] else set()
                making |= {one.py_func} if "np.empty(" in inspect.getsource(one.py_func) else set()
    assert len(counting) == 5
    assert counting == making
