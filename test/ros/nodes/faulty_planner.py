"""The planner node, with a watch that fails once in the first motion."""

from __future__ import annotations

from shoecal_core.arrays import FloatArray
from shoecal_ros.nodes.planner import main
from shoecal_ros.planner.stop_reason import StopReason
from shoecal_ros.planner.watch import MotionWatch

AFTER_S = 2.0
"""Since the motion's begin, by the robot's time."""

_look = MotionWatch.look


def _fail_once(self: MotionWatch, elapsed: float, joint_angles: FloatArray) -> StopReason | None:
    if elapsed > AFTER_S:
        MotionWatch.look = _look  # type: ignore[method-assign]
        raise ZeroDivisionError("made up,\nof two lines")
    return _look(self, elapsed, joint_angles)


if __name__ == "__main__":
    MotionWatch.look = _fail_once  # type: ignore[method-assign]
    main()
