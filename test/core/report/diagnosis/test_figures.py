from __future__ import annotations

import numpy as np
import pytest

from core.report.pages import read_svg
from core.robot import robots
from core.shoe import shoes
from shoecal_core.report.diagnosis.figures import residual_keys, rms_text, unit_of
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.figures.residual_field import (
    LONGEST_MM,
    LONGEST_OF_NOISE_MM,
    Field,
    FieldPanel,
    magnification,
    residual_fields,
)
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.palette import AFTER, BEFORE, PLAIN
from shoecal_core.report.quantities import percent

NOTHING = Field(np.empty((0, 2)), np.empty((0, 2)), np.empty(0))


def alt(svg: str) -> str:
    return read_svg(svg).get("aria-label", "")


def test_shares_are_told() -> None:
    told = alt(
        named_bars(
            [NamedBar("a", "46 %", 0.46, PLAIN, "kind"), NamedBar("b", "140 %", 1.4, PLAIN)],
            "Shares",
        )
    )
    assert told == "Shares: a 46 %; b 140 %."
    assert [percent(value) for value in (0.0, 0.001, 0.5, 0.999, 1.0)] == [
        "0 %", "< 1 %", "50 %", "> 99 %", "100 %",
    ]  # fmt: skip


def test_lines_by_run() -> None:
    time = np.linspace(0.0, 10.0, 50)
    before, after, unknown = np.full(50, 2.0), np.full(50, 0.5), np.full(50, np.nan)
    rows = [
        Strip("run 1", time, ((BEFORE, before), (AFTER, after)), -3.0, 3.0,
              rms_text([before, after]), band=(-0.2, 0.2), lifted=((3.0, 4.0),), onsets=(6.0,)),
        Strip("run 2 · test", time, ((BEFORE, unknown),), -3.0, 3.0, rms_text([unknown])),
    ]  # fmt: skip
    svg = strips(rows, residual_keys(rows), "each row: ±3 mm", "RMS (mm)")
    assert "run 1 2.0 → 0.50; run 2 · test –" in alt(svg)
    assert ">6.0 s<" in svg
    assert "one foot lifted" in svg
    alone = strips(rows[1:], residual_keys(rows[1:]), "each row: ±3 N", "RMS (N)")
    assert "with what was found" not in alone
    assert "something begins" not in alone


def test_arrows_have_one_round_scale_and_noise_stays_short() -> None:
    one = Field(np.zeros((9, 2)), np.full((9, 2), 2e-3), np.zeros(9))
    for noise in (0.0, 4e-4, 5e-3):
        times = magnification([one, NOTHING], noise)
        assert 2e-3 * np.sqrt(2.0) * times <= 1e-3 * LONGEST_MM
        assert noise * times <= 1e-3 * LONGEST_OF_NOISE_MM
        assert f"{times:.0e}"[0] in "125"
    assert magnification([NOTHING], 1e-3) == 1.0


def test_feet_with_and_without_arrows() -> None:
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    left, right = (foot_shape(robot, shoe, foot) for foot in (0, 1))
    some = Field(
        np.array([[0.01, 0.0], [0.03, 0.01]]), np.array([[1e-3, 0.0], [0.0, 2e-3]]),
        np.array([0.4, -0.2]),
    )  # fmt: skip
    both = FieldPanel((left,), some, "both", [right.outline])
    svg = residual_fields([both], BEFORE, 5.0)
    assert "both: 2 places, 1.50 mm on average, 2.00 mm at most" in alt(svg)
    assert "GRF off" not in svg
    soles = [
        FieldPanel((left,), some, "left", shares=[(left.cells[0], "46 %")]),
        FieldPanel((right,), NOTHING, "right"),
    ]
    svg = residual_fields(soles, BEFORE, 5.0, 0.4)
    assert ">46 %<" in svg
    assert "GRF off by 0.4 N" in svg
    assert "right: No sample." in alt(svg)


@pytest.mark.parametrize(
    ("name", "unit"),
    [("grf", "N"), ("cop_y", "mm"), ("air_f", "N"), ("air_mx", "N m"), ("closure_y", "mm"),
     ("closure_yaw", "°"), ("closure_pitch", "°"), ("parity_left", "N"), ("tilt_x", "°"),
     ("mine", "")],
)  # fmt: skip
def test_units_of_signals(name: str, unit: str) -> None:
    assert unit_of(name)[1] == unit
