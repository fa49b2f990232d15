"""Wrong calibrations of many kinds: none is applied as checked while the robot stands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from shoecal_msgs.msg import ShoeForces
from shoecal_msgs.srv import SetCalibration

from ros.bodies import nao
from ros.nodes.calibrations import (
    COUNT,
    LAW,
    SHOE,
    STATED,
    SUPPORT,
    any_valid,
    apply,
    healthy,
    law,
    made,
    start,
)
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

UNTIL_2038_S = 2**31 - 1


def at(index: int, value: float, others: float = 0.0) -> np.ndarray[Any, np.dtype[np.float64]]:
    found = np.full(COUNT, others)
    found[index] = value
    return found


FEET = np.repeat([1.0, -1.0], COUNT // 2)
FRONT = np.tile([1.0, 1.0, -1.0, -1.0], 2)


def raw(**fields: object) -> Any:
    """A message with fields that no calibration has."""
    message = calibration_to_ros(healthy("wrong"))
    for name, value in fields.items():
        if name == "stamp_s":
            message.header.stamp.sec = value
        elif isinstance(value, float) and name in {"gain", "offset"}:
            getattr(message, name)[0] = value
        else:
            setattr(message, name, value)
    return message


WRONG = {
    "gains 15 % too large": made(parameters=law(1.15)),
    "gains 15 % too small": made(parameters=law(0.85)),
    "gains doubled": made(parameters=law(2.0)),
    "gains a tenth": made(parameters=law(0.1)),
    "gains a hundredth": made(parameters=law(0.01)),
    "gains a hundredfold": made(parameters=law(100.0), covariance=None),
    "gains of the other sign": made(parameters=law(-1.0)),
    "one gain of the other sign": made(parameters=law(at(2, -1.0, 1.0))),
    "one gain sixfold": made(parameters=law(at(5, 6.0, 1.0))),
    "one foot's gains larger, the other's smaller": made(parameters=law(1.0 + 0.3 * FEET)),
    "one offset 4 N too large": made(parameters=law(offset=at(2, 4.0))),
    "one offset 4 N too small": made(parameters=law(offset=at(6, -4.0))),
    "all offsets 1 N too large": made(parameters=law(offset=1.0)),
    "offsets 8 N more in front, less behind": made(parameters=law(offset=8.0 * FRONT)),
    "an offset beyond the converter": made(parameters=law(offset=at(0, 500.0))),
    "no offsets": made(parameters=ChannelParameters(LAW.gain, np.full(COUNT, 1e-3))),
    "cells of another place": made(parameters=ChannelParameters(LAW.gain, LAW.offset[::-1])),
    "columns 20 % too large": made(columns=1.2 * SHOE.columns),
    "cells 30 mm farther in front": made(
        columns=SHOE.columns - 0.03 * np.outer(SHOE.columns[:, 0], [0.0, 0.0, 1.0])
    ),
    "three times the weight": made(weight=3.0 * nao().weight),
    "a third of the weight": made(weight=nao().weight / 3.0),
    "2 N more weight": made(weight=nao().weight + 2.0),
    "a covariance a thousandfold": made(covariance=1e3 * STATED),
    "a covariance of 1e-9": made(covariance=1e-9 * STATED),
    "a covariance of nothing": made(covariance=0.0 * STATED),
    "a negative covariance": made(covariance=-STATED),
    "a covariance of one sided terms": made(covariance=STATED + 0.01 * np.eye(16, k=1)),
    "of 2038": raw(stamp_s=UNTIL_2038_S),
    "of 1999": raw(stamp_s=915_148_800),
    "of simulated time": raw(simulated_time=True),
    "a gain that is no number": raw(gain=math.nan),
    "an offset without end": raw(offset=math.inf),
    "a weight that is no number": raw(weight=math.nan),
    "a covariance that is no number": raw(covariance=[math.nan] * (2 * COUNT) ** 2),
}


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    """A calibrator that has confirmed its calibration by a robot that stands."""
    with World(tmp_path_factory.mktemp("standing")) as world:
        StandingRobot(world, SUPPORT).stand_as_modelled()
        start(world)
        assert apply(world, calibration_to_ros(healthy())).success
        world.until_reported("calibrator", "agreement", "mm off the model")
        yield world


@pytest.mark.parametrize("wrong", WRONG, ids=lambda one: one.replace(" ", "-"))
def test_no_wrong_calibration_is_applied_as_checked(standing: World, wrong: str) -> None:
    answer = apply(standing, WRONG[wrong])
    checked = answer.success and not (answer.unconfirmed or answer.disagrees)
    assert not checked, answer.message
    if not answer.success:
        assert answer.error_code in {
            SetCalibration.Response.BAD_CALIBRATION,
            SetCalibration.Response.NOT_APPLICABLE,
        }
        return
    # What cannot be told from a robot in the air is applied, and not usable.
    forces = standing.receive(ShoeForces, "shoe/forces", qos.LIVE)
    for message in forces.messages:
        assert message.calibration != "wrong" or not any_valid(message)
    assert apply(standing, calibration_to_ros(healthy())).success


def test_a_healthy_one_is_applied_as_checked(standing: World) -> None:
    answer = apply(standing, calibration_to_ros(healthy("again")))
    assert answer.success, answer.message
    assert not answer.unconfirmed
    assert not answer.disagrees
    assert "agrees with the robot: GRF is" in answer.message
    assert apply(standing, calibration_to_ros(healthy())).success
