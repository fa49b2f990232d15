"""Dead and stuck cells, and cells that reach an end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.calibration.screening.recordings import Recording, read_coarsely, recording
from shoecal_core.calibration.screening.blocks import Blocks, blocks
from shoecal_core.calibration.screening.saturated import ended
from shoecal_core.calibration.screening.unresponsive import dead, neighbours, stuck

FloatArray = NDArray[np.float64]


def parts(whole: Recording) -> dict[int, Blocks]:
    return {run: blocks(one, whole.shoe) for run, one in whole.aligned.items()}


@pytest.fixture(params=["fine", "coarse"])
def clean(request: pytest.FixtureRequest) -> Recording:
    whole = recording()
    return whole if request.param == "fine" else read_coarsely(whole, 10, 0.01)


def test_living_cells(clean: Recording) -> None:
    cut = parts(clean)
    assert dead(clean.shoe, cut) == []
    assert stuck(clean.shoe, cut, range(8)) == []


@pytest.mark.parametrize("channel", [0, 5])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.005])
def test_a_cell_that_only_trembles_is_dead(channel: int, noise: float) -> None:
    rng = np.random.default_rng(4)
    whole = recording().with_channel(
        channel, lambda _, values: 0.7 + noise * rng.standard_normal(len(values))
    )
    assert dead(whole.shoe, parts(whole)) == [channel]


def test_a_robot_that_stands_still_has_no_dead_cells() -> None:
    rng = np.random.default_rng(4)
    whole = recording().with_readings(
        lambda _, values: values[0] + 0.001 * rng.standard_normal(values.shape)
    )
    assert dead(whole.shoe, parts(whole)) == []
    assert stuck(whole.shoe, parts(whole), range(8)) == []


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
    found = stuck(whole.shoe, parts(whole), range(8))
    assert {one.channel for one in found} == {3}
    assert {one.run for one in found} == {2, 3}
    first = next(one for one in found if one.run == 2)
    # It may have been near its turning point already.
    assert 7.0 < first.start < 13.0
    assert first.end > 29.0
    assert ended(parts(whole), found) == []


def test_a_cell_that_hardly_moves_for_a_while_is_not_stuck() -> None:
    def hardly(run: int, values: FloatArray) -> FloatArray:
        if run == 2:
            part = slice(1000, 1900)
            values[part] = values[1000] + 0.025 * (values[part] - values[1000])
        return values

    whole = recording().with_channel(3, hardly)
    assert stuck(whole.shoe, parts(whole), range(8)) == []


def test_a_moment_may_stay_while_the_other_one_moves() -> None:
    def along_the_sole(run: int, values: FloatArray) -> FloatArray:
        values[1000:2200, 0] = values[1000, 0]
        return values

    whole = recording().with_readings(along_the_sole)
    assert {one.channel for one in stuck(whole.shoe, parts(whole), range(8))} == {0}
    moments = tuple(replace(channel, torque=True) for channel in whole.shoe.channels)
    shoe = replace(whole.shoe, channels=moments)
    assert stuck(shoe, parts(whole), range(8)) == []


def test_a_foot_in_the_air_has_no_stuck_cells() -> None:
    def hanging(run: int, values: FloatArray) -> FloatArray:
        values[1000:2200, :4] = values[1000, :4]
        return values

    whole = recording().with_readings(hanging)
    assert stuck(whole.shoe, parts(whole), range(8)) == []


def test_a_cell_that_stays_at_one_end_again_and_again() -> None:
    whole = recording(seed=2)
    channel = 1
    values = np.concatenate([one.readings[:, channel] for one in whole.aligned.values()])
    level = float(np.quantile(values, 0.55))
    cut = whole.with_channel(channel, lambda _, one: np.minimum(one, level))
    still = stuck(cut.shoe, parts(cut), range(8))
    assert {one.channel for one in still} == {channel}
    (found,) = ended(parts(cut), still)
    assert found.channel == channel
    assert found.level == pytest.approx(level)
    assert found.share == pytest.approx(0.45, abs=0.02)


def test_only_like_channels_of_one_foot_are_neighbours() -> None:
    shoe = recording().shoe
    assert neighbours(shoe, 5).tolist() == [4, 6, 7]
