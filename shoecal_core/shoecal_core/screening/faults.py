"""The faults that are looked for."""

from __future__ import annotations

from enum import Enum


class Fault(Enum):
    """A kind of fault; its value is its name in result files."""

    UNREADABLE = "unreadable"
    DEAD = "dead"
    STUCK = "stuck"
    SATURATED = "saturated"
    INVERTED = "inverted"
    SWAPPED = "swapped"
    MOVED_ZEROS = "moved_zeros"
    WRONG_WEIGHT = "wrong_weight"
    SPIKE = "spike"
    TOO_FAST = "too_fast"
    DISTURBED = "disturbed"
    LIFTED = "lifted"
    LIFTING = "lifting"
    SLIPPED = "slipped"
    TOO_LITTLE = "too_little"
    LATE = "late"
    SLOW = "slow"
