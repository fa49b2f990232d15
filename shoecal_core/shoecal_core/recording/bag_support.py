"""The double support of a bag in which the feet stand still, by its joint angles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.bag import Bag
from shoecal_core.recording.bag_fields import table
from shoecal_core.recording.bag_match import Match
from shoecal_core.recording.joint_series import (
    JointSeries,
    from_pieces,
    postures,
    with_numbers,
    without_zeros,
)
from shoecal_core.recording.limits import in_degrees
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_zeros import open_loop
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError, Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import both_carry_load

SAMPLES = 200
"""Instants of a bag that are looked at, evenly over its messages."""
STILL_M = 0.01
"""Feet whose distance changes by less stand still."""
OUTER, OUTER_LOADED = 0.0, 15.0
"""Percentiles between which that is: of all instants, and of those at which both feet carry load,
of which some are of a foot that is about to leave or to land."""
LEAST_BOTH = 0.05
"""Of a bag, in which both feet carry load, from which their places are taken there alone."""
FEET_MOVE = (
    "has no base pose, and its feet move: record one, or give 'from_s' and 'to_s' of a part in "
    "which they stand still, and its 'support'"
)


@dataclass(frozen=True)
class Standing:
    """How the feet of a bag stand.

    Attributes:
        support: where the right sole is in the left one's frame; None where the feet move or the
            joint angles do not show it.
        notes: what is wrong with the joint angles, a line each.
    """

    support: DoubleSupport | None
    notes: tuple[str, ...]


def standing(
    bag: Bag,
    joints: Match,
    cells: Match | None,
    robot: Robot,
    shoe: Shoe,
    span: tuple[float, float] | None,
) -> Standing:
    """Where the feet stand, by forward kinematics, while both carry load where that is known.

    Args:
        bag: open.
        joints: the topics of its joint angles.
        cells: the topics of its readings; None: none fits.
        robot: with its shoes on.
        shoe: that it wears.
        span: part of the bag since its first message [s]; None: all of it.
    """
    series = _series(bag, joints, robot, span)
    if _degrees(series, robot):
        series = {name: replace(one, angle=np.radians(one.angle)) for name, one in series.items()}
    series, lacking = with_numbers(series, robot.optional)
    series, jumping = without_zeros(series)
    notes = [*lacking, *jumping]
    try:
        instants, angles = postures(series, robot, SAMPLES)
    except JointsMissingError as error:
        return Standing(None, (*notes, str(error)))
    kinematics = Kinematics(robot)
    both = None if cells is None else _both_carry_load(bag, cells, shoe, span, instants)
    angles = angles if both is None else angles[both]
    loop = open_loop(kinematics, angles)
    states = kinematics.states(angles)
    outer = OUTER if both is None else OUTER_LOADED
    low, high = np.percentile(states.translation[:, :2], (outer, 100.0 - outer), axis=0)
    moves = bool((high - low).max() > STILL_M)
    if loop is not None and (loop.fits or not moves or both is not None):
        return Standing(None, (*notes, loop.text(loaded=both is not None)))
    if moves:
        return Standing(None, (*notes, FEET_MOVE))
    return Standing(states.support(), tuple(notes))


def angles_in_degrees(bag: Bag, joints: Match, robot: Robot) -> bool:
    """Whether a bag's joint angles are beyond the robot's limits, but within them as degrees."""
    return _degrees(_series(bag, joints, robot, None), robot)


def _degrees(series: Mapping[str, JointSeries], robot: Robot) -> bool:
    for name, one in series.items():
        joint, there = robot.joint(name), one.angle[np.isfinite(one.angle)]
        if len(there) and in_degrees(there, robot.lower[joint], robot.upper[joint]):
            return True
    return False


def _ends(bag: Bag, span: tuple[float, float] | None) -> tuple[int | None, int | None]:
    """When a part of a bag starts and ends [ns]; None: with the bag."""
    if span is None:
        return None, None
    return bag.start_ns + round(1e9 * span[0]), bag.start_ns + round(1e9 * span[1])


def _series(
    bag: Bag, joints: Match, robot: Robot, span: tuple[float, float] | None
) -> dict[str, JointSeries]:
    """Angles of the robot's joints by when they were received, since the bag's start."""
    named: dict[str, list[tuple[Sequence[str], float, FloatArray]]] = defaultdict(list)
    for message in bag.messages(joints.topics, *_ends(bag, span)):
        fields = joints.fields.get(message.topic)
        if fields is None:
            names = [joints.rename.get(name, name) for name in message.content.name]
            position = message.content.position
        else:
            names = list(fields.values())
            position = table([message.content], list(fields))[0]
        if len(position) == len(names):
            time = 1e-9 * (message.received_ns - bag.start_ns)
            named["\n".join(names)].append((names, time, np.asarray(position, dtype=np.float64)))
    pieces: dict[str, list[tuple[FloatArray, FloatArray]]] = defaultdict(list)
    for rows in named.values():
        times = np.array([row[1] for row in rows])
        position = np.stack([row[2] for row in rows])
        for column, name in enumerate(rows[0][0]):
            if name in robot.joint_names:
                pieces[name].append((times, position[:, column]))
    return from_pieces(pieces)


def _both_carry_load(
    bag: Bag,
    cells: Match,
    shoe: Shoe,
    span: tuple[float, float] | None,
    instants: FloatArray,
) -> BoolArray | None:
    """(T,) both feet carry load at instants since the bag's start [s]; None: that is not known."""
    rows: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for message in bag.messages(cells.topics, *_ends(bag, span)):
        fields = cells.fields.get(message.topic)
        if fields is None:
            names = [cells.rename.get(name, name) for name in message.content.cell]
            values = message.content.voltage
        else:
            names, values = list(fields.values()), table([message.content], list(fields))[0]
        time = 1e-9 * (message.received_ns - bag.start_ns)
        for name, value in zip(names, values, strict=False):
            if np.isfinite(value):
                rows[name].append((time, float(value)))
    if any(len(rows[name]) < 2 for name in shoe.names):
        return None
    channels = [np.array(rows[name]).T for name in shoe.names]
    time = channels[0][0]
    readings = np.stack([np.interp(time, *one) for one in channels], axis=1)
    both = both_carry_load(shoe, readings)
    if both is None:
        return None
    there = np.interp(instants, time, both.astype(np.float64)) > 0.5
    return there if there.mean() >= LEAST_BOTH else None
