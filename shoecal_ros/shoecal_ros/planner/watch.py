"""What is watched while the robot moves, in addition to its joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shoecal_msgs.action import Plan

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner.foot_load import LoadWatch, needed_shares
from shoecal_ros.planner.heat import too_hot
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.silence import Silence
from shoecal_ros.planner.stop_reason import StopReason
from shoecal_ros.planner.tilt import Tilt, upward

COOL = "let its motors cool down, the robot sitting or held"


@dataclass(frozen=True)
class Senses:
    """What is received of a robot in addition to its joint angles; each of them may be missing.

    Attributes:
        imu, shoes, temperatures: what is heard.
        kinematics: of the robot.
        settings: bounds.
    """

    imu: ImuInput
    shoes: ShoeReports
    temperatures: TemperatureInput
    kinematics: Kinematics
    settings: MovingSettings

    @property
    def ages(self) -> dict[str, float]:
        """By quick source, since when it has sent nothing; infinite where it never did [s]."""
        return {"imu": self.imu.heard.age_s, **self.shoes.ages}

    @property
    def motor_ages(self) -> dict[str, float]:
        """The same of motors, which send their temperatures once in a while."""
        return {
            f"the temperature of '{joint}'": age for joint, age in self.temperatures.ages.items()
        }

    def tilt(
        self, joint_angles: FloatArray, support_phase: SupportPhase = SupportPhase.BOTH
    ) -> Tilt | None:
        """How the torso leans at joint angles (m,) [rad], feet flat; None where unknown."""
        up = self.imu.up
        if up is None or self.imu.heard.age_s > self.settings.stale_s:
            return None
        body = self.kinematics.states(joint_angles[None])
        return Tilt(up, upward(body, support_phase.standing))

    def unwatched(self, joint_angles: FloatArray) -> StopReason | None:
        """What would watch a motion and must, but does not come by now; (m,) joint angles [rad]."""
        settings, tilt = self.settings, self.tilt(joint_angles)
        if settings.tilt_required and (tilt is None or not tilt.usable):
            what = "nothing comes from imu" if tilt is None else "imu contradicts the joint angles"
            return StopReason(
                Plan.Result.SENSORS_STALE,
                f"{what}, so a fall would not be seen; start its driver, or set tilt_required to "
                "false",
            )
        if settings.load_required and self.shoes.heard.age_s > settings.stale_s:
            return StopReason(
                Plan.Result.SENSORS_STALE,
                "nothing comes from shoe/voltages, so lost load would not be seen; start "
                "shoe_driver, or set load_required to false",
            )
        return None

    def hot(self, limit: float) -> StopReason | None:
        """Motors at a limit or beyond [degC]."""
        problem = too_hot(self.temperatures.degc, limit)
        if not problem:
            return None
        return StopReason(Plan.Result.HOT_JOINTS, f"{problem}; {COOL}", can_wait=True)


class MotionWatch:
    """Watches a motion, in one part or several, by what was there when it began."""

    def __init__(
        self,
        senses: Senses,
        joint_angles: FloatArray,
        support_phase: SupportPhase = SupportPhase.BOTH,
    ) -> None:
        """The robot stands.

        Args:
            senses: what is heard.
            joint_angles: (m,) measured [rad].
            support_phase: the feet that stand.
        """
        self._senses, self._settings = senses, senses.settings
        settings = senses.settings
        self._silence = Silence(senses.ages, settings.stale_s)
        self._motor_silence = Silence(senses.motor_ages, settings.heat_stale_s)
        self._phases: tuple[Phase, ...] = ()
        self._load: LoadWatch | None = None
        tilt = senses.tilt(joint_angles, support_phase)
        self._tilt = tilt if tilt is not None and tilt.usable else None

    def begin(self, motion: Motion) -> None:
        """A part of the motion is sent now."""
        self._phases = motion.phases
        needed = needed_loads(motion, self._senses.kinematics)
        settings = self._settings
        self._load = LoadWatch(
            motion.time, needed, settings.load_needed, settings.follow_late, settings.load_lost_s
        )

    def support_phase(self, elapsed: float) -> SupportPhase:
        """Which feet carry at a time since the part was sent [s]."""
        for phase in self._phases:
            if elapsed < phase.end:
                return phase.support_phase
        return SupportPhase.BOTH

    def both_carry(self, elapsed: float) -> bool:
        """Whether both feet carry by then [s], even if the robot trails by `follow_late`."""
        earliest = elapsed - self._settings.follow_late
        return all(
            phase.support_phase is SupportPhase.BOTH
            for phase in self._phases
            if phase.begin <= elapsed and earliest < phase.end
        )

    def look(self, elapsed: float, joint_angles: FloatArray) -> StopReason | None:
        """What is wrong by now; what can wait comes last.

        Args:
            elapsed: since the part was sent [s].
            joint_angles: (m,) measured [rad].
        """
        return (
            self._tilted(elapsed, joint_angles)
            or self._load_lost(elapsed)
            or self._silent()
            or self._senses.hot(self._settings.hot_degc)
        )

    def _tilted(self, elapsed: float, joint_angles: FloatArray) -> StopReason | None:
        up = self._senses.imu.up
        if self._tilt is None or up is None:
            return None
        body = self._senses.kinematics.states(joint_angles[None])
        meant = upward(body, self.support_phase(elapsed).standing)
        error, bound = self._tilt.error(up, meant), self._settings.tilt_error
        if error <= bound:
            return None
        return StopReason(
            Plan.Result.TILTED,
            f"the torso leans {error:.2f} rad otherwise than its joints make it (tilt_error "
            f"{bound:g} rad); see that both feet are flat on even ground and nothing pushes it",
        )

    def _load_lost(self, elapsed: float) -> StopReason | None:
        problem = self._load.look(elapsed, self._senses.shoes.loaded) if self._load else ""
        if not problem:
            return None
        return StopReason(
            Plan.Result.LOAD_LOST,
            f"{problem}; see that nothing holds the robot and that its calibration is right",
        )

    def _silent(self) -> StopReason | None:
        senses = self._senses
        gone = self._silence.look(senses.ages) or self._motor_silence.look(senses.motor_ages)
        if not gone:
            return None
        return StopReason(
            Plan.Result.SENSORS_STALE,
            f"nothing comes any more from {gone}; check the driver and its cable",
            can_wait=True,
        )


def needed_loads(motion: Motion, kinematics: Kinematics) -> FloatArray:
    """(T, 2) load that the left and the right foot should have at least [N]."""
    robot = kinematics.robot
    shares = np.zeros((len(motion.time), 2))
    for phase in motion.phases:
        during = (motion.time >= phase.begin) & (motion.time <= phase.end)
        if phase.support_phase is not SupportPhase.BOTH:
            shares[during, phase.support_phase.standing] = 1.0
            continue
        left, right = (foot.outline for foot in robot.feet)
        right = phase.foot_poses[0].support.right_to_left(right)
        shares[during, 0] = needed_shares(motion.cop[during], left, right)
        shares[during, 1] = needed_shares(motion.cop[during], right, left)
    return shares * robot.weight
