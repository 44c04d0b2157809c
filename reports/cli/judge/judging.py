"""The command `judge`: what it does, and what it prints."""

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import typer

from ....scenarios import SIGNAL, Scenario, did_you_mean, printable
from ...harness.convergence_study import ConvergenceStudy
from ...harness.recorded.files.read import read_recording
from ...harness.recorded.files.recording import RecordingError
from ...harness.recorded.files.text_formats import SETTINGS
from ...harness.recorded.judged import JudgedMotion, judged_motion
from ...harness.recorded.recorded_ladder import results_of, study_of_files, verdict_on_files
from ...results.verdicts import Verdict
from ..choosing import compile_first
from ..grouped import angle, number
from ..terminal import AGREES, DISAGREES, Complaint, as_complaint, table, written

#: Width at which sentences are wrapped, characters.
WIDTH = 80


@dataclass(frozen=True, eq=False)
class Judgement:
    """Recorded motions of a scene, compared with the exact one.

    Attributes
    ----------
    motions : each motion with its errors, by the path of its file
    order : order of accuracy of the method that made the motions
    beyond : a sentence for each error that is larger than the bound that the user gave
    """

    scenario: Scenario
    motions: dict[str, JudgedMotion]
    order: int
    beyond: list[str]

    @cached_property
    def study(self) -> ConvergenceStudy:
        """The convergence study in which each file is a run of one method at another timestep.

        Raises
        ------
        Complaint
            If the files cannot be runs of one method.
        """
        names = ", ".join(map(printable, self.motions))
        with as_complaint(RecordingError, before=f"{names}: "):
            return study_of_files(self.scenario, list(self.motions.values()), self.order)

    @cached_property
    def verdict(self) -> Verdict | None:
        """The verdict on several files; None for a single file."""
        return verdict_on_files(self.study) if len(self.motions) > 1 else None

    @property
    def exit_code(self) -> int:
        """The program's exit code: 1 if a motion is wrong or exceeds a bound of the user's, else 0.

        A motion is wrong if a common mistake explains its errors. A single motion is also wrong if
        its error is larger than that of a method of its order. Several motions are also wrong if
        they do not agree with the exact motion, by the verdict on them.
        """
        motions = self.motions.values()
        # Of several files, the verdict judges the size of errors, and not a file's `is_beyond`.
        alone = self.verdict is None
        explained = any(one.explained_by or (alone and one.is_beyond) for one in motions)
        wrong = self.verdict is not None and not self.verdict.agrees
        return DISAGREES if self.beyond or explained or wrong else AGREES


def judged_files(
    scenario: Scenario,
    files: Sequence[Path],
    quaternion: str | None,
    omega: str | None,
    timesteps: Sequence[float],
    bounds: Sequence[str],
    noise: Sequence[str],
    order: int,
) -> Judgement:
    """Read recorded motions from files and compare them with the exact motion.

    Parameters
    ----------
    quaternion : order of a quaternion's components, "wxyz" or "xyzw"; if None, that which a file
        states, or else "wxyz"
    omega : axes of ω, "body" or "world"; if None, those that a file states, or else "body"
    timesteps : timestep of each file, s; if empty, those that the files state, if they do
    bounds, noise : the values of '--fail-above' and '--noise', as typed: SIGNAL=SIZE
    order : order of accuracy of the method that made the motions

    Raises
    ------
    Complaint
        If an option cannot be used, or a file cannot be read or compared.
    """
    if timesteps and len(timesteps) != len(files):
        raise Complaint(
            f"'--timestep' must be given once for each file, got {len(timesteps)} for {len(files)}"
        )
    wanted = dict(_bound("--fail-above", bound) for bound in bounds)
    stated = _words(quaternion=quaternion, omega=omega) | _noise(noise)
    # Files are checked before the solver is compiled, which takes half a minute the first time.
    with as_complaint(RecordingError):
        recordings = [read_recording(file) for file in files]
    compile_first()
    motions = {}
    # The order of several files is left to the verdict; each file alone is judged as of order 1.
    claimed = order if len(files) == 1 else 1
    for file, recording, timestep in zip_longest(files, recordings, timesteps):
        made = {} if timestep is None else {"timestep": repr(timestep)}
        with as_complaint(RecordingError, before=f"{file}: "):
            recording = replace(recording, settings=recording.settings | stated | made)
            motions[str(file)] = judged_motion(scenario, recording, claimed)
    beyond = []
    for name, motion in motions.items():
        with as_complaint(RecordingError, before=f"{name}: "):
            beyond += [f"{name}: {sentence}" for sentence in motion.beyond(wanted)]
    return Judgement(scenario, motions, order, beyond)


def write_page(judgement: Judgement, folder: Path) -> Path:
    """Write a report whose runs are the recorded files, all of one method.

    Parameters
    ----------
    folder : the folder of the report

    Returns
    -------
    The path of the scene's page.

    Raises
    ------
    Complaint
        If the folder cannot be written, or the files cannot be runs of one method.
    """
    from ...pages.render import render

    words = [one.explained_by for one in judgement.motions.values() if one.explained_by]
    with written(folder):
        index = render(results_of(judgement.study, words[0] if words else ()), folder)
    return index.parent / "scenes" / f"{judgement.scenario.name}.html"


