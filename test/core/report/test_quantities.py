from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.estimation.series import Mae
from shoecal_core.report.quantities import (
    UNKNOWN,
    mean_error,
    number,
    quantity,
    size,
    true_minus,
    uncertain,
)


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ").replace("\N{MINUS SIGN}", "-")


@pytest.mark.parametrize(
    ("value", "uncertainty", "unit", "expected"),
    [
        (25.3131, 0.4218, "N/V", "25.31 ± 0.42 N/V"),
        (-0.000123456, 0.0000012, "N/count", "-0.0001235 ± 0.0000012 N/count"),
        (673.2, 49.1, "N", "673 ± 49 N"),
        (1234.0, 812.0, "N", "1234 ± 812 N"),
        (0.89, 0.0096, "1", "0.8900 ± 0.0096"),
        (0.57841, math.nan, "N", "0.5784 N"),
        (0.0, math.nan, "N", "0 N"),
        (3.0, 0.0, "N", "3.000 N"),
        (math.nan, 1.0, "N", UNKNOWN),
    ],
)
def test_two_digits_of_the_uncertainty(
    value: float, uncertainty: float, unit: str, expected: str
) -> None:
    assert plain(uncertain(value, uncertainty, unit)) == expected


def test_errors_in_their_unit() -> None:
    assert plain(mean_error(Mae(0.00272, 0.00109, 9), "mm", 1e3)) == "2.72 ± 1.09 mm"
    assert mean_error(Mae(math.nan, math.nan, 0), "mm", 1e3) == UNKNOWN


def test_zero_has_no_sign() -> None:
    assert number(-0.0004, 2) == "0.00"
    assert plain(quantity(-0.4, "deg", 1)) == "-0.4 deg"
    assert quantity(math.inf, "s") == UNKNOWN


def test_a_guess_has_two_digits_whatever_its_sign() -> None:
    assert [plain(size(value, "N")) for value in (11.353, -0.5284, 0.0, 1234.5)] == [
        "11 N", "-0.53 N", "0 N", "1234 N"
    ]  # fmt: skip


def test_only_negative_numbers_get_a_minus_sign() -> None:
    text = "dx -0.02 m (-30 deg), run-3, 2026-11-22, --test 4, low-pass, 1e-3"
    assert true_minus(text) == text.replace(" -0", " \N{MINUS SIGN}0").replace(
        "(-", "(\N{MINUS SIGN}"
    )


@given(
    value=st.floats(-1e6, 1e6),
    uncertainty=st.floats(1e-9, 1e6),
)
def test_the_shown_number_is_right_within_its_uncertainty(value: float, uncertainty: float) -> None:
    shown, spread = plain(uncertain(value, uncertainty, "1")).split(" ± ")
    assert float(shown) == pytest.approx(value, abs=max(0.06 * uncertainty, 0.51))
    assert float(spread) == pytest.approx(uncertainty, abs=max(0.06 * uncertainty, 0.51))
    if uncertainty < 1.0:
        assert float(shown) == pytest.approx(value, abs=0.06 * uncertainty)
