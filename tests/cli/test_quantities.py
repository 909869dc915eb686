"""Lengths, times, percentages and resolutions as people type them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nephrite.cli import quantities
from nephrite.errors import ParameterError


@pytest.mark.parametrize(
    ("text", "millimetres"),
    [
        ("100mm", 100),
        ("2.5 cm", 25),
        ("0.1m", 100),
        ("4in", 101.6),
        (" .5MM ", 0.5),
        ("1e-3m", 1),
        (" 7 mm ", 7),
    ],
)
def test_lengths_are_read_in_millimetres(text: str, millimetres: float) -> None:
    assert quantities.length(text) == pytest.approx(millimetres, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("30s", 30), ("2m", 120), ("1m30s", 90), ("1h 2m 3s", 3723), ("0.5min", 30)],
)
def test_times_are_read_in_seconds(text: str, seconds: float) -> None:
    assert quantities.duration(text) == pytest.approx(seconds, rel=1e-12)


@pytest.mark.parametrize(("text", "fraction"), [("1%", 0.01), ("0.5 %", 0.005), ("150%", 1.5)])
def test_percentages_are_read_as_fractions(text: str, fraction: float) -> None:
    assert quantities.percentage(text) == pytest.approx(fraction, rel=1e-12)


@pytest.mark.parametrize("text", ["800x600", "800X600", " 800 x 600 ", "800×600"])
def test_resolutions_are_width_and_height(text: str) -> None:
    assert quantities.resolution(text) == (800, 600)


@pytest.mark.parametrize(
    ("read", "text", "says"),
    [
        (quantities.length, "100", "no unit"),
        (quantities.length, "100parsec", "unknown unit 'parsec'"),
        (quantities.length, "0mm", "more than nothing"),
        (quantities.length, "-5mm", "no length"),
        (quantities.length, "1e999m", "finite"),
        (quantities.length, "nan mm", "no length"),
        (quantities.length, "", "no length"),
        (quantities.duration, "30", "no unit"),
        (quantities.duration, "1m30", "no time"),
        (quantities.duration, "s", "no time"),
        (quantities.percentage, "1", "no percent sign"),
        (quantities.percentage, "inf%", "no positive percentage"),
        (quantities.percentage, "0%", "no positive percentage"),
        (quantities.percentage, "lots", "no positive percentage"),
        (quantities.resolution, "800", "like 800x600"),
        (quantities.resolution, "0x600", "between 1 and"),
        (quantities.resolution, "99999x1", "between 1 and"),
        (quantities.resolution, "-8x6", "like 800x600"),
    ],
)
def test_what_is_wrong_is_said(read, text: str, says: str) -> None:
    with pytest.raises(ParameterError, match=says):
        read(text)


@given(st.text(max_size=12))
def test_any_text_is_a_quantity_or_a_parameter_error(text: str) -> None:
    for read in (quantities.length, quantities.duration, quantities.percentage):
        try:
            value = read(text)
        except ParameterError:
            continue
        assert 0 < value < float("inf")


@given(st.floats(1e-6, 1e6), st.sampled_from(sorted(quantities.MILLIMETRES)))
def test_a_length_that_was_written_is_read_back(number: float, unit: str) -> None:
    assert quantities.length(f"{number!r}{unit}") == pytest.approx(number * quantities.MILLIMETRES[unit])
