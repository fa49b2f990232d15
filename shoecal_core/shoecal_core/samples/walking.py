"""Stances of a robot that walks or steps, and what its dynamics make of GRF and CoP.

With the pose of the base known, the CoM moves in the world with an acceleration a, and the
floor's force is m (g + a_z) through the zero-moment point
    c = com_xy - com_z a_xy / (g + a_z)
(the angular momentum about the CoM is left out). At rest this is the quasi-static model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import PoseSamples
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.contact import Contact, find_contact
from shoecal_core.samples.filters import evenly, typical_period
from shoecal_core.samples.local_cubic import acceleration_window, local_cubics
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.shoe.shoe import FEET, Shoe

LOADED_SHARE = 0.1
"""A foot that stands carries at least this share of the weight."""
MAX_FOOT_SPEED = 0.05
"""m/s; a foot that moves faster does not stand."""
MAX_FOOT_TILT = 0.05
"""rad; a foot that leans further stands on an edge."""
MIN_STANCE_S = 0.2
EDGE_S = 0.04
"""Cut from both ends of a stance: there the other foot is just landing or leaving."""
GAP_S = 0.1
"""What no sample shows for longer is not part of a stance."""


@dataclass(frozen=True)
class World:
    """The body in the world at T instants, z up.

    Attributes:
        com: (T, 3) [m].
        acceleration: (T, 3) of the CoM [m/s^2].
        sole_rotation: (T, 2, 3, 3) of the left and right sole frame.
        sole: (T, 2, 3) their origins [m].
        sole_velocity: (T, 2, 3) [m/s].
        lowest: (T, 2) height of each sole's lowest corner [m].
    """

    com: FloatArray
    acceleration: FloatArray
    sole_rotation: FloatArray
    sole: FloatArray
    sole_velocity: FloatArray
    lowest: FloatArray

    @property
    def clearance(self) -> FloatArray:
        """(T, 2) how much higher each sole's lowest corner is than the other's [m]."""
        return self.lowest - self.lowest[:, ::-1]

    @property
    def yaw(self) -> FloatArray:
        """(T, 2) heading of each sole [rad]."""
        return np.arctan2(self.sole_rotation[..., 1, 0], self.sole_rotation[..., 0, 0])

    @property
    def flat(self) -> BoolArray:
        """(T, 2) the sole neither leans nor moves."""
        tilt = np.arccos(np.clip(self.sole_rotation[..., 2, 2], -1.0, 1.0))
        speed = np.linalg.norm(self.sole_velocity, axis=-1)
        still: BoolArray = (tilt < MAX_FOOT_TILT) & (speed < MAX_FOOT_SPEED)
        return still


def in_world(aligned: Aligned, base: PoseSamples, robot: Robot) -> World:
    """The body in the world, from joint angles and the recorded pose of the base."""
    time = np.clip(aligned.time, base.time[0], base.time[-1])
    rotation = Slerp(base.time, Rotation.from_quat(base.quaternion))(time).as_matrix()
    position = np.stack([np.interp(time, base.time, axis) for axis in base.position.T], axis=1)
    states = aligned.states
    right_rotation = states.left_rotation @ states.rotation
    right = (
        np.einsum("tij,tj->ti", states.left_rotation, states.translation) + states.left_translation
    )
    soles = np.stack((states.left_translation, right), axis=1)
    sole = np.einsum("tij,tfj->tfi", rotation, soles) + position[:, None]
    turns = np.stack((states.left_rotation, right_rotation), axis=1)
    turned = np.einsum("tij,tfjk->tfik", rotation, turns)
    com = np.einsum("tij,tj->ti", rotation, states.com_in_base) + position
    lowest = [
        (turned[:, index, 2, :2] @ foot.outline.T).min(axis=1) + sole[:, index, 2]
        for index, foot in enumerate(robot.feet)
    ]
    return World(
        com=com,
        acceleration=derivative(com, aligned.time, 2),
        sole_rotation=turned,
        sole=sole,
        sole_velocity=derivative(sole, aligned.time, 1),
        lowest=np.stack(lowest, axis=1),
    )


def walking_stances(
    run: int, aligned: Aligned, world: World, shoe: Shoe, robot: Robot
) -> list[Stance]:
    """Single and double supports in which the feet that stand are flat and still.

    Raises:
        ShoecalError: there is none; it says what was found.
    """
    contact = find_contact(shoe, aligned.readings, world.clearance, robot.weight)
    stands = world.flat & ~contact.air & ~(contact.load < LOADED_SHARE)
    stances = []
    for loaded in ((True, True), (True, False), (False, True)):
        here = np.ones(len(aligned.time), dtype=bool)
        for foot in (0, 1):
            here &= stands[:, foot] if loaded[foot] else contact.air[:, foot]
        stances += [
            _stance(run, aligned, world, shoe, robot.mass, loaded, part)
            for part in _stretches(here, aligned.time)
        ]
    if not stances:
        raise ShoecalError(f"run {run}: {_without_stance(stands, contact, aligned.time)}")
    return sorted(stances, key=lambda stance: float(stance.time[0]))


def _without_stance(stands: BoolArray, contact: Contact, time: FloatArray) -> str:
    """What was found where no stance was, and what is needed."""
    period = typical_period(time)
    found = ", ".join(
        f"{FEET[foot]} foot flat, still and loaded for {period * stands[:, foot].sum():.1f} s, "
        f"in the air for {period * contact.air[:, foot].sum():.1f} s"
        for foot in (0, 1)
    )
    return (
        f"no stance was found in {time[-1] - time[0]:.1f} s ({found}); a foot has to stand for "
        f"{MIN_STANCE_S + 2.0 * EDGE_S:.2f} s at a time while the other one stands or hangs: walk "
        "more slowly, or check the shoe's channels and the base pose"
    )


def _stance(
    run: int,
    aligned: Aligned,
    world: World,
    shoe: Shoe,
    mass: float,
    loaded: tuple[bool, bool],
    part: slice,
) -> Stance:
    lift = GRAVITY + world.acceleration[part, 2]
    frame = loaded.index(True)
    origin = np.median(world.sole[part, frame], axis=0)
    # Unwrapped: a robot that walks backwards hops between pi and -pi.
    yaws = np.median(np.unwrap(world.yaw[part], axis=0), axis=0)
    height = world.com[part, 2] - origin[2]
    zmp = world.com[part, :2] - (height / lift)[:, None] * world.acceleration[part, :2]
    turn = DoubleSupport(float(origin[0]), float(origin[1]), float(yaws[frame]))
    other = turn.left_to_right(np.median(world.sole[part, 1, :2], axis=0))
    turned = math.remainder(float(yaws[1] - yaws[frame]), math.tau)
    support = DoubleSupport(float(other[0]), float(other[1]), turned)
    c, s = math.cos(turn.dtheta), math.sin(turn.dtheta)
    stance = make_stance(
        run,
        shoe,
        support,
        loaded,
        aligned.time[part],
        aligned.readings[part],
        mass * lift,
        turn.left_to_right(zmp),
        aligned.joint_angles[part],
    )
    push = mass * world.acceleration[part, :2] @ np.array([[c, -s], [s, c]])
    return replace(stance, push=push)


def _stretches(here: BoolArray, time: FloatArray) -> list[slice]:
    """Unbroken stretches, their edges cut, that are long enough."""
    period = typical_period(time)
    marked = np.flatnonzero(here)
    breaks = (np.diff(marked) > 1) | (np.diff(time[marked]) > max(GAP_S, 1.5 * period))
    parts = []
    for samples in np.split(marked, np.flatnonzero(breaks) + 1) if len(marked) else ():
        # A rounding must not decide about a sample.
        edge = EDGE_S - 0.5 * period
        first = int(np.searchsorted(time, time[samples[0]] + edge))
        last = int(np.searchsorted(time, time[samples[-1]] - edge, side="right"))
        if last > first and time[last - 1] - time[first] + period >= MIN_STANCE_S:
            parts.append(slice(first, last))
    return parts


def derivative(values: FloatArray, time: FloatArray, order: int) -> FloatArray:
    """(T, ...) smoothed derivative of values (T, ...), by local cubics; stamps may be uneven.

    Args:
        values: of any unit.
        time: (T,) [s].
        order: of the derivative: per s to this power.

    Raises:
        ShoecalError: too few samples for it.
    """

    def smooth(even: FloatArray, period: float) -> FloatArray:
        window = acceleration_window(period)
        if len(even) < window:
            raise ShoecalError(
                f"{len(even)} samples are too few for accelerations; {window} are needed"
            )
        return local_cubics(even, window, period, order)

    return evenly(smooth, values, time)
