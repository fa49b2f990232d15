"""One part of a motion: what it pursues and what it keeps, from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.horizon.problem import Aim, Scene
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.robot import Robot


@dataclass(frozen=True)
class MotionSegment:
    """A part of a motion.

    Attributes:
        name: for people and recordings, for example `landmarks` or `swing`.
        targets: (L, 5) pursued one after another: CoP [m], lean, height of the base [m], in the
            frame of the foot that carries (of the left one when both do).
        weights: (5,) of what is pursued; see Aim.
        arrival: (5,) weights by which a target counts as reached; those where not given.
        foot_poses: one a state, the last one stays: how the feet are placed.
        support_phase: which feet stand.
        pace: factor on all speeds.
        pause: standing still at its end [s].
        loaded: whether left, right have to keep load and grip, as a foot that is about to be
            lifted has not.
    """

    name: str
    targets: FloatArray
    weights: FloatArray
    foot_poses: tuple[FootPose, ...]
    support_phase: SupportPhase = SupportPhase.BOTH
    pace: float = 1.0
    pause: float = 0.0
    arrival: FloatArray | None = None
    loaded: tuple[bool, bool] = (True, True)

    def __post_init__(self) -> None:
        if not self.foot_poses:
            raise ShoecalError(f"part '{self.name}' of a motion has no pose of the feet")
        if not np.all(np.isfinite(self.targets)):
            raise ShoecalError(f"part '{self.name}' has targets that are not finite numbers")
        if len(self.foot_poses) > 1 and not len(self.targets):
            raise ShoecalError(f"part '{self.name}' moves a foot but pursues nothing")

    @property
    def moving(self) -> bool:
        """Whether a foot is on its way."""
        return len(self.foot_poses) > 1

    def pose(self, state: int) -> FootPose:
        """Between the feet, at a state counted from the part's start."""
        return self.foot_poses[min(state, len(self.foot_poses) - 1)]

    def scene(
        self, robot: Robot, settings: PlannerSettings, others: FloatArray, state: int
    ) -> Scene:
        """What the states after one, counted from the part's begin, have to keep.

        Args:
            robot: whose feet.
            settings: horizon and margins.
            others: (m,) all joint angles [rad].
            state: where the horizon begins.
        """
        support_phase, margin = self.support_phase, self.support_phase.margin(settings)
        share, feet = support_phase.share, support_phase.feet
        loaded = (self.loaded[0] and feet[0], self.loaded[1] and feet[1])
        return Scene.row(
            [
                Scene.of(support_phase.polygon(robot, pose), margin, pose, others, share, loaded)
                for pose in self._ahead(state, settings.horizon)
            ]
        )

    def aim(self, target: FloatArray, horizon: int, state: int) -> Aim:
        """A target (5,) for the states after one, counted from the part's start."""
        if self.support_phase is not SupportPhase.RIGHT:
            return Aim(target[None], self.weights)
        poses = self._ahead(state, horizon)
        return Aim(
            np.array([in_left(target, pose, self.support_phase) for pose in poses]), self.weights
        )

    def local(self, tasks: FloatArray, state: int) -> FloatArray:
        """(5,) what is pursued, in the frame of `targets`, from tasks (5,) of a state [m, -, m]."""
        return in_standing(tasks, self.pose(state), self.support_phase)

    def _ahead(self, state: int, horizon: int) -> list[FootPose]:
        """Of the states after one; a single pose where no foot is on its way."""
        count = horizon if self.moving else 1
        return [self.pose(state + index) for index in range(1, count + 1)]

    @property
    def left_targets(self) -> FloatArray:
        """(L, 2) places for the CoP in the left sole's frame as it is at the part's end [m]."""
        if self.support_phase is not SupportPhase.RIGHT:
            return self.targets[:, :2]
        return self.foot_poses[-1].support.right_to_left(self.targets[:, :2])


def in_left(tasks: FloatArray, pose: FootPose, support_phase: SupportPhase) -> FloatArray:
    """Tasks (5,) [m, -, m] in the left sole's frame from the carrying foot's; soles are level."""
    if support_phase is not SupportPhase.RIGHT:
        return tasks
    support = pose.support
    cop = support.right_to_left(tasks[:2])
    return np.array([*cop, *(support.rotation @ tasks[2:4]), tasks[4] + pose.translation[2]])


def in_standing(tasks: FloatArray, pose: FootPose, support_phase: SupportPhase) -> FloatArray:
    """Tasks (5,) [m, -, m] in the carrying foot's frame from those in the left sole's frame."""
    if support_phase is not SupportPhase.RIGHT:
        return tasks
    support = pose.support
    cop = support.left_to_right(tasks[:2])
    return np.array([*cop, *(support.rotation.T @ tasks[2:4]), tasks[4] - pose.translation[2]])


def cop_segment(
    name: str,
    places: FloatArray,
    foot_pose: FootPose,
    settings: PlannerSettings,
    *,
    pace: float = 1.0,
) -> MotionSegment:
    """Places (L, 2) for the CoP [m], pursued on both feet; nothing else is (paper, Algorithm 1)."""
    targets = np.zeros((len(places), 5))
    targets[:, :2] = places
    weights = settings.cop_weights
    # However the torso leans, a place is reached when the CoP is there.
    arrival = weights * [1.0, 1.0, 0.0, 0.0, 0.0]
    return MotionSegment(name, targets, weights, (foot_pose,), pace=pace, arrival=arrival)
