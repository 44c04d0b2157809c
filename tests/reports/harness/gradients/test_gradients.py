"""Derivatives that engines give are judged right, and mistakes in them are named.

Verified: honest derivatives of every engine that is installed converge, and are those of its own
steps, of every method on a heavy top, of the first one on a scene of each kind (`make gradients`:
of all on all ten); a mistake that is planted in MuJoCo's is told by its name on each of ten scenes,
free, heavy and on a table, that it changes anything on; a window's gradient is the exact one but
for the error of the steps; what an engine refuses or runs out of is a row.
Newton's tape: a solver that it goes through, one that it does not, and one that refuses it.
Not verified: MJX's and Brax's derivatives, which take long to compile, but of one method on one of
the scenes; of MJX's two (`make gradients`: all).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
import pytest
from case_loops import each_case
from kinds_of_engines import installed
from library_scenes import library_scene
from planted import METHOD, DerivativesSession, planted
from scenes_of_derivatives import SCENES
from spincheck.engine import Derivative, EngineError, FloatArray, State, UnsupportedError
from spincheck.engines import engines
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.gradients.compared import OURS, THEIRS
from spincheck.reports.harness.gradients.study import gradient_by, gradients_of, offered_by
from spincheck.reports.harness.gradients.window import Gradient, useless_from
from spincheck.scenarios import Scenario
from spincheck.scenarios.rotation import matrix

pytestmark = pytest.mark.slow

MUJOCO = engines()["mujoco"]
PAGE = Path(__file__).parents[4] / "docs/measured/gradients.md"
#: s; of runs along which no derivative is judged, and of a single step.
WINDOW, ONE_STEP = 0.02, 1e-9
#: Heavy, and of all methods; free in skew axes; heavy and not symmetric; on a table.
FEW = ("fast-top", "book-in-skew-axes", "lopsided-body", "gliding-top")
#: MuJoCo's own.
HONEST = MuJoCoSession.derivatives
#: CPU time that a call may take, s, which only one without end takes.
LIMIT = 2.0
#: What an engine or its adapter does not differentiate, by words of the reason.
OUT_OF_REACH = ("RK4 integrator is not supported", "its caller's")
#: Of MJX's, which are compiled for half a minute each: forward and in reverse, of a step and many.
OF_MJX = ("jacfwd", "jacrev, through 8 steps")


@dataclass(frozen=True, eq=False)
class Step:
    """What a mistake is made of: a step's Jacobian, by MuJoCo, and the states around it."""

    session: MuJoCoSession
    scenario: Scenario
    jacobian: FloatArray

    @property
    def h(self) -> float:
        """s."""
        return float(self.session.model.opt.timestep)

    @property
    def states(self) -> tuple[State, State]:
        """Before and after."""
        before = self.session.read_state()
        self.session.advance(1)
        after = self.session.read_state()
        self.session.restart(before)
        return before, after

    @property
    def omega(self) -> FloatArray:
        """rad/s, before, body axes."""
        return self.states[0].omega_body

    def without(self, rate: FloatArray, three: int) -> FloatArray:
        """The Jacobian without a part of that of dω/dt, (3, 3), in three of the columns."""
        made = self.jacobian.copy()
        made[3:, three : three + 3] -= self.h * np.linalg.solve(self.scenario.inertia, rate)
        return made


def cross_matrix(v: FloatArray) -> FloatArray:
    """M with M u = v × u."""
    return np.cross(v, np.eye(3)).T


