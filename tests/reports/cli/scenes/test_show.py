"""The table of `spincheck show`: every number with its unit, point and axes."""

import numpy as np
from library_scenes import library_scene
from spincheck.reports.cli.scenes.scene import scene_as_json, scene_rows


def rows_of(name: str) -> dict[str, dict[str, str]]:
    return {row[""]: row for row in scene_rows(library_scene(name))}


def test_a_scene_is_shown_with_the_com_where_the_pivot_holds_it():
    """The com is 0.06 m along the body's z axis, which leans by 30°."""
    shown = scene_as_json(library_scene("fast-top"))
    np.testing.assert_allclose(shown["position"], [0.03, 0.0, 0.06 * 0.75**0.5], rtol=1e-15)


def test_every_number_of_a_shown_scene_has_its_unit():
    rows = rows_of("brake-on-one-wheel")
    assert {name for name, row in rows.items() if not row["unit"]} <= {
        *("scene", "source", "tags", "effects")
    }
    assert rows["mass"]["unit"] == "kg; with parts that turn in it"
    assert rows["com"]["value"] == "[0.007894737, -0.01052632, 0.02894737]"
    assert rows["rotors 2: hinge"]["value"] == "locked"
    top = rows_of("fast-top")
    assert top["gravity: acceleration"]["unit"] == "m/s², world axes"
    assert top["mass"]["unit"] == "kg"
    assert "ball joint" in top["pivot"]["unit"]
