"""Recordings of bodies with rotors: their spins are optional columns."""

from pathlib import Path

import numpy as np
import pytest
import spincheck
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reports.cli.scenes.exact_motion import truth_files
from spincheck.reports.harness.recorded.files.read import read_recording
from spincheck.reports.harness.recorded.files.recording import Recording, RecordingError
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.scenarios import from_tables

pytestmark = pytest.mark.slow

SCENE = library_scene("wheel-in-a-box")
MOTION = solve(SCENE, SCENE.times[:51]).trajectory
RPM = np.pi / 30
EPS = float(np.finfo(float).eps)


def judged(
    factor: float = 1.0, spins: np.ndarray | None = None, order: int = 1, **settings: str
) -> JudgedMotion:
    omega = factor * MOTION.omega_body
    arrays = {"t": MOTION.t, "q": MOTION.q_world_body_wxyz, "omega": omega}
    arrays |= {} if spins is None else {"spins": spins}
    return judged_motion(SCENE, Recording(Path("wheel.csv"), arrays, settings), order)


def test_a_wrong_omega_is_seen_in_L_too_and_nothing_is_said_of_spins_that_are_not_there() -> None:
    exact, wrong = judged(), judged(1.001)
    assert exact.errors["omega"] == 0.0
    assert exact.errors["attitude"] <= 4 * EPS
    assert exact.errors["spins"] is None
    assert "rotors_momentum" not in exact.drifts
    assert wrong.errors["omega"] > 1e-4
    assert wrong.errors["angular_momentum"] > 1e-4


def test_spins_that_are_there_are_a_signal_and_what_rotors_keep_is_checked() -> None:
    slowing = 1 - 1e-3 * MOTION.t[:, None] / MOTION.t[-1]
    exact, slowed = judged(spins=MOTION.spins), judged(spins=MOTION.spins * slowing)
    assert exact.errors["spins"] == 0.0
    assert exact.drifts["rotors_momentum"] <= 8 * EPS
    assert not exact.is_another
    assert slowed.errors["spins"] == pytest.approx(1e-3, rel=0.1)
    assert slowed.drifts["rotors_momentum"] > 1e-4
    assert slowed.beyond({"spins": 1e-4})


