"""Calibrations that are set, and what `shoe/forces` then says of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from shoecal_msgs.msg import ShoeForces
from shoecal_msgs.srv import SetCalibration

from ros.bodies import calibration, nao, nao_shoe, parameters
from ros.world import Received, World
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_ros.common.conversions import calibration_to_ros

SUPPORT = DoubleSupport(0.0, -0.112, 0.0)
SHOE, LAW = nao_shoe(), parameters(nao_shoe())
COUNT = len(SHOE.names)
STATED = 0.01 * np.eye(2 * COUNT)
"""GRF to 0.3 N."""


def start(world: World) -> None:
    """Readings that a busy machine brings late are not stale here."""
    late = {"stale_s": 10.0, "live_stale_s": 10.0}
    world.start("calibrator", {**late, "state_dir": world.folder / "state"})


def healthy(identity: str = "healthy", **changes: object) -> Calibration:
    return calibration(nao(), SHOE, identity, **{"covariance": STATED, **changes})


def apply(world: World, message: Any, *, force: bool = False) -> Any:
    request = SetCalibration.Request(calibration=message, force=force)
    return world.call(SetCalibration, "shoe/set_calibration", request)


def until(world: World, heard: Received, condition: Callable[[Any], bool], what: str) -> Any:
    world.until(lambda: len(heard) and condition(heard.last), waited_for=what)
    return heard.last


def usable(one: ShoeForces) -> bool:
    return bool(one.left.valid and one.right.valid and one.both.valid)


def any_valid(one: ShoeForces) -> bool:
    return bool(one.left.valid or one.right.valid or one.both.valid)


def law(gain: Any = 1.0, offset: Any = 0.0) -> ChannelParameters:
    """Gains times a factor, and offsets plus a force [N]."""
    return ChannelParameters(LAW.gain * gain, LAW.offset + offset)


def made(**changes: object) -> Any:
    """A message of a wrong one."""
    return calibration_to_ros(healthy("wrong", **changes))
