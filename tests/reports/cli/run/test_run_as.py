"""What 'run --as' prints: what is wrong first, with the largest numbers and what to do."""

from spincheck.reports.cli.run.encodings import encoding_lines
from spincheck.reports.results.encoding_records import EncodedRun, EncodedRuns, EncodingWord
from spincheck.reports.results.records import Key
from spincheck.scenarios import SIGNALS, Errors


def apart(size: float) -> Errors:
    return Errors(*[size] * len(SIGNALS))


def runs(method: str, *each: EncodedRun) -> EncodedRuns:
    return EncodedRuns(Key("top", "mujoco", method), "4", 2e-3, each)


def run(encoding: str, word: EncodingWord, size: float) -> EncodedRun:
    return EncodedRun(encoding, word, f"off by {size:g}", apart=apart(size))


def test_the_method_that_is_furthest_off_gives_the_numbers_and_is_named() -> None:
    lines = list(
        encoding_lines(
            [runs("Euler", run("split", "differs", 0.1)), runs("RK4", run("split", "differs", 0.3))]
        )
    )
    assert lines[-1] == (
        "  mujoco Euler, RK4, split: another motion at any timestep: off by 0.3; most with RK4"
    )


def test_what_is_wrong_comes_before_what_is_coarser_and_says_what_to_do() -> None:
    coarser, wrong = run("offset", "coarser", 0.5), run("split", "other body", 0.1)
    heading, advice, *lines = encoding_lines([runs("RK4", coarser, wrong)])
    assert heading.endswith("0 of 2 runs are the same to round-off, 1 wrong")
    assert (
        advice == "  Describe the body as the scene does, or take a method that is not wrong below."
    )
    assert [line.split(",")[1].split(":")[0].strip() for line in lines] == ["split", "offset"]


def test_where_nothing_is_wrong_there_is_nothing_to_do() -> None:
    lines = list(encoding_lines([runs("RK4", run("offset", "coarser", 0.5))]))
    assert len(lines) == 2
