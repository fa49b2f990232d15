"""One law for all cells (paper, eqs. 16 and 17)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation import chunks
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters


def without_polarity(shoe: Shoe) -> Shoe:
    """The same shoe, bought from somebody who does not know how it is wired."""
    return replace(shoe, channels=tuple(replace(c, polarity=0) for c in shoe.channels))


def mixed(shoe: Shoe) -> IntArray:
    """Signs that differ from the shoe file's."""
    return np.where(np.arange(len(shoe.channels)) % 3 == 0, -1, 1)


@pytest.mark.parametrize("weight_row", [False, True])
@pytest.mark.parametrize("count", [1, 3])
def test_cells_of_one_law_are_recovered_exactly(
    shoe: Shoe, rng: np.random.Generator, count: int, *, weight_row: bool
) -> None:
    truth = synthetic.common(shoe, 23.0, -3.5, shoe.polarity)
    runs = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:count])
    guess = initial_guess(shoe, runs, weight_row=weight_row)
    assert guess.gain == pytest.approx(23.0, rel=1e-9)
    assert guess.offset == pytest.approx(-3.5, rel=1e-7)
    np.testing.assert_allclose(guess.parameters.gain, truth.gain, rtol=1e-9)
    np.testing.assert_allclose(guess.parameters.offset, truth.offset, rtol=1e-7)
    np.testing.assert_array_equal(guess.polarity, shoe.polarity)


@pytest.mark.parametrize("weight_row", [False, True])
def test_polarity_is_found_from_the_data(
    shoe: Shoe, rng: np.random.Generator, *, weight_row: bool
) -> None:
    sign = mixed(shoe)
    truth = synthetic.common(shoe, 23.0, 2.0, sign)
    guess = initial_guess(
        without_polarity(shoe), synthetic.stances(shoe, truth, rng), weight_row=weight_row
    )
    np.testing.assert_array_equal(guess.polarity, sign)
    np.testing.assert_allclose(guess.parameters.gain, truth.gain, rtol=1e-9)


def test_polarity_is_found_though_gains_differ_and_readings_are_noisy(
    shoe: Shoe, rng: np.random.Generator
) -> None:
    sign = mixed(shoe)
    spread = 25.0 * rng.uniform(0.7, 1.3, len(sign)) * sign
    truth = ChannelParameters(spread, rng.uniform(-8.0, 8.0, len(sign)))
    runs = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:3], noise=0.2)
    guess = initial_guess(without_polarity(shoe), runs, weight_row=False)
    np.testing.assert_array_equal(guess.polarity, sign)


def test_what_is_known_of_the_polarity_is_kept(shoe: Shoe, rng: np.random.Generator) -> None:
    truth = synthetic.common(shoe, 23.0, 2.0, shoe.polarity)
    half = replace(
        shoe,
        channels=tuple(
            replace(channel, polarity=channel.polarity if index % 2 else 0)
            for index, channel in enumerate(shoe.channels)
        ),
    )
    guess = initial_guess(half, synthetic.stances(shoe, truth, rng), weight_row=False)
    np.testing.assert_array_equal(guess.polarity, shoe.polarity)


def test_known_polarity_overrules_the_data(shoe: Shoe, rng: np.random.Generator) -> None:
    truth = synthetic.common(shoe, 23.0, 2.0, mixed(shoe))
    guess = initial_guess(shoe, synthetic.stances(shoe, truth, rng), weight_row=False)
    np.testing.assert_array_equal(guess.polarity, shoe.polarity)


@pytest.mark.parametrize("weight_row", [False, True])
def test_the_rows_are_the_paper_s(rng: np.random.Generator, *, weight_row: bool) -> None:
    """Against eq. 17 row by row, on cells that follow no common law."""
    square = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.04)]
    shoe = shoes.made(shoes.cells(0, square) + shoes.cells(1, square))
    truth = synthetic.truth(shoe, rng)
    runs = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:2], count=20)
    rows, targets = [], []
    for run in runs:
        places = shoe.positions.copy()
        places[4:] = run.support.right_to_left(places[4:])
        for k in range(20):
            S, G = run.readings[k], run.force[k]
            for axis in (0, 1):
                rows.append([S @ places[:, axis], places[:, axis].sum()])
                targets.append(run.cop[k, axis] * G)
            if weight_row:
                rows.append([S.sum(), 8.0])
                targets.append(G)
    (c0, d0), *_ = np.linalg.lstsq(np.array(rows), np.array(targets), rcond=None)
    guess = initial_guess(shoe, runs, weight_row=weight_row)
    assert guess.gain == pytest.approx(c0, rel=1e-9)
    assert guess.offset == pytest.approx(d0, rel=1e-9)
    np.testing.assert_allclose(guess.parameters.gain, c0)
    np.testing.assert_allclose(guess.parameters.offset, d0)


