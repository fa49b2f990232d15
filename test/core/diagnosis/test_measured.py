"""Zeros and weights that need no fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.test_six_axis import with_ankles
from shoecal_core.diagnosis.measured import MeasuredBefore, at_zeros, measure
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.estimation.weight import weigh
from shoecal_core.recording.session import Session
from shoecal_core.samples.zeros import Zero
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SETTINGS = DiagnosisSettings(rate_hz=2.0)
TRAIN, TEST = (1, 2, 3, 4, 5, 6), (7, 8)
SAMPLES = 40


def hanging(run: int, foot: int, law: ChannelParameters, output: float, shoe: Shoe) -> Zero:
    """A foot in the air, of which each channel of a vertical force shows so much [N]."""
    rng = np.random.default_rng(10 * run + foot)
    wanted = np.where(shoe.torque, 0.0, output)
    readings = (wanted - law.offset) / law.gain
    noise = 1e-3 * rng.normal(size=(SAMPLES, len(readings))) / np.abs(law.gain)
    return Zero(run, foot, np.zeros(SAMPLES, dtype=np.int64), readings + noise)


@pytest.fixture(scope="module")
def data(standard_session: Session) -> SessionData:
    return load_data(standard_session, (*TRAIN, *TEST))


def found(data: SessionData, workspace: Workspace, zeros: tuple[Zero, ...]) -> MeasuredBefore:
    return measure(
        data, workspace.signal_model.samples, zeros, TRAIN,
        workspace.signal_model.parameters, SETTINGS, weighs=True,
    )  # fmt: skip


def test_a_zero_that_moved_in_one_run(data: SessionData, workspace: Workspace) -> None:
    law, shoe = workspace.signal_model.parameters, data.shoe
    zeros = tuple(
        hanging(run, foot, law, 1.0 + 0.4 * (foot == 1 and run == 7), shoe)
        for run in (*TRAIN, *TEST)
        for foot in (0, 1)
    )
    told = found(data, workspace, zeros)
    (one,) = told.moved
    assert (one.run, one.foot) == (7, 1)
    assert one.offset == pytest.approx(0.4, abs=0.01)
    # Cells without data sheets do not tell a weight.
    assert told.heavier is None
    (cause,) = told.causes(workspace, workspace, SETTINGS)
    assert (cause.effect, cause.location, cause.run) == ("zero_offset", ("right",), 7)
    low, high = cause.size["offset"].ci95
    assert low < 0.4 < high


def test_zeros_that_stay_are_no_cause(data: SessionData, workspace: Workspace) -> None:
    zeros = tuple(
        hanging(run, 0, workspace.signal_model.parameters, 1.0 + 1e-3 * run, data.shoe)
        for run in TRAIN
    )
    assert not found(data, workspace, zeros)
    # Nor is one that has none to be compared with.
    assert not found(data, workspace, zeros[:1])


def test_readings_as_if_zeros_had_stayed(workspace: Workspace, data: SessionData) -> None:
    samples, law = workspace.signal_model.samples, workspace.signal_model.parameters
    zeros = [hanging(run, 0, law, 0.4 * (run == 7), data.shoe) for run in (*TRAIN, *TEST)]
    moved = law.outputs(at_zeros(samples, zeros, TRAIN).readings) - law.outputs(samples.readings)
    left = data.shoe.foot == 0
    np.testing.assert_allclose(moved[samples.run == 7][:, left], -0.4, atol=5e-3)
    np.testing.assert_allclose(moved[samples.run != 7][:, left], 0.0, atol=5e-3)
    assert not moved[:, ~left].any()


@pytest.mark.parametrize(("sheet", "weighs"), [(1.0, True), (1.05, True), (1.05, False)])
def test_data_sheets_tell_another_weight(
    standard_session: Session, tmp_path: Path, sheet: float, weighs: bool
) -> None:
    """Sensors that show a twentieth more than they feel, by their data sheets."""
    session = with_ankles(standard_session, tmp_path)
    data = load_data(session, (*TRAIN, *TEST))
    channels = tuple(
        replace(one, nominal_gain=sheet * (one.nominal_gain or 0.0)) for one in data.shoe.channels
    )
    shoe = replace(data.shoe, channels=channels)
    samples = replace(data, shoe=shoe).whole_samples(SETTINGS)
    count = len(channels)
    law = ChannelParameters(np.full(count, sheet), np.zeros(count))
    below = [plate.mass_below * 9.81 for plate in shoe.plates]
    zeros = tuple(hanging(run, foot, law, -below[foot], shoe) for run in TRAIN for foot in (0, 1))
    readings = {number: one.readings for number, one in data.recorded.items()}
    data = replace(data, shoe=shoe, weighed=weigh(shoe, readings, zeros))
    told = measure(data, samples, zeros, TRAIN, law, SETTINGS, weighs=weighs)
    assert bool(told) == (weighs and sheet > 1.0)
    if told:
        assert told.heavier is not None
        assert told.heavier.mass / samples.robot.mass == pytest.approx(1.05, abs=0.005)
        heavier = told.corrected(samples)
        np.testing.assert_allclose(heavier.force / samples.force, 1.05, atol=0.005)
        np.testing.assert_array_equal(heavier.cop, samples.cop)


def test_feet_in_the_air_show_their_zeros(data: SessionData) -> None:
    lifted = {run for run, one in data.runs.items() if one.info.motion.startswith("unload_")}
    assert lifted
    assert {zero.run for zero in data.zeros} == lifted
