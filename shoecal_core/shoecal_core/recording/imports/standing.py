"""How feet stand, by joint angles and by the load that they carry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.joint_series import Series, postures, with_numbers
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_laws import leg_joints
from shoecal_core.robot.joint_zeros import OpenLoop, open_loop
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.level import standing_samples
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import both_carry_load

SAMPLES = 200
"""Instants of a recording that are looked at, evenly."""
STILL_M = 0.01
"""Feet whose distance changes by less stand still."""
OUTER, OUTER_LOADED = 0.0, 15.0
"""Percentiles between which that is: of all instants, and of those at which both feet carry load,
of which some are of a foot that is about to leave or to land."""
LEAST_BOTH = 0.05
"""Of a recording, in which both feet carry load, from which they are looked at there alone."""


@dataclass(frozen=True)
class Feet:
    """What joint angles say of feet.

    Attributes:
        support: where the right sole is in the left one's frame, at instants at which both stand.
        moves: their distance changes.
        loaded: both are known to carry load at the instants that were looked at.
        loop: what is wrong with soles that are not level.
    """

    support: DoubleSupport
    moves: bool
    loaded: bool
    loop: OpenLoop | None

    @property
    def explained(self) -> bool:
        """Soles are not level with each other, and one joint, or two, explain it."""
        return self.loop is not None and self.loop.named(loaded=self.loaded)

    def wrong(self, *, stand: bool) -> str:
        """What is wrong with the soles, and the joint that explains it; empty where nothing is.

        Args:
            stand: the feet are known to stand; else what only their motion may explain is left out.
        """
        loop = self.loop
        if loop is None or not (self.explained or stand or not self.moves):
            return ""
        return loop.text(loaded=self.loaded)


def find_feet(kinematics: Kinematics, shoe: Shoe, angles: Series, readings: Series) -> Feet:
    """How the feet stand, by forward kinematics, while both carry load where that is known.

    Args:
        kinematics: of the robot with its shoes on.
        shoe: that it wears.
        angles: of joints, numbers only [rad].
        readings: of cells and six-axis sensors by the shoe's names, at times of the same clock.

    Raises:
        JointsMissingError: for a joint between the feet without angles.
    """
    instants, chosen = postures(angles, kinematics.robot, SAMPLES)
    both = _both_carry_load(shoe, readings, instants)
    loaded = both is not None and bool(both.mean() >= LEAST_BOTH)
    chosen = chosen[both] if loaded else chosen
    states = kinematics.states(chosen)
    outer = OUTER_LOADED if loaded else OUTER
    low, high = np.percentile(states.translation[:, :2], (outer, 100.0 - outer), axis=0)
    standing = states if loaded else states.part(standing_samples(states))
    return Feet(
        standing.support(),
        bool((high - low).max() > STILL_M),
        loaded,
        open_loop(kinematics, chosen),
    )


def find_feet_exchanged(
    kinematics: Kinematics, shoe: Shoe, angles: Series, readings: Series
) -> Feet | None:
    """How the feet would stand if each leg's angles were those of the other one.

    Args:
        kinematics, shoe, angles, readings: as of `find_feet`.

    Returns:
        None where they would not stand still and level, or the legs have no joints in pairs.
    """
    robot = kinematics.robot
    left, right = ([robot.joint_names[joint] for joint in leg] for leg in leg_joints(robot))
    if len(left) != len(right) or not {*left, *right} <= set(angles):
        return None
    other = dict(zip([*left, *right], [*right, *left], strict=True))
    exchanged = {name: angles[other.get(name, name)] for name in angles}
    feet = find_feet(kinematics, shoe, exchanged, readings)
    return None if feet.moves or feet.wrong(stand=True) else feet


def _both_carry_load(shoe: Shoe, readings: Series, instants: FloatArray) -> BoolArray | None:
    """(T,) both feet carry load at instants [s]; None: that is not known."""
    series, _ = with_numbers(readings, ())
    vertical = [name for name, own in zip(shoe.names, shoe.vertical, strict=True) if own]
    if not vertical or any(name not in series or len(series[name].time) < 2 for name in vertical):
        return None
    time = series[vertical[0]].time
    values = np.zeros((len(time), len(shoe.names)))
    for name in vertical:
        own = series[name]
        values[:, shoe.names.index(name)] = np.interp(time, own.time, own.angle)
    both = both_carry_load(shoe, values)
    return None if both is None else np.interp(instants, time, both.astype(np.float64)) > 0.5
