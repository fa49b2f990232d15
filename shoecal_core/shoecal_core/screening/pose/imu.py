"""Does the IMU show how the base leans? By the legs, upwards is along the normal of the soles.

An IMU that is mounted upside down, or turned by a right angle about one of its axes, shows another
direction upwards in every posture, and one turn brings all of them back. One whose orientation is
that of a world with its z axis down, as of an aircraft, shows the opposite direction; one whose
orientation is frozen shows the same direction in all of them.
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
from shoecal_core.screening.verdict import Finding, name_runs

LEAST_RAD = float(np.radians(2.0))
"""Play, sag, zeros of joints and a floor out of level set IMU and legs apart by less."""
CLOSED = 0.5
"""Of that, the most that a turn may leave: of a robot that hardly leans little is to be seen."""
WRONG_RAD = 0.2
"""No floor that a robot stands on, and no joints of level soles, set them apart by as much."""

FROZEN = 0.2
"""Of the spread that the legs show of the direction upwards, what a frozen IMU shows at most; 13
simulated sessions came to 0.99 to 1.06, frozen ones to 0."""


@dataclass(frozen=True)
class FrozenImu:
    """An IMU whose direction upwards stays while the legs say that the base leans.

    Attributes:
        runs: their numbers.
        lean: spread of the direction upwards by the legs, root mean square [rad].
    """

    runs: tuple[int, ...]
    lean: float

    @property
    def text(self) -> str:
        """What is seen, and what to do."""
        return (
            f"the IMU's direction upwards stays in {name_runs(self.runs)}, while the base leans "
            f"to and fro by {np.degrees(self.lean):.1f} degrees by the legs: its orientation is "
            "frozen; see that its driver fuses it and sends it, or leave the IMU's topic out of "
            "the import"
        )


@dataclass(frozen=True)
class WrongMount:
    """An IMU whose direction upwards is not that of the legs.

    Attributes:
        off: between both directions, root mean square [rad].
        turn: what brings them together: axis times angle, along the axes of the IMU's frame [rad];
            None where no turn by right angles does.
        down: the z axis of the world that its orientation is given in points down.
    """

    off: float
    turn: FloatArray | None
    down: bool = False

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
        if self.down:
            return (
                f"{seen}: {self._axes}; have its driver give x forward, y left and z up (REP-103), "
                "or leave the IMU's topic out of the import"
            )
        return f"{seen}: it is turned against its frame; {self._turn} brings both together: {cure}"

    @property
    def _turn(self) -> str:
        """Its turn, in words."""
        turn = np.zeros(3) if self.turn is None else self.turn
        angle = float(np.linalg.norm(turn))
        axis = ", ".join(f"{one:.2g}" for one in np.round(turn / max(angle, 1e-9), 2) + 0.0)
        return f"a turn by {np.degrees(angle):.0f} degrees about its axis ({axis})"

    @property
    def _axes(self) -> str:
        """Those of an orientation in a world with z down, in words."""
        if self.turn is None or not np.any(self.turn):
            return "its orientation is given in a world with its z axis down (NED)"
        if np.allclose(np.abs(self.turn), [np.pi, 0.0, 0.0]):
            return "its orientation is that of axes forward, right, down in a world likewise (NED)"
        return f"its world has its z axis down (NED), and {self._turn} brings both together"


def wrong_imu(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned]
) -> WrongMount | FrozenImu | None:
    """Whether the IMU is mounted otherwise than its frame says, or its orientation is frozen.

    Args:
        runs: in double support, by number. aligned: the same with the model's values.

    Returns:
        None where it shows how the base leans, or there is none.
    """
    shown, expected, frozen = list[FloatArray](), list[FloatArray](), dict[int, float]()
    for number, one in aligned.items():
        up = upwards(runs[number], one.time)
        if up is not None:
            shown.append(up)
            expected.append(one.states.left_rotation[:, :, 2])
            lean = _spread(expected[-1])
            if lean > LEAST_RAD and _spread(up) < FROZEN * lean:
                frozen[number] = lean
    if frozen:
        return FrozenImu(tuple(frozen), max(frozen.values()))
    if not shown:
        return None
    measured, modelled = np.concatenate(shown), np.concatenate(expected)
    turns = Rotation.create_group("O")
    off = np.array([_off(turn.apply(measured), modelled) for turn in turns])
    down = np.array([_off(turn.apply(-measured), modelled) for turn in turns])
    now, best = _off(measured, modelled), int(np.argmin(off))
    if now > LEAST_RAD and down.min() < CLOSED * min(now, off[best]):
        return WrongMount(now, turns[int(np.argmin(down))].as_rotvec(), down=True)
    if now > LEAST_RAD and off[best] < CLOSED * now:
        return WrongMount(now, turns[best].as_rotvec())
    return WrongMount(now, None) if now > WRONG_RAD else None


def _spread(directions: FloatArray) -> float:
    """Root mean square of directions (T, 3) about their mean [rad]."""
    return float(np.sqrt(np.sum(np.var(directions, axis=0))))


def _off(one: FloatArray, other: FloatArray) -> float:
    """Root mean square of the angle between directions (T, 3) [rad]."""
    across = np.linalg.norm(np.cross(one, other), axis=1)
    angle = np.arctan2(across, np.sum(one * other, axis=1))
    return float(np.sqrt(np.mean(angle**2)))


def describe_imu(found: WrongMount | FrozenImu | None) -> list[Finding]:
    """An IMU that does not show how the base leans."""
    return [] if found is None else [Finding("FAIL", found.text, Fault.IMU)]
