"""Files that cannot be read: one clear complaint. Any text at all: `test_fuzzed_loader.py`."""

import pytest
from case_loops import each_case
from scene_texts import TEXT
from spincheck.scenarios import ScenarioError, is_scenario, load, loads
from spincheck.scenarios.read_text import MAX_BYTES


def test_a_file_is_a_scene_named_by_its_stem(tmp_path):
    path = tmp_path / "my-top.2.toml"
    path.write_text(TEXT, encoding="utf-8")
    scenario = load(path)
    assert (scenario.name, scenario.path) == ("my-top.2", path)


def test_a_huge_file_is_not_read(tmp_path):
    path = tmp_path / "huge.toml"
    path.write_text(TEXT + "#" * MAX_BYTES)
    with pytest.raises(ScenarioError, match=f"too large for a scenario, the limit is {MAX_BYTES}"):
        load(path)


def test_broken_toml_is_reported_with_its_line():
    with pytest.raises(ScenarioError, match=r"made:2: not valid TOML: .* \(at line 2"):
        loads("spincheck = 1\ntitle = \n", name="made")


LATER = TEXT.replace("spincheck = 1\n", "").replace("\n[", "\nspincheck = 1\n[", 1)


@each_case("text", ["[tool]\nname = 1\n", LATER])
def test_a_file_whose_first_key_is_another_is_refused_as_no_folder_and_no_test_would_find_it(text):
    with pytest.raises(ScenarioError, match="not a scenario: the first key must be 'spincheck = 1"):
        loads(text, "made")


@each_case(
    ("text", "answer"),
    [
        ("spincheck = 1\n", True),
        ("# a comment\n\n  spincheck=1\n", True),
        ("spincheck = 7\nrubbish", True),
        ("title = 't'\nspincheck = 1\n", False),
        ("[spincheck]\n", False),
        ("spincheckers = 1\n", False),
        ("", False),
    ],
)
def test_a_scene_is_known_by_its_first_key(tmp_path, text, answer):
    path = tmp_path / "file.toml"
    path.write_text(text)
    assert is_scenario(path) is answer


def test_what_cannot_be_read_is_no_scene(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    assert not is_scenario(tmp_path / "binary.toml")
    assert not is_scenario(tmp_path / "missing.toml")
