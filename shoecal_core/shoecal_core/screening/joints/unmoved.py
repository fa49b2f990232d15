"""Joints above the legs that do not move as their angles say: a motor that is off, commands that
were recorded in place of angles, a slipping gear.

The legs' angles are checked by the soles, a joint of an arm or of the waist by the CoP alone. What
its motion adds to the modelled CoM, d(t), is taken away again by the share a that fits best, along
with gains and offsets:
    sum_i A_i (g_i S_i + d_i) = W (1, c_y - a d_y, -(c_x - a d_x)) - b
A joint that moves has a = 0, one that stays a = 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import block_size, blocks, in_blocks
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, solve
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

LEAST_RAD = 0.1
"""Joints that move by less are left to the fit."""
SHARE = 0.5
"""Of its motion, that a joint lacks at least. Links' masses in a URDF are seldom off by as much,
and swinging arms move the CoP by less than that by their inertia: by a quarter at 0.5 Hz."""
LEAST_GAIN = 12.0
"""By which the sum of squares has to fall: three and a half standard deviations, since several
joints are tried."""
LEFT = 0.6
"""Of the sum of squares, that taking the motion away leaves at most; arms that stayed left 0.2 and
0.5, iCub's waist, which moves, 0.99."""


@dataclass(frozen=True)
class Unmoved:
    """A joint that does not move as its angle says.

    Attributes:
        joint: name.
        share: of its motion that it lacks.
        std: standard deviation of it.
        size: how far its motion moves the modelled CoM [m].
    """

    joint: str
    share: float
    std: float
    size: float


def unmoved_joint(
    runs: Mapping[int, Aligned], shoe: Shoe, kinematics: Kinematics, settings: CalibrationSettings
) -> Unmoved | None:
    """The joint above the legs whose standing still explains the CoP best; None without.

    Args:
        runs: aligned, in double support.
        shoe: whose n channels they are.
        kinematics: of the robot, shoes on.
    """
    robot = kinematics.robot
    if not runs:
        return None
    angles = {run: in_blocks(one.joint_angles, block_size(one.time)).mean(axis=1)
              for run, one in runs.items()}  # fmt: skip
    middle = np.median(np.concatenate(list(angles.values())), axis=0)
    moved = np.max([np.ptp(one, axis=0) for one in angles.values()], axis=0)
    joints = [
        index
        for index, name in enumerate(robot.joint_names)
        if name not in robot.leg_names and moved[index] > LEAST_RAD
    ]
    if not joints:
        return None
    parts = {run: blocks(one, shoe) for run, one in runs.items()}
    statics = Statics.of(shoe, parts, robot.weight, settings)
    com = {run: kinematics.states(one).com[:, 0, :2] for run, one in angles.items()}
    plain = statics.fit.cost
    found = list[tuple[float, Unmoved]]()
    for joint in joints:
        added = {}
        for run, one in angles.items():
            still = one.copy()
            still[:, joint] = middle[joint]
            added[run] = com[run] - kinematics.states(still).com[:, 0, :2]
        changed = {
            run: statics.robust[run].with_columns(_moments(one, settings.cop_std_m))
            for run, one in added.items()
        }
        # Any share is possible, as far as is known before.
        fit = solve(changed, np.append(statics.information, 1.0))
        std = float(np.sqrt(fit.covariance[-1, -1]))
        size = max(float(np.ptp(one, axis=0).max()) for one in added.values())
        name = robot.joint_names[joint]
        found.append((fit.cost, Unmoved(name, float(fit.vector[-1]), std, size)))
    cost, best = min(found, key=lambda one: one[0])
    if best.share < SHARE or cost > min(LEFT * plain, plain - LEAST_GAIN):
        return None
    return best


def _moments(added: FloatArray, cop_std_m: float) -> FloatArray:
    """(3, B, 1) what taking away a CoM (B, 2) [m] does to the whitened wrench."""
    columns = np.zeros((3, len(added), 1))
    columns[1, :, 0], columns[2, :, 0] = added[:, 1] / cop_std_m, -added[:, 0] / cop_std_m
    return columns


def describe_unmoved(found: Unmoved | None) -> list[Finding]:
    """A joint that does not move as its angle says."""
    if found is None:
        return []
    return [
        Finding(
            "FAIL",
            f"{found.joint} does not move as its angles say: {100.0 * found.share:.0f} ± "
            f"{200.0 * found.std:.0f} % of its motion, which moves the modelled CoM by "
            f"{1e3 * found.size:.0f} mm, is missing in the CoP; see that its motor is on, that "
            "measured angles are recorded and not commands, and that its links' masses are right, "
            "then record again",
            Fault.UNMOVED,
        )
    ]
