"""The suite as its adopters run it: on engines, programs and recordings, with known failures."""

import shutil
import sys
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
import pytest
import spincheck
from spincheck.engines import engines
from spincheck.suite import SCENES

pytestmark = pytest.mark.slow

pytest_plugins = ["pytester"]

KNOWN = Path(__file__).with_name("known_failures.toml")
FAULTY = """
from stepped import DRAG, METHODS, Stepped, SteppedEngine

class Damped(Stepped):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.constants[DRAG] += 0.04 * self.inertia[0, 0]

class Faulty(SteppedEngine):
    methods = METHODS[2:]

    def __init__(self):
        super().__init__(Damped)
        self.name = "faulty"

class Taken(Faulty):
    def __init__(self):
        super().__init__()
        self.name = "mujoco"

not_one = 3
"""
ADAPTER = "spincheck.suite.test_adapter"
DAMPING, TORQUE = "test_no_hidden_damping", "test_torque_in_world_axes"


@pytest.fixture
def suite(pytester, run_pytest):
    """Run pytest on the suite, in this process."""
    pytester.makepyfile(faulty=FAULTY)
    pytester.syspathinsert()
    known = dict(engines())

    def run_on(*arguments: str, of: str = "spincheck.suite.test_physics"):
        return run_pytest("-p", "no:xdist", "-rsx", "--pyargs", of, *arguments)

    yield run_on
    engines().clear()
    engines().update(known)


def named(*names: str) -> list[str]:
    return [part for name in names for part in ("--spincheck-engine", name)]


REQUIRED = [name for name in ("mujoco", "pybullet") if name in engines()]


def test_the_engines_of_this_installation_fail_nothing_but_what_they_are_known_to(suite) -> None:
    # First steps of one method of each engine: the library's items judge those of all methods.
    chosen = "not begins or mujoco-RK4] or pybullet-multibody]"
    result = suite(*named(*REQUIRED), "-k", chosen, of=ADAPTER)
    assert result.ret == 0
    assert set(result.parseoutcomes()) == {"passed", "deselected"}
    # A method that passes, and one that does not; of all methods: `make suite`.
    chosen = "pybullet-default] or mujoco-RK4]"
    result = suite(*named(*REQUIRED), "-k", chosen, "--spincheck-xfails", str(KNOWN))
    assert result.ret == 0
    result.stdout.fnmatch_lines(["spincheck suite on mujoco *"])


def test_a_failure_says_what_it_means_and_which_issues_it_would_have_caught(suite) -> None:
    result = suite(*named("faulty:Faulty"), "-k", DAMPING)
    result.assert_outcomes(failed=1, deselected=15)
    lines = ["it disagrees: *", "scene: *sphere.toml", "*what this failure means*"]
    lines += ["Something slows a free body *", "https://github.com/mockingbirdnest/Principia/*"]
    result.stdout.fnmatch_lines(lines)


def test_an_adapter_that_fails_is_one_message_without_a_stack_trace(suite) -> None:
    result = suite(*named("faulty:Faulty"), "-k", "equations_of_motion", of=ADAPTER)
    result.assert_outcomes(failed=1, deselected=9)
    result.stdout.fnmatch_lines(["faulty * on *: behaves as if *"])
    result.stdout.no_fnmatch_line("*raise *")


def test_an_engine_that_is_registered_may_be_named_by_its_class(suite) -> None:
    engines()["faulty"] = resolve_name("faulty:Faulty")()
    result = suite(*named("faulty:Faulty"), "-k", DAMPING)
    result.assert_outcomes(failed=1, deselected=15)


def test_a_known_failure_is_none_and_one_that_passes_again_is_one(suite, pytester) -> None:
    text = f'{DAMPING} = "damps at 0.04 /s"\n"{TORQUE}[mujoco-RK4]" = "was fixed"\n'
    file = str(pytester.makefile(".toml", known=text))
    result = suite(*named("faulty:Faulty"), "-k", DAMPING, "--spincheck-xfails", file)
    result.assert_outcomes(xfailed=1, deselected=15)
    result.stdout.fnmatch_lines(["XFAIL *damps at 0.04 /s*"])
    again = suite(*named("mujoco"), "-k", f"{TORQUE} and RK4", "--spincheck-xfails", file)
    assert again.ret == 1
    again.stdout.fnmatch_lines(["*XPASS(strict)*was fixed*"])


