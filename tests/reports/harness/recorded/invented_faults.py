"""Motions with thirty faults of students' code, firmware, loggers and importers.

They were thought of by somebody who had not written what explains them, and are computed with
nothing of it.
"""

from collections.abc import Callable

import numpy as np
from planted_motions import Case, case, exactly, rates_of
from reported_faults import WHEEL, Arrays, Fault, euler, recorded, turning
from scipy.spatial.transform import Rotation
from spincheck.reference.other_equations import equations_of
from spincheck.scenarios import Scenario, from_tables

Made = tuple[Scenario, Arrays]
#: Of a gyroscope, rad/s; and when a recording began, s.
BIAS, SHIFT = np.array([0.05, -0.02, 0.01]), 0.37


def free(seed: int, samples: int = 201) -> Case:
    """A body that turns freely for four seconds."""
    return case(100 + seed, samples=samples)


def heavy(seed: int) -> Case:
    """A body on a pivot, under gravity."""
    return case(200 + seed, is_pivoted=True)


def written(one: Case, change: Callable[[Arrays], Arrays]) -> Made:
    """The right motion, and what is made of it where it is recorded."""
    arrays = exactly(one, rates_of(one))
    return one.scenario, arrays | change(arrays)


def read(one: Case, of_omega: Callable[[np.ndarray], np.ndarray]) -> Made:
    """The right motion, with ω as a gyroscope reads it, (n, 3)."""
    return written(one, lambda a: {"omega": of_omega(a["omega"])})


def computed(one: Case, **changes: object) -> Made:
    """A motion by other equations."""
    return one.scenario, exactly(one, rates_of(one, **changes))


def low_pass(omega: np.ndarray) -> np.ndarray:
    """A filter of first order, whose time constant is three samples."""
    out = omega.copy()
    for k in range(1, len(omega)):
        out[k] = out[k - 1] + (1 - np.exp(-1 / 3)) * (omega[k] - out[k - 1])
    return out


def resampled(one: Case, factor: float) -> Made:
    """Samples whose distance is another than their times say."""
    true = from_tables(
        one.scenario.document.model_dump(mode="json", exclude_none=True)
        | {
            "window": {
                "duration": factor * one.scenario.times[-1],
                "samples": len(one.scenario.times),
            }
        },
        "planted",
    )
    arrays = exactly(Case(true, one.inertia, one.com, one.gravity), rates_of(one))
    return one.scenario, arrays | {"t": one.scenario.times.copy()}


def one_sign(omega: np.ndarray, one: Case) -> np.ndarray:
    """What must be added to a torque where ω₂' = (I₁ − I₃)/I₂ ω₁ ω₃ instead of (I₃ − I₁)/I₂."""
    moments = np.diag(one.inertia)
    return np.array([0, 2 * (moments[0] - moments[2]) * omega[0] * omega[2], 0])


def along_its_axes(seed: int) -> Case:
    """A free body whose principal axes are the body's."""
    one = free(seed)
    moments = np.linalg.eigvalsh(one.inertia)[[1, 2, 0]]
    document = one.scenario.document.model_dump(mode="json", exclude_none=True)
    document["body"]["inertia"] = moments.tolist()
    return Case(from_tables(document, "planted"), np.diag(moments), one.com, one.gravity)


def principal(one: Case) -> Made:
    """Attitude and ω of the principal frame, as MuJoCo's `ximat` is, for those of the body."""
    axes = np.linalg.eigh(one.inertia)[1]
    axes *= np.sign(np.linalg.det(axes))
    turn = Rotation.from_matrix(axes)
    return written(
        one,
        lambda a: {
            "q": (Rotation.from_quat(a["q"], scalar_first=True) * turn).as_quat(scalar_first=True),
            "omega": a["omega"] @ axes,
        },
    )


def from_angles(a: Arrays, written_as: str, read_as: str) -> Arrays:
    """Attitudes by way of Euler angles of two conventions."""
    angles = Rotation.from_quat(a["q"], scalar_first=True).as_euler(written_as)
    return {"q": Rotation.from_euler(read_as, angles).as_quat(scalar_first=True)}


