"""Files are read if they are files, and written as new ones; nothing in between is ever seen."""

import ast
import errno
import os
import sys
from pathlib import Path

import pytest
from sources import files_with
from spincheck.engines.user_cache import user_cache
from spincheck.reference import kernel
from spincheck.reports.cli.terminal import refusal
from spincheck.scenarios.regular_files import read_regular, replacing, write_new

#: What opens a file for writing, or may.
WRITERS = ("write_text", "write_bytes", "os.open", "shutil.copy", "shutil.copyfile", "mkstemp")
MODES = ("w", "x", "a", "wb", "xb", "ab", "r+", "w+", "r+b", "w+b")
#: Where it is allowed besides: in temporary folders of their own, in the cache, on descriptors.
ALLOWED = {
    "scenarios/regular_files.py",
    "engines/adapters/pybullet/world.py",
    "engines/adapters/node/__main__.py",
    "engines/users_models/layout.py",
    "reports/cli/stopping.py",
    "reports/harness/executors/worker_main.py",
    "reports/results/only_writer.py",
}


def writes(call: ast.AST) -> bool:
    if not isinstance(call, ast.Call):
        return False
    name = ast.unparse(call.func)
    modes = [a.value for a in call.args if isinstance(a, ast.Constant) and a.value in MODES]
    opens = name.rpartition(".")[2] == "open" and bool(modes)
    return opens or name.endswith(WRITERS)


def test_nothing_else_opens_a_file_to_be_written() -> None:
    assert files_with(writes) == ALLOWED


@pytest.mark.parametrize("content", [b"", b"12345", b"123456", b"12345678"])
def test_as_many_bytes_are_read_as_tell_whether_there_are_too_many(tmp_path, content):
    (tmp_path / "file").write_bytes(content)
    assert read_regular(tmp_path / "file", 5) == content[:6]


@pytest.mark.parametrize(
    ("make", "words"), [(os.mkfifo, "it is not a regular file"), (Path.mkdir, "it is a folder")]
)
def test_what_is_no_file_is_not_replaced(tmp_path, make, words):
    """Nor read: see `bad_input/test_doors`."""
    make(tmp_path / "file")
    with pytest.raises(OSError, match=words):
        write_new(tmp_path / "file", "new")
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_a_link_is_replaced_and_what_it_leads_to_kept(tmp_path):
    other, link = tmp_path / "other", tmp_path / "link"
    other.write_text("kept")
    link.symlink_to(other)
    write_new(link, "new")
    assert (other.read_text(), link.read_text(), link.is_symlink()) == ("kept", "new", False)


def test_a_reader_has_the_old_file_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / "page.html"
    write_new(path, "old")
    with replacing(path) as new:
        new.write_text("half")
        assert path.read_text() == "old"
        assert new.suffix == ".html"
    assert path.read_text() == "half"


def test_a_disk_that_fills_leaves_the_old_file_and_names_it(tmp_path):
    path = tmp_path / "page.html"
    write_new(path, "old")

    def fill() -> None:
        with replacing(path):
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left") as full:
        fill()
    assert full.value.filename == str(path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["page.html"]


def test_a_disk_that_is_read_only_names_the_file(tmp_path, monkeypatch):
    def refuse(place, *_: object, **__: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system", str(place))

    monkeypatch.setattr(os, "open", refuse)
    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(OSError, match="Read-only") as read_only:
        write_new(tmp_path / "new.toml", "text")
    assert read_only.value.filename == str(tmp_path / "new.toml")


def test_a_new_file_has_the_rights_that_files_have(tmp_path):
    write_new(tmp_path / "new", "text")
    (tmp_path / "usual").touch()
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_one_that_may_not_be_replaced_is_not_even_as_a_link_to_nothing(tmp_path):
    (tmp_path / "scene.toml").symlink_to(tmp_path / "nothing")
    with pytest.raises(FileExistsError):
        write_new(tmp_path / "scene.toml", "new", replace=False)
    assert not (tmp_path / "nothing").exists()


@pytest.mark.skipif(sys.platform == "darwin", reason="its caches are elsewhere")
@pytest.mark.parametrize("stated", ["", "relative", ".", "../elsewhere"])
def test_no_cache_is_in_the_current_folder(tmp_path, monkeypatch, stated):
    """Whoever wrote that may have put code there."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", stated)
    assert user_cache() == tmp_path / ".cache" / "spincheck"


def test_a_user_without_a_home_is_told_to_name_a_cache(tmp_path, monkeypatch):
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    with pytest.raises(OSError, match="no home folder; set XDG_CACHE_HOME") as raised:
        user_cache()
    complaint = str(refusal(raised.value))
    assert complaint.startswith("~/")
    assert complaint.endswith("set XDG_CACHE_HOME to a folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert user_cache() == tmp_path / "spincheck"


def test_a_cache_that_others_may_write_to_is_not_used(tmp_path, monkeypatch):
    """Machine code, other versions and npm packages in it are executed."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = user_cache()
    folder.mkdir(mode=0o700)
    assert user_cache() == folder
    folder.chmod(0o777)
    with pytest.raises(PermissionError, match="others may write to it"):
        user_cache()
    monkeypatch.setattr(kernel.config, "CACHE_DIR", str(folder))
    ours = folder / f"kernels-{kernel.digest_of_kernels(kernel._PACKAGE)}"
    assert kernel._folder() == ours
    ours.chmod(0o777)
    assert kernel._folder() != ours
