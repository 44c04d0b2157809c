"""What `view` and `plot` write, and what they refuse."""

from pathlib import Path

import pytest
from made_up import at_stock, results
from PIL import Image
from spincheck.reports.cli.pictures import pictures
from spincheck.reports.cli.pictures.pictures import WHAT, plot, view
from spincheck.reports.cli.run import running
from spincheck.reports.cli.terminal import BAD_INPUT, Complaint
from spincheck.reports.results.results import Results

pytestmark = pytest.mark.slow

NO_FILE = Path("there-is-none.sqlite")


@pytest.fixture
def stored_runs(monkeypatch: pytest.MonkeyPatch) -> Results:
    """A result file with made-up runs of a scene, without a study."""
    stored = at_stock(results())
    monkeypatch.setattr(running, "read", lambda _: stored)
    scenario = stored.scenes["made-up-top"].scenario
    monkeypatch.setattr(pictures, "one_scene", lambda _: scenario)
    return stored


def draw(what: str, out: Path, *, runs: Path = NO_FILE, scene: str = "nutation-loops") -> Path:
    plot(scene, what, out, runs, [], [])
    return out


@pytest.mark.parametrize("what", [what for what in WHAT if what not in pictures.OF_RUNS])
def test_the_exact_motion_is_drawn_without_any_run(what: str, tmp_path: Path) -> None:
    text = draw(what, tmp_path / "a.svg").read_text(encoding="utf-8")
    assert text.startswith("<?xml")
    assert "exact" in text or what == "potential"


@pytest.mark.parametrize("what", pictures.OF_RUNS)
def test_every_method_is_in_a_figure_of_runs(
    stored_runs: Results, what: str, tmp_path: Path
) -> None:
    text = draw(what, tmp_path / "a.svg", runs=tmp_path).read_text(encoding="utf-8")
    assert all(label in text for label in ("mujoco Euler", "mujoco RK4", "pybullet maximal"))


@pytest.mark.parametrize("what", ["theta", "polhode"])
def test_a_method_that_is_named_is_drawn_beside_the_exact_motion(
    stored_runs: Results, what: str, tmp_path: Path
) -> None:
    alone, beside = tmp_path / "alone.svg", tmp_path / "beside.svg"
    plot("made-up-top", what, alone, tmp_path, [], [])
    plot("made-up-top", what, beside, tmp_path, ["MuJoCo"], ["euler"])
    assert "mujoco Euler" not in alone.read_text(encoding="utf-8")
    assert "mujoco Euler" in beside.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("engines", "methods"), [(["drake"], []), ([], ["RK5"]), (["pybullet"], ["Euler"])]
)
def test_a_run_that_is_named_and_not_there_is_reported(
    stored_runs: Results, engines: list[str], methods: list[str], tmp_path: Path
) -> None:
    named = " ".join([*engines, *methods])
    with pytest.raises(Complaint, match=f"has no motion of made-up-top by {named} .* mujoco Euler"):
        plot("made-up-top", "theta", tmp_path / "a.svg", tmp_path, engines, methods)


def test_the_same_figure_is_the_same_bytes_and_a_png_is_a_picture(tmp_path: Path) -> None:
    first, again = (draw("theta", tmp_path / f"{k}.svg").read_bytes() for k in range(2))
    assert first == again
    with Image.open(draw("herpolhode", tmp_path / "a.png")) as picture:
        assert len(picture.convert("L").getcolors() or []) > 2


@pytest.mark.parametrize(
    ("what", "scene", "name", "message"),
    [
        ("thetha", "nutation-loops", "a.svg", "must be one of theta, omega"),
        ("potential", "book-middle-axis", "a.svg", "has no figure 'potential', but theta,"),
        ("convergence", "nutation-loops", "a.svg", "'spincheck run nutation-loops' makes them"),
        ("theta", "nutation-loops", "a.doc", r"must end with \.svg, \.png, \.pdf, got '.*a\.doc'"),
        ("theta", "nutation-loops", "a", "'--out' must end with"),
        ("theta", "nutation-loops", "no/a.svg", r"no/a\.svg: cannot be written: No such file or "),
    ],
)
def test_what_cannot_be_drawn_is_reported(
    what: str, scene: str, name: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(Complaint, match=message) as complaint:
        draw(what, tmp_path / name, scene=scene)
    assert complaint.value.exit_code == BAD_INPUT


def test_a_file_in_the_place_of_the_folder_is_reported_before_anything_is_run(
    tmp_path: Path,
) -> None:
    (tmp_path / "a").write_text("a file", encoding="utf-8")
    with pytest.raises(Complaint, match="'--out' must be a folder, got the file"):
        view("nutation-loops", 1, tmp_path / "a")


def test_view_gives_the_page_of_its_scene(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    stored = at_stock(results())
    only = {"made-up-top": stored.scenes["made-up-top"]}
    rows = [row for row in stored.rows if row.key.scenario in only]
    quick = Results(stored.environment, only, rows, [], methods=stored.methods)
    monkeypatch.setattr(running, "run", lambda *_, **choice: quick if choice["quick"] else None)
    monkeypatch.setattr(pictures, "one_scene", lambda _: only["made-up-top"].scenario)
    page = view("made-up-top", 1, tmp_path)
    assert page == tmp_path / "scenes" / "made-up-top.html"
    assert "A top" in page.read_text(encoding="utf-8")
