"""Which feet carry the robot, and where its CoP may be then."""

from __future__ import annotations

from enum import StrEnum

import shapely

from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.robot import Robot


class SupportPhase(StrEnum):
    """The feet that stand on the floor; the other one is in the air."""

    BOTH = "both"
    LEFT = "left"
    RIGHT = "right"

    @property
    def share(self) -> tuple[float, float]:
        """Least and greatest share of the weight on the left foot."""
        return {"both": (0.0, 1.0), "left": (1.0, 1.0), "right": (0.0, 0.0)}[self.value]

    @property
    def feet(self) -> tuple[bool, bool]:
        """Whether left, right stand."""
        return self is not SupportPhase.RIGHT, self is not SupportPhase.LEFT

    @property
    def other(self) -> SupportPhase:
        """The other foot instead; both stay both."""
        return {
            SupportPhase.BOTH: SupportPhase.BOTH,
            SupportPhase.LEFT: SupportPhase.RIGHT,
            SupportPhase.RIGHT: SupportPhase.LEFT,
        }[self]

    @property
    def standing(self) -> int:
        """Index into the robot's feet of one that stands; of both the left one."""
        return 1 if self is SupportPhase.RIGHT else 0

    def margin(self, settings: PlannerSettings) -> float:
        """How far the CoP keeps from the edge of where it may be [m]."""
        both = self is SupportPhase.BOTH
        return settings.stability_margin if both else settings.one_foot_margin

    def polygon(self, robot: Robot, foot_pose: FootPose) -> shapely.Polygon:
        """Where the CoP may be, left sole's frame [m].

        The hull of both sensing polygons, or that of the one foot that carries.
        """
        if self is SupportPhase.BOTH:
            return sensing_hull(robot, foot_pose.support)
        left, right = (foot.sensing_polygon for foot in robot.feet)
        if self is SupportPhase.LEFT:
            return shapely.Polygon(left)
        return shapely.Polygon(foot_pose.support.right_to_left(right))
