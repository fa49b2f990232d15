"""Reading errors: the file, the field, the cure."""

from __future__ import annotations

from pathlib import Path

import pytest

from core.simulation.effects.chains import SIX_AXIS, item, shoes_with
from core.simulation.worlds import REALITIES
from shoecal_core.errors import FileError
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.sampled_robot import draw_shoes


def shoes(tmp_path: Path, listed: str, shoe: Shoe) -> None:
    """Draw shoes with one effect, as its item of a reality file says."""
    file = tmp_path / "mine.yaml"
    file.write_text(f"format: 1\nname: mine\neffects:\n  - {{{listed}}}\n")
    draw_shoes(load_reality(REALITIES / "default.yaml", file), shoe, 1)


@pytest.mark.parametrize(
    ("listed", "message"),
    [
        ("effect: nonlinearity, location: [left/front_left]", "quadratic_per_n: is missing"),
        ("effect: nonlinearity, location: [left], cubic_per_n2: 0", "'left' is no channel"),
        ("effect: nonlinearity, location: [a/b], cubic_per_n2: 0", "no channel 'a/b' .there are"),
        ("effect: nonlinearity, location: left, cubic_per_n2: 0", "expected a list of names"),
        ("effect: saturation, location: [left/front_left], level_n: 0", "level_n: must be above 0"),
        ("effect: saturation, location: [], level_n: 9", "location: names nothing"),
        ("effect: hysteresis, location: [left], fraction: 2", "fraction: must be at least -0.5"),
        ("effect: hysteresis, location: [nose], fraction: 0.1", "there is no channel 'nose'"),
        ("effect: creep, location: [left], fraction: 0.1", "time_s: is missing"),
        ("effect: creep, location: [left, left], fraction: 0.1, time_s: 9", "names one twice"),
        ("effect: zero_drift, location: [all]", "rate_n_per_s: is missing"),
        ("effect: zero_drift, location: [all], rate_per_s: 1", "rate_per_s: unknown key; did you"),
        ("effect: span_drift, location: [all]", "rate_per_s: is missing"),
        ("effect: stuck_cell, location: [left/front_left], time_s: 0", "share: is missing"),
        ("effect: swapped_cells, location: [left/front_left]", "must name 2 channels, got 1"),
        ("effect: crosstalk, location: [left/front_left], fraction: 0.1", "must name 2 channels"),
        ("effect: cell_position, location: [left/front_left], x_m: 0.001", "y_m: is missing"),
        ("effect: off_axis_load, location: [left/front_left], x: 0, y: 0", "is not one of: left"),
        ("effect: low_pass, location: [left], time_s: 0", "time_s: must be above 0"),
        ("effect: low_pass, location: [left], time_s: soon", "time_s: expected a number"),
    ],
)  # fmt: skip
def test_a_wrong_item_is_one_clear_error(tmp_path: Path, listed: str, message: str) -> None:
    with pytest.raises(FileError, match=rf"mine\.yaml: effects\[0\]\..*{message}"):
        shoes(tmp_path, listed, shoes_with().shoe)


@pytest.mark.parametrize(
    ("listed", "message"),
    [
        ("effect: nonlinearity, location: [left/mx], cubic_per_n2: 0", "'left/mx' reads a torque"),
        ("effect: saturation, location: [left/my], level_n: 9", "'left/my' reads a torque"),
        ("effect: zero_drift, location: [left/my], rate_n_per_s: 9", "'left/my' reads a torque"),
        ("effect: crosstalk, location: [left/fz, left/mx], fraction: 0.1", "reads a torque"),
        ("effect: swapped_cells, location: [left/fz, left/mx]", "names a force and a torque"),
        ("effect: cell_position, location: [left/fz], x_m: 0, y_m: 0", "needs a one-axis cell"),
    ],
)
def test_what_makes_no_sense_in_a_six_axis_sensor_is_said(
    tmp_path: Path, listed: str, message: str
) -> None:
    with pytest.raises(FileError, match=rf"mine\.yaml: effects\[0\]\.location: .*{message}"):
        shoes(tmp_path, listed, SIX_AXIS)


def test_an_axis_of_a_six_axis_sensor_takes_what_a_cell_takes() -> None:
    effects = (
        item("nonlinearity", "left/fz", quadratic_per_n=1e-4),
        item("hysteresis", "left", fraction=0.01),
        item("creep", "left/my", fraction=0.01, time_s=5.0),
        item("span_drift", "all", rate_per_s=1e-5),
        item("stuck_cell", "right/mx", share=1.0, time_s=0.0),
        item("swapped_cells", "left/mx", "left/my"),
        item("crosstalk", "left/fz", "left/fx", fraction=0.1),
        item("off_axis_load", "right", x=0.1, y=0.1),
        item("low_pass", "right", time_s=0.02),
    )
    assert len(shoes_with(*effects, shoe=SIX_AXIS).stages) == len(effects)
