"""Cells that show a share of the one that is read before them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.loads.test_weights import carrying
from core.screening.recordings import Recording, read_coarsely, recording
from core.screening.test_screen import screened
from core.shoe import shoes
from shoecal_core.screening.cells.leaking import (
    LONGEST_BLOCK_S,
    Chains,
    Leak,
    describe_leaking,
    leaking,
    mixing,
    orders,
)
from shoecal_core.screening.faults import Fault

SIX_AXIS = shoes.made(
    [*shoes.six_axis(0, [0.0, 0.01, 0.03]), *shoes.six_axis(1, [0.0, -0.01, 0.03])]
)
FILE = ((0, 1, 2, 3), (4, 5, 6, 7))


def found(whole: Recording) -> Leak | None:
    return leaking(whole.statics)


def leaky(whole: Recording, chains: Chains, share: float) -> Recording:
    mixed = mixing(chains, len(whole.shoe.names), share)
    return whole.with_readings(lambda _, values: values @ mixed.T)


def test_each_cell_keeps_a_share_of_the_one_before() -> None:
    values = np.arange(8.0) ** 2
    mixed = mixing(FILE, 8, 0.1) @ values
    assert mixed[2] == pytest.approx(0.9 * values[2] + 0.1 * values[1])
    assert mixed[4] == pytest.approx(0.9 * values[4] + 0.1 * values[7])
    assert (mixing((), 8, 0.1) == np.eye(8)).all()


@pytest.mark.parametrize("seed", range(1, 3))
@pytest.mark.parametrize(
    ("chains", "share"),
    [
        (FILE, 0.15),
        (((0, 3, 2, 1), (4, 7, 6, 5)), 0.25),
        (((0, 2, 1, 3),), 0.25),
        ((tuple(range(8)),), 0.2),
    ],
)
def test_a_leak_is_found_with_its_order_and_share(seed: int, chains: Chains, share: float) -> None:
    leak = found(leaky(recording(seed, count=5), chains, share))
    assert leak is not None
    assert leak.chains == chains
    assert abs(leak.share - share) < max(0.03, 3.0 * leak.std)


@pytest.mark.parametrize("seed", range(1, 4))
def test_sound_cells_do_not_leak(seed: int) -> None:
    assert found(recording(seed, count=5)) is None
    assert found(read_coarsely(recording(seed, count=5), 10, 0.01)) is None


def test_a_small_leak_is_left_to_the_fit() -> None:
    assert found(leaky(recording(count=5), FILE, 0.03)) is None


def test_other_faults_are_no_leak() -> None:
    whole = recording(count=5)
    touching = whole.with_channel(5, lambda _, one: np.minimum(one, np.quantile(one, 0.7)))
    assert found(touching) is None
    swapped = whole.with_readings(lambda _, values: values[:, [0, 2, 1, 3, 4, 5, 6, 7]])
    assert [one.fault for one in screened(swapped).findings] == [Fault.SWAPPED]


def test_another_weight_in_one_run_is_no_leak() -> None:
    assert found(carrying(recording(count=3), 2, 6.0)) is None


def test_six_axis_sensors_are_not_looked_at() -> None:
    whole = recording(count=3, shoe=SIX_AXIS)
    assert found(leaky(whole, (tuple(range(6)),), 0.2)) is None


def test_stamps_in_bunches_leave_too_few_blocks() -> None:
    quick = leaky(recording(count=3), FILE, 0.2).statics
    slower = quick.changed(lambda one: replace(one, time=one.time * 6.0 * LONGEST_BLOCK_S))
    assert leaking(quick) is not None
    assert leaking(slower) is None


def test_many_cells_are_tried_in_the_order_of_the_file_and_its_reverse() -> None:
    four = list(orders(shoes.shoe("nao_shoe")))
    assert len(four) == 7 * 7 - 1 + 2
    assert len(set(four)) == len(four)


def test_it_is_refused_with_order_share_and_cure() -> None:
    spoiled = leaky(recording(count=5), FILE, 0.15)
    (finding,) = screened(spoiled).findings
    assert finding.verdict == "FAIL"
    assert finding.fault is Fault.LEAKING
    assert finding.reason.startswith("each cell of both feet reads 1")
    assert (
        "(left/front_left, left/front_right, left/rear_left, left/rear_right; right/"
        in finding.reason
    )
    assert "read every channel twice and throw the first away" in finding.reason
    one = Leak(((4, 5, 6, 7),), 0.15, 0.01)
    (finding,) = describe_leaking(spoiled.shoe, one)
    assert "each cell of the right foot reads 15 +- 2 % of the cell before it" in finding.reason
    assert describe_leaking(spoiled.shoe, None) == []
