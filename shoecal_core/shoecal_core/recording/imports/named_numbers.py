"""Messages that name their numbers, as joint states do: a name for each number, each name once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

COUNTED = {"position": "positions", "velocity": "velocities", "effort": "efforts"}
"""What joint states may give of each joint, and many of it."""


def uneven(joint_state: Any) -> str:
    """Why a joint state has no angle for each of its names, with the cure; empty where it has.

    Args:
        joint_state: content of a sensor_msgs/JointState: names and, as many or none, the numbers
            of COUNTED.
    """
    count = len(joint_state.name)
    if len(joint_state.position) == count:
        return ""
    given = ", ".join(f"{len(getattr(joint_state, key))} {many}" for key, many in COUNTED.items())
    return (
        f"none of its messages has a position for each of its names (the first has {count} names, "
        f"{given}); correct its sender, or name the topic of the measured joint angles in the "
        "mapping"
    )


def named_twice(names: Sequence[str], known: Sequence[str]) -> str:
    """What is wrong with names, with the cure: a known one is there twice. Empty where none is."""
    twice = [name for name in known if list(names).count(name) > 1]
    if not twice:
        return ""
    listed = ", ".join(f"'{name}'" for name in twice)
    return (
        f"one message names {listed} twice, so which of its numbers count is not known; have its "
        "sender name each once, and record again"
    )
