"""Poinsot's picture of a body without a pivot: the tip of ω on an ellipsoid, and in space."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.rotational_problem import rotational_problem
from ....scenarios import FloatArray, Trajectory
from ...results.store import SceneResult
from ..analysis.report_data import Compared
from . import solid
from .axis_path import frame_about
from .plot import Figure, Panel, exact_look, layout, line, method_style, start_dot, thinned

ELLIPSOID = ((0.0, 0.56), (0.0, 1.0))
HERPOLHODE = ((0.66, 0.99), (0.0, 1.0))
#: Room around the herpolhode, as a factor.
MARGIN = 1.15
#: In lengths of its longest semi-axis: how far from the ellipsoid's centre a run is followed.
OFF_THE_ELLIPSOID = 1.5
#: A herpolhode smaller than this, relative to the largest ω, is drawn as the point it is.
NARROWEST = 1e-6


@dataclass(frozen=True, eq=False)
class Poinsot:
    """How a motion is put on the ellipsoid Σ Iₖ ωₖ² = 2T and on the plane across L.

    T is the largest rotational energy of the exact motion, L the exact one at the start
    (Landau & Lifshitz, Mechanics, §37; Goldstein §5.6).

    Attributes
    ----------
    moments : principal, kg m², (3,)
    root_energy : √2T, so that ω/√2T lies on an ellipsoid of semi-axes 1/√Iₖ
    R_axes_body, R_level_world : to principal axes; to axes of which the third is along L
    """

    moments: FloatArray
    root_energy: float
    R_axes_body: Rotation
    R_level_world: FloatArray

    def on_ellipsoid(self, motion: Trajectory) -> FloatArray:
        """ω/√2T in principal axes, (n, 3), with gaps where a blow-up is far off."""
        omega_axes = self.R_axes_body.apply(np.array(motion.omega_body))
        points = omega_axes[thinned(len(motion.t))] / self.root_energy
        farthest = OFF_THE_ELLIPSOID / np.sqrt(self.moments.min())
        near = np.linalg.norm(points, axis=1) <= farthest
        return np.where(near[:, None], points, np.nan)

    def in_space(self, motion: Trajectory) -> FloatArray:
        """ω across L, rad/s, (n, 2)."""
        omega_level = motion.to_world(motion.omega_body) @ self.R_level_world.T
        return np.asarray(omega_level[thinned(len(motion.t)), :2])


def polhode(found: SceneResult, compared: tuple[Compared, ...]) -> Figure | None:
    """The polhode on its ellipsoid beside the herpolhode; None for a body that never turns."""
    truth = found.solution.trajectory
    picture = _poinsot(found)
    if picture is None:
        return None
    curves = [(truth, exact_look())] + [
        (run.motion, method_style(run.runs.label, run.runs.look)) for run in compared
    ]
    traces = solid.surface(1 / np.sqrt(picture.moments), ("1", "2", "3"))
    for motion, look in curves:
        traces.append(solid.curve(picture.on_ellipsoid(motion), look))
        across = picture.in_space(motion)
        traces.append(line(across[:, 0], across[:, 1], 1, **look))
    tips, flat = picture.on_ellipsoid(truth), picture.in_space(truth)
    traces += [solid.dot(tips[0]), start_dot(flat[0, 0], flat[0, 1], 1)]
    fastest = float(np.linalg.norm(truth.omega_body, axis=1).max())
    widest = MARGIN * max(float(np.abs(flat).max()), NARROWEST * fastest)
    figure: Figure = {"data": traces, "layout": layout([[_panel(widest)]], height=500)}
    figure["layout"]["scene"] = solid.view(
        1 / np.sqrt(picture.moments), tips.mean(axis=0), ELLIPSOID
    )
    return figure


def _poinsot(found: SceneResult) -> Poinsot | None:
    problem = rotational_problem(found.scenario)
    moments = np.array(problem.moments, dtype=float)
    R_axes_body = Rotation.from_quat(np.array(problem.q_axes_body, dtype=float), scalar_first=True)
    truth = found.solution.trajectory
    omega_axes = R_axes_body.apply(np.array(truth.omega_body))
    twice_energy = float((omega_axes**2 @ moments).max())
    if twice_energy == 0:
        return None
    L_body = R_axes_body.inv().apply(omega_axes[0] * moments)
    L_world = truth.R_world_body[0].apply(L_body)
    size = float(np.linalg.norm(L_world))
    along = L_world / size if size else np.array([0.0, 0.0, 1.0])
    return Poinsot(moments, float(np.sqrt(twice_energy)), R_axes_body, frame_about(along))


def _panel(widest: float) -> Panel:
    return Panel(
        x_title="ω across the initial L, rad/s",
        y_title="ω across the initial L, rad/s",
        heading="Herpolhode",
        x_range=(-widest, widest),
        y_range=(-widest, widest),
        equal_scales=True,
        domain=HERPOLHODE,
    )
