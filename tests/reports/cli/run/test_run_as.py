"""What 'run --as' prints: what is wrong first, with the largest numbers and what to do."""

from spincheck.reports.cli.run.encodings import encoding_lines
from spincheck.reports.results.encoding_records import Beside, EncodingWord
from spincheck.reports.results.records import Key, Row, variation
from spincheck.scenarios import SIGNALS, Errors


def apart(size: float) -> Errors:
    return Errors(*[size] * len(SIGNALS))


def run(method: str, encoding: str, word: EncodingWord, size: float) -> Row:
    beside = Beside(word, f"off by {size:g}", apart(size))
    key, varied = Key("top", "mujoco", method), variation({"as": encoding})
    return Row(key, "4", 2e-3, "ok", beside=beside, variation=varied)


def test_the_method_that_is_furthest_off_gives_the_numbers_and_is_named() -> None:
    sizes = {"Euler": 0.1, "RK4": 0.3}
    made = [run(method, "split", "differs", size) for method, size in sizes.items()]
    *_, line = encoding_lines(made)
    wanted = "  mujoco Euler, RK4, split: another motion at any timestep: off by 0.3; most with RK4"
    assert line == wanted


def test_what_is_wrong_comes_before_what_is_coarser_and_says_what_to_do() -> None:
    coarser, wrong = run("RK4", "offset", "coarser", 0.5), run("RK4", "split", "other body", 0.1)
    heading, advice, *lines = encoding_lines([coarser, wrong])
    assert heading.endswith("0 of 2 runs are the same to round-off, 1 wrong")
    remedy = "Describe the body as the scene does, or take a method that is not wrong below."
    assert advice == f"  {remedy}"
    assert [line.split(",")[1].split(":")[0].strip() for line in lines] == ["split", "offset"]
    # Where nothing is wrong, there is nothing to do.
    assert len(list(encoding_lines([coarser]))) == 2
