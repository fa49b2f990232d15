"""Cells that get stuck are told by readings alone, and what they would have shown is put back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.rewritten import rewritten
from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.diagnose import Wanted, diagnose
from shoecal_core.diagnosis.stuck_cell import stuck_cell
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.effects.load_cell import StuckCell
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.samples.samples import Samples

STUCK = (StuckCell(),)


def stuck(
    samples: Samples, channel: int, time: float, share: float, end: float = np.inf
) -> Samples:
    """The session as it would be had a part of a cell's signal stayed from a moment to another."""
    first = samples.readings[np.argmin(np.abs(samples.clock - time)), channel]

    def held(readings: FloatArray, clock: FloatArray) -> FloatArray:
        shown = readings.copy()
        late = (clock >= time) & (clock < end)
        shown[late, channel] -= share * (readings[late, channel] - first)
        return shown

    tracks = tuple(
        replace(one, readings=held(one.readings, one.start + one.time)) for one in samples.tracks
    )
    return replace(samples, tracks=tracks, readings=held(samples.readings, samples.clock))


@pytest.mark.parametrize(("channel", "when", "share"), [(0, 0.3, 1.0), (6, 0.5, 0.8)])
def test_a_cell_that_gets_stuck_is_found_and_mended(
    workspace: Workspace, channel: int, when: float, share: float
) -> None:
    samples = workspace.signal_model.samples
    time = when * float(samples.clock.max())
    time += 0.1 + float(samples.clock[samples.clock >= time].min()) - time
    broken = stuck(samples, channel, time, share)
    found = stuck_cell(broken)
    assert found is not None
    assert found.channel == channel
    assert found.time == pytest.approx(time, abs=1.0)
    assert found.share == pytest.approx(share, abs=0.05)
    corrected = found.corrected(broken)
    late = samples.clock > time + 1.0
    away, was = (
        float(np.std((one.readings - samples.readings)[late, channel]))
        for one in (corrected, broken)
    )
    assert away < 0.1 * was
    others = np.arange(samples.readings.shape[1]) != channel
    np.testing.assert_array_equal(corrected.readings[:, others], samples.readings[:, others])
    for one, right in zip(corrected.tracks, samples.tracks, strict=True):
        assert np.std((one.readings - right.readings)[:, channel]) < was


def in_run(samples: Samples, run: int, second: float) -> float:
    """Time since the session began at a second of a run, from its end where it is negative."""
    (track,) = [one for one in samples.tracks if one.run == run]
    return float(track.start + (track.time[-1] + second if second < 0.0 else second))


@pytest.mark.parametrize(
    ("channel", "begins", "ends"),
    [
        (3, (2, 10.0), (2, 25.0)),
        (1, (4, -4.0), (5, 12.0)),
        (5, (7, 8.0), (8, 10.0)),
        (2, (8, -8.0), None),
        (6, (1, 0.0), (1, 15.0)),
        (0, (1, 0.0), (6, 5.0)),
    ],
)
def test_a_cell_may_be_stuck_for_a_while_in_any_run(
    workspace: Workspace,
    channel: int,
    begins: tuple[int, float],
    ends: tuple[int, float] | None,
) -> None:
    """In training runs and test runs, over their ends, and at the ends of the session."""
    samples = workspace.signal_model.samples
    time = in_run(samples, *begins)
    end = np.inf if ends is None else in_run(samples, *ends)
    broken = stuck(samples, channel, time, 1.0, end)
    found = stuck_cell(broken)
    assert found is not None
    assert found.channel == channel
    assert found.time == pytest.approx(time, abs=1.0)
    assert len(found.stretches) == 1
    assert found.stretches[0][1] == pytest.approx(end, abs=1.0)
    assert found.share == pytest.approx(1.0, abs=0.02)
    corrected = found.corrected(broken).readings[:, channel] - samples.readings[:, channel]
    away = broken.readings[:, channel] - samples.readings[:, channel]
    inside = (samples.clock > time + 1.0) & (samples.clock < end - 1.0)
    assert np.std(corrected[inside]) < 0.1 * np.std(away[inside])
    outside = (samples.clock < time - 1.0) | (samples.clock > end + 1.0)
    np.testing.assert_array_equal(corrected[outside], 0.0)


