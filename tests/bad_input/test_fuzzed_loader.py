"""Random bytes: the loader returns a scenario or raises ScenarioError, in bounded time.

`HYPOTHESIS_PROFILE=long` tries a thousand times as many.
"""

import os
import time
import unicodedata

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutated_scenes import LEAST, Raw, changed, leaves, tables, written
from spincheck.scenarios import LIBRARY, Scenario, ScenarioError, is_scenario, load, loads
from spincheck.scenarios.read_text import MAX_BYTES

pytestmark = pytest.mark.slow

#: CPU s; what the largest file that is read may take, many times over.
SOON = 20.0

settings.register_profile(
    "short",
    max_examples=60,
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
settings.register_profile("long", settings.get_profile("short"), max_examples=60_000)
PROFILE = settings.get_profile(os.environ.get("HYPOTHESIS_PROFILE", "short"))

FILES = [path.read_bytes() for path in sorted(LIBRARY.rglob("*.toml"))]
PLACES = [leaf.keys for leaf in leaves()] + list(tables())
#: As they may stand in a file, right or wrong.
VALUES = st.recursive(
    st.one_of(
        st.floats().map(str),
        st.integers().map(str),
        st.sampled_from(["true", "1e400", "-0.0", "0x10", "1979-05-27", "{}", '"""\na"""', "nan"]),
        st.text(max_size=8).map(lambda text: f'"{text}"'),
    ),
    lambda inner: st.lists(inner, max_size=4).map(lambda rows: f"[{', '.join(rows)}]"),
    max_leaves=12,
)


@st.composite
def damaged(draw) -> bytes:
    """A file of the library with a few stretches cut out, doubled, or replaced."""
    content = draw(st.sampled_from(FILES))
    for _ in range(draw(st.integers(1, 4))):
        first, last = sorted(draw(st.tuples(*[st.integers(0, len(content))] * 2)))
        inserted = draw(st.one_of(st.binary(max_size=12), st.just(content[first:last])))
        content = content[:first] + inserted + content[draw(st.sampled_from([first, last])) :]
    return content


@st.composite
def derived(draw) -> bytes:
    """A document of the format's tables and keys with values that may be anything."""
    file = LEAST
    for keys, value in draw(st.lists(st.tuples(st.sampled_from(PLACES), VALUES), max_size=6)):
        try:
            file = changed(file, keys, Raw(value))
        except (AttributeError, KeyError, TypeError, IndexError):
            continue  # a key below one that holds no table any more
    return written(file).encode(errors="replace")


def is_scene(read, where: str) -> bool:
    """Whether it is one; if not, there must be a complaint."""
    began, complaint = time.process_time(), ""
    try:
        assert isinstance(read(), Scenario)
    except ScenarioError as error:
        complaint = str(error)
        for line in complaint.split("\n"):
            assert line.startswith(where)
            assert not any(unicodedata.category(c) == "Cc" for c in line)
    assert time.process_time() - began < SOON
    return not complaint


@PROFILE
@given(content=st.one_of(st.binary(), damaged(), derived()))
def test_any_bytes_are_a_scene_or_are_complained_of(tmp_path, content):
    path = tmp_path / "made.toml"
    path.write_bytes(content)
    is_scenario(path)
    is_scene(lambda: load(path), str(path))


@PROFILE
@given(text=st.text(), name=st.text(max_size=20))
def test_any_text_of_any_name_is_a_scene_or_is_complained_of(text, name):
    is_scene(lambda: loads(f"spincheck = 1\n{text}", name), "")


#: What parsers take the square of in time, or a frame of the stack each.
LARGE = {
    "arrays in arrays": "a = " + "[" * MAX_BYTES,
    "tables in tables": "a = " + "{a=" * (MAX_BYTES // 4),
    "a key of many parts": ".".join("a" * (MAX_BYTES // 2 - 20)) + " = 1",
    "a quoted key of many parts": ".".join(['" "'] * (MAX_BYTES // 5)) + " = 1",
    "a table of many parts": f"[{'.'.join('a' * (MAX_BYTES // 2 - 20))}]",
    "unknown keys": "".join(f"k{n} = 1\n" for n in range(MAX_BYTES // 12)),
    "tables": "".join(f"[t{n}]\n" for n in range(MAX_BYTES // 12)),
    "an array of tables": "[[published]]\n" * (MAX_BYTES // 15),
    "quotes": 'a = "' + '\\"' * (MAX_BYTES // 3),
    "a long number": "a = " + "1" * (MAX_BYTES - 100),
    "a long key": "a" * (MAX_BYTES - 100) + " = 1",
    "one long line": "# " + "x" * (MAX_BYTES - 100),
}


@pytest.mark.parametrize("more", LARGE.values(), ids=LARGE)
def test_the_largest_files_are_judged_soon(tmp_path, more):
    path = tmp_path / "made.toml"
    path.write_text(f"spincheck = 1\n{more}\n")
    assert not is_scene(lambda: load(path), str(path))


def test_as_many_particles_as_a_file_holds_are_summed_soon():
    row = "[1.0, 2.0, 3.0, 4.0], "
    rows = row * ((MAX_BYTES - 1000) // len(row))
    body = {"particles": Raw(f"[{rows} [1, 0, 0, 0], [1, 1, 0, 0]]")}
    assert is_scene(lambda: loads(written({**LEAST, "body": body}), "made"), "made")


def test_a_planted_leak_is_caught():
    """The teeth: another exception, and a complaint with an escape in it, fail the property."""

    def leaking():
        raise KeyError("x")

    def commanding():
        raise ScenarioError("made: \x1b[31m")

    with pytest.raises(KeyError):
        is_scene(leaking, "made")
    with pytest.raises(AssertionError):
        is_scene(commanding, "made")
