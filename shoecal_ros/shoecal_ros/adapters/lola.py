"""Numbers of a NAO's joints in the messages of nao_lola."""

from __future__ import annotations

from collections.abc import Sequence

NUMBERS = {
    name: number
    for number, name in enumerate(
        (
            "HeadYaw", "HeadPitch",
            "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw",
            "LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll",
            "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll",
            "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw",
            "LHand", "RHand",
        )
    )
}  # fmt: skip
"""By name; RHipYawPitch has none, as both hips turn with LHipYawPitch's motor."""


def numbered(names: Sequence[str], angles: Sequence[float]) -> tuple[list[int], list[float]]:
    """Numbers and angles of the joints that have a number."""
    known = [
        (NUMBERS[name], float(angle))
        for name, angle in zip(names, angles, strict=True)
        if name in NUMBERS
    ]
    return [number for number, _ in known], [angle for _, angle in known]