@pytest.mark.parametrize("is_told", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_spins_are_judged_by_what_a_method_makes_of_them(order: int, is_told: bool) -> None:
    """A step moves what is along an axis by a power of its angle, here of the wheel's."""
    timestep = 1e-5
    turns = timestep * MOTION.spins.max()
    by_a_method = turns**order * np.linalg.norm(MOTION.omega_body, axis=1).max() / 2
    rate = by_a_method * (10 if is_told else 1)
    spins = MOTION.spins * (1 - rate * MOTION.t[:, None])
    found = judged(spins=spins, order=order, timestep=repr(timestep))
    assert found.is_beyond == found.is_another == is_told
    assert found.verdict.startswith("beyond" if is_told else "within")
    told = "the spin of rotor 1 changes at a rate of"
    assert [words.startswith(told) for words in found.explained_by] == [True] * is_told


OF_BODY = MOTION.omega_body @ SCENE.rotors.axes_body.T
MISTAKEN = {
    "the spins have the opposite sign": -MOTION.spins,
    "the spins are those in space; they are to be relative to the body": MOTION.spins + OF_BODY,
    "the spins are in degrees a second; spin1 [deg/s] says so": np.degrees(MOTION.spins),
    "the spins are in turns a second": MOTION.spins / (2 * np.pi),
}


@pytest.mark.parametrize("words", MISTAKEN)
def test_a_mistake_in_recording_spins_is_named(words: str) -> None:
    assert judged(spins=MISTAKEN[words]).explained_by == (words,)


def test_spins_that_are_exchanged_are_named() -> None:
    scene = library_scene("wheels-in-syrup")
    motion = solve(scene, scene.times[:51]).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    spins = {"right": motion.spins, "exchanged": motion.spins[:, ::-1]}
    found = {
        name: judged_motion(scene, Recording(Path("wheels.csv"), arrays | {"spins": one}, {}))
        for name, one in spins.items()
    }
    assert found["exchanged"].explained_by == ("spin1 and spin2 are exchanged",)
    assert not found["right"].is_another


def test_of_free_rotors_that_start_elsewhere_no_other_momentum_is_told() -> None:
    """They keep another momentum as the body that carries them turns otherwise at the start."""
    tables = SCENE.document.model_dump(mode="json", exclude_none=True)
    omega = [0.5 * one for one in SCENE.start.omega_body]
    start = tables["start"] | {"omega_body": omega}
    other = from_tables(tables | {"start": start}, "otherwise")
    motion = solve(other, SCENE.times[:51]).trajectory
    arrays = {"t": motion.t, "q": motion.q_world_body_wxyz, "omega": motion.omega_body}
    (words,) = judged_motion(SCENE, Recording(Path("wheel.csv"), arrays, {})).explained_by
    assert words.startswith("it started elsewhere: at t = 0 s the attitude is off by 0° and ω by ")


def test_spins_that_are_those_of_nothing_are_told() -> None:
    """No two factors of units are named, though two make nearly any number of them."""
    found = judged(spins=np.full_like(MOTION.spins, MOTION.spins[0, 0] / 3))
    (words,) = found.explained_by
    assert words.startswith("the spins are not those of the motion: they are off by up to ")


def test_a_recording_must_have_a_spin_for_each_rotor() -> None:
    with pytest.raises(RecordingError, match="each of the scene's 1 rotors, got 2"):
        judged(spins=np.hstack([MOTION.spins] * 2))
    arrays = {"t": MOTION.t, "q_wxyz": MOTION.q_world_body_wxyz}
    with pytest.raises(ValueError, match=r"'spins' must have the shape \(n, rotors\)"):
        spincheck.judge("wheel-in-a-box", **arrays, spins=MOTION.spins[:, 0])


FORMATS = {
    "motion.csv": "t,qw,qx,qy,qz,spin2 [rpm],spin1\n0,1,0,0,0,60,5\n0.1,1,0,0,0,60,5\n",
    "motion.jsonl": "\n".join(
        f'{{"t": {t}, "q": [1, 0, 0, 0], "spins": [5, {60 * RPM!r}]}}' for t in (0, 0.1)
    ),
}


@pytest.mark.parametrize("name", FORMATS)
def test_spins_are_read_from_text(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(FORMATS[name], encoding="utf-8")
    assert read_recording(path).arrays["spins"] == pytest.approx(
        np.array([[5, 60 * RPM]] * 2), rel=2 * EPS
    )


def test_spins_are_read_from_npz_and_one_that_is_left_out_is_missed(tmp_path: Path) -> None:
    path = tmp_path / "motion.npz"
    np.savez(path, t=[0, 0.1], q=[[1, 0, 0, 0]] * 2, spins=[[5, 6]] * 2)
    assert read_recording(path).arrays["spins"].tolist() == [[5, 6]] * 2
    path = tmp_path / "motion.csv"
    path.write_text(FORMATS["motion.csv"].replace("spin1", "spin3"), encoding="utf-8")
    with pytest.raises(RecordingError, match="'spin1', 'spin2', … must be columns of the file"):
        read_recording(path)


def test_the_truth_of_a_scene_with_rotors_has_their_spins_and_is_judged_as_it_is(tmp_path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(truth_files(SCENE)["truth.csv"], encoding="utf-8")
    found = judged_motion(SCENE, read_recording(path))
    assert found.errors["spins"] == 0.0
    assert not found.is_another


def test_an_engines_spins_are_judged() -> None:
    engine, timestep = engines()["mujoco"], 1e-3
    every = np.arange(0, 501, 10)
    run = engine.run(SCENE, engine.method("RK4"), timestep, every)
    made = run.trajectory
    arrays = {"t": made.t, "q_wxyz": made.q_world_body_wxyz, "omega_body": made.omega_body}
    given = arrays | {"spins": made.spins, "timestep": timestep, "order": 4}
    found = spincheck.judge("wheel-in-a-box", **given)
    assert 0 < found.errors["spins"] < 1e-6
    assert not found.is_another


def test_the_rounding_of_fast_spins_is_not_told() -> None:
    rounded = MOTION.spins.astype(np.float32).astype(float)
    found = judged(spins=rounded, order=4, timestep="1e-6", precision="single")
    assert not found.is_another
