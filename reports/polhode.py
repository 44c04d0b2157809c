"""Poinsot's picture of a body without a pivot: the tip of ω on an ellipsoid, and in space."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..reference.pose import pose
from ..scenarios import FloatArray, Trajectory
from . import solid
from .axis_path import frame_about
from .gather import Compared
from .plot import Figure, Panel, exact_look, layout, line, method_look, start_dot, thinned
from .store import SceneResult

ELLIPSOID = ((0.0, 0.56), (0.0, 1.0))
HERPOLHODE = ((0.66, 0.99), (0.0, 1.0))
#: Room around the herpolhode, as a factor.
MARGIN = 1.15
#: In lengths of its longest semi-axis: how far from the ellipsoid's centre a run is followed.
OFF_THE_ELLIPSOID = 1.5
#: A herpolhode smaller than this, relative to the largest ω, is drawn as the point it is.
NARROWEST = 1e-6


def polhode(found: SceneResult, compared: tuple[Compared, ...]) -> Figure | None:
    """ω/√2T in principal axes on Σ Iₖ ωₖ² = 2T, and ω in space across the initial L.

    T is the largest rotational energy of the exact motion; None for a body that never turns
    (Landau & Lifshitz, Mechanics, §37; Goldstein §5.6).
    """
    problem = pose(found.scenario)
    moments = np.array(problem.moments, dtype=float)
    R_axes_body = Rotation.from_quat(np.array(problem.q_axes_body, dtype=float), scalar_first=True)

    def in_axes(motion: Trajectory) -> FloatArray:
        return np.asarray(R_axes_body.apply(np.array(motion.omega_body)))

    truth = found.solution.trajectory
    omega_axes = in_axes(truth)
    twice_energy = float((omega_axes**2 @ moments).max())
    if twice_energy == 0:
        return None
    R_level_world = _across(truth, R_axes_body.inv().apply(omega_axes[0] * moments))

    def points(motion: Trajectory) -> FloatArray:
        """Three components on the ellipsoid, two in space, (n, 5)."""
        omega_level = motion.R_world_body.apply(np.array(motion.omega_body)) @ R_level_world.T
        both = np.hstack([in_axes(motion) / np.sqrt(twice_energy), omega_level[:, :2]])
        return np.asarray(both[thinned(len(motion.t))])

    exact = points(truth)
    narrowest = NARROWEST * float(np.linalg.norm(omega_axes, axis=1).max())
    curves = [(exact, exact_look())] + [
        (points(run.motion), method_look(run.runs.label, run.runs.look)) for run in compared
    ]
    traces = solid.surface(1 / np.sqrt(moments), ("1", "2", "3"))
    farthest = OFF_THE_ELLIPSOID / float(np.sqrt(moments.min()))
    for found_points, look in curves:
        traces.append(solid.curve(_within(farthest, found_points[:, :3]), look))
        traces.append(line(found_points[:, 3], found_points[:, 4], 1, **look))
    traces += [solid.dot(exact[0, :3]), start_dot(exact[0, 3], exact[0, 4], 1)]
    figure: Figure = {
        "data": traces,
        "layout": layout([[_panel(exact[:, 3:], narrowest)]], height=500),
    }
    figure["layout"]["scene"] = solid.view(exact[:, :3].mean(axis=0), ELLIPSOID)
    return figure


def _within(farthest: float, points: FloatArray) -> FloatArray:
    """With gaps beyond a distance: a blow-up would shrink the ellipsoid to a dot."""
    near = np.linalg.norm(points, axis=1) <= farthest
    return np.where(near[:, None], points, np.nan)


def _across(truth: Trajectory, L_body: FloatArray) -> FloatArray:
    """A frame whose third row is the direction of L at the start; z where L is zero, (3, 3)."""
    L_world = np.asarray(truth.R_world_body[0].apply(L_body))
    size = float(np.linalg.norm(L_world))
    return frame_about(L_world / size if size else np.array([0.0, 0.0, 1.0]))


def _panel(exact: FloatArray, narrowest: float) -> Panel:
    widest = MARGIN * max(float(np.abs(exact).max()), narrowest)
    return Panel(
        x_title="ω across the initial L, rad/s",
        y_title="ω across the initial L, rad/s",
        heading="Herpolhode",
        x_range=(-widest, widest),
        y_range=(-widest, widest),
        equal_scales=True,
        domain=HERPOLHODE,
    )
