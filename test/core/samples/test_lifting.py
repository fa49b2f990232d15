"""Runs that lift a foot on purpose become stances before, in the air, and after."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.lifting import (
    BOTH_STAND,
    LEAST_AIR_S,
    NEITHER,
    TRANSIT_S,
    UNLOADING,
    detect_lifted_foot,
    hanging_foot,
)
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.extract import stances_of
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening
from shoecal_core.screening.screen import screen
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import at_cop, weight_below
from shoecal_core.workspace import config_dir

RUN = 2
UP, DOWN, WAY_S, HEIGHT = 12.0, 17.0, 0.4, 0.01
MOTIONS = sorted(UNLOADING)


@pytest.fixture(scope="module")
def whole() -> Recording:
    return recording()


def height(time: FloatArray) -> FloatArray:
    return np.interp(time, [UP, UP + WAY_S, DOWN - WAY_S, DOWN], [0.0, HEIGHT, HEIGHT, 0.0])


def smooth(time: FloatArray) -> FloatArray:
    """From 0 to 1 within 6 s, with neither speed nor acceleration at its ends."""
    x = np.clip(time / 6.0, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


def lifting(whole: Recording, foot: int, *, carried: float = 0.0, shift: float = 0.0) -> Aligned:
    """The second run, a foot lifted in its middle, put down `shift` [m] further on.

    Args:
        carried: share of the weight that the foot still feels while it is up.
    """
    one = whole.aligned[RUN]
    shoe, time = whole.shoe, one.time
    up = smooth(time - (UP - 6.0)) - smooth(time - DOWN - 0.2)
    share = 0.5 + (carried - 0.5) * up
    other = 1 - foot
    outputs = np.zeros_like(one.readings)
    cop = shoe.positions[shoe.of_foot(other)].mean(axis=0) + 0.005 * np.stack(
        (np.sin(time), np.cos(0.7 * time)), axis=1
    )
    middle = np.tile(shoe.positions[shoe.of_foot(foot)].mean(axis=0), (len(time), 1))
    for index, force, place in ((foot, share, middle), (other, 1.0 - share, cop)):
        own = shoe.of_foot(index)
        felt = at_cop(WEIGHT * force, place) - weight_below(shoe)[index]
        outputs[:, own] = felt @ np.linalg.pinv(shoe.columns[own])
    noise = 0.01 * np.random.default_rng(5).standard_normal(outputs.shape)
    support = one.states.support()
    places = {foot: middle, other: cop}
    left_share = share if foot == 0 else 1.0 - share
    com = left_share[:, None] * places[0] + (1.0 - left_share)[:, None] * (
        support.right_to_left(places[1])
    )
    states = one.states
    translation = states.translation.copy()
    translation[:, 2] += height(time) * (1.0 if foot == 1 else -1.0)
    translation[time > DOWN, 0] += shift
    coms = states.com.copy()
    coms[:, 0, :2], coms[:, 1, :2] = com, support.left_to_right(com)
    return replace(
        one,
        readings=(outputs + noise - whole.parameters.offset) / whole.parameters.gain,
        states=replace(states, translation=translation, com=coms),
    )


def made(whole: Recording, motion: str, lifted: Aligned) -> tuple[dict[int, Run], Screening]:
    runs = replace(whole, aligned={**whole.aligned, RUN: lifted}).runs
    runs[RUN] = replace(runs[RUN], info=replace(runs[RUN].info, motion=motion))
    aligned = {**whole.aligned, RUN: lifted}
    return runs, screen(runs, aligned, whole.shoe, WEIGHT, SETTINGS)


def stances(
    whole: Recording, motion: str, lifted: Aligned, *, screened: bool = True
) -> list[Stance]:
    runs, screening = made(whole, motion, lifted)
    config = config_dir()
    kinematics = Kinematics(load_robot(config / "robots" / "nao.yaml", whole.shoe))
    told = screening if screened else None
    return stances_of(runs[RUN], lifted, whole.shoe, kinematics, told)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("screened", [True, False])
def test_three_stances(whole: Recording, motion: str, screened: bool) -> None:
    foot = UNLOADING[motion]
    before, air, after = stances(whole, motion, lifting(whole, foot), screened=screened)
    assert before.loaded == after.loaded == (True, True)
    assert air.hanging == foot
    assert before.time[-1] < UP < air.time[0] < air.time[-1] < DOWN < after.time[0]
    assert air.duration > DOWN - UP - 2.0 * WAY_S - 2.0 * TRANSIT_S - 0.2
    # In the air the other foot's frame counts: what it carries is where the model says.
    outputs = whole.parameters.outputs(air.readings)
    wrench = outputs @ air.columns + air.base
    np.testing.assert_allclose(wrench, air.reference, atol=0.3)
    own = whole.shoe.of_foot(foot)
    felt = outputs[:, own] @ whole.shoe.columns[own] + weight_below(whole.shoe)[foot]
    np.testing.assert_allclose(felt, 0.0, atol=0.1)


def test_nothing_is_reported_of_what_was_meant(whole: Recording) -> None:
    _, screening = made(whole, "unload_left", lifting(whole, 0))
    assert not screening.findings
    faults = {one.fault for one in screening.left_out if one.run == RUN}
    assert Fault.LIFTING in faults
    assert Fault.LIFTED not in faults


def test_only_a_foot_that_hangs_by_its_load_counts_as_in_the_air(whole: Recording) -> None:
    """Heights alone do not do: screening says at which samples load and height agree."""
    free, pressed = (
        made(whole, "unload_left", lifting(whole, 0, carried=carried))[1] for carried in (0.0, 0.3)
    )
    assert free.air[RUN].any()
    assert not pressed.air[RUN].any()


def test_the_same_in_another_motion_is_a_fault(whole: Recording) -> None:
    for foot, name in enumerate(FEET):
        _, screening = made(whole, "landmarks", lifting(whole, foot))
        assert [one.fault for one in screening.findings] == [Fault.LIFTED]
        assert f"had its {name} foot in the air" in screening.findings[0].reason


def test_a_foot_that_still_carries_does_not_hang(whole: Recording) -> None:
    lifted = lifting(whole, 0, carried=0.3)
    _, screening = made(whole, "unload_left", lifted)
    assert [one.fault for one in screening.findings] == [Fault.LIFTED]
    assert all(stance.hanging is None for stance in stances(whole, "unload_left", lifted))


def test_a_foot_put_down_elsewhere_is_no_slip(whole: Recording) -> None:
    shift = 0.004
    lifted = lifting(whole, 1, shift=shift)
    _, screening = made(whole, "unload_right", lifted)
    assert not screening.findings
    before, _, after = stances(whole, "unload_right", lifted)
    assert after.support.dx - before.support.dx == pytest.approx(shift, abs=2e-4)


def test_too_short_a_time_in_the_air_is_no_stance(whole: Recording) -> None:
    one = whole.aligned[RUN]
    up = (one.time > UP) & (one.time < UP + LEAST_AIR_S / 2.0)
    translation = one.states.translation + np.outer(up, [0.0, 0.0, HEIGHT])
    found = detect_lifted_foot(
        "unload_right", replace(one, states=replace(one.states, translation=translation))
    )
    assert found is not None
    assert not found.air.any()
    assert found.moving[up].all()


def test_other_motions_lift_no_foot(whole: Recording) -> None:
    assert detect_lifted_foot("landmarks", whole.aligned[RUN]) is None


def test_a_foot_that_stays_down_leaves_one_stretch(whole: Recording) -> None:
    found = detect_lifted_foot("unload_right", whole.aligned[RUN])
    assert found is not None
    (stretch,) = found.stretches()
    assert stretch.all()


@pytest.mark.parametrize("foot", [0, 1])
@pytest.mark.parametrize("begins", [UP - 0.4, UP - 2.5])
def test_joints_may_lift_a_foot_long_before_gears_that_give_let_it_go(
    whole: Recording, foot: int, begins: float
) -> None:
    """Its load still changes then, but not once it is as high as it gets."""
    one = lifting(whole, foot)
    way = np.interp(one.time, [begins, UP + WAY_S, DOWN, DOWN + WAY_S], [0.0, HEIGHT, HEIGHT, 0.0])
    translation = one.states.translation.copy()
    translation[:, 2] += (way - height(one.time)) * (1.0 if foot == 1 else -1.0)
    one = replace(one, states=replace(one.states, translation=translation))
    air = way > 0.2 * HEIGHT
    robot = load_robot(config_dir() / "robots" / "nao.yaml", whole.shoe)
    assert (hanging_foot(one, air, robot, whole.shoe)[air] == foot).all()
    pressed = one.readings.copy()
    pressed[air] += np.sin(5.0 * one.time[air])[:, None] * np.ptp(one.readings, axis=0)
    still = hanging_foot(replace(one, readings=pressed), air, robot, whole.shoe)
    assert (still == BOTH_STAND).all()


@pytest.mark.parametrize("foot", [0, 1])
@pytest.mark.parametrize(
    ("seems", "share", "stands"),
    [(0.006, 0.3, True), (0.006, 0.02, False), (0.02, 0.3, False)],
    ids=["carries", "carries nothing", "higher than gears let it seem"],
)
def test_a_foot_that_carries_load_stands_though_joints_lift_it(
    whole: Recording, foot: int, seems: float, share: float, stands: bool
) -> None:
    one = lifting(whole, foot)
    translation = one.states.translation.copy()
    rise = (seems / HEIGHT - 1.0) * height(one.time)
    translation[:, 2] += rise * (1.0 if foot == 1 else -1.0)
    one = replace(one, states=replace(one.states, translation=translation))
    up = height(one.time) > 0.9 * HEIGHT
    load = np.full((len(one.time), 2), 0.5)
    load[up, foot], load[up, 1 - foot] = share, 1.0 - share
    robot = load_robot(config_dir() / "robots" / "nao.yaml", whole.shoe)
    found = hanging_foot(one, up, robot, whole.shoe, load)
    assert (found[up] == (BOTH_STAND if stands else foot)).all()


@pytest.mark.parametrize("foot", [0, 1])
def test_a_foot_that_landed_on_an_edge_neither_hangs_nor_stands(
    whole: Recording, foot: int
) -> None:
    """Joints still lift it a little, and cells feel it: it stands elsewhere, or askew."""
    one, robot = lifting(whole, foot), load_robot(config_dir() / "robots" / "nao.yaml", whole.shoe)
    up = height(one.time) > 0.2 * HEIGHT
    edge = ~up & (one.time > UP + WAY_S) & (one.time < DOWN + 2.0)
    translation = one.states.translation.copy()
    translation[edge, 2] += 0.4 * HEIGHT * (1.0 if foot == 1 else -1.0)
    one = replace(one, states=replace(one.states, translation=translation))
    load = np.full((len(one.time), 2), 0.5)
    load[up, foot], load[up, 1 - foot] = 0.0, 1.0
    found = hanging_foot(one, up | edge, robot, whole.shoe, load)
    assert (found[up] == foot).all()
    assert (found[edge] == NEITHER).all()
    assert (found[~(up | edge)] == BOTH_STAND).all()


def test_screening_knows_what_each_foot_carries(whole: Recording) -> None:
    """To a few per cent of the weight: enough to tell a foot that hangs from one that stands."""
    carried = 0.25
    _, screening = made(whole, "landmarks", lifting(whole, 0, carried=carried))
    up = (whole.aligned[RUN].time > UP + 1.0) & (whole.aligned[RUN].time < DOWN - 1.0)
    share = screening.load[RUN][up].mean(axis=0)
    np.testing.assert_allclose(share, (carried, 1.0 - carried), atol=0.05)


def test_a_foot_in_the_air_most_of_the_time_still_stands_for_the_rest(whole: Recording) -> None:
    """Its height is held against that of standing, not against that of the air."""
    one = whole.aligned[RUN]
    time, translation = one.time, one.states.translation.copy()
    translation[:, 2] += np.interp(time, [3.0, 3.4, 26.6, 27.0], [0.0, 0.06, 0.06, 0.0])
    translation[:, 2] += 0.01 * np.sin(time) * (translation[:, 2] > 0.05)
    up = replace(one, states=replace(one.states, translation=translation))
    _, screening = made(whole, "landmarks", up)
    (lost,) = [one for one in screening.left_out if (one.run, one.fault) == (RUN, Fault.LIFTED)]
    assert lost.share == pytest.approx(0.8, abs=0.03)
    assert f"had its {lost.foot} foot in the air" in screening.findings[0].reason
    assert lost.stretches[0][0] == pytest.approx(3.0, abs=0.4)
