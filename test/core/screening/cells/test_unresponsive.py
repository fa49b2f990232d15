"""Dead and stuck cells, and cells that reach an end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import Recording, read_coarsely, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.blocks import Blocks, blocks
from shoecal_core.screening.cells.following import StuckBlocks
from shoecal_core.screening.cells.saturated import ended
from shoecal_core.screening.cells.unresponsive import Stuck, dead, dead_feet, stuck, stuck_channels
from shoecal_core.shoe.vertical import vertical_forces


def parts(whole: Recording) -> dict[int, Blocks]:
    return {run: blocks(one, whole.shoe) for run, one in whole.aligned.items()}


@pytest.fixture(params=["fine", "coarse"])
def clean(request: pytest.FixtureRequest) -> Recording:
    whole = recording()
    return whole if request.param == "fine" else read_coarsely(whole, 10, 0.01)


def blocks_of(whole: Recording) -> list[StuckBlocks]:
    return stuck_channels(whole.shoe, parts(whole), [])


def still(whole: Recording) -> list[Stuck]:
    return stuck(parts(whole), blocks_of(whole))


def test_living_cells(clean: Recording) -> None:
    cut = parts(clean)
    assert dead(clean.shoe, cut) == []
    assert still(clean) == []


@pytest.mark.parametrize("channel", [0, 5])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.005])
def test_a_cell_that_only_trembles_is_dead(channel: int, noise: float) -> None:
    rng = np.random.default_rng(4)
    whole = recording().with_channel(
        channel, lambda _, values: 0.7 + noise * rng.standard_normal(len(values))
    )
    assert dead(whole.shoe, parts(whole)) == [channel]


@pytest.mark.parametrize("foot", [0, 1])
def test_a_foot_that_is_dead_in_one_run(clean: Recording, foot: int) -> None:
    own = clean.shoe.foot == foot
    assert dead_feet(clean.shoe, parts(clean)) == {}
    lost = clean.with_readings(lambda run, values: np.where(own & (run == 1), values[0], values))
    assert dead_feet(clean.shoe, parts(lost)) == {1: foot}


def test_a_foot_that_hangs_through_a_run_is_not_dead(clean: Recording) -> None:
    """Of the other one the load stays, whatever its cells do."""
    shoe = clean.shoe
    gain = np.array([channel.rough_gain for channel in shoe.channels])

    def on_left(run: int, values: FloatArray) -> FloatArray:
        if run == 1:
            force = vertical_forces(shoe, values)[0][:, 0]
            left = shoe.foot == 0
            values[:, left] -= (force - force.mean())[:, None] / (gain[left] * left.sum())
            values[:, ~left] = values[0, ~left]
        return values

    assert dead_feet(shoe, parts(clean.with_readings(on_left))) == {}


def test_a_robot_that_stands_still_has_no_dead_cells() -> None:
    rng = np.random.default_rng(4)
    whole = recording().with_readings(
        lambda _, values: values[0] + 0.001 * rng.standard_normal(values.shape)
    )
    assert dead(whole.shoe, parts(whole)) == []
    assert still(whole) == []


def stuck_from(whole: Recording, run: int, second: float, channel: int) -> Recording:
    index = round(second * 100)
    level = float(whole.aligned[run].readings[index, channel])

    def change(number: int, values: FloatArray) -> FloatArray:
        if number == run:
            values[index:] = level
        elif number > run:
            values[:] = level
        return values

    return whole.with_channel(channel, change)


def test_a_cell_that_stops_answering(clean: Recording) -> None:
    whole = stuck_from(clean, 2, 12.0, 3)
    found = still(whole)
    assert {one.channel for one in found} == {3}
    assert {one.run for one in found} == {2, 3}
    first = next(one for one in found if one.run == 2)
    # It may have been near its turning point already.
    assert 7.0 < first.start < 13.0
    assert first.end > 29.0
    assert ended(parts(whole), blocks_of(whole)) == []


@pytest.mark.parametrize("share", [0.75, 0.9, 0.975])
def test_a_cell_that_shows_a_small_part_of_its_signal_is_stuck(share: float) -> None:
    def hardly(run: int, values: FloatArray) -> FloatArray:
        if run == 2:
            part = slice(1000, 1900)
            values[part] = values[1000] + (1.0 - share) * (values[part] - values[1000])
        return values

    (one,) = blocks_of(recording().with_channel(3, hardly))
    assert one.channel == 3
    assert one.share == pytest.approx(share, abs=0.03)
    assert set(np.flatnonzero(one.still)) <= set(range(198, 247))


def test_a_cell_with_a_smaller_gain_for_a_while_is_not_stuck() -> None:
    def less(run: int, values: FloatArray) -> FloatArray:
        return values if run != 2 else values[1000] + 0.5 * (values - values[1000])

    assert blocks_of(recording().with_channel(3, less)) == []


def test_a_moment_may_stay_while_the_other_one_moves() -> None:
    def along_the_sole(run: int, values: FloatArray) -> FloatArray:
        values[1000:2200, 0] = values[1000, 0]
        return values

    whole = recording().with_readings(along_the_sole)
    assert {one.channel for one in still(whole)} == {0}
    moments = tuple(replace(channel, torque=True) for channel in whole.shoe.channels)
    shoe = replace(whole.shoe, channels=moments)
    assert stuck_channels(shoe, parts(whole), []) == []


def test_a_foot_in_the_air_has_no_stuck_cells() -> None:
    def hanging(run: int, values: FloatArray) -> FloatArray:
        values[1000:2200, :4] = values[1000, :4]
        return values

    whole = recording().with_readings(hanging)
    assert still(whole) == []


def test_a_cell_that_stays_at_one_end_again_and_again() -> None:
    whole = recording(seed=2)
    channel = 1
    values = np.concatenate([one.readings[:, channel] for one in whole.aligned.values()])
    level = float(np.quantile(values, 0.55))
    cut = whole.with_channel(channel, lambda _, one: np.minimum(one, level))
    assert {one.channel for one in still(cut)} == {channel}
    (found,) = ended(parts(cut), blocks_of(cut))
    assert found.channel == channel
    assert found.level == pytest.approx(level)
    assert found.share == pytest.approx(0.45, abs=0.02)


def test_a_dead_cell_may_wander_from_run_to_run() -> None:
    """As its electronics warm up: by more than a dead one moves, in no run by as much."""
    whole, channel = recording(), 5
    others = np.concatenate([one.readings for one in whole.aligned.values()])
    step = 0.05 * float(np.ptp(others, axis=0).max())
    wandering = whole.with_channel(channel, lambda run, values: np.full_like(values, step * run))
    assert dead(wandering.shoe, parts(wandering)) == [channel]
