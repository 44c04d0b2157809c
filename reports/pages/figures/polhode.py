"""Poinsot's construction for a body without a pivot: the tip of ω on an ellipsoid, and in space."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.rotational_problem import rotational_problem
from ....scenarios import FloatArray, Trajectory
from ..analysis.report_data import SceneRuns
from .axis_path import dot, frame_about, surface, view
from .drawn_body import dense_motion
from .plot import Figure, Panel, drawing, start_dot

HEIGHT = 460
#: Room around the herpolhode, as a factor.
MARGIN = 1.15
#: A run is drawn up to this distance from the ellipsoid's centre, in longest semi-axes.
OFF_THE_ELLIPSOID = 1.5
#: A herpolhode smaller than this, relative to the largest ω, is drawn as a point.
NARROWEST = 1e-6


@dataclass(frozen=True, eq=False)
class Poinsot:
    """Maps a motion to the ellipsoid Σ Iₖ ωₖ² = 2T and to the plane across L.

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
        """ω/√2T in principal axes, (n, 3)."""
        omega_axes = self.R_axes_body.apply(np.array(motion.omega_body))
        return np.asarray(omega_axes / self.root_energy)

    def in_space(self, motion: Trajectory) -> FloatArray:
        """ω across L, rad/s, (n, 2)."""
        omega_level = motion.to_world(motion.omega_body) @ self.R_level_world.T
        return np.asarray(omega_level[:, :2])


def polhode(scene: SceneRuns) -> list[Figure]:
    """The polhode on its ellipsoid, and the herpolhode; none for a body that never turns."""
    exact = dense_motion(scene)
    picture = _poinsot(scene, exact)
    return [_on_ellipsoid(picture, exact), _in_space(picture, exact)] if picture else []


def _on_ellipsoid(picture: Poinsot, exact: Trajectory) -> Figure:
    semi_axes = 1 / np.sqrt(picture.moments)
    tips = picture.on_ellipsoid(exact)
    traces = [
        *surface(semi_axes, ("1", "2", "3")),
        dot(tips[0]),
    ]
    matrix = picture.R_axes_body.as_matrix() / picture.root_energy
    overlay = {
        "kind": "omega_body",
        "exact": "beginning",
        "matrix": matrix.tolist(),
        "within": OFF_THE_ELLIPSOID * float(semi_axes.max()),
    }
    scene = view(semi_axes, tips.mean(axis=0))
    return {"data": traces, "layout": {"height": HEIGHT, "scene": scene}, "overlays": [overlay]}


def _in_space(picture: Poinsot, exact: Trajectory) -> Figure:
    flat = picture.in_space(exact)
    fastest = float(np.linalg.norm(exact.omega_body, axis=1).max())
    widest = MARGIN * max(float(np.abs(flat).max()), NARROWEST * fastest)
    traces = [start_dot(flat[0, 0], flat[0, 1], 1)]
    overlay = {
        "kind": "omega_world",
        "exact": "beginning",
        "panel": 1,
        "matrix": picture.R_level_world[:2].tolist(),
    }
    return drawing(traces, [_panel(widest)], HEIGHT, overlay)


def _poinsot(scene: SceneRuns, exact_motion: Trajectory) -> Poinsot | None:
    problem = rotational_problem(scene.exact.scenario)
    moments = np.array(problem.moments, dtype=float)
    R_axes_body = Rotation.from_quat(np.array(problem.q_axes_body, dtype=float), scalar_first=True)
    omega_axes = R_axes_body.apply(np.array(exact_motion.omega_body))
    twice_energy = float((omega_axes**2 @ moments).max())
    if twice_energy == 0:
        return None
    L_body = R_axes_body.inv().apply(omega_axes[0] * moments)
    L_world = exact_motion.R_world_body[0].apply(L_body)
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
    )
