"""What may be wrong while the robot moves, and how soon it has to stop for it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StopReason:
    """A reason to stop.

    Attributes:
        code: constant of the action's result.
        message: what is wrong, with figures and the cure.
        can_wait: the robot is safer on both feet than still: it stops when both carry it.
    """

    code: int
    message: str
    can_wait: bool = False
