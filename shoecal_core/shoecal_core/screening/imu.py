"""Is the IMU mounted as its frame says? By the legs, upwards is along the normal of the soles.

An IMU that is mounted upside down, or turned by a right angle about one of its axes, shows another
direction upwards in every posture, and one turn brings all of them back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.side_channels import upwards
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

LEAST_RAD = float(np.radians(2.0))
"""Play, sag, zeros of joints and a floor out of level set IMU and legs apart by less."""
CLOSED = 0.5
"""Of that, the most that a turn may leave: of a robot that hardly leans little is to be seen."""
WRONG_RAD = 0.2
"""No floor that a robot stands on, and no joints of level soles, set them apart by as much."""


@dataclass(frozen=True)
class WrongMount:
    """An IMU whose direction upwards is not that of the legs.

    Attributes:
        off: between both directions, root mean square [rad].
        turn: what brings them together: axis times angle, along the axes of the IMU's frame [rad];
            None where no turn by right angles does.
    """

    off: float
    turn: FloatArray | None

    @property
    def text(self) -> str:
        """What is seen, and the turn that explains it."""
        seen = (
            f"by the IMU the soles are tilted by {np.degrees(self.off):.0f} degrees against what "
            "the legs say"
        )
        cure = (
            "correct the origin of its frame in the URDF or the turn in its driver, or leave the "
            "IMU's topic out of the import"
        )
        if self.turn is None:
            return f"{seen}: see how it is mounted, and whether its frame is the base's; {cure}"
        angle = float(np.linalg.norm(self.turn))
        axis = ", ".join(f"{one:.2g}" for one in np.round(self.turn / angle, 2) + 0.0)
        return (
            f"{seen}: it is turned against its frame; a turn by {np.degrees(angle):.0f} degrees "
            f"about its axis ({axis}) brings both together: {cure}"
        )


def wrong_mount(runs: Mapping[int, Run], aligned: Mapping[int, Aligned]) -> WrongMount | None:
    """Whether the IMU is mounted otherwise than its frame says.

    Args:
        runs: in double support, by number. aligned: the same with the model's values.

    Returns:
        None where it is mounted as it says, or there is none.
    """
    shown, expected = list[FloatArray](), list[FloatArray]()
    for number, one in aligned.items():
        up = upwards(runs[number], one.time)
        if up is not None:
            shown.append(up)
            expected.append(one.states.left_rotation[:, :, 2])
    if not shown:
        return None
    measured, modelled = np.concatenate(shown), np.concatenate(expected)
    turns = Rotation.create_group("O")
    off = np.array([_off(turn.apply(measured), modelled) for turn in turns])
    now, best = _off(measured, modelled), int(np.argmin(off))
    if now > LEAST_RAD and off[best] < CLOSED * now:
        return WrongMount(now, turns[best].as_rotvec())
    return WrongMount(now, None) if now > WRONG_RAD else None


def _off(one: FloatArray, other: FloatArray) -> float:
    """Root mean square of the angle between directions (T, 3) [rad]."""
    across = np.linalg.norm(np.cross(one, other), axis=1)
    angle = np.arctan2(across, np.sum(one * other, axis=1))
    return float(np.sqrt(np.mean(angle**2)))


def describe_imu(found: WrongMount | None) -> list[Finding]:
    """An IMU that is mounted otherwise than its frame says."""
    return [] if found is None else [Finding("FAIL", found.text, Fault.IMU)]
