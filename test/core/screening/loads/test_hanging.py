"""A robot that is lifted for a while within a run in double support: its zeros are found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.extract import stances_of, zeros_of
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.hanging import hung_runs, leave_out_hung
from shoecal_core.screening.screen import screen
from shoecal_core.shoe.wrench import weight_below
from shoecal_core.workspace import config_dir

RUN, UP, DOWN = 2, 9.0, 17.0


def hung(whole: Recording, *, dangling: float, carried: float = 0.0) -> Recording:
    """The second run, in which the robot hangs for eight seconds.

    Args:
        dangling: how far one foot hangs below the other [m].
        carried: share of the readings' change that the feet still show.
    """
    one = whole.aligned[RUN]
    shoe, time = whole.shoe, one.time
    outputs = np.zeros_like(one.readings)
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        outputs[:, own] = -weight_below(shoe)[foot] @ np.linalg.pinv(shoe.columns[own])
    outputs += 0.01 * np.random.default_rng(5).standard_normal(outputs.shape)
    zero = (outputs - whole.parameters.offset) / whole.parameters.gain
    up = np.interp(time, [UP, UP + 0.4, DOWN - 0.4, DOWN], [0.0, 1.0, 1.0, 0.0])
    up *= 1.0 - carried
    translation = one.states.translation.copy()
    translation[:, 2] += dangling * up
    readings = up[:, None] * zero + (1.0 - up[:, None]) * one.readings
    states = replace(one.states, translation=translation)
    return whole.with_run(RUN, readings=readings, states=states)


def zero_of(whole: Recording, aligned: Aligned, foot: int) -> FloatArray:
    """(3,) what a foot that is held against the truth shows in its zeros [N, N m]."""
    runs = whole.runs
    found = screen(runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS)
    kinematics = Kinematics(load_robot(config_dir() / "robots" / "nao.yaml", whole.shoe))
    zeros = zeros_of(runs[RUN], aligned, whole.shoe, kinematics, found)
    assert [zero.foot for zero in zeros] == [0, 1]
    assert zeros[foot].readings.shape[0] > 400
    return np.asarray(zeros[foot].wrench(whole.shoe, whole.parameters).mean(axis=0))


@pytest.mark.parametrize("dangling", [0.0, 0.03])
@pytest.mark.parametrize("seed", range(2))
def test_its_zeros_are_found_and_the_rest_counts(dangling: float, seed: int) -> None:
    whole = hung(recording(seed), dangling=dangling)
    found = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS)
    assert found.findings == ()
    (lost,) = [one for one in found.left_out if one.fault is Fault.HANGING]
    assert lost.run == RUN
    assert lost.stretches[0] == pytest.approx((UP, DOWN), abs=0.8)
    time = whole.aligned[RUN].time
    assert found.hanging[RUN][(time > UP + 0.8) & (time < DOWN - 0.8)].all()
    assert found.kept[RUN][(time < UP - 0.8) | (time > DOWN + 0.8)].mean() > 0.98
    for foot in (0, 1):
        np.testing.assert_allclose(zero_of(whole, whole.aligned[RUN], foot), 0.0, atol=0.02)
    kinematics = Kinematics(load_robot(config_dir() / "robots" / "nao.yaml", whole.shoe))
    (stance,) = stances_of(whole.runs[RUN], whole.aligned[RUN], whole.shoe, kinematics, found)
    assert stance.loaded == (True, True)
    assert not ((stance.time > UP) & (stance.time < DOWN)).any()


def test_a_robot_that_is_held_a_little_does_not_hang() -> None:
    whole = hung(recording(1), dangling=0.0, carried=0.5)
    found = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS)
    assert found.hanging == {}
    assert any(one.fault is Fault.PULLED for one in found.left_out)


def all_along(whole: Recording) -> Recording:
    """The second run, in which the robot hangs all the time."""
    one = whole.aligned[RUN]
    noise = 0.01 * np.random.default_rng(6).standard_normal(one.readings.shape)
    zero = (noise - whole.parameters.offset) / whole.parameters.gain
    return whole.with_run(RUN, readings=zero)


@pytest.mark.parametrize("seed", range(3))
def test_a_run_in_which_it_hangs_all_along_is_left_out(seed: int) -> None:
    whole = all_along(recording(seed))
    hung_all = hung_runs(whole.aligned, whole.shoe)
    assert list(hung_all) == [RUN]
    rest = {run: one for run, one in whole.aligned.items() if run != RUN}
    runs = {run: one for run, one in whole.runs.items() if run != RUN}
    found = screen(runs, rest, whole.shoe, WEIGHT, SETTINGS)
    found = leave_out_hung(found, hung_all, whole.aligned)
    (finding,) = found.findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.HANGING)
    assert finding.reason.startswith("run 2: no reading of either foot changes while the joints")
    assert not found.kept[RUN].any()


@pytest.mark.parametrize("seed", range(3))
def test_where_it_stands_on_its_feet_no_run_is_hung(seed: int) -> None:
    whole = recording(seed)
    assert hung_runs(whole.aligned, whole.shoe) == {}
    # One that stands still shows nothing, and says nothing.
    one = all_along(whole).aligned[RUN]
    still = replace(one.states, com=np.repeat(one.states.com[:1], len(one.time), axis=0))
    assert (
        hung_runs(whole.with_run(RUN, readings=one.readings, states=still).aligned, whole.shoe)
        == {}
    )
