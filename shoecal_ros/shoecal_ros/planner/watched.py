"""What would be watched in a motion by now, and what not, for diagnostics."""

from __future__ import annotations

import math

from shoecal_core.arrays import FloatArray
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.planner import heat
from shoecal_ros.planner.silence import silent
from shoecal_ros.planner.watch import Senses


def watched(senses: Senses, joint_angles: FloatArray | None) -> dict[str, Condition]:
    """Tilt, shoes and heat; what never came is missing, what came and comes no more has failed.

    Args:
        senses: what is heard, and how motions are watched.
        joint_angles: (m,) the last ones [rad]; None before there were any.
    """
    return {
        "tilt": _tilt(senses, joint_angles),
        "shoes": _shoes(senses),
        "heat": _heat(senses),
    }


def _tilt(senses: Senses, joint_angles: FloatArray | None) -> Condition:
    settings, heard = senses.settings, senses.imu.heard
    figures = heard.figures()
    if math.isinf(heard.age_s):
        if settings.tilt_required:
            problem = "no imu: nothing moves; start its driver, or set tilt_required to false"
            return Condition(Level.WARN, problem, figures, Code.IMU_STALE)
        return Condition(Level.OK, "no imu: not watched", figures)
    if heard.age_s > settings.stale_s:
        reported = f"no imu for {heard.age_s:.0f} s: not watched; check its driver"
        return Condition(Level.WARN, reported, figures, Code.IMU_STALE)
    tilt = None if joint_angles is None else senses.tilt(joint_angles)
    if tilt is None:
        return Condition(Level.OK, "imu comes", figures)
    if not tilt.usable:
        return Condition(
            Level.WARN,
            f"imu and joints disagree by {tilt.offset:.1f} rad: not watched; let its frame_id "
            "name a link of the URDF on the torso, or the robot stand",
            figures,
            Code.IMU_CONTRADICTS,
        )
    return Condition(Level.OK, "imu comes", {**figures, "offset_rad": f"{tilt.offset:.3f}"})


def _shoes(senses: Senses) -> Condition:
    settings, heard = senses.settings, senses.shoes.heard
    figures = heard.figures()
    if math.isinf(heard.age_s):
        if settings.load_required:
            problem = (
                "no shoe/voltages: nothing moves; start shoe_driver, or set load_required to false"
            )
            return Condition(Level.WARN, problem, figures, Code.SHOES_STALE)
        return Condition(Level.OK, "no shoe/voltages: not watched", figures)
    if heard.age_s > settings.stale_s:
        reported = f"no shoe/voltages for {heard.age_s:.0f} s: not watched; check the shoes' driver"
        return Condition(Level.WARN, reported, figures, Code.SHOES_STALE)
    return Condition(Level.OK, "shoe/voltages comes", figures)


def _heat(senses: Senses) -> Condition:
    settings = senses.settings
    degc = senses.temperatures.degc
    found = heat.hottest(degc)
    figures = {} if found is None else {"joint": found[0], "degc": f"{found[1]:.1f}"}
    reason = senses.hot(settings.hot_degc)
    if reason is not None:
        return Condition(Level.WARN, reason.message, figures, Code.MOTOR_HOT)
    gone = silent(senses.motor_ages, settings.heat_stale_s)
    if gone:
        reported = f"nothing comes any more from {gone}: not watched; check the robot's driver"
        return Condition(Level.WARN, reported, figures, Code.HEAT_STALE)
    return Condition(Level.OK, heat.margin(degc, settings.hot_degc), figures)
