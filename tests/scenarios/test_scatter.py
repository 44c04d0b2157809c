"""Members of an ensemble: reproducible one by one, valid, and distributed as documented."""

import numpy as np
import pytest
import top_scenes
from case_loops import each_case
from library_scenes import library
from scipy.spatial.transform import Rotation
from spincheck.scenarios import ScenarioError, loads
from spincheck.scenarios.scatter import SCATTER, member

pytestmark = pytest.mark.slow

EPS = np.finfo(float).eps
START = "euler_zyz_deg = [10.0, 40.0, 70.0]\nomega_body = {}"
SKEW = "[[2.0, 0.1, 0.0], [0.1, 2.2, 0.3], [0.0, 0.3, 2.4]]"
MEMBERS = 400
#: Standard deviations by which a mean of as many members may be off: once in 10⁹.
SIGMAS = 6.0


def scene(inertia="[1.0, 2.0, 2.5]", effects="", omega=(1.0, 2.0, 0.5)):
    com = "com = [0.0, 0.0, 0.1]" if effects else ""
    body = f"mass = 2.0\ninertia = {inertia}\n{com}"
    return top_scenes.scene(body, START.format(list(omega)), effects)


def members(base, count: int = MEMBERS):
    return [member(base, 1, number) for number in range(count)]


@pytest.fixture(scope="module")
def free():
    return members(scene())


@pytest.fixture(scope="module")
def heavy():
    return members(scene("[2.0, 2.0, 1.0]", top_scenes.HEAVY))


def attitudes(scenes) -> Rotation:
    return Rotation.from_quat([s.start.q_world_body_wxyz for s in scenes], scalar_first=True)


def test_a_member_is_that_of_numpys_spawned_streams():
    """So that anybody can draw it again: the first normals make the attitude."""
    stream = np.random.SeedSequence(7).spawn(3)[2]
    n = np.random.Generator(np.random.PCG64(stream)).standard_normal(4)
    expected = Rotation.from_quat(n).as_quat(scalar_first=True)
    q_wxyz = member(scene(), 7, 2).start.q_world_body_wxyz
    assert min(np.abs(q_wxyz - expected).max(), np.abs(q_wxyz + expected).max()) <= 8 * EPS


def test_seeds_and_numbers_distinguish_members():
    texts = {member(scene(), seed, number).text for seed in range(5) for number in range(5)}
    assert len(texts) == 25


def test_a_member_reads_back_from_its_text():
    one = member(scene(), 7, 3)
    again = loads(one.text, "again")
    assert np.array_equal(again.start.omega_body, one.start.omega_body)
    assert np.array_equal(again.body.inertia_com, one.body.inertia_com)


def test_a_member_names_no_file_which_has_other_numbers():
    origin = f'model = "arm.urdf"\nlink = "arm"\nwelded = ["tool"]\nsha256 = "{"0" * 64}"\n'
    one = member(loads(scene().text.replace("[body]\n", f"[body]\n{origin}"), "made"), 7, 3)
    assert one.document.body.model_fields_set == {"mass", "inertia"}


@each_case("base", library())
def test_every_scene_of_the_library_can_be_scattered(base):
    if "table" in base.called_for and (reason := _refusal(base)):
        # The tip of a body that is started otherwise may leave its table at once.
        assert "lift" in reason
        return
    assert member(base, 1, 0).called_for == base.called_for


def _refusal(base):
    """Why a member is no scene; empty if it is one."""
    try:
        member(base, 1, 0)
    except ScenarioError as error:
        return str(error)
    return ""


def test_free_attitudes_are_uniform(free):
    """Of a uniform rotation every entry of the matrix has mean 0 and variance 1/3."""
    matrices = attitudes(free).as_matrix()
    deviations = np.abs(matrices.mean(axis=0)) * np.sqrt(3 * MEMBERS)
    assert deviations.max() < SIGMAS


def test_attitudes_under_gravity_stay_near_the_scenes(heavy):
    base = Rotation.from_euler("ZYZ", [10.0, 40.0, 70.0], degrees=True)
    turns = (base.inv() * attitudes(heavy)).as_rotvec()
    assert abs(turns.std() / SCATTER - 1) < SIGMAS / np.sqrt(2 * turns.size)


def test_spins_are_longer_and_shorter_by_the_factor_that_is_said(free):
    longer = np.log([np.linalg.norm(s.start.omega_body) / np.sqrt(5.25) for s in free])
    assert abs(longer.std() / SCATTER - 1) < SIGMAS / np.sqrt(2 * MEMBERS)
    assert abs(longer.mean()) < SIGMAS * SCATTER / np.sqrt(MEMBERS)


def test_spins_are_turned_as_is_said(free):
    """Of a small rotation vector two components, those across the spin, turn it."""
    directions = np.array([s.start.omega_body / np.linalg.norm(s.start.omega_body) for s in free])
    aside = np.cross(directions, np.array([1.0, 2.0, 0.5]) / np.sqrt(5.25))
    turn = np.sqrt((aside**2).sum(axis=1).mean() / 2)
    assert abs(turn / SCATTER - 1) < SIGMAS / np.sqrt(4 * MEMBERS)


def test_second_moments_of_mass_are_scattered_as_is_said(free):
    moments = np.array([np.diag(s.body.inertia_com) for s in free])
    second = moments.sum(axis=1, keepdims=True) / 2 - moments
    factors = np.log(second / [1.75, 0.75, 0.25])
    assert np.abs(factors.std(axis=0) / SCATTER - 1).max() < SIGMAS / np.sqrt(2 * MEMBERS)
    assert np.abs(np.corrcoef(factors.T)[np.triu_indices(3, 1)]).max() < SIGMAS / np.sqrt(MEMBERS)


def test_a_symmetric_top_stays_one_its_com_on_its_axis(heavy):
    assert all(s.body.inertia_com[0, 0] == s.body.inertia_com[1, 1] for s in heavy)
    assert all(s.body.com[0] == s.body.com[1] == 0.0 for s in heavy)


def test_a_flat_body_stays_flat():
    moments = np.array([np.diag(s.body.inertia_com) for s in members(scene("[1.0, 2.0, 3.0]"), 20)])
    assert np.abs(moments[:, 0] + moments[:, 1] - moments[:, 2]).max() <= 8 * EPS * moments.max()


def test_a_sphere_stays_one():
    for s in members(scene("[2.0, 2.0, 2.0]"), 20):
        assert len(set(np.diag(s.body.inertia_com))) == 1


def test_a_body_in_skew_axes_keeps_them():
    """To the rounding of its eigenvectors: the tensors commute."""
    base = scene(SKEW)
    for s in members(base, 20):
        a, b = base.body.inertia_com, s.body.inertia_com
        assert np.abs(a @ b - b @ a).max() <= 64 * EPS * np.abs(a).max() * np.abs(b).max()
        assert np.abs(a / np.trace(a) - b / np.trace(b)).max() > SCATTER**3


def test_a_body_at_rest_stays_at_rest():
    assert not member(scene(omega=(0.0, 0.0, 0.0)), 1, 1).start.omega_body.any()
