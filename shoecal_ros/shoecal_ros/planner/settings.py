"""Settings of sending motions and watching them."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.settings import Settings, setting


@dataclass(frozen=True)
class MovingSettings(Settings):
    """How motions are sent and watched; wall-clock times unless said otherwise."""

    arm_timeout_s: float = setting(
        900.0, "s", "without use for that long it disarms: time to place the robot", minimum=1.0
    )
    other_commanders: str = setting(
        "",
        "",
        "nodes that may publish joint_trajectory, too, as a walk engine: names, by commas",
    )
    stale_s: float = setting(
        0.5,
        "s",
        "without joint angles, or what else came before, for that long a motion is stopped",
        minimum=0.01,
    )
    follow_error: float = setting(
        0.12, "rad", "a joint farther off its trajectory stops the motion", minimum=1e-3
    )
    follow_late: float = setting(
        1.0, "s", "the robot may trail its trajectory by this (robot's time)", minimum=0.0
    )
    start_error: float = setting(
        0.03, "rad", "a joint that moved farther while planning refuses the motion", minimum=1e-4
    )
    stop_time: float = setting(0.5, "s", "in which a stopped robot comes to rest", minimum=0.05)
    chunk_states: int = setting(8, "states", "planned states of one streamed part", minimum=4)
    give: float = setting(
        0.03, "rad", "most that a standing joint may be behind streamed commands", minimum=1e-3
    )
    tilt_required: bool = setting(
        True,
        "",
        "without a usable imu nothing moves; false: falls are not seen where there is none",
    )
    load_required: bool = setting(
        True, "", "without shoe/voltages nothing moves; false: loads are not watched then"
    )
    tilt_error: float = setting(
        0.1, "rad", "a torso (/imu) that leans farther from what is meant stops it", minimum=1e-3
    )
    load_needed: float = setting(
        8.0, "N", "a foot on which the planned CoP puts more than this has to carry", minimum=1.0
    )
    load_lost_s: float = setting(
        0.3, "s", "without load for that long (robot's time) such a foot stops it", minimum=0.0
    )
    hot_degc: float = setting(
        68.0, "degC", "a joint's motor this hot stops the motion", minimum=0.0
    )
    cool_by: float = setting(
        5.0, "degC", "by which every motor must be cooler than that to begin", minimum=0.0
    )
    heat_stale_s: float = setting(
        10.0,
        "s",
        "a motor that reported its temperature before, and does not for that long, stops a motion",
        minimum=0.1,
    )
    steps: bool = setting(
        False,
        "",
        "offers robot/reach_support by own steps, for robots without a walk engine",
    )
