"""Every weight, horizon, radius and threshold of planning."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.settings import SettingError, Settings, setting

SOLVERS = ("sqp", "ipopt")
LEAN_WEIGHT, HEIGHT_WEIGHT = 1.0e3, 1.0e5
"""Of the torso's lean [1/rad^2] and height [1/m^2], in motions that pursue them."""


@dataclass(frozen=True)
class PlannerSettings(Settings):
    """Settings of double supports, postures and motions; see `config/nodes/planner.yaml`."""

    # Double supports
    supports: int = setting(5, "", "double supports of one calibration", minimum=1, maximum=100)
    distance_weight: float = setting(
        1.0, "1/m", "w_d, weight of the way between the feet in their distance d", minimum=0.0
    )
    orientation_weight: float = setting(
        0.1, "1/rad", "w_o, weight of the yaw between the feet in their distance d", minimum=0.0
    )
    distance_min: float = setting(
        0.11, "", "least distance d between the feet of a double support", minimum=0.0
    )
    foot_clearance: float = setting(
        0.006, "m", "least gap between the outlines of the two feet", minimum=0.0
    )
    support_pool: int = setting(
        16, "", "double supports that pass all checks, from which the sets are drawn", minimum=1
    )
    landmarks_in_reach: int = setting(
        3, "", "landmarks (of four) above which the robot must be able to stand", minimum=0,
        maximum=4,
    )  # fmt: skip
    one_foot: bool = setting(
        False, "", "draw only double supports in which one foot can carry the whole weight, as own "
        "steps need"
    )  # fmt: skip
    training_supports: int = setting(
        3, "", "fewer double supports are not asked to fix every observable direction", minimum=1
    )
    test_supports: int = setting(
        2, "", "double supports without which the others still fix those directions", minimum=0
    )

    # What the data would fix
    fixed_below: float = setting(
        0.8, "", "a direction counts as fixed when its relative uncertainty is below this (the fit "
        "asks for 1)", minimum=1e-6,
    )  # fmt: skip

    # Posture
    joint_margin: float = setting(
        0.03, "rad", "distance kept from the joints' limits while moving", minimum=0.0
    )
    knee_margin: float = setting(
        0.25, "rad", "least bend of a knee: near straight the feet can hardly be kept", minimum=0.0
    )
    stance_margin: float = setting(
        0.02, "rad", "distance kept from the limits when standing, beyond that while moving",
        minimum=0.0,
    )  # fmt: skip
    torque_share: float = setting(
        0.8, "", "part of a motor's torque limit that holding a posture may need, however the feet "
        "share the load", minimum=0.01, maximum=1.0,
    )  # fmt: skip
    load_share: float = setting(
        0.1, "", "part of the weight that each foot keeps at least while both stand, however they "
        "share it", minimum=0.0, maximum=0.5,
    )  # fmt: skip

    # Optimisation over one horizon
    horizon: int = setting(10, "states", "N, states of one optimisation", minimum=2, maximum=100)
    step_time: float = setting(
        0.25, "s", "time from one state to the next at full speed", minimum=0.01
    )
    cop_weight_x: float = setting(
        1.0e4, "1/m^2", "Q_c, weight of the CoP's distance to the landmark, forward", minimum=1e-6
    )
    cop_weight_y: float = setting(
        1.0e4, "1/m^2", "Q_c, weight of the CoP's distance to the landmark, sideways", minimum=1e-6
    )
    transition_weight: float = setting(
        5.0e3, "1/rad^2", "Q_u, weight of the change from one transition to the next", minimum=1e-6
    )
    joint_speed: float = setting(0.15, "rad/s", "largest speed of a leg joint", minimum=1e-3)
    stability_margin: float = setting(
        0.005, "m", "distance kept between CoP and the edge of the sensing polygon", minimum=0.0
    )
    one_foot_margin: float = setting(
        0.01, "m", "the same, between CoP and the edge of the one foot that carries", minimum=0.0
    )
    capsule_clearance: float = setting(
        0.003, "m", "d_min, least distance between two capsules", minimum=0.0
    )
    solver: str = setting(
        "sqp", "", "sqp (fast, falls back to ipopt) or ipopt (reference)", choices=SOLVERS
    )
    tolerance: float = setting(
        1.0e-5, "m, rad, N m", "largest violation of a constraint that a solution may have",
        minimum=1e-9, maximum=1e-3,
    )  # fmt: skip
    iterations: int = setting(200, "", "most iterations of one optimisation", minimum=1)

    # Rolling horizon (Algorithm 1)
    applied_states: int = setting(
        2, "states", "planned states that are taken over from each optimisation", minimum=1
    )
    landmark_radius: float = setting(
        0.004, "m", "r, a landmark is reached when the CoP is nearer than this", minimum=1e-4
    )
    progress_min: float = setting(
        0.0002, "m", "coming nearer by less than this in a step is no progress", minimum=0.0
    )
    progress_patience: int = setting(
        3, "steps", "steps without progress after which the next landmark is taken", minimum=1
    )
    steps_max: int = setting(600, "steps", "most steps of one motion", minimum=1)

    # Timing of a motion
    hold_time: float = setting(1.5, "s", "standing still before and after a motion", minimum=0.0)
    sample_rate: float = setting(50.0, "Hz", "points of a joint trajectory a second", minimum=10.0)
    joint_acceleration: float = setting(
        0.5, "rad/s^2", "largest acceleration of a leg joint", minimum=1e-3
    )
    com_speed: float = setting(0.014, "m/s", "largest speed of the CoM", minimum=1e-4)
    dynamic_cop_error: float = setting(
        0.0004, "m", "largest shift of the CoP that the CoM's acceleration causes", minimum=1e-6
    )
    foot_drift: float = setting(
        0.0001, "m, rad", "largest change of the pose between the feet that a check lets pass",
        minimum=1e-6,
    )  # fmt: skip

    # Motions beyond the paper's
    dwell_time: float = setting(8.0, "s", "standing still at each landmark of `hold`", minimum=0.0)
    lift: float = setting(
        0.025, "m", "how high an unloaded foot is lifted; gears take some", minimum=1e-3
    )
    unloaded_time: float = setting(3.0, "s", "how long it stays there", minimum=0.0)
    tilt: float = setting(
        0.1, "rad", "how far `torso_tilt` leans the torso each way", minimum=0.0, maximum=0.5
    )
    sink: float = setting(0.015, "m", "how far `height` lowers the torso", minimum=0.0)

    # Own steps
    step_lift: float = setting(0.015, "m", "how high a foot is lifted to be carried", minimum=5e-3)
    step_clearance: float = setting(
        0.015, "m", "least gap between the feet while one is carried; gears take some", minimum=0.0
    )
    step_pace: float = setting(
        2.5, "", "factor on all speeds while one foot carries: its motors get hot",
        minimum=0.1, maximum=5.0,
    )  # fmt: skip
    step_error: float = setting(
        0.004, "m", "feet nearer to a double support than this stand in it", minimum=1e-4
    )
    step_yaw_error: float = setting(0.02, "rad", "the same, of the yaw between them", minimum=1e-4)

    # A start that is measured
    sole_height: float = setting(
        0.005, "m", "largest difference of height between the soles of a standing robot; at most "
        "half of lift and step_lift", minimum=0.0,
    )  # fmt: skip
    sole_tilt: float = setting(
        0.1, "rad", "largest tilt between the soles of a standing robot", minimum=0.0
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if 2.0 * self.sole_height > min(self.lift, self.step_lift):
            raise SettingError(
                "sole_height",
                f"{self.sole_height:g} m takes a foot in the air for one that stands; set it to at "
                "most half of lift and step_lift",
            )

    @property
    def cop_weights(self) -> FloatArray:
        """(5,) where nothing but the CoP is pursued (the paper's Q_c); see Aim."""
        return np.array([self.cop_weight_x, self.cop_weight_y, 0.0, 0.0, 0.0])

    @property
    def task_weights(self) -> FloatArray:
        """(5,) of CoP, lean and height where all are pursued; see Aim."""
        weights = self.cop_weights
        weights[2:] = LEAN_WEIGHT, LEAN_WEIGHT, HEIGHT_WEIGHT
        return weights

    def finer(self) -> Self:
        """Settings under which a motion has twice as many states, half as far apart."""
        return dataclasses.replace(
            self,
            step_time=self.step_time / 2.0,
            steps_max=self.steps_max * 2,
            progress_min=self.progress_min / 2.0,
            progress_patience=self.progress_patience * 2,
        )

    def paced(self, pace: float) -> Self:
        """Settings under which a motion takes 1 / pace of the time."""
        return dataclasses.replace(
            self,
            joint_speed=self.joint_speed * pace,
            com_speed=self.com_speed * pace,
            joint_acceleration=self.joint_acceleration * pace**2,
            dynamic_cop_error=self.dynamic_cop_error * pace**2,
            step_time=self.step_time / pace,
        )