@pytest.mark.parametrize("weight_row", [False, True])
@pytest.mark.parametrize("chunk", [1, 7, 399])
def test_chunks_do_not_change_the_result(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch,
    chunk: int, *, weight_row: bool,
) -> None:  # fmt: skip
    runs = synthetic.stances(
        shoe, truth, rng, synthetic.SUPPORTS[:2], count=400 if chunk > 7 else 40
    )
    pair = rated(without_polarity(shoe), {1: 24.0})
    whole = initial_guess(pair, runs, weight_row=weight_row)
    monkeypatch.setattr(chunks, "CHUNK", chunk)
    parts = initial_guess(pair, runs, weight_row=weight_row)
    np.testing.assert_array_equal(parts.polarity, whole.polarity)
    assert parts.gain == pytest.approx(whole.gain, rel=1e-10)
    assert parts.offset == pytest.approx(whole.offset, rel=1e-8)


@pytest.mark.parametrize("zero", [1e1, 1e3, 1e5])
def test_readings_far_off_zero_still_tell_gain_and_offset(
    shoe: Shoe, rng: np.random.Generator, zero: float
) -> None:
    """Counts of a converter that is not centred: what varies is little of what is read."""
    truth = synthetic.common(shoe, 23.0, -23.0 * zero, np.abs(shoe.polarity))
    runs = synthetic.stances(shoe, truth, rng)
    guess = initial_guess(without_polarity(shoe), runs, weight_row=True)
    assert guess.gain == pytest.approx(23.0, rel=1e-11 * zero)
    off = [guess.parameters.outputs(r.readings) - truth.outputs(r.readings) for r in runs]
    np.testing.assert_allclose(off, 0.0, atol=1e-9 * zero)


def test_the_weight_row_helps_the_grf(shoe: Shoe, rng: np.random.Generator) -> None:
    truth = synthetic.truth(shoe, rng)
    runs = synthetic.stances(shoe, truth, rng)

    def grf_error(*, weight_row: bool) -> float:
        guess = initial_guess(shoe, runs, weight_row=weight_row)
        errors = [
            guess.parameters.outputs(run.readings) @ run.columns[:, 0] + run.base[0] - run.force
            for run in runs
        ]
        return float(np.abs(np.concatenate(errors)).mean())

    assert grf_error(weight_row=True) < grf_error(weight_row=False)


# ---- data sheets ------------------------------------------------------------------------------


def rated(shoe: Shoe, gains: dict[int, float]) -> Shoe:
    """The shoe with data-sheet gains for some channels."""
    channels = [
        replace(channel, nominal_gain=gains.get(index))
        for index, channel in enumerate(shoe.channels)
    ]
    return replace(shoe, channels=tuple(channels))


def test_data_sheet_gains_are_taken_with_the_cell_s_polarity(
    shoe: Shoe, rng: np.random.Generator
) -> None:
    count = len(shoe.channels)
    truth = synthetic.common(shoe, 23.0, 0.0, shoe.polarity)
    runs = synthetic.stances(shoe, truth, rng)
    guess = initial_guess(rated(shoe, dict.fromkeys(range(count), 20.0)), runs, weight_row=False)
    np.testing.assert_array_equal(guess.parameters.gain, 20.0 * shoe.polarity)
    np.testing.assert_array_equal(guess.parameters.offset, np.zeros(count))
    assert np.isnan(guess.gain)
    assert np.isnan(guess.offset)


@pytest.mark.parametrize("weight_row", [False, True])
def test_unknown_gains_are_fitted_beside_known_ones(
    shoe: Shoe, rng: np.random.Generator, *, weight_row: bool
) -> None:
    known = {0: 40.0, 2: 50.0}
    gain = np.array([known.get(i, 23.0) for i in range(len(shoe.channels))]) * shoe.polarity
    offset = np.array([0.0 if i in known else 4.0 for i in range(len(shoe.channels))])
    truth = ChannelParameters(np.asarray(gain), offset)
    guess = initial_guess(
        rated(shoe, known), synthetic.stances(shoe, truth, rng), weight_row=weight_row
    )
    np.testing.assert_allclose(guess.parameters.gain, truth.gain, rtol=1e-9)
    np.testing.assert_allclose(guess.parameters.offset, truth.offset, atol=1e-6)


# ---- what cannot be guessed -------------------------------------------------------------------


def test_no_runs(shoe: Shoe) -> None:
    with pytest.raises(ShoecalError, match="at least one training run"):
        initial_guess(shoe, [], weight_row=False)


def still(stance: Stance, value: ArrayLike) -> Stance:
    return replace(stance, readings=np.broadcast_to(value, stance.readings.shape).copy())


def test_readings_that_stay_constant(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    run = synthetic.stance(shoe, truth, synthetic.SUPPORTS[0], rng)
    frozen = [still(run, 0.4 * shoe.polarity)]
    for weight_row in (False, True):
        with pytest.raises(ShoecalError, match="stay constant"):
            initial_guess(shoe, frozen, weight_row=weight_row)
        with pytest.raises(ShoecalError, match="cells are alive"):
            initial_guess(shoe, [still(run, 0.0)], weight_row=weight_row)
