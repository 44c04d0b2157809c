"""A report's folder holds the files of the last report, and other files that were there."""

import pytest
from spincheck.reports.pages.written import LIST, ReportFolder


def report(folder, *names: str) -> set[str]:
    """Write these files as a report; returns what is there then, but for the list of files."""
    written = ReportFolder(folder)
    for name in names:
        written.write(name, name)
    written.finish()
    paths = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return paths - {LIST}


def test_pages_of_an_earlier_report_go(tmp_path):
    assert report(tmp_path, "index.html", "scenes/a.html") == {"index.html", "scenes/a.html"}
    assert report(tmp_path, "index.html", "scenes/b.html") == {"index.html", "scenes/b.html"}


def test_files_of_others_stay(tmp_path):
    report(tmp_path, "index.html", "scenes/a.html")
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


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    outside, folder = tmp_path / "outside", tmp_path / "report"
    outside.mkdir()
    (outside / "a.html").write_text("kept")
    report(folder, "index.html")
    (folder / "scenes").symlink_to(outside)
    (folder / LIST).write_text("scenes/a.html")
    report(folder, "index.html")
    assert (outside / "a.html").read_text() == "kept"


def test_a_list_that_is_no_text_is_ignored(tmp_path):
    report(tmp_path, "index.html")
    (tmp_path / LIST).write_bytes(b"\xff\xfe")
    assert report(tmp_path, "index.html") == {"index.html"}