@pytest.mark.parametrize("living", [0.0, 8.0])
def test_a_cell_that_is_stuck_from_the_beginning_shows_what_the_weight_leaves(
    workspace: Workspace, living: float
) -> None:
    samples = workspace.signal_model.samples
    channel = 4
    broken = stuck(samples, channel, living, 1.0)
    found = stuck_cell(broken)
    assert found is not None
    assert found.channel == channel
    # A cell that hardly moves yet may as well be stuck already.
    assert living - 3.0 < found.time < living + 1.0
    assert found.share == 1.0
    corrected = found.corrected(broken).readings[:, channel]
    assert np.corrcoef(corrected, samples.readings[:, channel])[0, 1] > 0.99


def test_a_cell_that_reaches_its_end_is_not_stuck(workspace: Workspace) -> None:
    samples = workspace.signal_model.samples
    level = float(np.quantile(samples.readings[:, 0], 0.8))

    def cut(readings: FloatArray) -> FloatArray:
        shown = readings.copy()
        shown[:, 0] = np.minimum(shown[:, 0], level)
        return shown

    tracks = tuple(replace(one, readings=cut(one.readings)) for one in samples.tracks)
    assert stuck_cell(replace(samples, tracks=tracks, readings=cut(samples.readings))) is None


def test_cells_that_go_on_are_not_stuck(workspace: Workspace) -> None:
    assert stuck_cell(workspace.signal_model.samples) is None


def test_a_gain_that_changes_little_is_no_stuck_cell(workspace: Workspace) -> None:
    samples = workspace.signal_model.samples
    assert stuck_cell(stuck(samples, 2, 0.5 * float(samples.clock.max()), 0.3)) is None


def test_a_force_that_is_missing_elsewhere_on_the_foot_is_no_stuck_cell(
    workspace: Workspace,
) -> None:
    """Put back in another cell it makes up for the GRF, and the CoP is further off."""
    signal_model = workspace.signal_model
    samples, gain = signal_model.samples, signal_model.parameters.gain
    channel, other = 0, 3
    broken = stuck(samples, channel, 0.4 * float(samples.clock.max()), 1.0)
    found = stuck_cell(broken)
    assert found is not None
    right = found.corrected(broken)
    elsewhere = broken.readings.copy()
    missing = right.readings[:, channel] - broken.readings[:, channel]
    elsewhere[:, other] += missing * gain[channel] / gain[other]

    def seen(shown: Samples) -> Workspace:
        return replace(workspace, signal_model=replace(signal_model, samples=shown))

    assert found.explains(seen(broken), seen(right))
    assert not found.explains(seen(broken), seen(replace(broken, readings=elsewhere)))


def test_what_it_tells_is_a_cause(workspace: Workspace) -> None:
    samples = workspace.signal_model.samples
    found = stuck_cell(stuck(samples, 0, 0.4 * float(samples.clock.max()), 1.0))
    assert found is not None
    cause = found.cause(workspace, workspace)
    assert cause.location == (samples.shoe.names[0],)
    low, high = cause.size["time"].ci95
    assert low < found.time < high


def test_a_diagnosis_names_the_cell_and_its_moment(
    standard_session: Session, tmp_path: Path
) -> None:
    """Of a session that is recorded anew with a cell that stops in the middle of the second run."""
    channel, moment = 1, 15.0
    level: list[float] = []

    def stops(run: Run) -> Run:
        readings = run.readings
        number, value = run.info.run, readings.value.copy()
        late = readings.time >= (moment if number == 2 else 0.0)
        if number >= 2:
            level.append(float(value[late][0, channel]))
            value[late, channel] = level[0]
        return replace(run, readings=replace(readings, value=value))

    session = rewritten(standard_session, tmp_path / "stops", (1, 2, 3, 5), stops)
    cell = session.shoe.names[channel]
    said = diagnose(session, (1, 2, 3), (4,), only=Wanted("stuck_cell", (cell,)), effects=STUCK)
    (cause,) = said.causes
    assert (said.verdict, cause.effect, cause.location) == ("explained", "stuck_cell", (cell,))
    assert cause.size["share"].value == pytest.approx(1.0, abs=0.05)
    first, second = (session.read(number).start_ns for number in (1, 2))
    assert cause.size["time"].value == pytest.approx(1e-9 * (second - first) + moment, abs=1.0)
    assert cause.shrink.fraction > 0.9