def of_blocks(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """[[a, 0], [b, c]]."""
    return np.block([[a, np.zeros((3, 3))], [b, c]])


def in_world(attitude: bool, omega: bool) -> Callable[[Step], FloatArray]:
    """Either vector along the world's axes."""

    def made(step: Step) -> FloatArray:
        ends = []
        for state in step.states:
            R = matrix(state.q_world_body_wxyz)
            carried = -R @ cross_matrix(state.omega_body) if omega else np.zeros((3, 3))
            ends.append(of_blocks(R if attitude else np.eye(3), carried, R if omega else np.eye(3)))
        return ends[1] @ step.jacobian @ np.linalg.inv(ends[0])

    return made


def scaled(rows: float, columns: float) -> Callable[[Step], FloatArray]:
    """The attitude's rows and columns times a factor."""
    left, right = (np.repeat([factor, 1.0], 3) for factor in (rows, columns))
    return lambda step: left[:, None] * step.jacobian * right


def kept(order: list[int]) -> Callable[[Step], FloatArray]:
    """Rows and columns in another order."""
    return lambda step: step.jacobian[np.ix_(order, order)]


def gyroscopic(step: Step) -> FloatArray:
    """Without the derivative of −ω × I ω."""
    inertia, omega = step.scenario.inertia, step.omega
    return step.without(cross_matrix(inertia @ omega) - cross_matrix(omega) @ inertia, 3)


def half_gyroscopic(step: Step) -> FloatArray:
    """Without that by I ω."""
    return step.without(-cross_matrix(step.omega) @ step.scenario.inertia, 3)


def gravity(step: Step) -> FloatArray:
    """Without the derivative of m com × Rᵀ g."""
    body, R = step.scenario.body, matrix(step.states[0].q_world_body_wxyz)
    pulled = cross_matrix(step.scenario.gravity_world @ R)
    return step.without(body.mass * cross_matrix(np.array(body.com)) @ pulled, 0)


def axes_that_stay(step: Step) -> FloatArray:
    """Without −ω × δθ."""
    made = step.jacobian.copy()
    made[:3, :3] += step.h * cross_matrix(step.omega)
    return made


def unnormalised(step: Step) -> FloatArray:
    """Through q + h q', whose norm is more than 1."""
    (_, after) = step.states
    speed = float(np.linalg.norm(after.omega_body))
    return scaled(np.sqrt(1 + (step.h * speed / 2) ** 2), 1.0)(step)


def differences(epsilon: float, centred: bool) -> Callable[[Step], FloatArray]:
    """MuJoCo's own, with ε too large."""

    def made(step: Step) -> FloatArray:
        model, data = step.session.model, step.session.data
        A = np.zeros((2 * model.nv, 2 * model.nv))
        mujoco.mjd_transitionFD(model, data, epsilon, centred, A, None, None, None)
        kept = step.session.turning
        kept = np.concatenate([kept, kept + model.nv])
        return A[np.ix_(kept, kept)]

    return made


def always(_: Scenario) -> bool:
    return True


def on_no_table(scenario: Scenario) -> bool:
    return scenario.constraint.is_free or scenario.constraint.is_pivot


def on_a_pivot_with_weight(scenario: Scenario) -> bool:
    return scenario.constraint.is_pivot and "gravity" in scenario.called_for


#: By name: the mistake, words of the reason, and scenes on which it is another derivative.
FAULTS: dict[str, tuple[Callable[[Step], FloatArray], str, Callable[[Scenario], bool]]] = {
    "transposed": (lambda step: step.jacobian.T, "transposed", always),
    "inverse": (lambda step: np.linalg.inv(step.jacobian), "inverse", always),
    "zero": (lambda step: 0 * step.jacobian, "it is zero", always),
    "identity": (lambda step: np.eye(6), "identity", always),
    "NaN": (lambda step: step.jacobian * np.nan, "not finite", always),
    "seven numbers": (lambda step: np.eye(7), "four numbers", always),
    "half angles": (scaled(0.5, 2.0), "half of the angle, in its rows and columns", always),
    "half angles in rows": (scaled(0.5, 1.0), "half of the angle, in its rows", always),
    "half angles in columns": (scaled(1.0, 2.0), "half of the angle, in its columns", always),
    "detached quaternion": (scaled(1.0, 0.0), "attitude is detached: its columns", always),
    "detached attitude rows": (scaled(0.0, 1.0), "attitude is detached: its rows", always),
    "attitude in world axes": (in_world(True, False), "the attitude is in world axes", always),
    "ω in world axes": (in_world(False, True), "ω is in world axes", always),
    "world axes": (in_world(True, True), "attitude and ω are in world axes", always),
    "axes exchanged": (kept([1, 0, 2, 4, 3, 5]), "axes are exchanged", always),
    "ω first": (kept([3, 4, 5, 0, 1, 2]), "ω comes first", always),
    "gyroscopic torque": (gyroscopic, "gyroscopic torque is not", on_no_table),
    "half of the gyroscopic torque": (half_gyroscopic, "the factor I ω", on_no_table),
    "gravity": (gravity, "gravity is not differentiated", on_a_pivot_with_weight),
    "axes that stay": (axes_that_stay, "lacks the turn", always),
    "ε forward": (differences(0.1, False), "ε of forward differences", on_a_pivot_with_weight),
    "ε centred": (differences(0.3, True), "ε of central differences", on_a_pivot_with_weight),
    "not normalised": (unnormalised, "not normalised", always),
}


@each_case("scene", list(map(library_scene, SCENES)))
def test_a_planted_fault_is_named(monkeypatch: pytest.MonkeyPatch, scene: Scenario) -> None:
    """All are planted at once, as derivatives of one step by so many names."""
    there = {name: fault for name, fault in FAULTS.items() if fault[-1](scene)}

    def planted(session: MuJoCoSession) -> dict[str, Derivative]:
        centred = HONEST(session)["mjd_transitionFD, centred"]

        def by(mistake: Callable[[Step], FloatArray]) -> Derivative:
            return replace(
                centred, compute=lambda: mistake(Step(session, scene, centred.compute()))
            )

        return {name: by(mistake) for name, (mistake, *_) in there.items()}

    with monkeypatch.context() as patch:
        patch.setattr(MuJoCoSession, "derivatives", planted)
        *rows, _ = gradients_of(scene, MUJOCO, "Euler", window=ONE_STEP)
    assert [row.derivative for row in rows] == [*there]
    reasons = {row.derivative: row.judged.reason for row in rows}
    assert {name: r for name, r in reasons.items() if there[name][1] not in r} == {}


def test_the_page_lists_what_is_planted_and_of_how_many_scenes() -> None:
    page = PAGE.read_text(encoding="utf-8")
    scenes = list(map(library_scene, SCENES))
    lines = [
        f"| {name} | {words} | {sum(map(applies, scenes))} |"
        for name, (_, words, applies) in FAULTS.items()
    ]
    lines += [f"| a tape: {name} | {words} | 1 |" for name, (_, _, words) in TAPES.items() if words]
    assert [line for line in lines if line not in page] == []


@each_case(
    ("engine", "scenes"),
    [
        *((name, FEW) for name in ("mujoco", "pin", "drake")),
        # JAX compiles each derivative for a minute.
        ("mjx", SCENES[3:4]),
        ("brax", SCENES[:1]),
    ],
)
def test_honest_derivatives_are_not_accused(engine: str, scenes: tuple[str, ...]) -> None:
    """But for what `OUT_OF_REACH` names: that is refused, with a reason."""
    if engine not in engines():
        pytest.skip(f"{engine} is not installed")
    accused: dict[str, str] = {}
    for scene in map(library_scene, scenes):
        methods = [
            method.name
            for method in engines()[engine].methods_for(scene)
            if not (method.as_shipped or method.name.startswith("contact"))
        ]
        # Of the others on one scene: what is differentiated is the same plant, stepped otherwise.
        for method in methods if scene.name == FEW[0] else methods[:1]:
            rows = [
                row
                for name in (OF_MJX if engine == "mjx" else (None,))
                for row in gradients_of(
                    scene, engines()[engine], method, window=WINDOW, derivative=name
                )
            ]
            assert engine == "mjx" or rows[-1].derivative == OURS
            for row in rows:
                is_refused = row.judged.verdict == "unsupported" and any(
                    words in row.judged.reason for words in OUT_OF_REACH
                )
                is_right = row.judged.verdict == "converges" and not row.judged.reason
                if not (is_refused or is_right) or row.judged.is_own is False:
                    accused[f"{scene.name} {method} {row.derivative}"] = row.judged.reason
    assert not accused


@each_case(
    ("method", "verdict", "words"),
    [
        ("featherstone", "converges", ""),
        ("mujoco-euler", "disagrees", "it is zero: nothing is differentiated"),
        ("steel", "unsupported", "SolverSteel does not support gradients"),
    ],
)
def test_newtons_tape_is_judged_by_its_solver(method: str, verdict: str, words: str) -> None:
    newton = installed("newton")
    row = gradients_of(library_scene("fast-top"), newton, method)[0]
    assert (row.derivative, row.judged.verdict) == ("Warp's tape", verdict)
    assert words in row.judged.reason
    assert row.judged.is_own in ((True,) if verdict == "converges" else (False, None))


def raising(error: Exception) -> Callable[..., FloatArray]:
    """A derivative that cannot be had, or all of a session."""

    def compute(*_: MuJoCoSession) -> FloatArray:
        raise error

    return compute


#: By what a derivative raises or returns: the verdict, and words of the reason.
BAD: dict[str, tuple[Callable[[], object], str, str]] = {
    "out of memory": (
        raising(MemoryError("RESOURCE_EXHAUSTED: out of memory")),
        "failed",
        "MemoryError: RESOURCE_EXHAUSTED: out of memory",
    ),
    "out of memory, without a word": (raising(MemoryError()), "failed", "MemoryError"),
    "an engine's error": (
        raising(EngineError("its solver did not end")),
        "failed",
        "its solver did not end",
    ),
    "a bug": (raising(KeyError("qpos")), "failed", "KeyError: 'qpos'"),
    "a long message": (raising(RuntimeError("a\n" * 999)), "failed", "RuntimeError: a a a"),
    "not for this method": (
        raising(UnsupportedError("no derivatives of RK4")),
        "unsupported",
        "no derivatives of RK4",
    ),
    "words": (lambda: "a Jacobian", "failed", "could not convert string to float: 'a Jacobian'"),
    "nothing": (lambda: None, "disagrees", "its shape is ()"),
    "twelve numbers": (lambda: np.eye(12), "disagrees", "its shape is (12, 12), not (6, 6)"),
    "one number": (lambda: 1.0, "disagrees", "its shape is (), not (6, 6)"),
    "infinite": (lambda: np.full((6, 6), np.inf), "disagrees", "not finite from 40 of 40 states"),
    "huge": (lambda: np.full((6, 6), 1e30), "disagrees", "off by"),
}


def test_a_derivative_that_is_not_offered_any_more_is_a_row_that_says_so() -> None:
    (row,) = gradients_of(library_scene("fast-top"), MUJOCO, "Euler", derivative="of yesterday")
    assert row.judged.verdict == "failed"
    assert row.judged.reason == "it does not offer 'of yesterday' any more"


def test_a_derivative_that_cannot_be_had_is_a_row_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One row of one line for each, and all others as they are."""
    planted = {name: Derivative(compute) for name, (compute, _, _) in BAD.items()}  # type: ignore[arg-type]
    monkeypatch.setattr(MuJoCoSession, "derivatives", lambda _: planted)
    *rows, ours = gradients_of(library_scene("fast-top"), MUJOCO, "Euler")
    assert [row.derivative for row in rows] == list(BAD)
    wrong = {
        row.derivative: f"{row.judged.verdict}: {row.judged.reason}"
        for row, (_, verdict, words) in zip(rows, BAD.values(), strict=True)
        if row.judged.verdict != verdict
        or words not in row.judged.reason
        or "\n" in row.judged.reason
        or len(row.judged.reason) > 300
    }
    assert not wrong
    assert (ours.derivative, ours.judged.verdict) == (OURS, "converges")


@each_case(
    ("given", "verdict", "words"),
    [
        (raising(KeyError("qpos")), "failed", "KeyError: 'qpos'"),
        (raising(UnsupportedError("none of RK4")), "unsupported", "none of RK4"),
        (lambda _: {"mine": np.eye(6)}, "failed", "'mine' must be a Derivative, got array("),
        (lambda _: None, "failed", "AttributeError: 'NoneType' object has no attribute 'items'"),
    ],
)
def test_an_engine_that_fails_to_give_derivatives_is_not_spinchecks_failure(
    given: Callable[[MuJoCoSession], object], verdict: str, words: str
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MuJoCoSession, "derivatives", given)
        theirs, ours = gradients_of(library_scene("fast-top"), MUJOCO, "Euler", window=ONE_STEP)
    assert (theirs.derivative, theirs.judged.verdict) == (THEIRS, verdict)
    assert theirs.judged.reason.startswith(words)
    assert (ours.derivative, ours.judged.verdict) == (OURS, "converges")


def test_a_derivative_that_changes_the_state_of_the_session_is_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def planted(session: MuJoCoSession) -> dict[str, Derivative]:
        one = HONEST(session)["mjd_transitionFD, centred"]

        def through(steps: int) -> FloatArray:
            jacobian = np.eye(6)
            for _ in range(steps):
                jacobian = one.compute() @ jacobian
                session.advance(1)
            return jacobian

        return {"stepping": replace(one, compute=lambda: through(1), through=through)}

    monkeypatch.setattr(MuJoCoSession, "derivatives", planted)
    *rows, ours = gradients_of(library_scene("fast-top"), MUJOCO, "Euler", window=ONE_STEP)
    assert [row.derivative for row in rows] == ["stepping", "stepping, through 8 steps"]
    words = "computing it changes the state of the session"
    assert {(row.judged.verdict, row.judged.reason) for row in rows} == {("disagrees", words)}
    assert ours.judged.verdict == "converges"


def test_a_derivative_that_hangs_or_crashes_is_a_row_and_the_others_are_judged() -> None:
    of = library_scene("t-handle"), planted(DerivativesSession), METHOD.name
    with LocalWorkers(1, time_limit=LIMIT) as executor:
        rows = [gradient_by(executor, *of, name) for name in offered_by(executor, *of)]
    found = {row.derivative: (row.judged.verdict, row.judged.reason) for row in rows}
    assert found["without end"][0] == found["crash"][0] == "failed"
    assert f"did not finish within {LIMIT:g} s" in found["without end"][1]
    assert "SIGSEGV" in found["crash"][1]
    assert found["identity"] == ("disagrees", "it is the identity: the step is detached")
    assert found[OURS] == ("converges", "")
    assert all(row.seconds > 0 for row in rows)


def test_states_whose_derivative_is_not_finite_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a norm that is differentiated at zero."""
    honest, asked = MuJoCoSession.derivatives, iter(range(10**6))

    def mostly(session: MuJoCoSession) -> dict[str, Derivative]:
        one = honest(session)["mjd_transitionFD, centred"]
        return {"nan": Derivative(lambda: one.compute() * (1.0 if next(asked) else np.nan), 1e-6)}

    monkeypatch.setattr(MuJoCoSession, "derivatives", mostly)
    one = gradients_of(library_scene("fast-top"), MUJOCO, "Euler")[0].judged
    assert (one.verdict, one.reason) == ("disagrees", "it is not finite from 1 of 40 states")


def test_differences_of_whole_runs_are_the_derivative_of_the_engines_steps() -> None:
    """Also where the motion multiplies a change of the start by ten thousand."""
    rows = gradients_of(library_scene("middle-axis-exactly"), MUJOCO, "Euler")
    (_, centred, ours) = (row.window[-1] for row in rows)
    assert centred.conditioning > 1e3
    assert abs(ours.error - centred.error) < 0.01 * centred.error


def test_the_window_may_be_given() -> None:
    """Its last gradient is after the nearest number of steps."""
    of = library_scene("fast-top"), MUJOCO, "Euler"
    (row,) = gradients_of(*of, timestep=1e-3, window=0.1, derivative=OURS)
    assert [round(one.t / 1e-3) for one in row.window] == [1, 2, 4, 8, 16, 32, 64, 100]


def test_a_windows_gradient_is_off_by_the_error_of_its_steps() -> None:
    """Of first order: half the error with half the timestep, at the same time."""
    scene, errors = library_scene("fast-top"), []
    for h in (1e-3, 5e-4):
        row = gradients_of(scene, MUJOCO, "Euler", h)[0]
        errors.append({round(one.t / 1e-3): one.error for one in row.window})
    shared = [errors[0][steps] / errors[1][steps] for steps in (16, 32, 64)]
    assert np.allclose(shared, 2.0, rtol=0.1), shared


#: Steps that a tape through so many is of, what becomes of its Jacobian, and words of the reason.
TAPES: dict[str, tuple[Callable[[int], range], Callable[[int, FloatArray], FloatArray], str]] = {
    "honest": (range, lambda _, J: J, ""),
    "half": (lambda n: range(n // 2), lambda _, J: J, "the tape is cut: it is of 4 of 8 steps"),
    "zero": (range, lambda _, J: 0 * J, "it is zero: nothing is differentiated"),
    "not finite": (range, lambda _, J: np.nan * J, "it is not finite"),
    "none": (lambda _: range(0), lambda _, J: J, "it is the identity"),
    "32 at most": (lambda n: range(min(n, 32)), lambda _, J: J, "cut: it is of the first 32"),
    "the last 32": (
        lambda n: range(max(n - 32, 0), n),
        lambda _, J: J,
        "cut: it is of the last 32",
    ),
    "zero if long": (range, lambda n, J: J * (n < 9), "over 64 steps it is zero"),
    "NaN if long": (
        range,
        lambda n, J: J * (1.0 if n < 9 else np.nan),
        "64 steps it is not finite",
    ),
    "another if long": (
        range,
        lambda n, J: J * (1.0 if n < 9 else 1.01),
        "64 steps it is not the product",
    ),
}


def test_a_tape_through_many_steps_is_right_or_the_fault_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All are planted at once, as derivatives by so many names."""

    def planted(session: MuJoCoSession) -> dict[str, Derivative]:
        one = HONEST(session)["mjd_transitionFD, centred"]

        def through(name: str, steps: int) -> FloatArray:
            kept, after, _ = TAPES[name]
            before, jacobian = session.read_state(), np.eye(6)
            for step in range(steps):
                if step in kept(steps):
                    jacobian = one.compute() @ jacobian
                session.advance(1)
            session.restart(before)
            return after(steps, jacobian)

        return {name: replace(one, through=partial(through, name)) for name in TAPES}

    monkeypatch.setattr(MuJoCoSession, "derivatives", planted)
    *rows, _ = gradients_of(library_scene("fast-top"), MUJOCO, "Euler", window=ONE_STEP)
    single, many = rows[: len(TAPES)], rows[len(TAPES) :]
    assert {(row.judged.verdict, row.judged.reason) for row in single} == {("converges", "")}
    assert [row.derivative for row in many] == [f"{name}, through 8 steps" for name in TAPES]
    wrong = {}
    for (name, (_, _, words)), row in zip(TAPES.items(), many, strict=True):
        found = row.judged
        is_told = found.reason or found.verdict != "converges" or found.is_own is False
        if words not in found.reason or bool(is_told) != bool(words):
            wrong[name] = f"{found.verdict}: {found.reason}"
    assert not wrong


def test_steps_of_a_body_that_a_constraint_holds_are_judged_after_they_settled() -> None:
    of = library_scene("fast-top"), installed("pybullet"), "multibody-p2p"
    (row,) = gradients_of(*of, window=0.1)
    assert (row.derivative, row.judged.verdict, row.judged.order) == (OURS, "converges", 1)
    assert row.window[-1].cosine > 0.9


@each_case(
    ("errors", "wanted"),
    {
        "never": ([0.1, 2.0, 0.5], None),
        "from the second on": ([0.1, 2.0, 3.0], 2.0),
        "always": ([1.0, 2.0, 3.0], 1.0),
    },
)
def test_the_time_from_which_gradients_mean_nothing(
    errors: list[float], wanted: float | None
) -> None:
    along = tuple(Gradient(t, e, 0.0, e, 1.0) for t, e in zip((1.0, 2.0, 3.0), errors, strict=True))
    assert useless_from(along) == wanted
