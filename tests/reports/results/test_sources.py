"""What sources say is kept between processes, and a file that says it otherwise is not believed."""

import json
from pathlib import Path

import pytest
from spincheck.engines.user_cache import user_cache
from spincheck.reports.results import sources

SOURCE = (
    '"""Words."""\nfrom .records import Row as R\n\ndef f():\n    from ..a import b\n    return 1\n'
)


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    """Begins as a new process does, with an empty cache; its end is called by hand."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    ends = []
    monkeypatch.setattr(sources.atexit, "register", lambda f, *given: ends.append((f, given)))

    def begin() -> None:
        for end, given in ends:
            end(*given)
        ends.clear()
        sources.source.cache_clear()
        sources._known.cache_clear()

    begin()
    yield begin
    sources.source.cache_clear()
    sources._known.cache_clear()


@pytest.fixture
def file(tmp_path) -> Path:
    path = tmp_path / "one.py"
    path.write_text(SOURCE, encoding="utf-8")
    return path


def test_what_is_kept_is_what_was_found_and_only_a_changed_file_is_parsed_again(
    fresh, file, monkeypatch
):
    found = sources.source(file)
    outer, inner = found.imports
    assert outer == sources.Import(1, "records", (("Row", "R"),), True)
    assert inner == sources.Import(2, "a", (("b", "b"),), False)
    fresh()
    with monkeypatch.context() as patch:
        patch.setattr(sources.ast, "parse", lambda text: pytest.fail("parsed again"))
        assert sources.source(file) == found
    fresh()
    file.write_text(SOURCE.replace("return 1", "return 2"), encoding="utf-8")
    assert sources.source(file).digest != found.digest


@pytest.mark.parametrize("content", ["", "{", '{"a": 1}', '{"a": ["d", [[1]]]}', "[1]", "\0"])
def test_a_damaged_cache_is_passed_over(fresh, file, content):
    found = sources.source(file)
    fresh()
    (kept,) = user_cache().glob("sources-*.json")
    kept.write_text(content, encoding="utf-8")
    assert sources.source(file) == found
    fresh()
    assert json.loads(kept.read_text(encoding="utf-8"))


def test_a_cache_that_others_may_write_is_neither_read_nor_written(fresh, file):
    sources.source(file)
    folder = user_cache()
    folder.mkdir()
    folder.chmod(0o777)
    fresh()
    sources.source(file)
    assert list(folder.iterdir()) == []