def _words(**options: str | None) -> dict[str, str]:
    """Return the options that were given, as settings that a recording's file would state.

    Parameters
    ----------
    options : values, which are words such as "wxyz", by the option's name; None if not given

    Raises
    ------
    Complaint
        If a value is not one of the option's words.
    """
    given = {name: value for name, value in options.items() if value is not None}
    for name, value in given.items():
        if value not in (known := SETTINGS[name] or ()):
            raise Complaint(f"'--{name}' must be {' or '.join(known)}, got '{value}'")
    return given


def _noise(stated: Sequence[str]) -> dict[str, str]:
    """Return the noise of attitude, rad, and ω, rad/s, as settings of a recording's file.

    A `Complaint` is raised for any other signal.

    Parameters
    ----------
    stated : values of '--noise', as typed
    """
    noise = dict(_bound("--noise", one) for one in stated)
    if others := noise.keys() - {"attitude", "omega"}:
        raise Complaint(f"'--noise' must be of attitude or omega, got '{others.pop()}'")
    return {f"noise_{name}": repr(size) for name, size in noise.items()}


def _bound(option: str, text: str) -> tuple[str, float]:
    """Return signal and size from the text SIGNAL=SIZE, the value of an option.

    The size of the attitude is in rad; any other size is the number as typed. A `Complaint` that
    names the option is raised for a text of another form, and for a negative or infinite size.
    """
    name, _, size = text.partition("=")
    if name not in SIGNAL:
        hint = did_you_mean(name, SIGNAL)
        known = ", ".join(SIGNAL)
        raise Complaint(f"'{option}' must begin with one of {known}, got '{name}'{hint}")
    try:
        bound = angle(size) if SIGNAL[name].unit else number(size)
    except typer.BadParameter:
        bound = -1.0
    if not 0 <= bound < float("inf"):
        raise Complaint(f"'{option}' must be SIGNAL=SIZE, such as {name}=1e-3, got '{text}'")
    return name, bound


def judgement_as_json(judgement: Judgement) -> dict[str, Any]:
    """Return a judgement as a JSON object.

    It has the scene's name, `scenario`; `files`, with the errors of each; `verdict` and `reason` on
    all files, null for a single one; and `beyond`, sentences on errors that exceed the bounds.
    """
    return {
        "scenario": judgement.scenario.name,
        "files": [
            {"file": name} | motion.as_record() for name, motion in judgement.motions.items()
        ],
        "verdict": judgement.verdict.verdict if judgement.verdict else None,
        "reason": judgement.verdict.reason if judgement.verdict else None,
        "beyond": judgement.beyond,
    }


def print_judgement(judgement: Judgement) -> None:
    """Print each file's errors and what explains them, the verdict, and the bounds exceeded."""
    for name, motion in judgement.motions.items():
        print("\n".join(_lines(name, motion)))
        table(_rows(motion))
    if verdict := judgement.verdict:
        print("\n".join(textwrap.wrap(f"{verdict.verdict}: {verdict.reason}", WIDTH)))
    for sentence in judgement.beyond:
        print(sentence)


def _lines(name: str, motion: JudgedMotion) -> Iterator[str]:
    """Yield the lines that are printed about one recorded motion, without its table of errors.

    `name` is the path of its file.
    """
    t = motion.recorded.trajectory.t
    yield f"{printable(name)}: {len(t)} samples from {t[0]:g} to {t[-1]:g} s"
    # Mistakes that explain the errors come first: they tell what to do about the motion.
    sentences = [f"Explained by: {words}." for words in motion.explained_by]
    sentences.append(f"{motion.verdict[0].upper()}{motion.verdict[1:]}.")
    if motion.made_by:
        sentences.append(f"It is {motion.made_by}.")
    if motion.measured:
        sentences.append(motion.measured.tensor_in_words())
    sentences += [f"{remark[0].upper()}{remark[1:]}." for remark in motion.remarks]
    if not motion.recorded.has_omega:
        sentences.append("ω was not recorded; L and energy are of ω found from the attitudes.")
    if motion.ignored:
        sentences.append(f"Columns that mean nothing here: {', '.join(motion.ignored)}.")
    when = motion.exceeds_1deg_at
    sentences.append(
        "The attitude is within 1° of the exact one throughout."
        if when is None
        else f"The attitude is off by more than 1° from t = {when:.4g} s on."
    )
    if motion.drifts:
        drifts = ", ".join(f"{name} {drift:.3g}" for name, drift in motion.drifts.items())
        sentences.append(f"Drift of what the motion conserves, relative: {drifts}.")
    for sentence in sentences:
        yield from textwrap.wrap(printable(sentence), WIDTH)


def _rows(motion: JudgedMotion) -> list[dict[str, object]]:
    """Return a table row, by headings, for each signal in which the motion has an error.

    It has the largest error, the median and largest defect, and the time of the latter.
    """
    rows: list[dict[str, object]] = []
    for name, error in motion.errors.items():
        signal, defect = SIGNAL[name], motion.defects.get(name)
        if error is not None:
            rows.append(
                {
                    "signal": f"{signal.label}, {signal.shown_unit}",
                    "largest error": error * signal.shown,
                    "defect, median": defect and defect.p50 * signal.shown,
                    "largest defect": defect and defect.max * signal.shown,
                    "at, s": defect and defect.at,
                }
            )
    return rows
