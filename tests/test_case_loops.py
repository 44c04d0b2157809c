"""A loop over cases in one test reports every case that fails, and no other."""

import pytest
from case_loops import each_case


def test_every_failing_case_is_reported_by_name() -> None:
    @each_case(("a", "b"), {"w": (1, 1), "x": (1, 2), "y": (2, 2), "z": (3, 4)})
    def equal(a: int, b: int) -> None:
        assert a == b

    with pytest.raises(BaseExceptionGroup, match="2 of 4 cases") as raised:
        equal()
    assert [error.__notes__ for error in raised.value.exceptions] == [["case: x"], ["case: z"]]


@each_case("skips", [False, True])
def test_a_case_may_be_skipped(skips: bool, tmp_path) -> None:
    assert tmp_path.is_dir()
    if skips:
        pytest.skip("this one")


def test_nothing_but_skips_is_a_skip() -> None:
    @each_case("k", range(3))
    def never(k: int) -> None:
        pytest.skip("none")

    with pytest.raises(pytest.skip.Exception, match="none"):
        never()


def test_no_case_at_all_is_noticed() -> None:
    with pytest.raises(AssertionError):
        each_case("k", [])(lambda k: None)
