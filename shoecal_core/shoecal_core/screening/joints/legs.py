"""What the legs' joint angles say that cannot be: with such angles nothing else can be judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from shoecal_core.recording.run import Run
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.joints.angle_steps import coarse_step
from shoecal_core.screening.joints.dropouts import Dropouts, find_dropouts
from shoecal_core.screening.joints.loose_encoders import LooseEncoder, loose_encoder
from shoecal_core.screening.pose.carrying import MovingFoot, moving_feet
from shoecal_core.screening.pose.soles import Soles, open_soles
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class Legs:
    """Faults of the legs' angles.

    Attributes:
        soles: that are not level, by run.
        moving: feet that do not stay while they carry a walking robot, by run.
        step: of the angles, where it is coarse [rad].
        dropouts: joints between the feet whose angles were held.
        loose: the joint whose zero moves.
    """

    soles: Mapping[int, Soles] = field(default_factory=dict)
    moving: Mapping[int, MovingFoot] = field(default_factory=dict)
    step: float = 0.0
    dropouts: Sequence[Dropouts] = ()
    loose: LooseEncoder | None = None

    @property
    def wrong(self) -> bool:
        """The feet are not where the angles say."""
        return bool(self.soles or self.moving or self.dropouts or self.loose)


def examine_legs(
    runs: Mapping[int, Run],
    aligned: Mapping[int, Aligned],
    shoe: Shoe,
    kinematics: Kinematics,
    settings: CalibrationSettings,
) -> Legs:
    """Look for them in runs, by number, in which a foot carries the robot."""
    robot = kinematics.robot
    soles = open_soles(runs, aligned, shoe, kinematics)
    # What is wrong in every run is no zero that moves.
    always = len(soles) == len(runs)
    return Legs(
        soles,
        moving_feet(runs, aligned, shoe, robot),
        coarse_step(runs.values(), robot.leg_names, settings),
        find_dropouts(runs, [robot.joint_names[joint] for joint in robot.between_feet]),
        None if always else loose_encoder(runs, aligned, shoe, kinematics),
    )
