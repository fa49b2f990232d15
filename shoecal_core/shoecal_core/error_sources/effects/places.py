"""Where effects can sit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from shoecal_core.arrays import IntArray
from shoecal_core.error_sources.base import ALL, Place
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.shoe.shoe import FEET, Shoe


def cells(shoe: Shoe) -> IntArray:
    """(k,) indices of the one-axis cells: channels of vertical force, not of six-axis sensors."""
    return np.array(
        [
            index
            for index in range(len(shoe.channels))
            if shoe.columns[index, 0] == 1.0 and not _six_axis(shoe, index)
        ],
        dtype=np.int64,
    )


def _six_axis(shoe: Shoe, index: int) -> bool:
    return bool(shoe.torque[shoe.of_foot(int(shoe.foot[index]))].any())


def coupled_axes(shoe: Shoe) -> Iterator[tuple[int, int]]:
    """Receivers and donors among the axes of each six-axis sensor.

    What vertical force adds to torques is the sensor's place, what sideways channels receive
    hardly counts: both are left out.
    """
    for foot in range(len(FEET)):
        own = [int(index) for index in shoe.of_foot(foot) if _six_axis(shoe, int(index))]
        upright = set(vertical(shoe).tolist())
        for receiver in own:
            if receiver not in upright and not shoe.torque[receiver]:
                continue
            for donor in own:
                if donor != receiver and not (donor in upright and shoe.torque[receiver]):
                    yield receiver, donor


def vertical(shoe: Shoe) -> IntArray:
    """(k,) indices of the channels of vertical force: cells, and that axis of six-axis sensors."""
    return np.flatnonzero(shoe.vertical)


def each_cell(signal_model: SignalModel) -> Iterator[Place]:
    """Every channel of vertical force by itself."""
    shoe = signal_model.samples.shoe
    for index in vertical(shoe):
        yield (shoe.names[index],)


def each_foot(_signal_model: SignalModel) -> Iterator[Place]:
    """Left and right."""
    for foot in FEET:
        yield (foot,)


def feet_and_all(signal_model: SignalModel) -> Iterator[Place]:
    """Left, right, both."""
    yield from each_foot(signal_model)
    yield (ALL,)


def cells_and_feet(signal_model: SignalModel) -> Iterator[Place]:
    """Every cell, and each foot's together."""
    yield from each_cell(signal_model)
    yield from each_foot(signal_model)


def cells_feet_and_all(signal_model: SignalModel) -> Iterator[Place]:
    """Every cell, each foot's together, all."""
    yield from cells_and_feet(signal_model)
    yield (ALL,)


def each_joint(signal_model: SignalModel) -> Iterator[Place]:
    """Every joint of the legs."""
    robot = signal_model.samples.robot
    for joint in sorted(robot.moved.tolist()):
        yield (robot.joint_names[joint],)


def joints_and_all(signal_model: SignalModel) -> Iterator[Place]:
    """Every joint of the legs, and all of them alike."""
    yield from each_joint(signal_model)
    yield (ALL,)


def channels_at(signal_model: SignalModel, place: Place) -> IntArray:
    """(k,) indices of the channels of vertical force at a place: a cell, a foot, or all."""
    shoe = signal_model.samples.shoe
    (name,) = place
    chosen = vertical(shoe)
    if name in shoe.names:
        return np.array([shoe.names.index(name)])
    if name in FEET:
        own: IntArray = chosen[shoe.foot[chosen] == FEET.index(name)]
        return own
    return chosen


def all_channels_at(signal_model: SignalModel, place: Place) -> IntArray:
    """(k,) indices of all channels of a foot, whatever their kind, or of both feet."""
    shoe = signal_model.samples.shoe
    (name,) = place
    channels = shoe.of_foot(FEET.index(name)) if name in FEET else range(len(shoe.channels))
    return np.array(channels, dtype=np.int64)


def joints_at(signal_model: SignalModel, place: Place) -> Sequence[int]:
    """Joints at a place."""
    robot = signal_model.samples.robot
    (name,) = place
    return sorted(robot.moved.tolist()) if name == ALL else [robot.joint(name)]
