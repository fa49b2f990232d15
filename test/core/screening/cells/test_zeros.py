"""Channels that were zeroed again between runs, under load."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from core.screening.loads.test_weights import carrying
from core.screening.recordings import HEIGHT, WEIGHT, Recording, recording
from core.screening.test_screen import screened
from core.shoe import shoes
from shoecal_core.screening.blocks import block_size
from shoecal_core.screening.cells.zeros import (
    MovedZeros,
    all_start_at_zero,
    describe_starts,
    describe_zeros,
    moved_zeros,
)
from shoecal_core.screening.faults import Fault
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.shoe_file import load_shoe


def found(whole: Recording) -> MovedZeros | None:
    return moved_zeros(whole.statics, HEIGHT)


def tared(whole: Recording, at: dict[int, float]) -> Recording:
    """Zeroed while the robot stood as it did at a share of a run, by run."""
    return whole.with_readings(
        lambda run, values: (
            values - values[int(at[run] * (len(values) - 1))] if run in at else values
        )
    )


@pytest.mark.parametrize("count", [2, 3, 5])
def test_zeros_that_stay(count: int) -> None:
    assert found(recording(count=count)) is None


@pytest.mark.parametrize("newtons", [-8.0, 5.0, 15.0])
def test_a_load_in_one_run_is_none(newtons: float) -> None:
    assert found(carrying(recording(count=4), 2, newtons)) is None


@pytest.mark.parametrize("runs", [(2,), (1, 3), (2, 3, 4)])
def test_a_tare_under_load_before_some_runs(runs: tuple[int, ...]) -> None:
    moved = found(tared(recording(count=4), dict.fromkeys(runs, 0.0)))
    assert moved is not None
    assert moved.less == runs
    assert moved.reference == tuple(run for run in range(1, 5) if run not in runs)
    (finding,) = describe_zeros(shoes.shoe("nao_shoe"), moved, WEIGHT)
    assert finding.verdict == "FAIL"
    assert f"{WEIGHT:.1f} N less than" in finding.reason
    assert "zeroed (tare) under load" in finding.reason
    assert "HX711" in finding.reason
    six_axis = shoes.made([*shoes.six_axis(0, [0, 0, 0.05]), *shoes.six_axis(1, [0, 0, 0.05])])
    (finding,) = describe_zeros(six_axis, moved, WEIGHT)
    assert "set no bias while the robot stands" in finding.reason


@pytest.mark.parametrize("foot", ["left", "right"])
def test_a_tare_of_one_foot_under_load_before_later_runs(foot: str) -> None:
    """It is no question of cables, and no run is better than the others."""
    whole = recording(count=5)
    own = np.array([name.startswith(foot) for name in whole.shoe.names])
    readings = whole.aligned[3].readings
    zero = readings[int(0.6 * len(readings))] * own
    moved = found(whole.with_readings(lambda run, values: values - zero * (run >= 3)))
    assert moved is not None
    assert (moved.less, moved.reference) == ((3, 4, 5), (1, 2))
    (finding,) = describe_zeros(shoes.shoe("nao_shoe"), moved, WEIGHT)
    assert finding.verdict == "FAIL"
    assert f"{moved.part:.1f} N less than runs 1 and 2, each by as much" in finding.reason


@pytest.mark.parametrize("shoe", ["nao_shoe", "odd_shoe"])
@pytest.mark.parametrize("runs", [(2,), (2, 3), (1, 2, 3), (1, 2, 3, 4)], ids=str)
@pytest.mark.parametrize("foot", [0, 1])
def test_a_tare_of_one_foot_before_each_run(foot: int, runs: tuple[int, ...], shoe: str) -> None:
    """It hides another load in each run; neither cables nor the good runs are blamed."""
    whole = recording(5, count=4, shoe=shoe)
    own = whole.shoe.foot == foot
    spoilt = whole.with_readings(
        lambda run, values: values - own * values[:20].mean(axis=0) * (run in runs)
    )
    (finding,) = screened(spoilt).findings
    assert finding.verdict == "FAIL"
    *others, last = map(str, runs)
    named = f"runs {', '.join(others)} and {last}" if others else f"run {last}"
    assert f"(the {FEET[foot]} foot before {named})" in finding.reason
    assert "zeroed (tare) under load" in finding.reason


def test_a_tare_in_another_posture_before_each_run() -> None:
    """The sums agree, and each channel's zero is another one."""
    whole = recording(count=3)
    extreme = {
        run: float(np.argmax(one.states.cop[:, 0] @ direction)) / (len(one.time) - 1)
        for (run, one), direction in zip(
            whole.aligned.items(), ([1.0, 0.0], [-1.0, 1.0], [0.0, -1.0]), strict=True
        )
    }
    moved = found(tared(whole, extreme))
    assert moved is not None
    assert moved.less == ()
    assert moved.cop
    (finding,) = describe_zeros(shoes.shoe("nao_shoe"), moved, WEIGHT)
    assert "at the same weight" in finding.reason


def test_a_tare_once_before_all_runs_does_no_harm() -> None:
    whole = recording(count=3)
    first = whole.aligned[1].readings[0]
    assert found(whole.with_readings(lambda _, values: values - first)) is None


@pytest.mark.parametrize(("shoe", "verdict"), [("nao_shoe", "WARN"), ("reemc", "FAIL")])
def test_a_tare_before_each_run_alike(shoe: str, verdict: str) -> None:
    """It hides what each foot carried, though no run contradicts another one."""
    whole = recording(count=3)
    zeroed = tared(whole, dict.fromkeys(whole.aligned, 0.0))
    assert all_start_at_zero(zeroed.statics.parts)
    assert not all_start_at_zero(whole.statics.parts)
    assert not all_start_at_zero(tared(whole, {1: 0.0, 3: 0.0}).statics.parts)
    same = {
        run: replace(one, cop=one.cop - one.cop[0]) for run, one in zeroed.statics.parts.items()
    }
    assert not all_start_at_zero(same)
    (finding,) = describe_starts(load_shoe(shoes.ROOT / "config/shoes" / f"{shoe}.yaml"))
    assert finding.verdict == verdict
    assert "all readings of both feet start at zero in each run" in finding.reason


@pytest.mark.parametrize("runs", [(4,), (2, 3)], ids=str)
@pytest.mark.parametrize("channels", [(2,), (1, 6)], ids=str)
def test_a_tare_of_some_cells_names_these_and_the_runs(
    channels: tuple[int, ...], runs: tuple[int, ...]
) -> None:
    """Their zeros were far from nothing before: it hides another force than the weight."""
    whole = recording(count=5)
    own = np.isin(np.arange(len(whole.shoe.names)), channels)
    usual = whole.aligned[1].readings
    zero = 1.5 * np.ptp(usual, axis=0) * np.sign(np.median(usual, axis=0))
    far = whole.with_readings(lambda _, values: values + zero)
    first = block_size(whole.aligned[1].time)
    spoilt = far.with_readings(
        lambda run, values: values - own * np.median(values[:first], axis=0) * (run in runs)
    )
    (finding,) = screened(spoilt).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.MOVED_ZEROS)
    assert re.search(rf"runs? {' and '.join(map(str, runs))}\b", finding.reason)
    assert [one for one in channels if whole.shoe.names[one] not in finding.reason] == []
