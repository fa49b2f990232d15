"""What a manual calibration tells the joint fit: rows that are zero at the truth, and linear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.as_built import plates_column
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.estimation.known import KnownShoe, Since
from shoecal_core.estimation.known_shoe import known_shoe
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workspace import config_dir

WEIGHT = 53.0
RANGE = np.array([[-0.02, -0.01], [0.06, 0.02]])


@pytest.fixture(scope="module")
def shoe() -> Shoe:
    return load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")


def deviations(shoe: Shoe) -> list[Deviation]:
    """Plates of both shoes, and one that the shoe's channels do not follow."""
    nothing = np.zeros((0, 0))
    found = [
        Deviation(
            "plates", (side,), axis, "", 0.1, nothing, shoe_column=plates_column(shoe, side, axis)
        )
        for side in FEET
        for axis in ("x", "y")
    ]
    return [*found, Deviation("joint_offset", ("LKneePitch",), "angle", "rad", 0.004, nothing)]


def manual(shoe: Shoe, parameters: ChannelParameters) -> Sensing:
    """Of shoes that carry where `shoe` says; the correction changes nothing, and was trained."""
    corrections = []
    for foot in (0, 1):
        size = 4 + len(shoe.of_foot(foot))
        span = np.zeros((2, size - 4))
        corrections.append(CopCorrection(foot, np.zeros(size), np.zeros(size), RANGE, span))
    return Sensing(shoe, parameters, tuple(corrections))


def rows(
    known: KnownShoe, shoe: Shoe, parameters: ChannelParameters
) -> tuple[FloatArray, FloatArray, FloatArray]:
    return known.rows(shoe, parameters, deviations(shoe))


def test_nothing_is_left_at_the_truth(shoe: Shoe) -> None:
    parameters = ChannelParameters(np.linspace(8.0, 12.0, 8), np.linspace(-3.0, 3.0, 8))
    known = known_shoe(shoe, manual(shoe, parameters), None, WEIGHT)
    _, _, target = rows(known, shoe, parameters)
    np.testing.assert_allclose(target, 0.0, atol=1e-9)


def test_rows_find_the_plates_that_the_manual_calibration_knows(shoe: Shoe) -> None:
    parameters = ChannelParameters(np.full(8, 10.0), np.zeros(8))
    true = np.array([0.02, -0.01, 0.015, 0.005, 0.0])
    columns = shoe.columns + sum(
        size * one.shoe_column
        for size, one in zip(true, deviations(shoe), strict=True)
        if one.shoe_column is not None
    )
    known = known_shoe(shoe.with_columns(columns), manual(shoe, parameters), None, WEIGHT)
    # The outputs that the truth has under each load, and where its CoP is.
    truly = Sensing(shoe.with_columns(columns), parameters)
    measured = truly.measure(known.outputs / 10.0).cop
    known = replace(known, cop=measured[np.arange(len(known.foot)), known.foot])
    _, by_deviation, target = rows(known, shoe, parameters)
    found = np.linalg.lstsq(by_deviation, target, rcond=None)[0]
    np.testing.assert_allclose(found, true, atol=1e-4)


def test_gains_count_by_what_they_are_too_large(shoe: Shoe) -> None:
    parameters = ChannelParameters(np.full(8, 10.0), np.zeros(8))
    known = known_shoe(shoe, manual(shoe, parameters), np.diag(np.full(16, 0.01)), WEIGHT)
    larger = ChannelParameters(parameters.gain + 0.3, parameters.offset)
    by_parameters, _, target = rows(known, shoe, larger)
    found = np.linalg.lstsq(by_parameters[:16], target[:16], rcond=None)[0]
    np.testing.assert_allclose(found, np.repeat([0.3, 0.0], 8), atol=1e-12)


def test_each_hypothesis_allows_more(shoe: Shoe) -> None:
    parameters = ChannelParameters(np.full(8, 10.0), np.zeros(8))
    known = known_shoe(shoe, manual(shoe, parameters), np.diag(np.full(16, 0.01)), WEIGHT)
    stds = {since: np.sqrt(np.diag(known.under(since).now)) for since in Since}
    steady, zeros, changed = (stds[since] for since in Since)
    np.testing.assert_allclose(steady, 0.1, rtol=1e-3)
    np.testing.assert_allclose(zeros, np.repeat([0.1, np.hypot(0.1, 0.1 * WEIGHT)], 8), rtol=1e-3)
    np.testing.assert_allclose(changed[:8], np.hypot(0.1, 0.05))
    np.testing.assert_array_equal(changed[8:], zeros[8:])


def test_without_corrections_only_gains_and_offsets_are_known(shoe: Shoe) -> None:
    parameters = ChannelParameters(np.full(8, 10.0), np.zeros(8))
    known = known_shoe(shoe, Sensing(shoe, parameters), None, WEIGHT)
    by_parameters, by_deviation, target = rows(known, shoe, parameters)
    assert by_parameters.shape == (16, 16)
    assert by_deviation.shape == (16, 5)
    assert target.shape == (16,)