def along_other_world_axes(a: Arrays, degrees: float) -> Arrays:
    turn = Rotation.from_euler("x", degrees, degrees=True)
    q = turn * Rotation.from_quat(a["q"], scalar_first=True)
    return {"q": q.as_quat(scalar_first=True)}


def gap(one: Case) -> Made:
    """A row that the logger lost; times are counted."""
    return written(
        one,
        lambda a: {"t": a["t"][:-1], **{n: np.delete(a[n], 90, axis=0) for n in ("q", "omega")}},
    )


def wheel(factor: float) -> Made:
    """Rotors whose momentum is so many times as large."""
    e = equations_of(WHEEL)
    inertia, h = np.array(e.inertia), factor * np.array(e.kept)
    return WHEEL, recorded(
        *turning(WHEEL, euler(inertia, lambda R, omega: np.cross(h, R.T @ omega)))
    )


def started(one: Case, factor: float) -> Made:
    """Angles of the start in degrees that are taken for radians."""
    document = one.scenario.document.model_dump(mode="json", exclude_none=True)
    turn = Rotation.from_quat(one.scenario.start.q_world_body_wxyz, scalar_first=True)
    other = Rotation.from_rotvec(factor * turn.as_rotvec()).as_quat(scalar_first=True)
    document["start"]["quaternion_wxyz"] = other.tolist()
    true = Case(from_tables(document, "planted"), one.inertia, one.com, one.gravity)
    return one.scenario, exactly(true, rates_of(true))


def mirrored_in_z(one: Case) -> Made:
    com, mass = one.com * [1, 1, -1], one.scenario.body.mass
    of_com = one.inertia - mass * (one.com @ one.com * np.eye(3) - np.outer(one.com, one.com))
    tensor = of_com + mass * (com @ com * np.eye(3) - np.outer(com, com))
    other = Case(one.scenario, tensor, com, one.gravity)
    return one.scenario, exactly(other, rates_of(other))


