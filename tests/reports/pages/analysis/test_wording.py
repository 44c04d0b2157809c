"""Numbers as the report prints them, and Markdown in and out."""

import math

import pytest
from spincheck.reports.pages.analysis.wording import count, limited, number, observed
from spincheck.reports.pages.templating import code_block, escaped, to_html


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (0.0, "0"),
        (1.0, "1.00"),
        (123.456, "123"),
        (999.9, "1.00×10³"),
        (1234.5, "1.23×10³"),
        (0.0123456, "0.0123"),
        (0.00999, "9.99×10⁻³"),
        (-2.5e-17, "−2.50×10⁻¹⁷"),
        (math.inf, "∞"),
        (-math.inf, "−∞"),
        (math.nan, "undefined"),
        (None, "—"),
    ],
)
def test_numbers_have_three_digits(value: float | None, printed: str) -> None:
    assert number(value) == printed


def test_a_number_with_more_digits_than_asked_for_is_rounded() -> None:
    assert number(456.7, digits=2) == "460"


def test_values_to_be_compared_have_five() -> None:
    assert observed(1.234567) == "1.2346"


def test_thousands_are_apart() -> None:
    assert count(1048576) == "1\N{NARROW NO-BREAK SPACE}048\N{NARROW NO-BREAK SPACE}576"


def test_an_error_above_the_limit_is_printed() -> None:
    assert limited(3e-12, 1e-13) == "3.00×10⁻¹²"


@pytest.mark.parametrize("error", [0.0, 1e-16, 1e-13])
def test_an_error_at_or_below_the_limit_is_the_limit(error: float) -> None:
    assert limited(error, 1e-13) == "≤ 1.00×10⁻¹³"


def test_no_error_is_no_claim() -> None:
    assert limited(None, 1e-13) == "—"


def test_markdown_s_own_marks_work() -> None:
    assert to_html("**fast** and `code`") == "<p><strong>fast</strong> and <code>code</code></p>\n"


def test_escaped_text_reads_as_it_was_written() -> None:
    text = "a | b *c* _d_ `e` <f> & [g] # h"
    assert (
        to_html(escaped(text)).replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">")
        == f"<p>{text}</p>\n"
    )


def test_escaped_text_is_one_line() -> None:
    assert escaped("a\n\nb") == "a b"


def test_a_fence_is_longer_than_those_inside() -> None:
    assert code_block("x = '```'", "toml") == "````toml\nx = '```'\n````"
