"""Files that cannot be read, and any text at all: one clear complaint, never another exception."""

import numpy as np
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


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ScenarioError, match=r"nothing.toml: cannot be read: No such file"):
        load(tmp_path / "nothing.toml")


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(ScenarioError, match=r"cannot be read: it is a folder"):
        load(tmp_path)


def test_a_file_that_is_no_text_is_named(tmp_path):
    path = tmp_path / "picture.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match=r"picture.toml: not a text file in UTF-8"):
        load(path)


def test_a_huge_file_is_not_read(tmp_path):
    path = tmp_path / "huge.toml"
    path.write_text(TEXT + "#" * MAX_BYTES)
    with pytest.raises(ScenarioError, match=f"too large for a scenario, the limit is {MAX_BYTES}"):
        load(path)


def test_broken_toml_is_reported_with_its_line():
    with pytest.raises(ScenarioError, match=r"made:2: not valid TOML: .* \(at line 2"):
        loads("spincheck = 1\ntitle = \n", name="made")


def test_toml_of_another_kind_is_no_scene():
    with pytest.raises(
        ScenarioError, match=r"not a scenario: the first key must be 'spincheck = 1"
    ):
        loads("[tool]\nname = 1\n", name="made")


@each_case("name", ["", "a b", "-a", ".hidden", "a/b", "a'b", "é;"])
def test_a_name_that_could_be_mistaken_is_refused(name):
    with pytest.raises(ScenarioError, match="a scenario's name is its file's stem; use letters"):
        loads(TEXT, name=name)


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


VALUES = [
    *("true", "-1", "0", "1e400", "1e308", "5e-324", "inf", "nan", '"x"', "[]", "[[]]", "{}"),
    *("[1, 2]", "[1, 2, 3, 4]", "[true, 1, 1]", "[[1, 2, 3]]", "1979-05-27", "1" + 400 * "0"),
]
LINES = [number for number, line in enumerate(TEXT.splitlines()) if " = " in line]


def complaint_about(text):
    """What is said of a text; None of a scene. Any other exception is passed on."""
    try:
        loads(text, name="made")
    except ScenarioError as complaint:
        return str(complaint)
    return None


@each_case("value", VALUES)
@each_case("number", LINES)
def test_any_value_anywhere_is_taken_or_complained_of_in_its_line(number, value):
    lines = TEXT.splitlines()
    lines[number] = f"{lines[number].split(' = ')[0]} = {value}"
    table = max(n for n in range(number + 1) if n == 0 or lines[n].startswith("["))
    places = tuple(f"made:{n + 1}: " for n in range(table, number + 1))
    complaint = complaint_about("\n".join(lines))
    assert complaint is None or complaint.startswith(places)


def test_random_damage_is_never_another_exception():
    """A thousand files with a stretch cut out, doubled, or moved."""
    random = np.random.default_rng(7)
    for _ in range(1000):
        a, b, c = sorted(random.integers(0, len(TEXT), 3))
        ways = (TEXT[:a] + TEXT[b:], TEXT[:b] + TEXT[a:], TEXT[:a] + TEXT[b:c] + TEXT[a:b])
        complaint = complaint_about(ways[random.integers(3)])
        assert complaint is None or complaint.startswith("made:")