def gravity_that_turns(one: Case) -> Made:
    """Gravity along body axes, as at the start."""
    R = Rotation.from_quat(one.scenario.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    constant = one.torque(R)
    return computed(one, scale=0.0, torque=lambda omega: constant)


def permuted(one: Case) -> Made:
    order = [1, 2, 0]
    return computed(one, inertia=one.inertia[np.ix_(order, order)])


def products_twice(one: Case) -> Made:
    return computed(one, inertia=2 * one.inertia - np.diag(np.diag(one.inertia)))


def shifted(one: Case) -> Made:
    """A recording that began later than the motion, with times from zero."""
    fine = free(13, samples=4001)
    a = exactly(fine, rates_of(fine))
    at = np.arange(0, 4001 - int(1000 * SHIFT), 20) + int(1000 * SHIFT)
    return one.scenario, {"t": a["t"][at] - SHIFT, "q": a["q"][at], "omega": a["omega"][at]}


def rounded_times(one: Case) -> Made:
    return written(one, lambda a: {"t": np.round(a["t"], 2)})


#: What went wrong, who does so, words that must be said, and the motion.
INVENTED = tuple(
    Fault(who, what, words, motion)
    for who, what, words, motion in (
        (
            "firmware",
            "a bias of the gyroscope",
            ("a bias of",),
            lambda: read(free(1), lambda w: w + BIAS),
        ),
        (
            "firmware",
            "a gyroscope's axis scaled by 1.03",
            ("axes read",),
            lambda: read(free(2), lambda w: w * [1, 1, 1.03]),
        ),
        (
            "firmware",
            "a gyroscope mounted at 45°",
            ("axes are turned",),
            lambda: read(free(3), lambda w: Rotation.from_euler("z", 45, degrees=True).apply(w)),
        ),
        (
            "firmware",
            "a gyroscope that saturates",
            ("clamped to 1.2 rad/s",),
            lambda: read(free(4), lambda w: np.clip(w, -1.2, 1.2)),
        ),
        (
            "firmware",
            "ω through a filter of three samples",
            ("ω is filtered",),
            lambda: read(free(5), low_pass),
        ),
        (
            "firmware",
            "ω three samples late",
            ("3 samples older",),
            lambda: read(free(6), lambda w: np.vstack([w[:1]] * 3 + [w[:-3]])),
        ),
        ("logger", "ω in rpm", ("rpm",), lambda: read(free(7), lambda w: w * 30 / np.pi)),
        (
            "student",
            "ω = q* q' without the 2",
            ("half of what it should be",),
            lambda: read(free(8), lambda w: w / 2),
        ),
        (
            "student",
            "angular momentum logged for ω",
            ("angular momentum",),
            lambda: read(free(9), lambda w: w @ free(9).inertia),
        ),
        (
            "logger",
            "ticks of 1/1024 s counted as ms",
            ("1.024 times too long",),
            lambda: resampled(free(10), 1000 / 1024),
        ),
        (
            "student",
            "1/60 s written as 0.0167",
            ("1.002 times too long",),
            lambda: resampled(free(11, 241), (1 / 60) / 0.0167),
        ),
        (
            "logger",
            "a row lost, times counted",
            ("1 sample is lost before t = 1.8 s",),
            lambda: gap(free(12)),
        ),
        (
            "logger",
            "a late start, times from zero",
            ("started elsewhere",),
            lambda: shifted(free(13)),
        ),
        (
            "logger",
            "times with two decimals, of samples at 1/60 s",
            ("times are rounded",),
            lambda: rounded_times(free(14, 241)),
        ),
        (
            "importer",
            "qy and qz exchanged",
            ("[qw, qx, qz, qy]",),
            lambda: written(free(15), lambda a: {"q": a["q"][:, [0, 1, 3, 2]]}),
        ),
        (
            "importer",
            "Euler angles of another convention",
            ("Euler angles ZYX",),
            lambda: written(free(16), lambda a: from_angles(a, "ZYX", "XYZ")),
        ),
        (
            "importer",
            "the principal frame for the body's",
            ("principal axes, not",),
            lambda: principal(free(17)),
        ),
        (
            "importer",
            "y up for z up, of the attitude",
            ("the world's axes are [x, -z, y]",),
            lambda: written(free(18), lambda a: along_other_world_axes(a, 90)),
        ),
        (
            "student",
            "one sign in Euler's equations",
            ("ωy' had the other sign",),
            lambda: computed(along_its_axes(19), torque=lambda w: one_sign(w, along_its_axes(19))),
        ),
        (
            "student",
            "drag with ‖ω‖ ω",
            ("drag were 0.02 ‖ω‖^2",),
            lambda: computed(free(20), torque=lambda w: -0.02 * np.linalg.norm(w) * w),
        ),
        (
            "student",
            "gravity upwards",
            ("gravity were turned round, or the com were on the other side",),
            lambda: computed(heavy(21), scale=-1.0),
        ),
        (
            "student",
            "weight of twice the mass",
            ("gravity were 2 times",),
            lambda: computed(heavy(22), scale=2.0),
        ),
        ("importer", "the com mirrored in z", ("com were at",), lambda: mirrored_in_z(heavy(23))),
        (
            "student",
            "rpm of a wheel taken for rad/s",
            ("9.549297 times",),
            lambda: wheel(30 / np.pi),
        ),
        (
            "student",
            "a wheel that does not spin",
            ("there were no rotors' torque",),
            lambda: wheel(0.0),
        ),
        (
            "engine",
            "angular drag of 0.05 /s",
            ("L were slowed by 0.05 /s",),
            lambda: computed(heavy(26), torque=lambda w: -0.05 * heavy(26).inertia @ w),
        ),
        (
            "importer",
            "rows and columns in the order y z x",
            ("rows and columns",),
            lambda: permuted(free(27)),
        ),
        (
            "importer",
            "products of inertia twice",
            ("tensor were Ixx",),
            lambda: products_twice(free(28)),
        ),
        (
            "student",
            "degrees of the start taken for radians",
            ("started elsewhere",),
            lambda: started(free(29), np.pi / 180),
        ),
        (
            "student",
            "gravity that turns with the body",
            ("no gravity", "along body axes"),
            lambda: gravity_that_turns(heavy(30)),
        ),
    )
)