RK5_WORDS = "'test_heavy_top[mujoco-RK5]' names no method of mujoco; did you mean*mujoco-RK4]'?"
REFUSED = {
    "no engine": ((), "'--spincheck-engine' must name what is tested"),
    "an unknown engine": (named("mujocco"), "must be one of *did you mean*mujoco"),
    "no such module": (named("no_module:Engine"), "ModuleNotFoundError: No module named"),
    "an object that is none": (named("faulty:not_one"), "must be a subclass of * got 3"),
    "another engine's name": (named("faulty:Taken"), "'mujoco' is another engine's name; rename"),
    "no file": ((*named("mujoco"), "--spincheck-xfails", "none.toml"), "cannot be read: No such"),
    "no TOML": ((*named("mujoco"), "--spincheck-xfails", "faulty.py"), "must be TOML in UTF-8"),
    "no test": ((*named("mujoco"), "--spincheck-xfails", "typo.toml"), "mean*test_heavy_top"),
    "no method": ((*named("mujoco"), "--spincheck-xfails", "rk5.toml"), RK5_WORDS),
    "no end": ((*named("mujoco"), "--spincheck-xfails", "open.toml"), "no method*mujoco-RK4]"),
    "no reason": ((*named("mujoco"), "--spincheck-xfails", "mute.toml"), "must have its reason"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_used_is_refused_with_one_message(case: str, suite, pytester) -> None:
    pytester.makefile(".toml", typo='test_heavy_tops = "x"', mute='test_heavy_top = ""')
    pytester.makefile(
        ".toml",
        rk5='"test_heavy_top[mujoco-RK5]" = "x"',
        open='"test_heavy_top[mujoco-RK4" = "x"',
    )
    arguments, words = REFUSED[case]
    result = suite(*arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    text = " ".join((result.stdout.str() + result.stderr.str()).split())
    assert all(part in text for part in words.split("*"))


def test_known_failures_of_engines_that_are_not_tested_are_accepted(suite, pytester) -> None:
    """One file may be that of several engines, whose names may begin alike."""
    lines = [f'"{DAMPING}[{engine}-RK9]" = "x"' for engine in ("mujoco-warp", "mjx", "mine")]
    file = str(pytester.makefile(".toml", known="\n".join(lines)))
    result = suite(*named("mujoco"), "-k", f"{DAMPING}[mujoco-RK4]", "--spincheck-xfails", file)
    assert result.ret == 0


@pytest.mark.processes
def test_a_program_is_tested_as_any_engine(suite) -> None:
    child = Path(spincheck.engines.__path__[0]).parent / "tests/engines/child/planted_child.py"
    command = f"child:{sys.executable} -S {child} "
    result = suite(*named(command), "-k", "test_attitude_follows_omega")
    assert result.ret == 0
    # It turns every body like a sphere.
    result = suite(*named(command), "-k", "equations_of_motion", of=ADAPTER)
    result.assert_outcomes(failed=1, deselected=9)
    result.stdout.fnmatch_lines(["*on 'free': *gyroscopic torque*"])


@pytest.mark.processes
@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_an_engine_of_fifty_lines_in_another_language_keeps_the_contract(suite) -> None:
    toy = Path(spincheck.engines.__path__[0]).parent / "tests/engines/interface_1/toy.mjs"
    assert len(toy.read_text(encoding="utf-8").splitlines()) <= 55
    suite(*named(f"child:node {toy}"), of=ADAPTER).assert_outcomes(passed=10)


def test_recordings_are_judged_and_what_is_missing_is_skipped(suite, tmp_path: Path) -> None:
    times = np.linspace(0.0, 1.0, 21)
    for name, offset in (("torque-in-body-axes", 0.0), ("fast-sphere", 0.05)):
        scene = spincheck.load(SCENES / f"{name}.toml")
        exact = spincheck.exact(scene).at(times)
        (tmp_path / name).mkdir()
        for timestep in (0.01, 0.005, 0.0025):
            off = timestep + offset
            arrays = {"q": exact.q_world_body_wxyz, "omega": exact.omega_body * (1 + off)}
            path = tmp_path / name / f"{timestep}.npz"
            np.savez(path, t=times, timestep=str(timestep), com=exact.com_world, **arrays)
    result = suite(*named(str(tmp_path)))
    result.assert_outcomes(passed=1, failed=1, skipped=14)
    words = "it disagrees: *the recorded ω is not that of the attitudes*"
    result.stdout.fnmatch_lines([words])
    result.stdout.fnmatch_lines(["SKIPPED *heavy-top.toml, at halved timesteps*got 0"])
