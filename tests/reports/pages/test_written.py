"""A report's folder holds the files of the last report, and other files that were there."""

import os

import pytest
from spincheck.reports.pages.templating import LIST, ReportFolder


def report(folder, *names: str) -> set[str]:
    """Write these files as a report; returns what is there then, but for the list of files."""
    written = ReportFolder(folder)
    for name in names:
        written.write(name, name)
    written.finish()
    paths = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return paths - {LIST}


def test_pages_of_an_earlier_report_go_and_files_of_others_stay(tmp_path):
    assert report(tmp_path, "index.html", "scenes/a.html") == {"index.html", "scenes/a.html"}
    assert report(tmp_path, "index.html", "scenes/b.html") == {"index.html", "scenes/b.html"}
    (tmp_path / "scenes" / "mine.html").write_text("mine")
    assert report(tmp_path, "index.html") == {"index.html", "scenes/mine.html"}


@pytest.mark.parametrize("listed", ["../outside.txt", "{outside}", "scenes/../../outside.txt"])
def test_a_forged_list_removes_nothing_outside_the_folder(tmp_path, listed):
    outside, folder = tmp_path / "outside.txt", tmp_path / "report"
    outside.write_text("kept")
    report(folder, "index.html")
    (folder / LIST).write_text(listed.format(outside=outside))
    report(folder, "index.html")
    assert outside.read_text() == "kept"


@pytest.mark.parametrize("listed", ["mine.txt", "scenes/mine.txt", "mine/index.html", ".git", "a"])
def test_a_list_is_trusted_only_for_names_that_a_report_writes(tmp_path, listed):
    report(tmp_path, "index.html", "scenes/a.html")
    (tmp_path / listed).parent.mkdir(exist_ok=True)
    (tmp_path / listed).write_text("kept")
    (tmp_path / LIST).write_text(listed)
    report(tmp_path, "index.html")
    assert (tmp_path / listed).read_text() == "kept"


def test_links_are_not_written_through(tmp_path):
    outside, folder = tmp_path / "outside", tmp_path / "report"
    outside.mkdir()
    (outside / "a.html").write_text("kept")
    report(folder, "index.html", "scenes/a.html")
    (folder / "scenes" / "a.html").unlink()
    (folder / "scenes").rmdir()
    (folder / "scenes").symlink_to(outside)
    with pytest.raises(OSError, match="it is a link"):
        report(folder, "index.html", "scenes/a.html")
    # A page that is a link becomes a page.
    (folder / "index.html").unlink()
    (folder / "index.html").symlink_to(outside / "a.html")
    report(folder, "index.html")
    assert (outside / "a.html").read_text() == "kept"
    assert (folder / "index.html").read_text() == "index.html"


@pytest.mark.parametrize("name", ["index.html", LIST])
def test_a_pipe_in_the_folder_is_one_message(tmp_path, name):
    report(tmp_path, "index.html")
    (tmp_path / name).unlink()
    os.mkfifo(tmp_path / name)
    with pytest.raises(OSError, match=r"it is not a regular file|and no report"):
        report(tmp_path, "index.html")


def test_a_folder_of_somebody_elses_is_not_written_into(tmp_path):
    (tmp_path / "index.html").write_text("mine")
    with pytest.raises(OSError, match=r"it holds 'index.html' and no report; give a new"):
        report(tmp_path, "index.html")
    assert (tmp_path / "index.html").read_text() == "mine"


def test_hidden_files_and_a_list_that_is_no_text_are_no_reason_to_refuse_a_folder(tmp_path):
    (tmp_path / ".nojekyll").touch()
    assert report(tmp_path, "index.html") == {".nojekyll", "index.html"}
    (tmp_path / LIST).write_bytes(b"\xff\xfe")
    assert report(tmp_path, "index.html") == {".nojekyll", "index.html"}
