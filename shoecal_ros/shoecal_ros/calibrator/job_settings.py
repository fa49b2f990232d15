"""What a job that moves the robot does where nothing else is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.planning.motion_sets import MOTION_SETS, STANDARD
from shoecal_core.settings import Settings, setting

MOST_SUPPORTS = 100


@dataclass(frozen=True)
class JobSettings(Settings):
    """Of self-calibrations and diagnoses; wall-clock times."""

    supports: int = setting(5, "", "double supports to visit", minimum=2, maximum=MOST_SUPPORTS)
    train: int = setting(3, "", "of them used for the fit, the others test it", minimum=2)
    seed: int = setting(1, "", "draws the supports, and which of them train", minimum=0)
    motion: str = setting(
        STANDARD, "", "what to record: a set of motions ("
        + "; ".join(f"{name}: {one.doc}" for name, one in MOTION_SETS.items())
        + "), or one motion of the planner's catalogue in each support, as the paper's landmarks",
    )  # fmt: skip
    target_m: float = setting(
        0.0, "m", "expected CoP error of each foot at which no further run trains, of a "
        "self-calibration by the joint fit; 0: all train", minimum=0.0,
    )  # fmt: skip
    sessions_dir: str = setting(
        "~/.ros/shoecal/sessions",
        "",
        "folder that takes one folder a recorded session",
    )
    planner_file: str = setting(
        "", "", "the planner's parameter file; empty: the configuration's nodes/planner.yaml"
    )
    manual_file: str = setting(
        "",
        "",
        "calibration of these shoes by `shoecal manual shoe`, a prior of each self-calibration, as "
        "`shoecal calibrate --manual FILE`; empty: none",
    )
    apply_warned: bool = setting(
        False, "", "also apply a calibration whose checks passed with warnings"
    )
    lead_s: float = setting(
        0.5, "s", "robot's time recorded before the motion is sent", minimum=0.0, maximum=60.0
    )
    still_speed: float = setting(
        0.01, "rad/s", "a robot whose joints are slower stands still", minimum=1e-4
    )
    still_time: float = setting(
        0.5, "s", "robot's time for which it must be so", minimum=0.05, maximum=60.0
    )
    still_resolution: float = setting(
        0.004, "rad", "changes up to this are the encoders', not the robot's", minimum=0.0
    )
    still_timeout_s: float = setting(30.0, "s", "in which it must stand still", minimum=1.0)
    reach_timeout_s: float = setting(
        600.0, "s", "in which a support must be reached; a person may have to", minimum=1.0
    )
    motion_timeout_s: float = setting(
        900.0, "s", "in which a motion must be planned and done", minimum=1.0
    )
