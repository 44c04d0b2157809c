"""Scenes are found by path, by folder and by name."""

import os
from pathlib import Path

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
    """Two scenes, one of them deeper, and a TOML file of another kind."""
    (tmp_path / "deep").mkdir()
    (tmp_path / "one.toml").write_text(TEXT)
    (tmp_path / "deep" / "two.toml").write_text(TEXT)
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def stems(paths):
    return [path.stem for path in paths]


def test_a_folder_is_searched_to_the_bottom_and_other_files_are_passed_over(folder):
    assert stems(scenario_files(folder)) == ["two", "one"]


def test_a_file_a_folder_and_a_name_may_be_mixed(folder):
    assert stems(find(["one.toml", "deep", "tennis-racket"])) == ["one", "two", "tennis-racket"]


def test_what_is_named_twice_is_found_once(folder):
    assert stems(find(["one.toml", os.curdir])) == ["one", "two"]


def test_a_folder_of_the_library_is_found_by_its_name(folder):
    assert find(["free"]) == scenario_files(LIBRARY / "free")


def test_with_no_names_it_is_the_whole_library():
    assert find([]) == scenario_files(LIBRARY)
    assert len(find([])) > 1


def test_a_name_that_is_nothing_is_reported_where_to_look(folder):
    with pytest.raises(
        ScenarioError, match=r"nothing: neither a file, a folder, nor .* 'spincheck l"
    ):
        find(["nothing"])


def test_a_folder_without_scenes_is_reported(folder):
    (folder / "empty").mkdir()
    with pytest.raises(ScenarioError, match="empty: no scenario in this folder"):
        find(["empty"])


def test_two_files_of_one_name_are_distinguished(folder):
    (folder / "deep" / "one.toml").write_text(TEXT)
    with pytest.raises(ScenarioError, match=r"another scene has the same name, .*one.toml; rename"):
        scenario_files(folder)


def test_a_file_of_a_library_scenes_name_is_reported_only_beside_it(folder):
    (folder / "sphere.toml").write_text(TEXT)
    assert stems(find(["sphere.toml"])) == ["sphere"]
    with pytest.raises(ScenarioError, match="another scene has the same name"):
        find(["sphere.toml", "free"])


def test_a_file_of_the_current_folder_may_be_named_as_its_scene(tmp_path, monkeypatch):
    (tmp_path / "my-top.toml").write_text("spincheck = 1")
    monkeypatch.chdir(tmp_path)
    assert find(["my-top"]) == [Path("my-top.toml")]


@pytest.mark.parametrize("name", ["robot.urdf", "scene.XML", "robot.xacro"])
def test_a_model_is_told_from_a_scene(name):
    with pytest.raises(ScenarioError, match="a model, not a scene; 'spincheck inspect'"):
        find([name])


def test_a_disk_is_refused_before_it_is_searched(folder, monkeypatch):
    monkeypatch.setattr(catalogue, "MOST_ENTRIES", 2)
    with pytest.raises(ScenarioError, match="holds more than 2 files and folders; name the folder"):
        find([os.curdir])


def test_a_hidden_folder_is_not_entered(folder):
    (folder / ".venv").mkdir()
    (folder / ".venv" / "three.toml").write_text(TEXT)
    assert stems(find([os.curdir])) == ["two", "one"]


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
