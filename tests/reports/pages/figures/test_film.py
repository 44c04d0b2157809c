"""A film of the motion: slow enough to be followed, and true between a run's samples."""

import shutil
import subprocess

import numpy as np
import pytest
from made_up import results
from scipy.spatial.transform import Rotation
from spincheck.scenarios import Trajectory

film = pytest.importorskip("spincheck.reports.pages.figures.film", reason="needs matplotlib")
FOUND = results().scenes["made-up-top"]


@pytest.fixture
def few_frames(monkeypatch):
    monkeypatch.setattr(film, "MOST_FRAMES", 3)


@pytest.mark.usefixtures("few_frames")
def test_a_gif_has_a_frame_a_time_and_they_differ(tmp_path):
    pictures = pytest.importorskip("PIL.Image")
    path = tmp_path / "top.gif"
    exact = FOUND.solution.trajectory
    film.write_film(FOUND, [film.Filmed("alone", exact)], path)
    with pictures.open(path) as opened:
        assert opened.n_frames == 3
        frames = []
        for k in range(opened.n_frames):
            opened.seek(k)
            frames.append(np.asarray(opened.convert("RGB")))
    assert not np.array_equal(frames[0], frames[1])
    assert frames[0].shape[1] == pytest.approx(2 * film.SIZE * film.PIXELS_AN_INCH)


@pytest.mark.usefixtures("few_frames")
@pytest.mark.processes
def test_an_mp4_has_a_frame_a_time_and_they_differ(tmp_path):
    ffmpeg = shutil.which("ffmpeg")
    if ffmpeg is None:
        pytest.skip("ffmpeg is not installed")
    path = tmp_path / "top.mp4"
    film.write_film(FOUND, [], path)
    read = [ffmpeg, "-v", "error", "-i", path, "-f", "framemd5", "-"]
    listed = subprocess.run(read, check=True, capture_output=True, text=True).stdout
    frames = [line.split(",")[-1] for line in listed.splitlines() if not line.startswith("#")]
    assert len(set(frames)) == len(frames) == 3


def test_a_frame_turns_the_body_by_no_more_than_the_eye_follows():
    times = film.frame_times(FOUND)
    fastest = np.linalg.norm(FOUND.solution.trajectory.omega_body, axis=1).max()
    assert len(times) <= film.MOST_FRAMES
    assert np.diff(times).max() * fastest <= film.TURN_A_FRAME * 1.01


def test_between_two_samples_the_body_is_turned_a_part_of_the_way():
    turned = Rotation.from_rotvec([[0, 0, 0], [0, 0, 1.0]])
    motion = Trajectory(
        t=np.array([0.0, 2.0]),
        q_world_body_wxyz=turned.as_quat(scalar_first=True),
        omega_body=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0]]),
        com_world=np.zeros((2, 3)),
        velocity_world=np.zeros((2, 3)),
    )
    attitude, omega = film.state_at(motion, 0.5)
    assert attitude.as_rotvec() == pytest.approx([0, 0, 0.25], abs=1e-15)
    assert omega == pytest.approx([0, 0, 1.0])
    for beyond in (2.0, 3.0):
        assert film.state_at(motion, beyond)[0].as_rotvec() == pytest.approx([0, 0, 1.0])


def test_another_ending_is_no_film(tmp_path):
    with pytest.raises(ValueError, match=r"a film is \.gif or \.mp4, got '\.svg'"):
        film.write_film(FOUND, [], tmp_path / "top.svg")


def test_without_ffmpeg_there_is_no_mp4(tmp_path, monkeypatch):
    monkeypatch.setattr(film.FFMpegWriter, "isAvailable", lambda: False)
    with pytest.raises(film.NoWriterError, match=r"needs ffmpeg, .*install it, or write a '\.gif'"):
        film.write_film(FOUND, [], tmp_path / "top.mp4")
