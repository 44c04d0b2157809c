"""Scenario files are test files, in any folder, with only the package installed."""

import pytest
from library_scenes import library_scene
from scene_texts import sphere_text
from spincheck.engines import engines
from spincheck.reports.cli import kept_items, scene_items
from spincheck.reports.harness.executors import compiling

pytestmark = pytest.mark.slow

pytest_plugins = ["pytester"]

SPHERE = sphere_text((0.0, 1.0, 2.0), samples=5, tilt_deg=30.0)
PUBLISHED = """
[[published]]
t = 1.0
omega_body = [0.0, 1.0, {value}]
tolerance = 1e-12
source = "made up"
"""
EXPECTATION = """
[[expect]]
engine = "mujoco"
method = "RK4"
timestep = 0.01
energy = 1e-300
"""


@pytest.fixture
def run(pytester, run_pytest, engines_in_process):
    """Run pytest on files given by name and text."""

    def run_on(*arguments: str, **files: str):
        for name, text in files.items():
            pytester.makefile(".toml", **{name: text})
        return run_pytest("-rs", *arguments)

    return run_on


@pytest.mark.processes
def test_an_engine_that_is_not_installed_is_a_skip_with_its_reason(pytester):
    pytester.makeconftest("import sys; sys.modules.update(mujoco=None, pybullet=None)")
    pytester.makefile(".toml", sphere=SPHERE)
    wanted = "reference or mujoco or pybullet"
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "-rs", "-k", wanted)
    result.assert_outcomes(passed=1, skipped=2)
    for engine in ("mujoco", "pybullet"):
        reason = f"not tested: the package '{engine}' is not installed"
        result.stdout.fnmatch_lines([f"SKIPPED*{reason}*"])


def test_a_body_that_no_engine_holds_is_a_skip_that_says_so(run):
    rod = library_scene("rod-1e-12").text
    rod = rod.replace("1.0000000000005, 1e-12]", "1.00000000000005, 1e-13]")
    result = run("-k", "mujoco-RK4", rod=rod)
    result.assert_outcomes(skipped=1)
    lines = ["SKIPPED*unsupported: the body cannot be held in double precision*"]
    lines += ["spincheck: scenes: 1;*fail: 0, do not support the scene: 1,*"]
    result.stdout.fnmatch_lines_random(lines)


SHIPPED_EXPECTATION = """
[[expect]]
engine = "pybullet"
method = "default"
timestep = 0.01
omega = {bound}
"""


@pytest.mark.needs_pybullet
def test_an_engine_as_shipped_is_no_item_unless_the_scene_expects_something_of_it(run):
    promised = SPHERE.replace("A spinning", "A promised") + SHIPPED_EXPECTATION.format(bound=1.0)
    result = run("--collect-only", "-q", sphere=SPHERE, promised=promised)
    collected = [line for line in result.outlines if "-default" in line]
    assert collected == ["promised.toml::pybullet-default"]


@pytest.mark.needs_pybullet
def test_of_an_engine_as_shipped_the_expectation_is_judged_and_not_the_motion(run):
    for bound, outcome in ((1.0, "passed"), (1e-12, "failed")):
        text = SPHERE + SHIPPED_EXPECTATION.format(bound=bound)
        result = run("-k", "pybullet-default", sphere=text)
        assert {outcome: 1}.items() <= result.parseoutcomes().items()


@pytest.mark.needs_pybullet
def test_a_good_scene_passes_on_both_engines_by_the_methods_that_are_made_for_it(run):
    wanted = "reference or mujoco or pybullet"  # whatever else is installed
    result = run("-k", wanted, sphere=SPHERE)
    result.assert_outcomes(passed=8)


def test_other_toml_files_are_not_touched(run):
    result = run(other='[tool]\nname = "spincheck"\n', unmet="this is not TOML spincheck = 1")
    result.assert_outcomes()


def test_a_value_printed_elsewhere_that_differs_fails_in_words(run):
    result = run("-k", "reference", sphere=SPHERE + PUBLISHED.format(value=2.0))
    result.assert_outcomes(passed=1)
    result = run("-k", "reference", sphere=SPHERE + PUBLISHED.format(value=2.001))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*omega_body at t = 1 s: 0, 1, 2.001 in * exact *, 2; they differ by 1.00e-03*",
            "*reproduce with: spincheck*",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")
    result.stdout.no_fnmatch_line("*plugin.py*")


