"""What of a simulated robot and its shoes is as chance and effects have made it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.stage import AnyStage
from shoecal_core.simulation.temperature import WarmUp


@dataclass(frozen=True)
class SampledBody:
    """The robot itself, as it truly is.

    Attributes:
        robot: as its files say, with the shoes on.
        mass: without shoes and payloads [kg].
        mass_factor: (L,) true mass over the model's, before all are scaled to `mass`.
        com_error: (L, 3) true CoM minus the model's, in the link's frame [m].
        payload: (L,) mass welded to a link where the model has the link's CoM [kg].
        encoder_error: (m,) encoder reading minus motor angle, where that is zero [rad].
        eccentricity: (m, 2) amplitude [rad] and phase [rad] of each encoder's error once a turn:
            see `encoders.Encoders`. Followers of a shared motor have none of their own.
        play: (m,) whole width of the dead band between motor and link [rad].
        compliance: (m,) give between motor and link [rad/(N m)].
        friction: (m, 2) of each joint's bearings and teeth: static, kinetic [N m].
        imu_mounting: (3,) rotation vector of the inertial sensor's frame in the root link's [rad].
        foot_placement: (2, 3) of left, right: the true sole frame in the model's, along x and y
            [m] and about z [rad]. Cells and plates go with the true one.
    """

    robot: Robot
    mass: float
    mass_factor: FloatArray
    com_error: FloatArray
    payload: FloatArray
    encoder_error: FloatArray
    eccentricity: FloatArray
    play: FloatArray
    compliance: FloatArray
    friction: FloatArray
    imu_mounting: FloatArray
    foot_placement: FloatArray

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of the URDF's links, L of them, the root first."""
        return link_names(self.robot)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, m of them."""
        return self.robot.joint_names


@dataclass(frozen=True)
class SampledShoes:
    """The shoes and the floor below them, as they truly are.

    Attributes:
        shoe: as its file says.
        position: (n, 2) where each channel acts, in its foot's sole frame [m].
        parameters: true output = gain * reading + offset, polarity included.
        noise: (n,) standard deviation of a reading's noise [N or N m].
        latency: (n,) age of a reading [s].
        mass_factor: (2,) true mass of each shoe's plates over the shoe file's.
        clamp_share: (2,) part of a foot's moment that the clamps carry past the cells.
        tilt: (2,) slope of the floor: its turn about x and about y [rad].
        ground_compliance: (2,) tilt of each shoe in the floor, a moment about its middle
            [rad/(N m)].
        full_scale: (n,) output at half the converter's span, of a nominal gain [N or N m].
        temperature: how warm the shoes are.
        stages: what signals pass between the channels and their converter, in any order.
    """

    shoe: Shoe
    position: FloatArray
    parameters: ChannelParameters
    noise: FloatArray
    latency: FloatArray
    mass_factor: FloatArray
    clamp_share: FloatArray
    tilt: FloatArray
    ground_compliance: FloatArray
    full_scale: FloatArray
    temperature: WarmUp
    stages: tuple[AnyStage, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """Names, n of them."""
        return self.shoe.names


def link_names(robot: Robot) -> tuple[str, ...]:
    """Links of the robot's URDF, the root first."""
    return tuple(frame.name for frame in robot.model.frames if frame.type == pin.FrameType.BODY)
