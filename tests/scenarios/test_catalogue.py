"""Scenes are found by path, by folder and by name."""

import os

import pytest
from scene_texts import TEXT
from spincheck.scenarios import (
    LIBRARY,
    ScenarioError,
    catalogue,
    find,
    hiding_the_library,
    scenario_files,
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Three scenes, one deeper, one hidden; a folder without, and a TOML file of another kind."""
    for name in ["one.toml", "deep/two.toml", ".venv/three.toml"]:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(TEXT)
    (tmp_path / "empty").mkdir()
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def stems(paths):
    return [path.stem for path in paths]


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ([os.curdir], ["two", "one"]),
        (["one.toml", "deep", "tennis-racket"], ["one", "two", "tennis-racket"]),
        (["one.toml", os.curdir], ["one", "two"]),
        (["one"], ["one"]),
    ],
    ids=["to the bottom", "mixed", "twice", "as its scene"],
)
def test_scenes_are_found_other_files_and_hidden_folders_passed_over(folder, names, found):
    assert stems(find(names)) == found


def test_a_folder_of_the_library_is_found_by_its_name(folder):
    assert find(["free"]) == scenario_files(LIBRARY / "free")


def test_with_no_names_it_is_the_whole_library():
    assert find([]) == scenario_files(LIBRARY)
    assert len(find([])) > 1


MODEL = "a model, not a scene; 'spincheck inspect'"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nothing", r"nothing: neither a file, a folder, nor .* 'spincheck l"),
        ("empty", "empty: no scenario in this folder"),
        ("robot.urdf", MODEL),
        ("scene.XML", MODEL),
        ("robot.xacro", MODEL),
    ],
)
def test_what_is_no_scene_is_reported(folder, name, words):
    with pytest.raises(ScenarioError, match=words):
        find([name])


def test_two_files_of_one_name_are_distinguished(folder):
    (folder / "deep" / "one.toml").write_text(TEXT)
    with pytest.raises(ScenarioError, match=r"another scene has the same name, .*one.toml; rename"):
        scenario_files(folder)


def test_a_file_of_a_library_scenes_name_is_reported_only_beside_it(folder):
    (folder / "sphere.toml").write_text(TEXT)
    assert stems(find(["sphere.toml"])) == ["sphere"]
    with pytest.raises(ScenarioError, match="another scene has the same name"):
        find(["sphere.toml", "free"])


def test_a_disk_is_refused_before_it_is_searched(folder, monkeypatch):
    monkeypatch.setattr(catalogue, "MOST_ENTRIES", 2)
    with pytest.raises(ScenarioError, match="holds more than 2 files and folders; name the folder"):
        find([os.curdir])


def test_what_goes_before_the_library_is_known(folder):
    (folder / "sphere.toml").write_text(TEXT)
    (folder / "free").mkdir()
    names = ["sphere", "free", "one", "tennis-racket"]
    sentences = hiding_the_library(names)
    assert [sentence.partition(": taken from the current")[0] for sentence in sentences] == [
        "sphere.toml",
        "free",
    ]


def test_the_library_does_not_hide_itself(monkeypatch):
    monkeypatch.chdir(LIBRARY)
    assert hiding_the_library(["free", "sphere"]) == []
