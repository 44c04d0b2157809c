"""Scenes made of other scenes' tables, and tables written as they were read."""

import tomllib

import pytest
from case_loops import each_case
from spincheck.scenarios import ScenarioError, find, load, loads
from spincheck.scenarios.vary import own_tables, rewritten
from spincheck.scenarios.write import to_toml

TEXT = """
spincheck = 1
title = "A top"
source = "made up"
[body]
mass = 2
inertia = [1.0, 2.0, 2.5]
com = [0.0, 0.0, 0.1]
[start]
euler_zyz_deg = [10.0, 40.0, 70.0]
omega_body = [1.0, 2.0, 0.5]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 1.0
samples = 11
[[published]]
t = 1.0
omega_body = [1.0, 2.0, 3.0]
tolerance = 1e-3
source = "made up"
[[expect]]
engine = "mujoco"
method = "RK4"
timestep = 0.001
omega = 1e-6
"""
TOP = loads(TEXT, "top")
LIBRARY_FILES = find([])


def test_what_holds_of_a_scene_alone_is_left_out_and_the_scene_itself_is_not_changed():
    before, tables = TOP.text, own_tables(TOP)
    tables["body"]["mass"] = 3.0
    scene = rewritten(TOP, tables, "another mass")
    assert (scene.body.mass, scene.name, scene.title) == (3.0, "top", "A top, with another mass")
    assert (scene.document.published, scene.expect, TOP.text) == ((), (), before)


def test_a_rewritten_scene_is_checked_like_a_file():
    tables = own_tables(TOP)
    tables["body"]["inertia"][0] = 5.0
    with pytest.raises(ScenarioError, match="may exceed the sum of the other two"):
        rewritten(TOP, tables, "")


@each_case("path", LIBRARY_FILES)
def test_every_scene_of_the_library_is_written_as_it_was_read(path):
    tables = tomllib.loads(load(path).text)
    assert tomllib.loads(to_toml(tables)) == tables


def test_text_of_every_kind_is_written_as_it_was_read():
    tables = {"a": 'quotes " and \\ and\nlines, \x7f, \x01, ω', "b": {"c": [], "d": True}}
    assert tomllib.loads(to_toml(tables)) == tables
