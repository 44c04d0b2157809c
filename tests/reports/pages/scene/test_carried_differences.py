"""Arrays on a page come back to half a step, and smooth ones take little room."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from page import read_page
from spincheck.reports.pages.page_data import LARGEST, PageData, differenced
from spincheck.scenarios import FloatArray

STEP = 2.0**-13


def restored(values: FloatArray, folder: Path) -> FloatArray:
    """By way of a page, after another array."""
    packed = PageData()
    packed.add({"before": differenced(np.arange(7.0), 1.0)})
    number = packed.add({"values": differenced(values, STEP)})
    path = folder / "page.html"
    path.write_text(f'<script id="packed">{packed.encoded()}</script>', encoding="utf-8")
    page = read_page(path)
    return page.restored(page.packed[number]["values"])


@given(arrays(float, st.integers(1, 40), elements=st.floats(-1e6, 1e6) | st.just(np.nan)))
def test_values_come_back_to_half_a_step_and_gaps_stay(
    tmp_path_factory: pytest.TempPathFactory, values: FloatArray
) -> None:
    found = restored(values, tmp_path_factory.getbasetemp())
    np.testing.assert_array_equal(np.isnan(found), np.isnan(values))
    assert np.nanmax(np.abs(found - values), initial=0.0) <= 0.5 * STEP


def test_what_no_picture_shows_is_cut(tmp_path: Path) -> None:
    found = restored(np.array([1e300, -np.inf, 1.0]), tmp_path)
    np.testing.assert_array_equal(found, [LARGEST * STEP, -LARGEST * STEP, 1.0])


def test_a_smooth_line_takes_a_byte_a_sample() -> None:
    """24 samples a turn: fourth differences are (2 sin π/24)⁴ = 0.005 of the line."""
    wave = np.sin(2 * np.pi * np.arange(600) / 24)
    rounded = differenced(wave, STEP)
    assert rounded.order >= 3
    assert np.median(np.abs(rounded.values)) < 1 << 7
    assert np.median(np.abs(wave / STEP)) > 1 << 11
