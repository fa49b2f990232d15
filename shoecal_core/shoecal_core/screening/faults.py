"""The faults that are looked for."""

from __future__ import annotations

from enum import Enum


class Fault(Enum):
    """A kind of fault; its value is its name in result files."""

    TWINS = "twins"
    UNREADABLE = "unreadable"
    JOINT_ZERO = "joint_zero"
    BASE_POSE = "base_pose"
    IMU = "imu"
    UNIT = "unit"
    DEAD = "dead"
    STUCK = "stuck"
    CODES = "codes"
    HUM = "hum"
    BENT = "bent"
    UNEXPLAINED = "unexplained"
    SATURATED = "saturated"
    INVERTED = "inverted"
    SWAPPED = "swapped"
    MOVED_ZEROS = "moved_zeros"
    CHANGED_GAINS = "changed_gains"
    LEAKING = "leaking"
    WRONG_WEIGHT = "wrong_weight"
    PULLED = "pulled"
    SPIKE = "spike"
    TOO_FAST = "too_fast"
    DISTURBED = "disturbed"
    LIFTED = "lifted"
    LIFTING = "lifting"
    HANGING = "hanging"
    SLIPPED = "slipped"
    TOO_LITTLE = "too_little"
    LATE = "late"
    SLOW = "slow"
    SMOOTHED = "smoothed"
    UNMOVED = "unmoved"
    HELD = "held"
    COARSE_ANGLES = "coarse_angles"
