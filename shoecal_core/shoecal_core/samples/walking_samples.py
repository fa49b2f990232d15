"""What a diagnosis makes of a run in which feet move: walking, or stepping on the spot.

Single and double supports in which the feet that stand are flat and still count as stances
(`calibration.walking`). The body accelerates: the expected force is m (g + a_z), and the
expected CoP is the zero-moment point of a single mass at the CoM. What that leaves out, the
rate of the angular momentum L about the CoM, moves the zero-moment point by
    (-dL_y/dt, dL_x/dt) / (m (g + a_z))
and is kept separate, so that a diagnosis can ask whether it is needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.run import PoseSamples, Run
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.momentum import angular_momentum
from shoecal_core.samples.walking import World, derivative, in_world, walking_stances
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class Walk:
    """F samples of a run at the rate of its readings; what is between stances is NaN.

    Attributes:
        stance: (F,) number of each sample's stance, -1 between two.
        loaded: (S, 2) which feet carry each stance.
        force: (F,) expected vertical force [N].
        cop: (F, 2) zero-moment point of a single mass, in the stance's frame [m].
        spin: (F, 2) what the angular momentum adds to it [m].
    """

    stance: IntArray
    loaded: BoolArray
    force: FloatArray
    cop: FloatArray
    spin: FloatArray


def find_walk(run: Run, aligned: Aligned, shoe: Shoe, robot: Robot) -> Walk:
    """Stances of a run that names no double support.

    Raises:
        RecordingError: without the pose of the base.
        ShoecalError: when no foot ever stands flat and still under load.
    """
    base = run.base_pose
    if base is None or len(base.time) < 2:
        raise RecordingError(
            run.path,
            "names no double support and has no /base_pose to find the stances with; "
            "record one of the two",
        )
    world = in_world(aligned, base, robot)
    stances = walking_stances(run.info.run, aligned, world, shoe, robot)
    count = len(aligned.time)
    stance = np.full(count, -1)
    force, cop, added = np.full(count, np.nan), np.full((count, 2), np.nan), np.zeros((count, 2))
    shift = spin(aligned, base, world, robot)
    for number, one in enumerate(stances):
        here = np.searchsorted(aligned.time, one.time)
        stance[here], force[here], cop[here] = number, one.force, one.cop
        yaw = np.median(np.unwrap(world.yaw[here, one.loaded.index(True)]))
        c, s = np.cos(yaw), np.sin(yaw)
        added[here] = shift[here] @ np.array([[c, -s], [s, c]])
    return Walk(stance, np.array([one.loaded for one in stances]), force, cop, added)


def pieces(time: FloatArray, stance: IntArray, rate: float) -> FloatArray:
    """(F,) number of the piece of its stance that each sample is of, all about 1 / rate long.

    What a model of a walk misses within a step is in the readings too: fitted sample by sample,
    gains would shrink to hide it. Over a whole step accelerations even out.
    """
    found = np.zeros(len(time))
    for number in range(int(stance.max()) + 1):
        here = stance == number
        since = time[here] - time[here][0]
        count = max(1, round(float(since[-1]) * rate))
        found[here] = np.minimum(np.floor(since / max(float(since[-1]), 1e-9) * count), count - 1)
    return found


def spin(aligned: Aligned, base: PoseSamples, world: World, robot: Robot) -> FloatArray:
    """(F, 2) how far the angular momentum's rate moves the zero-moment point, in the world [m]."""
    momentum = angular_momentum(_poses(aligned, base), aligned.time, robot)
    rate = derivative(momentum, aligned.time, 1)
    force = robot.mass * (GRAVITY + world.acceleration[:, 2])
    return np.stack((-rate[:, 1], rate[:, 0]), axis=1) / force[:, None]


def _poses(aligned: Aligned, base: PoseSamples) -> FloatArray:
    """(F, 7 + m) of base and joints at the times of the readings."""
    time = np.clip(aligned.time, base.time[0], base.time[-1])
    turns = Slerp(base.time, Rotation.from_quat(base.quaternion))(time).as_quat()
    place = np.stack([np.interp(time, base.time, axis) for axis in base.position.T], axis=1)
    return np.hstack((place, turns, aligned.joint_angles))
