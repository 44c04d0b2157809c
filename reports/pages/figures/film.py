"""The motion as a film (GIF, MP4): the body drawn as its solid, ω, L, and the path of its axis.

matplotlib is an optional dependency; without it the import of this module fails.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.colors import LightSource
from matplotlib.figure import Figure as Canvas
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial.transform import Rotation

from ....reference import ExactMotion
from ....scenarios import FloatArray, Scenario, Trajectory
from ...results.store import SceneResult
from .axis_path import frame_about
from .drawn_body import DrawnBody, drawn_body, kept_body

#: Frames a second; largest number of frames of a film.
FRAMES_A_SECOND, MOST_FRAMES = 20, 120
#: rad, largest turn between frames: beyond it a body seems to stand still or to turn backwards.
TURN_A_FRAME = 0.5
#: Inches of one body's picture and of the title above; pixels an inch.
SIZE, TITLE, PIXELS_AN_INCH = 3.4, 0.6, 100
#: Points of the exact path between two frames.
PATH_POINTS = 8
#: Lengths of ω and L in the picture, different so that both are visible if parallel.
OMEGA_LENGTH, MOMENTUM_LENGTH = 0.95, 0.65
LIGHT = LightSource(azdeg=200, altdeg=65)
#: Patches of an ellipsoid from pole to pole, and around.
BELTS, SECTORS = 8, 16
#: Writers by the ending of the file.
WRITERS: dict[str, Any] = {".gif": PillowWriter, ".mp4": FFMpegWriter}
BODY, STRIPE, OMEGA, MOMENTUM, PATH = "#8492a6", "#5f6d80", "#b3261e", "#0b6e4f", "#1b1f24"


class NoWriterError(Exception):
    """The program that writes such a film is not installed."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """A motion to be filmed, and its title."""

    title: str
    motion: Trajectory


def write_film(solved: SceneResult, runs: Sequence[Filmed], path: Path) -> None:
    """Film the exact motion, and runs beside it, from the start on, slowly enough to be followed.

    Raises
    ------
    ValueError
        If the file's ending is that of no film.
    NoWriterError
        If ffmpeg is needed and not there.
    OSError
        If the file cannot be written.
    """
    if path.suffix not in WRITERS:
        raise ValueError(f"a film is {' or '.join(WRITERS)}, got '{path.suffix}'")
    writer = WRITERS[path.suffix]
    if not writer.isAvailable():
        raise NoWriterError(
            f"'{path.suffix}' needs ffmpeg, which is not on the PATH; install it, or write a '.gif'"
        )
    times = frame_times(solved)
    dense = np.linspace(0.0, times[-1], PATH_POINTS * (len(times) - 1) + 1)
    exact = Filmed("exact", ExactMotion(solved.scenario).outline(dense))
    shown = [exact, *runs]
    body = drawn_body(solved)
    with mpl.rc_context({"font.size": 9}):
        canvas = Canvas(figsize=(SIZE * len(shown), SIZE + TITLE))
        high = SIZE / (SIZE + TITLE)
        places = [(k / len(shown), 0.0, 1 / len(shown), high) for k in range(len(shown))]
        panes = [
            _Pane(canvas.add_axes(place, projection="3d"), one, body, solved.scenario)
            for place, one in zip(places, shown, strict=True)
        ]
        film = writer(fps=FRAMES_A_SECOND)
        with film.saving(canvas, str(path), PIXELS_AN_INCH):
            for time in times:
                for pane in panes:
                    pane.draw(float(time))
                canvas.suptitle(f"{solved.scenario.title}\n{time:.3f} s", fontsize=9)
                film.grab_frame()


def frame_times(solved: SceneResult) -> FloatArray:
    """Times of the frames, s, from the start on."""
    motion = solved.solution.trajectory
    fastest = float(np.linalg.norm(motion.omega_body, axis=1).max())
    end = float(motion.t[-1])
    shown = min(end, MOST_FRAMES * TURN_A_FRAME / fastest) if fastest else end
    frames = min(MOST_FRAMES, max(2, math.ceil(shown * FRAMES_A_SECOND)))
    if fastest:
        frames = min(MOST_FRAMES, max(frames, math.ceil(shown * fastest / TURN_A_FRAME)))
    return np.linspace(0.0, shown, frames)


def state_at(motion: Trajectory, time: float) -> tuple[Rotation, FloatArray]:
    """Attitude and ω (body axes, rad/s), interpolated between samples; constant after the last."""
    last = len(motion.t) - 1
    k = min(max(int(np.searchsorted(motion.t, time)), 1), last)
    if not last or time >= motion.t[-1]:
        return motion.R_world_body[last], motion.omega_body[last]
    part = (time - motion.t[k - 1]) / (motion.t[k] - motion.t[k - 1])
    between = motion.R_world_body[k - 1].inv() * motion.R_world_body[k]
    turned = motion.R_world_body[k - 1] * Rotation.from_rotvec(part * between.as_rotvec())
    omega = motion.omega_body[k - 1] + part * (motion.omega_body[k] - motion.omega_body[k - 1])
    return turned, omega


class _Pane:
    """One body in its picture, drawn about the com or the pivot."""

    def __init__(self, axes: Any, filmed: Filmed, body: DrawnBody, scenario: Scenario) -> None:
        self._axes, self._filmed = axes, filmed
        self._upright = frame_about(body.up_world)
        com = scenario.body.com if scenario.constraint.is_pivot else np.zeros(3)
        self._faces = (_faces(body) * body.half_sides) @ body.R_body_axes.T + com
        self._tints = _tints(len(self._faces))
        self._inertia, self._kept = scenario.inertia, kept_body(scenario)
        self._reach = 1.1 * float(np.linalg.norm(self._faces, axis=-1).max())
        self._path = filmed.motion.to_world(body.axis_body) @ self._upright.T * self._reach
        # Of a body on a pivot one half alone is of interest.
        is_held = scenario.constraint.is_pivot
        self._centre = 0.4 * self._path.mean(axis=0) if is_held else np.zeros(3)
        momenta = filmed.motion.omega_body @ self._inertia.T + self._kept
        self._largest = [
            float(np.linalg.norm(vectors, axis=1).max()) or 1.0
            for vectors in (filmed.motion.omega_body, momenta)
        ]

    def draw(self, time: float) -> None:
        """The frame of a time, s."""
        axes, motion = self._axes, self._filmed.motion
        axes.clear()
        axes.set_axis_off()
        axes.set_title(self._filmed.title, fontsize=9)
        limits = [(at - self._reach, at + self._reach) for at in self._centre]
        axes.set(xlim=limits[0], ylim=limits[1], zlim=limits[2])
        axes.set_box_aspect((1, 1, 1), zoom=1.6)
        attitude, omega = state_at(motion, time)
        R_upright_body = self._upright @ attitude.as_matrix()
        faces = Poly3DCollection(
            self._faces @ R_upright_body.T, facecolors=self._tints, shade=True, lightsource=LIGHT
        )
        axes.add_collection3d(faces)
        axes.plot(*self._path[motion.t <= time].T, color=PATH, lw=1)
        momentum = self._inertia @ omega + self._kept
        arrows = ((omega, OMEGA, OMEGA_LENGTH), (momentum, MOMENTUM, MOMENTUM_LENGTH))
        for (vector, colour, length), largest in zip(arrows, self._largest, strict=True):
            tip = R_upright_body @ vector * (length * self._reach / largest)
            axes.quiver(0, 0, 0, *tip, color=colour, lw=2, arrow_length_ratio=0.12)


def _tints(faces: int) -> list[str]:
    """Colours of the faces: one for a box; stripes for an ellipsoid, to make its spin visible."""
    if faces < SECTORS:
        return [BODY] * faces
    return [STRIPE if (k % SECTORS // 2) % 2 else BODY for k in range(faces)]


def _faces(body: DrawnBody) -> FloatArray:
    """Four corners of each face of the unit solid, (faces, 4, 3)."""
    if body.shape == "box":
        square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        corners = [
            [np.roll((side, a, b), k) for a, b in square] for k in range(3) for side in (-1, 1)
        ]
        return np.array(corners, dtype=float)
    polar, around = np.linspace(0, np.pi, BELTS + 1), np.linspace(0, 2 * np.pi, SECTORS + 1)
    p, a = np.meshgrid(polar, around, indexing="ij")
    at = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1)
    patches = [at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]]
    return np.stack(patches, axis=2).reshape(-1, 4, 3)
