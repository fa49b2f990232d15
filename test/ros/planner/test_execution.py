from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from shoecal_msgs.action import Plan

from ros.bodies import nao
from ros.clock import Clock
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.kinematics import Kinematics
from shoecal_core.planning.carrying import Carrying
from shoecal_core.planning.horizon.rolling import Path
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.posture import stance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.execution import Execution
from shoecal_ros.planner.order import Mover, Order
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.watch import Senses

SUPPORT = DoubleSupport(0.0, -0.11, 0.0)
ANGLES = nao().from_legs(stance(nao(), SUPPORT))


def standing() -> Motion:
    """A motion in which nothing moves, 1 s long."""
    time = np.linspace(0.0, 1.0, 51)
    positions = np.tile(ANGLES, (len(time), 1))
    pose, none = FootPose.of(SUPPORT), np.zeros(0)
    path = Path(
        np.zeros((1, len(nao().legs))), np.zeros((0, 2)), none, none.astype(np.int64), (), none
    )
    return Motion(
        "standing", SUPPORT, pose, nao().joint_names, time, positions, np.zeros_like(positions),
        np.tile([0.0, -0.055], (len(time), 1)), path,
        (Phase("both", Carrying.BOTH, 0.0, 1.0, (pose, pose)),),
    )  # fmt: skip


def test_who_disarms_and_arms_at_once_stops_the_robot_for_good() -> None:
    clock, sent = Clock(), list[JointTrajectory]()
    arming = Arming(10.0, clock)
    arming.set(True)
    mover = SimpleNamespace(
        robot=nao(),
        kinematics=Kinematics(nao()),
        planning=PlannerSettings(),
        moving=MovingSettings(),
        arming=arming,
        joints=SimpleNamespace(latest=JointBatch(np.array([1]), ANGLES[None]), problem=""),
        senses=Senses(
            ImuInput(nao(), clock), ShoeReports(clock=clock), TemperatureInput(nao(), clock)
        ),
        command=sent.append,
    )
    order = Order(True, lambda: False, lambda *_: None)
    execution = Execution(cast(Mover, mover), order)
    execution.check_ready()
    following = execution.follow(execution.commanded(standing()), standing())
    following.send(None)
    assert execution.following
    assert len(sent) == 1
    arming.set(False)
    arming.set(True)
    with pytest.raises(RefusedError, match="disarmed since") as refusal:
        following.send(None)
    assert refusal.value.code == Plan.Result.NOT_ARMED
    assert not execution.following
    np.testing.assert_allclose(sent[1].positions[0], ANGLES[nao().moved])
    with pytest.raises(RefusedError, match="disarmed since"):
        execution.check_ready()
    Execution(cast(Mover, mover), order).check_ready()
