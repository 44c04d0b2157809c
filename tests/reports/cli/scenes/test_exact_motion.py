"""What `spincheck reference` prints of the exact motion."""

import numpy as np
import pytest
from library_scenes import library_scene
from scene_texts import scene
from scipy.spatial.transform import Rotation
from spincheck.reports.cli.scenes.exact_motion import describe, print_truth
from spincheck.scenarios.exact import omega_body_from_zyz_rates

TOP = library_scene("fast-top")
UPRIGHT = library_scene("asleep-at-the-threshold")
#: Of a few trigonometric functions each.
ROUNDING = 16 * float(np.finfo(float).eps)
SKEW = [[2.0, 0.3, 0.1], [0.3, 2.5, 0.2], [0.1, 0.2, 3.0]]


def test_its_euler_angles_are_the_attitude_and_their_rates_the_angular_velocity():
    for state in describe(TOP, [0.3, 1.7])["states"]:
        by_angles = Rotation.from_euler("ZYZ", state["euler_zyz_deg"], degrees=True)
        by_quaternion = Rotation.from_quat(state["quaternion_wxyz"], scalar_first=True)
        assert (by_angles.inv() * by_quaternion).magnitude() <= ROUNDING
        omega = omega_body_from_zyz_rates(state["euler_zyz_deg"], state["euler_zyz_rates"])
        speed = np.linalg.norm(state["omega_body"])
        assert np.abs(np.array(omega, dtype=float) - state["omega_body"]).max() <= ROUNDING * speed


def test_an_upright_axis_has_no_rates():
    upright = describe(UPRIGHT, [0.0])["states"][0]
    assert upright["euler_zyz_deg"][1] == 0
    assert np.isnan(upright["euler_zyz_rates"]).all()


@pytest.mark.parametrize("tilt", [0.0, 180.0])
def test_a_tilt_within_the_uncertainty_is_none(tilt, capsys):
    """Along skew principal axes an attitude that is upright in the file is so but for rounding."""
    skew = scene(
        ("inertia = [1.0, 2.0, 2.5]", f"inertia = {SKEW}"),
        ("euler_zyz_deg = [10.0, 30.0, 20.0]", f"euler_zyz_deg = [0.0, {tilt}, 20.0]"),
    )
    truth = describe(skew, [0.0])
    (state,) = truth["states"]
    assert state["quaternion_wxyz"][1 if tilt == 0.0 else 3] != 0, "there is rounding to leave out"
    assert state["euler_zyz_deg"][1:] == [tilt, 0.0]
    print_truth(truth)
    assert "euler_zyz_rates  undefined where β is 0° or 180°" in capsys.readouterr().out