def test_an_unmet_expectation_fails_and_names_signal_size_and_command(run):
    tumbling = SPHERE.replace("[1.0, 1.0, 1.0]", "[1.0, 2.0, 2.5]")
    result = run("-k", "mujoco-RK4", box=tumbling + EXPECTATION)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "energy error at *: * exceeds the expected 1e-300 from t = * s on",
            "*reproduce with: spincheck run * --engine mujoco --method RK4",
            "a method and timestep that keep it: spincheck recommend *box.toml --engine mujoco "
            "--energy 1e-300",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


def test_a_misspelt_method_is_refused_with_the_nearest(run):
    result = run(sphere=SPHERE + EXPECTATION.replace("RK4", "RK5"))
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*must be one of *, got 'RK5'; did you mean 'RK4'[?]"])


def test_a_failed_engine_comes_before_the_bound_that_it_misses(run, monkeypatch):
    def fail(*_: object) -> None:
        raise ValueError("the matrix is singular")

    monkeypatch.setattr(type(engines()["mujoco"]), "open", fail)
    result = run("-k", "mujoco-RK4", sphere=SPHERE + EXPECTATION)
    result.assert_outcomes(failed=1)
    first = next(line for line in result.outlines if "singular" in line)
    assert first.startswith("failed: ValueError: the matrix is singular")
    result.stdout.fnmatch_lines(["outcome at 0.01 s: failed, *; expected: energy error at most *"])
    result.stdout.no_fnmatch_line("*spincheck recommend*")


def test_what_is_compiled_first_is_announced(run, monkeypatch):
    monkeypatch.setattr(compiling, "is_compiled", lambda: False)
    monkeypatch.setattr(compiling, "compile_side_by_side", lambda _: None)
    result = run("-k", "reference", sphere=SPHERE)
    words = "First, once: the solver of exact motions is compiled, roughly * s."
    result.stdout.fnmatch_lines([words])
    for nothing_runs in ("--collect-only", "-q"):
        result = run(nothing_runs, sphere=SPHERE, typo=SPHERE.replace("mass", "mas"))
        result.stdout.no_fnmatch_line("First, once*")


@pytest.mark.parametrize(
    ("setting", "key", "words"),
    [
        ("mujoco", "omga_body", "*omga_body: unknown key; did you mean 'omega_body'*"),
        ("mujco", "omega_body", "*'spincheck_engines' must be of *; did you mean 'mujoco'*"),
    ],
)
def test_a_broken_file_or_an_engine_that_there_is_not_is_one_message(run, setting, key, words):
    sphere = SPHERE.replace("omega_body", key)
    result = run("-o", f"spincheck_engines={setting}", sphere=sphere)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines([words])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_items_are_of_the_engines_in_the_settings_alone(run):
    result = run("--collect-only", "-q", "-o", "spincheck_engines=mujoco", sphere=SPHERE)
    mujoco = engines()["mujoco"].methods
    methods = [m.name for m in mujoco if not (m.as_shipped or m.requires)]
    items = [line for line in result.outlines if "::" in line]
    assert items == ["sphere.toml::reference", *(f"sphere.toml::mujoco-{m}" for m in methods)]


def test_what_agreed_is_run_again_when_something_it_rests_on_changes(run, pytester, monkeypatch):
    def outcomes(text: str = SPHERE, *options: str) -> dict[str, int]:
        pytester.makefile(".toml", sphere=text)
        return pytester.runpytest_inprocess("-k", "mujoco-RK4", *options).parseoutcomes()

    assert outcomes()["passed"] == 1
    monkeypatch.setattr(scene_items, "run_and_judge", lambda *_: pytest.fail("it is run"))
    assert outcomes()["passed"] == 1
    assert outcomes(SPHERE, "-o", "spincheck_max_steps=8")["failed"] == 1
    assert outcomes(SPHERE.replace("[0.0, 1.0, 2.0]", "[0.0, 1.0, 2.5]"))["failed"] == 1
    monkeypatch.setattr(kept_items, "_stamp", lambda file: "rebuilt")
    assert outcomes()["failed"] == 1


def test_ladders_end_at_the_steps_in_the_settings(run):
    """With so few steps there is no ladder: single steps and replays decide."""
    result = run("-k", "mujoco-RK4", "-o", "spincheck_max_steps=8", sphere=SPHERE)
    assert {"passed": 1}.items() <= result.parseoutcomes().items()


@pytest.mark.parametrize("setting", ["0", "-1", "1.5", "many"])
def test_steps_that_are_no_number_are_one_message(run, setting):
    result = run("-o", f"spincheck_max_steps={setting}", sphere=SPHERE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    wanted = f"*'spincheck_max_steps' must be a whole number from 1 on, got '{setting}'"
    result.stderr.fnmatch_lines([wanted])
