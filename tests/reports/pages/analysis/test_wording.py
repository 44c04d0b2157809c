"""Numbers as the report prints them, and Markdown in and out."""

import math
from html import unescape

import pytest
from spincheck.reports.pages.analysis.wording import count, limited, number, observed
from spincheck.reports.pages.markdown import code_block, escaped
from spincheck.reports.pages.templating import to_html


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


def test_numbers_are_rounded_to_be_compared_and_counted() -> None:
    assert number(456.7, digits=2) == "460"
    assert observed(1.234567) == "1.2346"
    assert count(1048576) == "1\N{NARROW NO-BREAK SPACE}048\N{NARROW NO-BREAK SPACE}576"


@pytest.mark.parametrize(
    ("error", "printed"),
    [
        (3e-12, "3.00×10⁻¹²"),
        (1e-13, "≤ 1.00×10⁻¹³"),
        (1e-16, "≤ 1.00×10⁻¹³"),
        (0.0, "≤ 1.00×10⁻¹³"),
        (None, "—"),
    ],
)
def test_an_error_at_or_below_the_limit_is_the_limit(error: float | None, printed: str) -> None:
    assert limited(error, 1e-13) == printed


def test_markdown_s_own_marks_work_and_escaped_text_reads_as_it_was_written() -> None:
    assert to_html("**fast** and `code`") == "<p><strong>fast</strong> and <code>code</code></p>\n"
    text = "a | b *c* _d_ `e` <f> & [g] # h"
    assert unescape(to_html(escaped(text))) == f"<p>{text}</p>\n"
    assert escaped("a\n\nb") == "a b"
    # A fence is longer than those inside.
    assert code_block("x = '```'") == "````\nx = '```'\n````"
